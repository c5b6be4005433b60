//! The complete test of a pair.

use super::detail::Answer;
use super::rays::{Quota, RayCount, Sighting};
use super::steps::Step;
use super::worker::Worker;
use super::{NodeEnd, Strategy, VisibilityOptions};
use crate::hierarchy::{Hierarchy, Interval};
use crate::math::Plane;
use crate::shaft::{
    MOST_FOUND, Shaft, blocks_all, blocks_together, has_facet_in, intervals_of, large_facets_on, walls_hide,
};
use crate::tracer::{BruteTracer, Candidates, NO_FACET, Tracer};
use glam::DVec3;

/// Pairs of this importance are not believed to be clear or blocked because rays are, unless both ends are
/// elements: near parts of clusters exchange most of the light, and rays spread evenly over them rarely join such.
const MATTERS: f64 = 1.0;

/// Rays that have to agree to be believed about two elements, for each unit of importance and each ray of a link.
/// Of n that agree the next disagrees with a chance of 1 / (n + 2) (rule of succession): with 16 rays for a link,
/// 1/16 of what a link may get wrong is at risk.
const RAYS_PER_IMPORTANCE: f64 = 1.0;

/// The fewest and the most such rays, for each ray of a link. Links are dropped as blocked by no fewer than the fewest:
/// as many as a link that draws a shadow gets, so that it is never weighed again by fewer than it was made with.
const BELIEVED_RAYS: [u32; 2] = [4, 16];

/// How many times the rays links that draw a shadow get.
const SHADOW_RAYS: f64 = 4.0;

/// Facets at least this large, by their radius and that of the smaller end, are tried as blockers: alone they
/// have to be larger, together with others in their plane they need not.
const LARGE: f64 = 0.5;

/// Node tests `adaptive` may spend on one shaft.
const ADAPTIVE_ALLOWANCE: u64 = 512;

/// Whether light passes between two nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Nothing in between.
    Visible,
    /// Nothing gets through.
    Invisible,
    /// Something gets through.
    Partial,
}

/// The answer for one pair.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// The class.
    pub class: Class,
    /// Proved, not sampled.
    pub certified: bool,
    /// Descendants have the same class and need no test.
    pub inheritable: bool,
    /// The rays agreed, but too much power rests on them: look closer.
    pub doubtful: bool,
    /// Share of the light that gets through; 1 or 0 when proved, above 1 where a source is brighter than
    /// its mean where it is seen.
    pub fraction: f32,
    /// A facet that blocked, to be tried first by the children.
    pub blocker: u32,
}

/// Facets that may block, as hierarchy nodes and as the intervals a tracer's filter takes.
#[derive(Clone, Debug, Default)]
pub struct CandidateSet {
    /// Ascending node ids.
    pub nodes: Vec<u32>,
    pub(super) intervals: Vec<Interval>,
}

impl CandidateSet {
    /// The whole scene.
    pub fn root() -> CandidateSet {
        CandidateSet { nodes: vec![0], intervals: Vec::new() }
    }

    /// For the tracer; the whole scene needs no list.
    fn for_rays(&self) -> Candidates<'_> {
        if self.nodes == [0] { Candidates::All } else { Candidates::Only(&self.intervals) }
    }
}

/// What a pair takes over from its ancestors.
#[derive(Clone, Copy, Debug)]
pub struct Inheritance<'a> {
    /// What is left in the ancestor's shaft.
    pub candidates: &'a CandidateSet,
    /// The facet that blocked the ancestor, or [`NO_FACET`].
    pub blocker: u32,
}

/// How bright a source is, point by point.
pub trait Brightness {
    /// Sum of the kernels of the rays, times the exitance where they end, in any unit; may put the rays in another
    /// order.
    fn sum(&self, sightings: &mut [Sighting]) -> f64;

    /// Mean exitance, in the same unit; `None` for a cluster, which sends by direction.
    fn mean(&self) -> Option<f64>;
}

/// One pair under test.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    /// The node that is lit.
    pub receiver: &'a NodeEnd<'a>,
    /// The node that lights it.
    pub source: &'a NodeEnd<'a>,
    /// Fixes the sample points, such as [`hash_pair`](crate::math::hash_pair).
    pub seed: u64,
    /// What it takes over from its ancestors.
    pub inherited: Inheritance<'a>,
    /// About to be split: its class is wanted, its fraction is not.
    pub subdivided: bool,
    /// Power of the link over the threshold of refinement.
    pub importance: f64,
    /// Irradiance of the link over the threshold of refinement.
    pub prominence: f64,
    /// Rays count as much as the source is bright where they end; `None` for a uniform source.
    pub brightness: Option<&'a dyn Brightness>,
}

impl Pair<'_> {
    fn joins_elements(&self) -> bool {
        [self.receiver, self.source].iter().all(|end| matches!(end, NodeEnd::Element { .. }))
    }
}

/// Tests pairs of nodes of one hierarchy.
pub struct Tester<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    tracer: &'a dyn Tracer,
    listed: Option<BruteTracer>,
    options: VisibilityOptions,
    is_detailed: bool,
}

impl<'a> Tester<'a> {
    /// A tester that casts its rays with `tracer`; `all` walks the list of triangles instead.
    pub fn new(hierarchy: &'a Hierarchy, tracer: &'a dyn Tracer, options: VisibilityOptions) -> Tester<'a> {
        let listed = (options.strategy == Strategy::All).then(|| BruteTracer::new(&hierarchy.mesh));
        Tester { hierarchy, tracer, listed, options, is_detailed: false }
    }

    /// The same, with workers that keep a [`Detail`](super::Detail), if `is_detailed`.
    pub fn detailed(self, is_detailed: bool) -> Self {
        Tester { is_detailed, ..self }
    }

    /// For one task.
    pub fn worker(&self) -> Worker {
        Worker::new(self.is_detailed)
    }

    /// Into how many halves a node is smaller than the scene, by its radius.
    pub fn level(&self, radius: f64) -> usize {
        let times = self.hierarchy.nodes[0].bounds.radius() / radius.max(f64::MIN_POSITIVE);
        times.max(1.0).log2() as usize
    }

    /// How visibility is decided.
    pub fn options(&self) -> &VisibilityOptions {
        &self.options
    }

    pub(super) fn tracer_for_rays(&self) -> &dyn Tracer {
        self.listed.as_ref().map_or(self.tracer, |listed| listed)
    }

    /// Classifies a pair.
    ///
    /// The second result, when there is one, is the narrowed candidate set for the children; recycle it
    /// when they are done.
    pub fn classify(&self, worker: &mut Worker, pair: &Pair<'_>) -> (Verdict, Option<CandidateSet>) {
        let begun = worker.begin(pair.seed);
        worker.counters.pairs_tested += 1;
        let (mut verdict, narrowed) = match self.options.strategy {
            Strategy::All | Strategy::Root => (self.by_rays(worker, pair, Candidates::All, None), None),
            Strategy::Shaft => self.shaft_first(worker, pair),
            Strategy::Adaptive => self.rays_first(worker, pair),
            Strategy::Sampled => {
                let count = self.options.rays;
                let quota = Quota { count, if_blocked: count, until_mixed: false };
                let met = self.cast(worker, pair, quota, Candidates::All, None);
                (Verdict { inheritable: false, ..verdict_of(&met) }, None)
            }
        };
        if self.options.certify {
            verdict.inheritable = verdict.certified;
            verdict.doubtful |=
                !verdict.certified && verdict.class != Class::Partial && pair.importance >= MATTERS;
        }
        let cast = worker.counters.rays_cast - begun.counters.rays_cast;
        worker.counters.rays_avoided += (self.options.rays as u64).saturating_sub(cast);
        worker.end(&begun, |counters| {
            let is_fused = counters.fused_blockers > begun.counters.fused_blockers;
            (answer_of(&verdict, is_fused), self.level_of(pair))
        });
        (verdict, narrowed)
    }

    /// The level of the larger end.
    fn level_of(&self, pair: &Pair<'_>) -> usize {
        let radii = [pair.receiver, pair.source].map(|end| end.radius(self.hierarchy));
        self.level(radii[0].max(radii[1]))
    }

    /// Share of the light that gets through a pair, by rays over the whole scene, whatever the strategy.
    pub fn weigh(&self, worker: &mut Worker, pair: &Pair<'_>) -> f32 {
        let begun = worker.begin(pair.seed);
        let met = self.cast(worker, pair, self.weighing(pair), Candidates::All, None);
        worker.end(&begun, |_| (Answer::WeighedAgain, self.level_of(pair)));
        met.fraction
    }

    /// The paper's order: shaft, cull, single blocker, rays over the candidates.
    fn shaft_first(&self, worker: &mut Worker, pair: &Pair<'_>) -> (Verdict, Option<CandidateSet>) {
        let (shaft, set) = self.cull(worker, pair, u64::MAX);
        if set.nodes.is_empty() {
            worker.recycle(set);
            return (Verdict::proved(Class::Visible, NO_FACET), None);
        }
        let leaves = set.nodes.iter().map(|&n| &self.hierarchy.nodes[n as usize]).filter(|n| n.is_leaf());
        if let Some(blocker) = self.blocker_among(worker, pair, leaves.map(|n| n.first)) {
            worker.recycle(set);
            return (Verdict::proved(Class::Invisible, blocker), None);
        }
        (self.by_rays(worker, pair, set.for_rays(), Some(&shaft)), Some(set))
    }

    /// Rays first, proofs only where they will be inherited and matter.
    fn rays_first(&self, worker: &mut Worker, pair: &Pair<'_>) -> (Verdict, Option<CandidateSet>) {
        if pair.inherited.blocker != NO_FACET && self.is_blocked_by(worker, pair, pair.inherited.blocker) {
            return (Verdict::proved(Class::Invisible, pair.inherited.blocker), None);
        }
        let candidates = pair.inherited.candidates.for_rays();
        if !pair.subdivided {
            let met = self.cast(worker, pair, self.weighing(pair), candidates, None);
            return (verdict_of(&met), None);
        }
        let met = self.cast(worker, pair, self.classifying(pair), candidates, None);
        let mut verdict = verdict_of(&met);
        if verdict.class == Class::Partial {
            return (verdict, None);
        }
        // What is lost (or gained) by each pair that is believed adds up over thousands of them.
        verdict.doubtful = met.cast() == 0 || self.believed_rays(pair).is_none();
        verdict.inheritable = !verdict.doubtful;
        if verdict.inheritable {
            return (verdict, None);
        }
        match verdict.class {
            Class::Invisible if self.is_hidden_by_walls(worker, pair) => {
                (Verdict::proved(Class::Invisible, NO_FACET), None)
            }
            Class::Invisible => {
                let (found, count) = self.large_facets_between(worker, pair);
                let found = &found[..count];
                let largest = found.first().copied();
                verdict.blocker = largest.unwrap_or(NO_FACET);
                let alone = found.iter().copied().find(|&f| self.is_blocked_by(worker, pair, f));
                let proof =
                    alone.or_else(|| largest.filter(|&f| self.is_blocked_in_plane_of(worker, pair, f)));
                match proof {
                    Some(blocker) => (Verdict::proved(Class::Invisible, blocker), None),
                    None => (verdict, None),
                }
            }
            _ => {
                let (_, set) = self.cull(worker, pair, ADAPTIVE_ALLOWANCE);
                if set.nodes.is_empty() {
                    worker.recycle(set);
                    return (Verdict::proved(Class::Visible, NO_FACET), None);
                }
                (verdict, Some(set))
            }
        }
    }

    /// What blocks all segments alone blocks each of them, so it is among the facets on any one: a single
    /// blocker is found without a shaft, too.
    fn by_rays(
        &self,
        worker: &mut Worker,
        pair: &Pair<'_>,
        candidates: Candidates<'_>,
        shaft: Option<&Shaft>,
    ) -> Verdict {
        let quota = if pair.subdivided { self.classifying(pair) } else { self.weighing(pair) };
        let met = self.cast(worker, pair, quota, candidates, shaft);
        let verdict = verdict_of(&met);
        if verdict.class == Class::Invisible {
            let on_one = self.facets_on_one(worker).into_iter();
            if let Some(blocker) = self.blocker_among(worker, pair, on_one) {
                return Verdict::proved(Class::Invisible, blocker);
            }
        }
        Verdict { inheritable: pair.joins_elements() && met.cast() > 0 && !met.is_mixed(), ..verdict }
    }

    /// For the class of a pair: stops when two rays disagree.
    fn classifying(&self, pair: &Pair<'_>) -> Quota {
        // Where agreement alone decides what is inherited, all rays have to agree.
        let count = match self.options.strategy {
            Strategy::Adaptive => self.believed_rays(pair).unwrap_or(self.options.rays),
            _ => self.options.rays,
        };
        Quota { count, if_blocked: count, until_mixed: true }
    }

    /// How many rays have to agree to be believed without a proof; `None` where too much rests on them. Where only
    /// proofs are inherited, proofs are tried as soon as a pair matters.
    fn believed_rays(&self, pair: &Pair<'_>) -> Option<u32> {
        let rays = self.options.rays;
        if !pair.joins_elements() || self.options.certify {
            return (pair.importance < MATTERS).then_some(rays * SHADOW_RAYS as u32);
        }
        let [fewest, most] = BELIEVED_RAYS.map(|times| times * rays);
        let wanted = pair.importance * RAYS_PER_IMPORTANCE * rays as f64;
        (wanted <= most as f64).then_some((wanted as u32).next_multiple_of(rays).clamp(fewest, most))
    }

    /// For the fraction of a link: more rays where noise would show.
    fn weighing(&self, pair: &Pair<'_>) -> Quota {
        let count = (self.options.rays as f64 * pair.prominence.clamp(1.0, SHADOW_RAYS)) as u32;
        // A link that is all blocked is dropped for good.
        let if_blocked = match self.options.strategy {
            Strategy::Adaptive => count.max(BELIEVED_RAYS[0] * self.options.rays),
            _ => count,
        };
        Quota { count, if_blocked, until_mixed: false }
    }

    /// Facets between the middles of a pair that are large enough to block it, perhaps with others.
    fn large_facets_between(&self, worker: &mut Worker, pair: &Pair<'_>) -> ([u32; MOST_FOUND], usize) {
        let middles = [pair.receiver, pair.source].map(|end| end.center(self.hierarchy));
        let radii = [pair.receiver, pair.source].map(|end| end.radius(self.hierarchy));
        let found = large_facets_on(self.hierarchy, middles, LARGE * radii[0].min(radii[1]));
        worker.lap(Step::Blockers);
        found
    }

    /// Builds the pair's shaft and narrows the inherited candidates.
    fn cull(&self, worker: &mut Worker, pair: &Pair<'_>, allowance: u64) -> (Shaft, CandidateSet) {
        let shaft =
            Shaft::between(pair.receiver.shaft_end(self.hierarchy), pair.source.shaft_end(self.hierarchy));
        worker.lap(Step::Shafts);
        let mut set = worker.empty_set();
        let culled = shaft.cull(self.hierarchy, &pair.inherited.candidates.nodes, allowance, &mut set.nodes);
        intervals_of(self.hierarchy, &set.nodes, &mut set.intervals);
        worker.lap(Step::Culling);
        worker.note_candidates(culled.facets);
        let counters = &mut worker.counters;
        counters.shafts_built += 1;
        counters.nodes_tested += culled.nodes_tested;
        if set.nodes.is_empty() {
            counters.empty_shafts += 1;
        } else {
            counters.filled_shafts += 1;
            counters.candidates += culled.facets;
        }
        (shaft, set)
    }

    /// The first of `facets` that blocks the pair alone, or else together with what lies in its plane.
    fn blocker_among(
        &self,
        worker: &mut Worker,
        pair: &Pair<'_>,
        facets: impl Iterator<Item = u32> + Clone,
    ) -> Option<u32> {
        let alone = facets.clone().find(|&facet| self.is_blocked_by(worker, pair, facet));
        alone.or_else(|| facets.clone().find(|&facet| self.is_blocked_in_plane_of(worker, pair, facet)))
    }

    /// Whether a facet blocks a pair alone.
    fn is_blocked_by(&self, worker: &mut Worker, pair: &Pair<'_>, facet: u32) -> bool {
        let plane = &self.hierarchy.facets[facet as usize].plane;
        let is_blocked = self.with_corners(pair, |receiver, source| {
            blocks_all(&self.hierarchy.polygon(facet), plane, receiver, source)
        }) && self.hides(pair, plane);
        worker.lap(Step::Blockers);
        worker.counters.single_blockers += u64::from(is_blocked);
        is_blocked
    }

    /// Whether the facets in the plane of one block a pair together.
    fn is_blocked_in_plane_of(&self, worker: &mut Worker, pair: &Pair<'_>, facet: u32) -> bool {
        let plane = &self.hierarchy.facets[facet as usize].plane;
        let is_blocked = self
            .with_corners(pair, |receiver, source| blocks_together(self.hierarchy, facet, receiver, source))
            && self.hides(pair, plane);
        worker.lap(Step::Blockers);
        worker.counters.fused_blockers += u64::from(is_blocked);
        is_blocked
    }

    /// Whether the walls of rooms hide a pair.
    fn is_hidden_by_walls(&self, worker: &mut Worker, pair: &Pair<'_>) -> bool {
        let is_hidden = self.with_corners(pair, |receiver, source| {
            let receiver = pair.receiver.occupant(self.hierarchy, receiver);
            walls_hide(self.hierarchy, [receiver, pair.source.occupant(self.hierarchy, source)])
        });
        worker.lap(Step::Blockers);
        worker.counters.fused_blockers += u64::from(is_hidden);
        is_hidden
    }

    fn with_corners(&self, pair: &Pair<'_>, test: impl FnOnce(&[DVec3], &[DVec3]) -> bool) -> bool {
        let (mut a, mut b) = ([DVec3::ZERO; 8], [DVec3::ZERO; 8]);
        let a_count = pair.receiver.shaft_end(self.hierarchy).corners(&mut a);
        let b_count = pair.source.shaft_end(self.hierarchy).corners(&mut b);
        test(&a[..a_count], &b[..b_count])
    }

    /// Whether nothing of a pair lies in the plane of its occluder, where it sees past it.
    fn hides(&self, pair: &Pair<'_>, plane: &Plane) -> bool {
        [pair.receiver, pair.source].iter().all(|end| match end {
            NodeEnd::Cluster(node) => !has_facet_in(self.hierarchy, *node, plane),
            NodeEnd::Element { .. } => true,
        })
    }
}

impl Verdict {
    fn proved(class: Class, blocker: u32) -> Verdict {
        let fraction = if class == Class::Visible { 1.0 } else { 0.0 };
        Verdict { class, certified: true, inheritable: true, doubtful: false, fraction, blocker }
    }
}

/// What settled a pair that was tested; `is_fused` when it took several blockers.
fn answer_of(verdict: &Verdict, is_fused: bool) -> Answer {
    match (verdict.class, verdict.certified) {
        (Class::Visible, true) => Answer::EmptyShaft,
        (Class::Visible, false) => Answer::RaysClear,
        (Class::Invisible, true) if is_fused => Answer::FusedBlockers,
        (Class::Invisible, true) => Answer::SingleBlocker,
        (Class::Invisible, false) => Answer::RaysBlocked,
        (Class::Partial, _) => Answer::RaysDisagree,
    }
}

fn verdict_of(met: &RayCount) -> Verdict {
    let class = match (met.clear, met.blocked) {
        (0, 1..) => Class::Invisible,
        (_, 0) => Class::Visible,
        _ => Class::Partial,
    };
    Verdict {
        class,
        certified: false,
        inheritable: class != Class::Partial,
        doubtful: false,
        fraction: met.fraction,
        blocker: NO_FACET,
    }
}
