//! What is proved holds: between elements that are certified visible no segment is blocked, between
//! those certified invisible every segment is. A failure means that a proof of this program is none.

use lightshaft::hierarchy::Hierarchy;
use lightshaft::radiosity::{Forest, Link, LinkClass, Piece, Solution};
use lightshaft::tracer::{BruteTracer, NO_FACET, TraceMesh};
use lightshaft::visibility::{
    CandidateSet, Class, Inheritance, NodeEnd, Pair, Strategy, Tester, Verdict, VisibilityOptions, Worker,
};

use crate::boxes::Rectangles;
use crate::covered_pairs::Leaf;
use crate::proofs::{Attack, Claim, attack};
use crate::segments::Numbers;
use crate::solving::{Case, OWN_SCENES, options};

fn leaf_of(piece: &Piece) -> Leaf {
    Leaf { polygon: piece.polygon, plane: piece.plane, facet: piece.side.facet }
}

/// Every element, inner ones too, by id.
fn elements(hierarchy: &Hierarchy, forest: &Forest) -> Vec<Piece> {
    let mut all = Vec::with_capacity(forest.len());
    forest.for_each_element(hierarchy, |piece| all.push(piece.clone()));
    all.sort_by_key(|piece| piece.id);
    all
}

/// Attacks the links between elements that `chosen` picks as if they were proved visible.
fn attack_links(case: &Case, solution: &Solution, chosen: impl Fn(&Link) -> bool) -> (usize, Attack) {
    let clusters = case.hierarchy.nodes.len() as u32;
    let elements = elements(&case.hierarchy, &solution.forest);
    let judge = BruteTracer::new(&case.hierarchy.mesh);
    let mut numbers = Numbers(21);
    let chosen: Vec<&Link> = solution
        .links
        .links
        .iter()
        .filter(|l| l.receiver >= clusters && l.source >= clusters && chosen(l))
        .collect();
    let mut sum = Attack::default();
    for (index, link) in chosen.iter().enumerate() {
        let [receiver, source] =
            [link.receiver, link.source].map(|id| leaf_of(&elements[(id - clusters) as usize]));
        // A few links very closely, all others for a moment. Segments that graze an edge come in crowds, on few
        // links: their share is that of many links, not of the few that are looked at closely.
        let count = if index % (chosen.len() / 128).max(1) == 0 { 2000 } else { 128 };
        sum += attack(&case.hierarchy, &judge, &receiver, &source, Claim::Clear, count, &mut numbers);
    }
    (chosen.len(), sum)
}

#[test]
fn links_certified_visible_are_never_blocked() {
    let mut by_adaptive = 0;
    for name in OWN_SCENES {
        let case = Case::load(name);
        for strategy in [Strategy::Shaft, Strategy::Adaptive] {
            let solution = case.solve(&case.fallback(), &options(strategy));
            let (links, found) = attack_links(&case, &solution, |l| l.class == LinkClass::CertifiedVisible);
            println!("{name} {}: {links} links certified visible, {found:?}", strategy.name());
            assert_eq!(found.against, 0, "{name} {}: {found:?}", strategy.name());
            assert!(strategy == Strategy::Adaptive || links > 100, "{name}: {links} proofs");
            by_adaptive += if strategy == Strategy::Adaptive { links } else { 0 };
        }
    }
    assert!(by_adaptive > 100, "{by_adaptive} proofs that the light needed");
}

/// What random pairs were proved to be, and what segments said: visible, then invisible.
#[derive(Debug, Default)]
struct Proofs {
    proved: [u32; 2],
    tried: [Attack; 2],
}

pub(crate) fn end(leaf: &Leaf) -> NodeEnd<'_> {
    NodeEnd::Element { polygon: &leaf.polygon, plane: leaf.plane, facet: leaf.facet }
}

/// A pair about to be split that takes nothing over; `root` is all candidates.
pub(crate) fn pair<'a>(
    receiver: &'a NodeEnd<'a>,
    source: &'a NodeEnd<'a>,
    root: &'a CandidateSet,
) -> Pair<'a> {
    Pair {
        receiver,
        source,
        seed: 7,
        inherited: Inheritance { candidates: root, blocker: NO_FACET },
        subdivided: true,
        importance: 1.0,
        prominence: 1.0,
        brightness: None,
    }
}

/// What is found out about such a pair.
fn classified(
    tester: &Tester<'_>,
    worker: &mut Worker,
    receiver: &NodeEnd<'_>,
    source: &NodeEnd<'_>,
) -> Verdict {
    let (verdict, narrowed) = tester.classify(worker, &pair(receiver, source, &CandidateSet::root()));
    narrowed.into_iter().for_each(|set| worker.recycle(set));
    verdict
}

/// What a proof claims.
fn claim(hierarchy: &Hierarchy, verdict: &Verdict) -> Claim {
    match verdict.class {
        Class::Visible => Claim::Clear,
        _ => Claim::BlockedAt(hierarchy.facets[verdict.blocker as usize].plane),
    }
}

/// Classifies random pairs of elements by the shaft and by single blockers of one scene, and attacks what is
/// proved with the rays of `judge`.
fn prove(case: &Case, judge: &BruteTracer, pairs: usize) -> Proofs {
    let tracer = case.fallback();
    let solution = case.solve(&tracer, &options(Strategy::Shaft));
    let elements = elements(&case.hierarchy, &solution.forest);
    let visibility = VisibilityOptions { strategy: Strategy::Shaft, rays: 4, certify: false };
    let tester = Tester::new(&case.hierarchy, &tracer, visibility);
    let (mut worker, mut numbers) = (Worker::default(), Numbers(31));
    let mut found = Proofs::default();
    for _ in 0..pairs {
        let [r, s] = std::array::from_fn(|_| &elements[numbers.below(elements.len())]);
        let (receiver, source) = (leaf_of(r), leaf_of(s));
        if !receiver.faces(&source) {
            continue;
        }
        let verdict = classified(&tester, &mut worker, &end(&receiver), &end(&source));
        if verdict.certified {
            let is_blocked = verdict.class == Class::Invisible;
            assert_ne!(verdict.class, Class::Partial, "nothing proves that a pair is partly visible");
            found.proved[usize::from(is_blocked)] += 1;
            found.tried[usize::from(is_blocked)] += attack(
                &case.hierarchy,
                judge,
                &receiver,
                &source,
                claim(&case.hierarchy, &verdict),
                50,
                &mut numbers,
            );
        }
    }
    found
}

/// Random pairs of elements, proved or not by the shaft and by single blockers.
#[test]
fn pairs_proved_visible_or_invisible_are() {
    for name in OWN_SCENES {
        let case = Case::load(name);
        let found = prove(&case, &BruteTracer::new(&case.hierarchy.mesh), 20_000);
        println!("{name}: {found:?}");
        assert!(found.proved.iter().all(|&count| count > 100), "{name}: {found:?}");
        for tried in found.tried {
            assert_eq!(tried.refuted, 0, "{name}: {found:?}");
            assert!(tried.against <= tried.segments / 10_000, "{name}: {found:?}");
        }
    }
}

/// A side of some facet below a node.
fn leaf_below(hierarchy: &Hierarchy, node: u32, numbers: &mut Numbers) -> Leaf {
    let node = &hierarchy.nodes[node as usize];
    let facet = node.first + numbers.below((node.end - node.first) as usize) as u32;
    let (polygon, plane) = (hierarchy.polygon(facet), hierarchy.facets[facet as usize].plane);
    match numbers.below(2) {
        0 => Leaf { polygon, plane, facet },
        _ => Leaf { polygon: polygon.flipped(), plane: plane.flipped(), facet },
    }
}

/// As [`prove`], with a cluster at one end and a cluster or an element at the other: what is proved of the whole
/// holds for all facets in it.
fn prove_clusters(case: &Case, judge: &BruteTracer, pairs: usize) -> Proofs {
    let (hierarchy, tracer) = (&case.hierarchy, case.fallback());
    let solution = case.solve(&tracer, &options(Strategy::Shaft));
    let elements = elements(hierarchy, &solution.forest);
    let clusters: Vec<u32> =
        (0..hierarchy.nodes.len() as u32).filter(|&n| !hierarchy.nodes[n as usize].is_leaf()).collect();
    let visibility = VisibilityOptions { strategy: Strategy::Shaft, rays: 4, certify: false };
    let tester = Tester::new(hierarchy, &tracer, visibility);
    let (mut worker, mut numbers) = (Worker::default(), Numbers(41));
    let mut found = Proofs::default();
    for index in 0..pairs {
        let receiver = clusters[numbers.below(clusters.len())];
        let (other, element) = (clusters[numbers.below(clusters.len())], numbers.below(elements.len()));
        let element = leaf_of(&elements[element]);
        let source = if index % 2 == 0 { NodeEnd::Cluster(other) } else { end(&element) };
        let verdict = classified(&tester, &mut worker, &NodeEnd::Cluster(receiver), &source);
        if !verdict.certified {
            continue;
        }
        let is_blocked = verdict.class == Class::Invisible;
        found.proved[usize::from(is_blocked)] += 1;
        for _ in 0..8 {
            let from = leaf_below(hierarchy, receiver, &mut numbers);
            let to = if index % 2 == 0 {
                leaf_below(hierarchy, other, &mut numbers)
            } else {
                Leaf { polygon: element.polygon, plane: element.plane, facet: element.facet }
            };
            if from.facet != to.facet && from.faces(&to) {
                found.tried[usize::from(is_blocked)] +=
                    attack(hierarchy, judge, &from, &to, claim(hierarchy, &verdict), 50, &mut numbers);
            }
        }
    }
    found
}

#[test]
fn clusters_proved_visible_or_invisible_are() {
    let mut all = [0; 2];
    for name in OWN_SCENES {
        let case = Case::load(name);
        let found = prove_clusters(&case, &BruteTracer::new(&case.hierarchy.mesh), 20_000);
        println!("{name}: {found:?}");
        for (sum, (proved, tried)) in all.iter_mut().zip(found.proved.iter().zip(found.tried)) {
            *sum += proved;
            assert_eq!(tried.refuted, 0, "{name}: {found:?}");
            assert!(tried.against <= tried.segments / 10_000, "{name}: {found:?}");
        }
    }
    assert!(all.iter().all(|&count| count > 100), "{all:?} proofs");
}

/// The check itself: where the boxes of the scene are no candidates of any shaft, pairs are proved visible
/// that are not; where a board is believed in that is not there, pairs are proved invisible that are not.
#[test]
fn a_dropped_candidate_and_an_invented_one_are_noticed() {
    let room = || {
        let mut room = Rectangles::new("room");
        let grey = room.material(0.5, 0.0);
        let lamp = room.material(0.0, 10.0);
        room.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
        room.quad([[1.5, 1.0, 2.4], [1.5, 2.0, 2.4], [2.5, 2.0, 2.4], [2.5, 1.0, 2.4]], lamp);
        (room, grey)
    };
    let with_board = || {
        let (mut room, grey) = room();
        room.quad([[0.5, 0.5, 1.2], [3.5, 0.5, 1.2], [3.5, 2.5, 1.2], [0.5, 2.5, 1.2]], grey);
        Case::of(room.finish(), false)
    };
    let without_board = || Case::of(room().0.finish(), false);
    for (believed, real, is_blocked) in
        [(without_board(), with_board(), false), (with_board(), without_board(), true)]
    {
        // Facets are numbered anew: the judge must know the ends by the numbers of those who believe.
        let judge = BruteTracer::new(&renumbered(&real, &believed));
        let found = prove(&believed, &judge, 20_000);
        println!("board there: {}, {found:?}", !is_blocked);
        let tried = found.tried[usize::from(is_blocked)];
        assert!(
            found.proved[usize::from(is_blocked)] > 100 && tried.refuted > tried.segments / 10,
            "{found:?}"
        );
    }
}

/// The mesh of one case, its facets numbered like those in the same place in another; others come last.
fn renumbered(real: &Case, like: &Case) -> TraceMesh {
    let others = like.hierarchy.facets.len() as u32;
    let center = |case: &Case, facet: u32| case.hierarchy.polygon(facet).center();
    let mut mesh = real.hierarchy.mesh.clone();
    for number in &mut mesh.facet_of_triangle {
        let own = center(real, *number);
        *number = (0..others).find(|&f| center(like, f).distance(own) < 1e-6).unwrap_or(others);
    }
    mesh
}

/// The check itself: links that are partly blocked, passed off as proved visible, have to be found.
#[test]
fn a_wrong_proof_is_noticed() {
    let case = Case::load("cornell-box");
    let solution = case.solve(&case.fallback(), &options(Strategy::Shaft));
    let (links, found) = attack_links(&case, &solution, |l| l.class == LinkClass::Partial);
    println!("{links} partial links passed off as proved: {found:?}");
    assert!(found.refuted > found.segments / 10, "{found:?}");
}
