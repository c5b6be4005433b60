//! Light that comes to a cluster falls on what lies open in it, and not on what the cluster hides.

use glam::Vec3;
use lightshaft::hierarchy::Side;
use lightshaft::radiosity::{Arriving, Link, LinkClass, Quarters};
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, rough};

/// A room with a lamp, and in it a closed box: nothing from outside gets to the inside of its walls.
#[test]
fn the_inside_of_a_closed_box_receives_nothing() {
    let mut room = Rectangles::new("closed box");
    let (grey, lamp, wood) = (room.material(0.5, 0.0), room.material(0.0, 5.0), room.material(0.5, 0.0));
    room.closed_box([0.0; 3], [4.0, 4.0, 4.0], true, grey);
    room.quad([[1.5, 1.5, 3.9], [1.5, 2.5, 3.9], [2.5, 2.5, 3.9], [2.5, 1.5, 3.9]], lamp);
    room.closed_box([1.8, 1.8, 1.5], [2.2, 2.1, 1.9], false, wood);
    let case = Case::of(room.finish(), false);
    let hierarchy = &case.hierarchy;
    let solution = case.solve(&case.fallback(), &rough(Strategy::Adaptive));
    let (forest, openness) = (&solution.forest, &solution.openness);

    // The cluster that is the box.
    let is_wood = |facet: u32| hierarchy.facets[facet as usize].material == wood;
    let is_box = |node: &lightshaft::hierarchy::Node| {
        node.end - node.first == 6 && (node.first..node.end).all(is_wood)
    };
    let cluster = hierarchy.nodes.iter().position(is_box).expect("the box is a cluster") as u32;
    let mut link = Link {
        receiver: cluster,
        source: 0,
        factor: 1.0,
        spread: 0.0,
        visibility: 0.5,
        quarters: Quarters::UNIFORM,
        class: LinkClass::Partial,
        inherited: false,
    };
    for direction in [Vec3::Z, Vec3::X, Vec3::new(1.0, 2.0, 2.0).normalize()] {
        let mut received = |class: LinkClass| {
            link.class = class;
            let mut arriving = vec![Arriving::default(); hierarchy.nodes.len()];
            openness.add(&mut arriving[cluster as usize], &link, direction, Vec3::ONE);
            Arriving::hand_down(hierarchy, &mut arriving);
            let mut power = [0.0; 2];
            for side in 0..forest.side_count() {
                let named: Side = forest.side(side);
                let irradiance = openness.irradiance(hierarchy, side, forest, &arriving).x;
                if !is_wood(named.facet) {
                    assert_eq!(irradiance, 0.0, "{named:?} is not in the cluster");
                }
                let area = forest.area[forest.first_element[side] as usize];
                power[usize::from(named.back)] += area * irradiance;
            }
            power
        };
        // Seen in full, and so lit by where its sides face: half of the power on the inside.
        let [outside, inside] = received(LinkClass::Visible);
        assert!((inside / outside - 1.0).abs() < 1e-4 && outside > 0.0, "{direction}: {outside}, {inside}");
        let all = outside + inside;
        let [outside, inside] = received(LinkClass::Partial);
        println!("{direction}: of {all} outside {outside}, inside {inside}");
        assert!(
            (outside / all - 1.0).abs() < 0.02 && inside < 0.01 * all,
            "{direction}: {outside}, {inside}"
        );
    }
}
