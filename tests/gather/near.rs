//! Looking up light where it was looked up a moment ago gives what looking it up anew gives, bit by bit. A failure means
//! that a picture depends on the order in which its pixels are made.

use glam::DVec3;
use lightshaft::gather::Reconstruction;
use lightshaft::visibility::Strategy;

use crate::penumbra::{self, BOARDS};
use crate::solving::rough;

#[test]
fn what_was_found_before_has_no_say() {
    let case = penumbra::scene(BOARDS[0]);
    let tracer = case.fallback();
    let solution = case.solve(&tracer, &rough(Strategy::Adaptive));
    let [near, anew] = [(); 2].map(|()| Reconstruction::new(&case.hierarchy, &solution));
    let (mut recent, mut elements, mut again) = (None, 0, 0);
    for index in 0..solution.forest.side_count() {
        let side = solution.forest.side(index);
        let outline = case.hierarchy.polygon(side.facet);
        let corners = outline.vertices();
        let (a, along, across) = (corners[0], corners[1] - corners[0], corners[2] - corners[1]);
        // Fine steps over the whole side and along its edges; some points lie on edges of elements, and some beyond.
        let mut last = None;
        for step in 0..=90_000 {
            let (x, y) = (f64::from(step % 301) / 300.0, f64::from(step / 301) / 299.0);
            let point: DVec3 = a + along * x + across * y;
            let fresh = anew.look_up(side, point).expect("a side that takes part");
            let spot = near.look_up_near(&mut recent, side, point).expect("a side that takes part");
            assert_eq!((spot.element, spot.irradiance), (fresh.element, fresh.irradiance), "{point}");
            assert_eq!(spot.polygon.vertices(), fresh.polygon.vertices());
            again += u32::from(last == Some(spot.element));
            elements += u32::from(last.replace(spot.element) != Some(fresh.element));
        }
    }
    assert!(elements > 1000 && again > elements, "{elements} changes, {again} times the same");
}
