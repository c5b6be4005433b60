//! Light that comes to a cluster falls on what lies open in it, and not on what the cluster hides.

use glam::Vec3;
use lightshaft::hierarchy::Hierarchy;
use lightshaft::radiosity::{Link, LinkClass, LinkSet, Quarters, Solution, direction};
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, rough};

/// One link of this class from an element or cluster to a cluster.
fn link(receiver: u32, source: u32, class: LinkClass) -> Link {
    Link {
        receiver,
        source,
        factor: 1.0,
        spread: 0.0,
        visibility: 0.5,
        quarters: Quarters::UNIFORM,
        class,
        inherited: false,
        work: 0,
    }
}

/// Irradiance of every side over these links.
fn received(hierarchy: &Hierarchy, solution: &Solution, links: &[Link]) -> Vec<Vec3> {
    let (forest, openness) = (&solution.forest, &solution.openness);
    let links = LinkSet::new(links.to_vec(), hierarchy.nodes.len() + forest.len());
    let arriving = openness.arriving(hierarchy, forest, &links, &solution.light);
    (0..forest.side_count()).map(|side| openness.irradiance(hierarchy, forest, side, &arriving)).collect()
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
            for (side, irradiance) in irradiance.into_iter().enumerate() {
                let named = forest.side(side);
                if !is_wood(named.facet) {
                    assert_eq!(irradiance, Vec3::ZERO, "{named:?} is not in the cluster");
                }
                let area = forest.area[forest.first_element[side] as usize];
                power[usize::from(named.back)] += area * irradiance.element_sum();
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
        let areas = (0..irradiance.len()).map(|side| forest.area[forest.first_element[side] as usize]);
        irradiance.iter().zip(areas).map(|(irradiance, area)| irradiance.x * area).sum()
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
        let mut sum = vec![Vec3::ZERO; forest.side_count()];
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
