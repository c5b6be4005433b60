//! Links partition the exchange of light: each pair of leaf elements that face each other is covered
//! by one link, or by none if nothing gets through. A failure means light counted twice or lost.

use lightshaft::radiosity::{Link, Record, Solution, SolveOptions};
use lightshaft::scene::Scene;
use lightshaft::tracer::{BruteTracer, NO_FACET, Segment};
use lightshaft::visibility::{Strategy, VisibilityOptions};

use crate::boxes::Rectangles;
use crate::covered_pairs::CoveredPairs;
use crate::segments::{Numbers, blockers};
use crate::solving::{Case, STRATEGIES, links_only};

/// Coarse enough that all pairs of leaves can be looked at.
fn coarse(strategy: Strategy) -> SolveOptions {
    SolveOptions {
        epsilon: 1e-3,
        contrast: 0.1,
        min_size: None,
        resolution: 32.0,
        iterations: 50,
        visibility: VisibilityOptions { strategy, rays: 16, certify: false },
        record: Record::Nothing,
    }
}

/// A room lit by a lamp under its ceiling; convex but for the lamp, which hangs 0.01 below.
fn empty_room() -> Scene {
    let mut room = Rectangles::new("empty room");
    let grey = room.material(0.5, 0.0);
    let lamp = room.material(0.0, 10.0);
    room.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
    room.quad([[1.5, 1.0, 2.49], [1.5, 2.0, 2.49], [2.5, 2.0, 2.49], [2.5, 1.0, 2.49]], lamp);
    room.finish()
}

/// A room whose six walls shine: nothing is hidden from anything.
fn bare_room() -> Scene {
    let mut room = Rectangles::new("bare room");
    let grey = room.material(0.5, 1.0);
    room.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
    room.finish()
}

/// How links cover the pairs of leaves that face each other.
#[derive(Debug, Default)]
struct Gaps {
    leaves: usize,
    facing: u64,
    /// Pairs with two links or more.
    twice: u64,
    /// Pairs without a link.
    uncovered: u64,
    /// Power over all pairs and over those without a link, occlusion left aside, and the part of the
    /// latter that nothing blocks: what is lost.
    power: f64,
    without_link: f64,
    lost: f64,
}

/// Segments tried for each pair without a link.
const SEGMENTS: usize = 4;

fn gaps(case: &Case, solution: &Solution, links: &[Link]) -> Gaps {
    let pairs = CoveredPairs::of(&case.hierarchy, solution, links);
    let mut found = Gaps { leaves: pairs.leaves.len(), ..Gaps::default() };
    let mut numbers = Numbers(11);
    let (mut segments, mut carried) = (Vec::new(), Vec::new());
    for (r, s) in pairs.facing() {
        found.facing += 1;
        found.twice += u64::from(pairs.times(r, s) > 1);
        let is_covered = pairs.times(r, s) > 0;
        found.uncovered += u64::from(!is_covered);
        let (receiver, source) = (&pairs.leaves[r], &pairs.leaves[s]);
        let count = if is_covered { 1 } else { SEGMENTS };
        for _ in 0..count {
            let from = receiver.polygon.point_at(numbers.next(), numbers.next());
            let to = source.polygon.point_at(numbers.next(), numbers.next());
            let power = receiver.exchange(from, source, to) * pairs.exitance[s] / count as f64;
            found.power += power;
            if !is_covered && power > 0.0 {
                let skip = [receiver.facet, source.facet];
                segments.push(Segment { from: from.as_vec3(), to: to.as_vec3(), skip });
                carried.push(power);
            }
        }
    }
    let judge = BruteTracer::new(&case.hierarchy.mesh);
    found.without_link = carried.iter().sum();
    let clear = blockers(&judge, &segments).into_iter().zip(carried).filter(|(b, _)| *b == NO_FACET);
    found.lost = clear.map(|(_, power)| power).sum();
    found
}

fn check(case: &Case, strategy: Strategy) -> Gaps {
    let solution = case.solve(&case.fallback(), &links_only(coarse(strategy)));
    let found = gaps(case, &solution, &solution.links.links);
    println!("{} {}: {found:?}", case.scene.name, strategy.name());
    assert!(found.leaves < 6000, "{found:?}: too many to look at all pairs");
    assert!(found.facing > 100, "{found:?}");
    assert_eq!(found.twice, 0, "{} {}: {found:?}", case.scene.name, strategy.name());
    found
}

#[test]
fn in_a_bare_room_every_pair_has_exactly_one_link() {
    let case = Case::of(bare_room(), false);
    for strategy in STRATEGIES {
        let found = check(&case, strategy);
        assert_eq!(found.uncovered, 0, "{}: {found:?}", strategy.name());
    }
}

#[test]
fn no_pair_has_two_links_and_little_is_lost_without_one() {
    let mut cases = vec![Case::of(empty_room(), false), Case::of(empty_room(), true)];
    cases.extend(["cornell-box", "paper-1", "paper-3"].map(Case::load));
    for case in &cases {
        for strategy in STRATEGIES {
            let found = check(case, strategy);
            let lost = found.lost / found.power;
            // Sixteen rays that are all blocked can miss a gap. `adaptive` takes their word where little
            // power rests on it, and the classic method takes it everywhere.
            let tolerance = match strategy {
                Strategy::Sampled => 0.1,
                Strategy::Adaptive => 0.05,
                _ => 0.02,
            };
            assert!(lost < tolerance, "{} {}: {lost}, {found:?}", case.scene.name, strategy.name());
        }
    }
}

/// The check itself: a link too many and a link too few have to be noticed.
#[test]
fn a_doubled_and_a_lost_link_are_noticed() {
    let case = Case::of(bare_room(), false);
    let solution = case.solve(&case.fallback(), &coarse(Strategy::Adaptive));
    let links = &solution.links.links;
    let clusters = case.hierarchy.nodes.len() as u32;
    // Area × form factor of the links between elements: the largest joins two shining walls.
    let exchange = |l: &Link| {
        let element = l.receiver.checked_sub(clusters).filter(|_| l.source >= clusters);
        element.map_or(0.0, |element| l.factor * solution.forest.area[element as usize])
    };
    let largest = (0..links.len()).max_by(|&a, &b| exchange(&links[a]).total_cmp(&exchange(&links[b])));
    let inside = largest.expect("walls light each other");
    let mut doubled = links.clone();
    doubled.push(links[inside]);
    assert!(gaps(&case, &solution, &doubled).twice > 0);
    let mut lost = links.clone();
    lost.remove(inside);
    let found = gaps(&case, &solution, &lost);
    assert!(found.uncovered > 0 && found.lost > 1e-5 * found.power, "{found:?}");
}
