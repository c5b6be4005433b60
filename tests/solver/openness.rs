//! Light that comes to a cluster falls on what lies open in it, and not on what the cluster hides; so it is with elements.

use glam::Vec3;
use lightshaft::hierarchy::Hierarchy;
use lightshaft::radiosity::{Link, LinkClass, LinkSet, Solution, direction};
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, options, rough};

/// One link of this class from an element or cluster to a cluster.
fn link(receiver: u32, source: u32, class: LinkClass) -> Link {
    Link { visibility: 0.5, class, ..Link::untested(receiver, source, 1.0, 0.0) }
}

/// Irradiance of every leaf element over these links; nothing in inner elements.
fn received(hierarchy: &Hierarchy, solution: &Solution, links: &[Link]) -> Vec<Vec3> {
    let (forest, openness, light) = (&solution.forest, &solution.openness, &solution.light);
    let links = LinkSet::new(links.to_vec(), hierarchy.nodes.len() + forest.len());
    let arriving = openness.arriving(hierarchy, forest, &links, light);
    let gathered = |element| light.gathered(hierarchy, forest, &links, element);
    let (even, mut received): (Vec<Vec3>, Vec<Vec3>) =
        (0..forest.len() as u32).map(|element| gathered(element).into()).unzip();
    for side in 0..forest.side_count() {
        let own = forest.elements_of(side);
        openness.push(hierarchy, forest, side, &arriving, (&even[own.clone()], &mut received[own]));
    }
    (0..forest.len()).filter(|&element| forest.second[element] != 0).for_each(|e| received[e] = Vec3::ZERO);
    received
}

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
    let forest = &solution.forest;

    // The cluster that is the box.
    let is_wood = |facet: u32| hierarchy.facets[facet as usize].material == wood;
    let is_box = |node: &lightshaft::hierarchy::Node| {
        node.end - node.first == 6 && (node.first..node.end).all(is_wood)
    };
    let cluster = hierarchy.nodes.iter().position(is_box).expect("the box is a cluster") as u32;
    // From the lamp and from every wall.
    let nodes = hierarchy.nodes.len() as u32;
    let is_source = |&side: &usize| !forest.side(side).back && !is_wood(forest.side(side).facet);
    let sources: Vec<usize> = (0..forest.side_count()).filter(is_source).collect();
    assert!(sources.len() >= 7);
    for source in sources {
        let power = |class: LinkClass| {
            let source = nodes + forest.first_element[source];
            let irradiance = received(hierarchy, &solution, &[link(cluster, source, class)]);
            let mut power = [0.0; 2];
            for (element, irradiance) in irradiance.into_iter().enumerate() {
                let named = forest.side(forest.side_of(element as u32));
                if !is_wood(named.facet) {
                    assert_eq!(irradiance, Vec3::ZERO, "{named:?} is not in the cluster");
                }
                power[usize::from(named.back)] += forest.area[element] * irradiance.element_sum();
            }
            power
        };
        // Seen in full, and so lit by where its sides face: half of the power on the inside.
        let [outside, inside] = power(LinkClass::Visible);
        assert!((inside / outside - 1.0).abs() < 1e-4 && outside > 0.0, "{source}: {outside}, {inside}");
        let all = outside + inside;
        let [outside, inside] = power(LinkClass::Partial);
        println!("{source}: of {all} outside {outside}, inside {inside}");
        assert!((outside / all - 1.0).abs() < 1e-4 && inside < 1e-6 * all, "{source}: {outside}, {inside}");
    }
}

/// A box stands on the floor of a room: of light that is kept off some of the floor, nothing falls under the box, and as
/// much more beside it; light that reaches all of the floor falls everywhere alike.
#[test]
fn light_that_is_kept_off_a_floor_is_not_missing_beside_what_stands_on_it() {
    let mut room = Rectangles::new("box on the floor");
    let (grey, lamp, wood) = (room.material(0.5, 0.0), room.material(0.0, 5.0), room.material(0.5, 0.0));
    room.closed_box([0.0; 3], [4.0, 4.0, 3.0], true, grey);
    room.quad([[0.5, 0.5, 2.9], [0.5, 1.0, 2.9], [1.0, 1.0, 2.9], [1.0, 0.5, 2.9]], lamp);
    let (low, high) = ([1.6, 1.4], [3.2, 2.6]);
    room.closed_box([low[0], low[1], 0.0], [high[0], high[1], 0.25], false, wood);
    let case = Case::of(room.finish(), false);
    let hierarchy = &case.hierarchy;
    let solution = case.solve(&case.fallback(), &options(Strategy::Adaptive));
    let forest = &solution.forest;
    let nodes = hierarchy.nodes.len() as u32;
    let height = |side: usize| {
        let root = forest.first_element[side] as usize;
        hierarchy.frame.scene_from_local(forest.center[root].as_dvec3()).z
    };
    // The side of this material that faces up or down at a height.
    let side_at = |material: u32, z: f64, upwards: f64| {
        let is_it = |&side: &usize| {
            let named = forest.side(side);
            hierarchy.facets[named.facet as usize].material == material
                && hierarchy.side_normal(named).z * upwards > 0.9
                && (height(side) - z).abs() < 1e-3
        };
        (0..forest.side_count()).find(is_it).expect("a side")
    };
    let floor = side_at(grey, 0.0, 1.0);
    let source = side_at(lamp, 2.9, -1.0);
    let root = forest.first_element[floor];
    let leaves: Vec<usize> =
        forest.elements_of(floor).filter(|&element| forest.second[element] == 0).collect();
    // Whether a leaf lies under the box, or well beside it and in no corner of the room: there as much is believed to be
    // hidden as is so in many a half-open place.
    let place = |leaf: usize| {
        let center = hierarchy.frame.scene_from_local(forest.center[leaf].as_dvec3());
        let within = |by: f64| (0..2).all(|i| low[i] - by < center[i] && center[i] < high[i] + by);
        let in_corner = (0..2).all(|i| (center[i] - 2.0).abs() > 1.2);
        if within(-0.05) {
            Some(true)
        } else if within(0.7) || in_corner {
            None
        } else {
            Some(false)
        }
    };
    let of = |under: bool| leaves.iter().copied().filter(move |&leaf| place(leaf) == Some(under));
    assert!(of(true).count() >= 2 && of(false).count() >= 20, "{} {}", of(true).count(), of(false).count());
    let area = f64::from(forest.area[root as usize]);
    let covered = (high[0] - low[0]) * (high[1] - low[1]) / 16.0;
    for (class, under, beside) in [
        (LinkClass::Visible, 1.0, 1.0),
        (LinkClass::CertifiedVisible, 1.0, 1.0),
        (LinkClass::Partial, 0.0, 1.0 / (1.0 - covered)),
    ] {
        let link = link(nodes + root, nodes + forest.first_element[source], class);
        let carried = f64::from(solution.light.carried(hierarchy, forest, &link).x);
        let irradiance = received(hierarchy, &solution, &[link]);
        for (leaf, light) in irradiance.iter().enumerate() {
            assert!(leaves.contains(&leaf) || *light == Vec3::ZERO, "{leaf} is not of the floor");
        }
        let power: f64 =
            leaves.iter().map(|&leaf| f64::from(irradiance[leaf].x) * f64::from(forest.area[leaf])).sum();
        assert!((power / (carried * area) - 1.0).abs() < 1e-3, "{class:?}: {power} of {}", carried * area);
        for leaf in of(true) {
            let light = f64::from(irradiance[leaf].x) / carried;
            assert!((light - under).abs() < 1e-3, "{class:?} under the box: {light} for {under}");
        }
        // Close to a wall of the room, too, though half of all rays end there.
        for leaf in of(false) {
            let light = f64::from(irradiance[leaf].x) / carried;
            assert!((light - beside).abs() < 0.1, "{class:?} beside the box: {light} for {beside}");
        }
    }

    // The same further down: a part of the floor with some of what lies under the box, divided more than once.
    let below = |element: u32| {
        leaves.iter().copied().filter(move |&leaf| forest.above(leaf as u32).any(|e| e == element))
    };
    let is_mixed = |&element: &u32| {
        let depth = forest.above(element).count();
        let has = |under| below(element).any(|leaf| place(leaf) == Some(under));
        depth >= 2 && forest.second[element as usize] != 0 && has(true) && has(false)
    };
    let part =
        forest.elements_of(floor).map(|element| element as u32).find(is_mixed).expect("a part of the floor");
    let links = [root, part]
        .map(|element| link(nodes + element, nodes + forest.first_element[source], LinkClass::Partial));
    let [all, above] = [&links[..], &links[..1]].map(|links| received(hierarchy, &solution, links));
    let carried = f64::from(solution.light.carried(hierarchy, forest, &links[1]).x);
    let difference = |leaf: usize| f64::from(all[leaf].x) - f64::from(above[leaf].x);
    let area = f64::from(forest.area[part as usize]);
    let power: f64 = below(part).map(|leaf| difference(leaf) * f64::from(forest.area[leaf])).sum();
    assert!((power / (carried * area) - 1.0).abs() < 1e-3, "{power} of {}", carried * area);
    for &leaf in &leaves {
        let share = difference(leaf) / carried;
        let is_below = below(part).any(|below| below == leaf);
        assert!(is_below || share.abs() < 1e-5, "{share} beside the part");
        // Some rays within the box go further than beside so small a part.
        assert!(place(leaf) != Some(true) || (-1e-5..0.3).contains(&share), "{share} under the box");
        assert!(!is_below || place(leaf) != Some(false) || share > 1.0, "{share} in the open");
    }
}

/// Whatever comes to whichever cluster: no side receives less than nothing, all together what is turned towards the
/// light, or less where next to nothing lies open, and from two sources as much as from each. So light cannot grow in
/// clusters.
#[test]
fn light_is_shared_out_without_making_any() {
    let mut room = Rectangles::new("things in a room");
    let (grey, lamp, wood) = (room.material(0.5, 0.0), room.material(0.0, 5.0), room.material(0.5, 0.0));
    room.closed_box([0.0; 3], [4.0, 4.0, 4.0], true, grey);
    room.quad([[1.5, 1.5, 3.9], [1.5, 2.5, 3.9], [2.5, 2.5, 3.9], [2.5, 1.5, 3.9]], lamp);
    for i in 0..12 {
        // Boxes, some in others, and boards, most of them turned.
        let (x, y) = (0.3 + 0.3 * f64::from(i), 0.5 + 0.25 * f64::from(i * 5 % 12));
        room.closed_box([x, y, 0.4], [x + 0.25, y + 0.3, 0.9 + 0.1 * f64::from(i % 4)], false, wood);
        let (sin, cos) = (0.5 * f64::from(i)).sin_cos();
        let along = [0.3 * cos, 0.3 * sin, 0.0];
        let up = [-0.2 * sin, 0.2 * cos, 0.1 * f64::from(i % 3)];
        let corner =
            |a: f64, b: f64| [0, 1, 2].map(|axis| [x, y, 1.5][axis] + a * along[axis] + b * up[axis]);
        room.quad([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)], wood);
    }
    let case = Case::of(room.finish(), false);
    let hierarchy = &case.hierarchy;
    let solution = case.solve(&case.fallback(), &rough(Strategy::Adaptive));
    let forest = &solution.forest;
    let nodes = hierarchy.nodes.len() as u32;
    let power = |irradiance: &[Vec3]| -> f32 {
        irradiance.iter().zip(&forest.area).map(|(irradiance, area)| irradiance.x * area).sum()
    };
    let clusters: Vec<u32> = (1..nodes).filter(|&node| !hierarchy.nodes[node as usize].is_leaf()).collect();
    let sources: Vec<u32> = (0..forest.side_count())
        .filter(|&side| !forest.side(side).back)
        .map(|side| nodes + forest.first_element[side])
        .collect();
    let (mut whole, mut cases) = (0, 0);
    for (index, &cluster) in clusters.iter().enumerate() {
        let links: Vec<Link> = sources
            .iter()
            .skip(index % 7)
            .step_by(7)
            .map(|&source| link(cluster, source, LinkClass::Partial))
            .collect();
        let mut sum = vec![Vec3::ZERO; forest.len()];
        for link in &links {
            let irradiance = received(hierarchy, &solution, std::slice::from_ref(link));
            assert!(irradiance.iter().all(|irradiance| irradiance.min_element() >= 0.0), "{link:?}");
            let facing =
                solution.openness.area(hierarchy, cluster).evaluate(direction(hierarchy, forest, link));
            let arrives = facing * solution.light.carried(hierarchy, forest, link).x;
            let falls = power(&irradiance);
            assert!(falls <= arrives * 1.001, "{link:?}: {falls} of {arrives}");
            (whole, cases) = (whole + u32::from(falls > arrives * 0.999), cases + 1);
            sum.iter_mut().zip(irradiance).for_each(|(sum, irradiance)| *sum += irradiance);
        }
        let together = received(hierarchy, &solution, &links);
        for (together, sum) in together.iter().zip(&sum) {
            assert!(together.abs_diff_eq(*sum, 1e-4 * sum.max_element() + 1e-5), "{together} for {sum}");
        }
    }
    println!("all of the light of {whole} of {cases} links");
    assert!(cases > 200 && whole > cases * 9 / 10, "{whole} of {cases}");
}
