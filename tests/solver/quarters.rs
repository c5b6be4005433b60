//! Parts of a source count as much as they send to the receiver. A failure means that light between
//! near surfaces is too weak, and closed rooms lose it.

use glam::Vec3;
use lightshaft::hierarchy::Hierarchy;
use lightshaft::math::Polygon;
use lightshaft::radiosity::{Link, PolygonSource, Quarters, Solution};
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, rough};

/// Share of each quarter of the source in what a grid of points on the receiver gets from it.
fn exact(hierarchy: &Hierarchy, solution: &Solution, link: &Link) -> [f64; 4] {
    let clusters = hierarchy.nodes.len() as u32;
    let [receiver, source] =
        [link.receiver, link.source].map(|id| solution.forest.piece(hierarchy, id - clusters));
    let quarters: Vec<Polygon> = source.polygon.bisect().into_iter().flat_map(|half| half.bisect()).collect();
    let mut sums = [0.0; 4];
    for i in 0..256 {
        let point = receiver
            .polygon
            .point_at((i % 16) as f64 / 16.0 + 1.0 / 32.0, (i / 16) as f64 / 16.0 + 1.0 / 32.0);
        for (sum, quarter) in sums.iter_mut().zip(&quarters) {
            *sum += PolygonSource::new(quarter, source.plane).form_factor(point, receiver.plane.normal);
        }
    }
    let total: f64 = sums.iter().sum();
    sums.map(|sum| sum / total)
}

#[test]
fn quarters_of_a_source_share_as_they_send() {
    let mut scene = Rectangles::new("a closed box");
    let wall = scene.material(0.5, 1.0);
    scene.closed_box([0.0; 3], [1.0, 1.5, 2.0], true, wall);
    let case = Case::of(scene.finish(), true);
    let solution = case.solve(&case.fallback(), &rough(Strategy::Adaptive));
    let (mut weighed, mut worst) = (0, 0.0f64);
    for link in solution.links.links.iter().filter(|link| link.quarters != Quarters::UNIFORM) {
        let weights = link.quarters.weights();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{link:?}");
        let expected = exact(&case.hierarchy, &solution, link);
        let off = weights.iter().zip(expected).map(|(w, e)| (w - e).abs()).fold(0.0, f64::max);
        worst = worst.max(off);
        weighed += 1;
    }
    assert!(weighed > 20, "{weighed}");
    // Between walls that share an edge the middle of a quarter stands for all of it.
    assert!(worst < 0.03, "{worst}");
}

#[test]
fn a_weighed_source_is_as_bright_as_its_quarters() {
    let mut scene = Rectangles::new("a closed box");
    let wall = scene.material(0.5, 1.0);
    scene.closed_box([0.0; 3], [1.0, 1.5, 2.0], true, wall);
    let case = Case::of(scene.finish(), true);
    let solution = case.solve(&case.fallback(), &rough(Strategy::Adaptive));
    let (forest, clusters) = (&solution.forest, case.hierarchy.nodes.len() as u32);
    // Every element as bright as its own number.
    let exitance: Vec<Vec3> = (0..forest.len()).map(|element| Vec3::splat(element as f32)).collect();
    let halves = |element: u32| {
        let piece = forest.piece(&case.hierarchy, element);
        match forest.second[element as usize] {
            0 => [element; 2],
            _ => piece.halves(forest).map(|half| half.id),
        }
    };
    let uneven = solution.links.links.iter().find(|link| link.quarters != Quarters::UNIFORM);
    let weighed = uneven.expect("walls that meet are near").quarters;
    // Elements split not at all, once and twice.
    let mut splits = [0; 3];
    for source in 0..forest.len() as u32 {
        let [first, second] = halves(source).map(halves);
        let quarters = [first[0], first[1], second[0], second[1]];
        let expected: f64 =
            quarters.iter().zip(weighed.weights()).map(|(&q, weight)| q as f64 * weight).sum();
        let found = weighed.weigh(forest, &exitance, source).x as f64;
        assert!((found - expected).abs() < 1e-5 * expected.max(1.0), "{found} for {expected} of {source}");
        splits[usize::from(first[0] != second[0]) + usize::from(first[0] != first[1])] += 1;
    }
    assert!(splits.iter().all(|&count| count > 0), "{splits:?}");
    let as_uniform = Quarters::UNIFORM.weigh(forest, &exitance, clusters);
    assert_eq!(as_uniform.x, clusters as f32, "without weights the mean counts");
}
