//! Refinement: pairs are subdivided until one number for each is good enough, and their visibility is
//! decided on the way down. [HSA91] [SAG94], paper §2.4 and §3.

use super::estimate::{Estimate, Party, estimate, estimate_of_link, refined_factor};
use super::forest::Forest;
use super::links::{Blocked, Link, LinkClass, Pairs};
use super::quarters::Quarters;
use super::shading::Shading;
use super::solve::Record;
use super::transport::Light;
use super::work::WorkDone;
use crate::hierarchy::Hierarchy;
use crate::math::hash_pair;
use crate::memory::give_back_freed;
use crate::progress::{Progress, Work};
use crate::tracer::NO_FACET;
use crate::visibility::{
    Answer, CandidateSet, Class, Detail, Inheritance, Pair, Strategy, Tester, VisibilityCounters, Worker,
};
use rayon::prelude::*;
use std::ops::AddAssign;

/// Pairs that carry this many thresholds of power have enough below them to be worth sharing out.
const PARALLEL_IMPORTANCE: f64 = 64.0;

/// Links are refined in no more parts than this, and so are blocked pairs, each part with counters of its own; threads
/// share out a part's work, too.
const MOST_PARTS: usize = 4096;

/// Fewer pairs than this are not worth a part.
const LEAST_IN_PART: usize = 256;

/// Pairs the refinement ended at and that are not stored, and the work it took.
#[derive(Clone, Debug, Default)]
pub struct RefineCounters {
    /// Pairs found invisible.
    pub invisible: u64,
    /// Of those, proved.
    pub certified_invisible: u64,
    /// Work of the visibility tests.
    pub visibility: VisibilityCounters,
    /// Where that goes, if it was asked for.
    pub detail: Option<Box<Detail>>,
}

impl AddAssign for RefineCounters {
    fn add_assign(&mut self, other: RefineCounters) {
        self.invisible += other.invisible;
        self.certified_invisible += other.certified_invisible;
        self.visibility += other.visibility;
        Detail::merge(&mut self.detail, other.detail);
    }
}

/// When a pair is good enough, relative to the irradiance where the light arrives: a dim room behind a
/// door deserves the care of the bright one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thresholds {
    /// How many times coarser than the thresholds of the end these are.
    pub(super) coarseness: f64,
    /// Power a link may get wrong, as the local area on which the receiver's irradiance is that power.
    pub(super) area: f64,
    /// Irradiance a link may get wrong on receivers larger than `min_size`, as a share of the receiver's.
    pub(super) contrast: f64,
    /// For power, receivers darker than this count as this bright.
    pub(super) dark: f64,
    /// For irradiance, receivers darker than this count as this bright.
    pub(super) black: f64,
    /// Elements with no edge longer than this are not split, local length.
    pub(super) min_size: f64,
}

/// The thresholds for one receiver. Powers in local areas.
#[derive(Clone, Copy, Debug)]
struct Limits {
    power: f64,
    irradiance: f64,
}

/// Refines links with the light of the last iteration.
pub(super) struct Refiner<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
    pub(super) tester: &'a Tester<'a>,
    pub(super) thresholds: Thresholds,
    pub(super) record: Record,
    pub(super) progress: &'a dyn Progress,
}

/// What a pair knows from above.
#[derive(Clone, Copy)]
struct PairState<'a> {
    /// Fully visible, and whether that is proved.
    visible: Option<bool>,
    inheritance: Inheritance<'a>,
}

/// Pairs and counts of one task.
struct Output {
    pairs: Pairs,
    counters: RefineCounters,
    done: WorkDone,
    worker: Worker,
}

impl Output {
    fn absorb(&mut self, other: Output) {
        self.pairs.absorb(other.pairs);
        self.counters += other.counters;
        self.worker.absorb(other.worker);
        self.done.absorb(other.done);
    }

    /// Without room to grow or to work in: parts wait for each other until the last is done.
    fn closed(mut self) -> Output {
        self.pairs.shrink();
        self.done.join();
        self.worker = self.worker.closed();
        self
    }
}

/// Whether a cluster lights itself.
fn is_same(receiver: &Party, source: &Party) -> bool {
    matches!((receiver, source), (Party::Cluster(a), Party::Cluster(b)) if a == b)
}

/// Whether both are of one facet, which does not see itself.
fn share_facet(a: &Party, b: &Party) -> bool {
    match (a, b) {
        (Party::Element { piece: a, .. }, Party::Element { piece: b, .. }) => a.side.facet == b.side.facet,
        _ => false,
    }
}

/// The best factor for a link that is kept.
fn factor_to_keep(figures: &Estimate, receiver: &Party, source: &Party) -> f32 {
    let refined = match (receiver, source) {
        (Party::Element { piece: r, .. }, Party::Element { piece: s, .. }) if figures.rough => {
            refined_factor(r, s)
        }
        _ => None,
    };
    refined.unwrap_or(figures.factor) as f32
}

/// How the parts of a source share, if both are elements.
fn quarters(receiver: &Party, source: &Party, forest: &Forest) -> Quarters {
    match (receiver, source) {
        (Party::Element { piece: r, .. }, Party::Element { piece: s, .. }) => Quarters::of(r, s, forest),
        _ => Quarters::UNIFORM,
    }
}

/// Which end to split: of a cluster that lights itself, both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Split {
    Receiver,
    Source,
    Both,
}

impl<'a> Refiner<'a> {
    /// Splits every pair that is not good enough any more; the others stay as they are. The order of
    /// the result depends on the input alone.
    pub(super) fn refine(&self, Pairs { links, blocked }: Pairs) -> (Pairs, RefineCounters, WorkDone) {
        // What the light of the iterations before was in would stay resident besides all that is made here.
        give_back_freed();
        let root = CandidateSet::root();
        let mut parts = self.revisited(links, |link, output| {
            if self.stays_or_is_divided(link, &root, output) {
                output.pairs.links.push(*link);
            }
        });
        parts.extend(self.revisited(blocked, |blocked, output| {
            if self.stays_or_is_divided(&blocked.as_link(), &root, output) {
                output.pairs.blocked.push(*blocked);
            }
        }));
        // At its largest, memory holds the pairs twice: not the old ones as well, nor room to grow.
        let mut all = self.output();
        all.pairs.links.reserve_exact(parts.iter().map(|part| part.pairs.links.len()).sum());
        all.pairs.blocked.reserve_exact(parts.iter().map(|part| part.pairs.blocked.len()).sum());
        parts.into_iter().for_each(|part| all.absorb(part));
        // The parts lay in the heaps of all threads, where nothing as large as what comes next finds room.
        give_back_freed();
        (all.counters.visibility, all.counters.detail) = all.worker.into_counted();
        (all.pairs, all.counters, all.done)
    }

    /// What becomes of `pairs`, as parts in their order; the memory of the pairs is free afterwards.
    fn revisited<T: Sync>(&self, pairs: Vec<T>, revisit: impl Fn(&T, &mut Output) + Sync) -> Vec<Output> {
        let size = pairs.len().div_ceil(MOST_PARTS).max(LEAST_IN_PART);
        let parts = pairs.par_chunks(size).with_max_len(1).map(|chunk| {
            let _work = Work::begin(self.progress, "refine");
            let mut output = self.output();
            chunk.iter().for_each(|pair| revisit(pair, &mut output));
            self.progress.advance(chunk.len() as u64);
            output.closed()
        });
        parts.collect()
    }

    fn output(&self) -> Output {
        Output {
            pairs: Pairs::default(),
            counters: RefineCounters::default(),
            done: WorkDone::default(),
            worker: self.tester.worker(),
        }
    }

    /// Weighs the partial links from clusters again, with the present light. What is bright in a cluster
    /// when its links are made lies open to the lamps; light that arrives inside later is more hidden, but
    /// the old weight would count it as equally visible.
    pub(super) fn weigh_again(&self, links: &mut [Link]) -> (RefineCounters, WorkDone) {
        let mut counters = RefineCounters::default();
        let clusters = self.hierarchy.nodes.len() as u32;
        let root = CandidateSet::root();
        let inherited = Inheritance { candidates: &root, blocker: NO_FACET };
        let counted: Vec<(Worker, WorkDone)> = links
            .par_chunks_mut(256)
            .map(|chunk| {
                let _work = Work::begin(self.progress, "weigh");
                let (mut worker, mut done) = (self.tester.worker(), WorkDone::default());
                for link in chunk.iter_mut().filter(|l| l.class == LinkClass::Partial && l.source < clusters)
                {
                    let (receiver, source) = (self.party(link.receiver), self.party(link.source));
                    if let Some(figures) = estimate(&receiver, &source, self.hierarchy, self.light) {
                        let before = worker.counters;
                        link.visibility =
                            self.with_pair(&receiver, &source, &figures, inherited, false, |pair| {
                                self.tester.weigh(&mut worker, pair)
                            });
                        let work = worker.counters.work_since(&before);
                        link.add_work(work);
                        self.note(&mut done, link.receiver, work);
                    }
                }
                done.join();
                self.progress.advance(chunk.len() as u64);
                (worker.closed(), done)
            })
            .collect();
        let (mut all, mut all_done) = (self.tester.worker(), WorkDone::default());
        for (worker, done) in counted {
            all.absorb(worker);
            all_done.absorb(done);
        }
        (counters.visibility, counters.detail) = all.into_counted();
        (counters, all_done)
    }

    /// Whether a link stays as it is. Else it is taken up again with the present light, and what becomes of it is in
    /// the output.
    fn stays_or_is_divided(&self, link: &Link, root: &CandidateSet, output: &mut Output) -> bool {
        let clusters = self.hierarchy.nodes.len() as u32;
        if link.class != LinkClass::Untested && link.receiver >= clusters && link.source >= clusters {
            let source = (link.source - clusters) as usize;
            let exitance = self.light.exitance[source].max_element() as f64;
            let area = self.forest.area[(link.receiver - clusters) as usize] as f64;
            let irradiance = link.factor as f64 * exitance;
            let uneven = 0.5 * (link.factor * self.light.variation[source]) as f64;
            let error = 0.5 * link.spread() as f64 * exitance + uneven;
            let cell = self.forest.cell[(link.receiver - clusters) as usize];
            let limits = self.limits_at(self.irradiance_of(cell));
            let shadow = link.class == LinkClass::Partial
                && (0.5 * irradiance > limits.irradiance || 0.25 * irradiance * area > limits.power);
            if error * area <= limits.power && uneven <= limits.irradiance && !shadow {
                return true;
            }
        }
        let (receiver, source) = (self.party(link.receiver), self.party(link.source));
        let inheritance = Inheritance { candidates: root, blocker: NO_FACET };
        let visible = match link.class {
            LinkClass::CertifiedVisible => Some(true),
            LinkClass::Visible if link.is_inherited() => Some(false),
            _ => None,
        };
        if link.class != LinkClass::Untested {
            let figures = estimate_of_link(link, &receiver, &source, self.hierarchy, self.light);
            let Some(figures) = figures else { return false };
            let partial = link.class == LinkClass::Partial;
            if self.wanted_split(&receiver, &source, &figures, partial).is_none() {
                return true;
            }
        }
        self.pair(&receiver, &source, PairState { visible, inheritance }, output);
        false
    }

    /// Whether a link is one that would be divided further.
    pub(super) fn is_coarse(&self, link: &Link) -> bool {
        let (receiver, source) = (self.party(link.receiver), self.party(link.source));
        let partial = link.class == LinkClass::Partial;
        estimate_of_link(link, &receiver, &source, self.hierarchy, self.light)
            .is_some_and(|figures| self.wanted_split(&receiver, &source, &figures, partial).is_some())
    }

    /// Keeps work for a receiver, if that is asked for.
    fn note(&self, done: &mut WorkDone, receiver: u32, work: u64) {
        if self.record == Record::Work {
            done.add(receiver, work);
        }
    }

    fn limits(&self, receiver: &Party) -> Limits {
        match receiver {
            Party::Element { piece, .. } => self.limits_at(self.irradiance_of(piece.cell)),
            Party::Cluster(node) => self.limits_at(self.light.lit[*node as usize]),
        }
    }

    /// Mean irradiance of an element, largest channel.
    fn irradiance_of(&self, element: u32) -> f32 {
        self.light.irradiance[element as usize].max_element()
    }

    fn limits_at(&self, irradiance: f32) -> Limits {
        let irradiance = irradiance as f64;
        Limits {
            power: self.thresholds.area * irradiance.max(self.thresholds.dark),
            irradiance: self.thresholds.contrast * irradiance.max(self.thresholds.black),
        }
    }

    /// Irradiance of a link over what it may get wrong in the end; before it is known where light falls,
    /// every link may turn out to matter.
    fn prominence(&self, figures: &Estimate, limits: &Limits) -> f64 {
        if limits.irradiance.is_finite() {
            figures.irradiance * self.thresholds.coarseness / limits.irradiance
        } else {
            f64::MAX
        }
    }

    fn party(&self, id: u32) -> Party {
        Party::of_id(id, self.hierarchy, self.forest, self.light)
    }

    /// Decides one pair: link, drop, or split and go on below.
    fn pair(&self, receiver: &Party, source: &Party, state: PairState<'_>, output: &mut Output) {
        let level = || self.tester.level(receiver.radius(self.hierarchy).max(source.radius(self.hierarchy)));
        let Some(mut figures) = estimate(receiver, source, self.hierarchy, self.light) else {
            output.worker.count_untested(Answer::Facing, level);
            return;
        };
        let mut link = Link::untested(
            receiver.id(self.hierarchy),
            source.id(self.hierarchy),
            figures.factor as f32,
            figures.spread as f32,
        );
        // Dark, for now. A bright source that only few points see is another matter.
        if figures.power.max(figures.kernel_error) <= 0.0 {
            output.worker.count_untested(Answer::Dark, level);
            output.pairs.links.push(link);
            return;
        }
        if let Some(certified) = state.visible {
            output.worker.count_untested(Answer::Inherited, level);
            match self.wanted_split(receiver, source, &figures, false) {
                Some(split) => self.split(receiver, source, split, figures.power, state, output),
                None => {
                    link.inherit(if certified { LinkClass::CertifiedVisible } else { LinkClass::Visible });
                    link.factor = factor_to_keep(&figures, receiver, source);
                    link.quarters = quarters(receiver, source, self.forest);
                    output.pairs.links.push(link);
                }
            }
            return;
        }

        let if_partial = self.wanted_split(receiver, source, &figures, true);
        let subdivided = if_partial.is_some();
        let before = output.worker.counters;
        let (verdict, narrowed) =
            self.with_pair(receiver, source, &figures, state.inheritance, subdivided, |pair| {
                self.tester.classify(&mut output.worker, pair)
            });
        let work = output.worker.counters.work_since(&before);
        link.add_work(work);
        self.note(&mut output.done, link.receiver, work);
        if self.is_classic() {
            // A kernel-weighted fraction can be tiny: fewer than one ray in n + 1 is more than n rays can tell. Where
            // few points face each other, few are cast.
            let cast = output.worker.counters.rays_cast - before.rays_cast;
            let least = 1.0 / (cast as f64 + 1.0);
            let fraction = (verdict.fraction as f64).max(least);
            figures.kernel_error *= fraction;
            figures.source_error *= fraction;
        }
        let split = match verdict.class {
            // The fraction is an estimate, also when it is 0 (paper §2.1).
            Class::Partial | Class::Invisible if self.is_classic() => {
                self.wanted_split(receiver, source, &figures, true)
            }
            Class::Partial => if_partial,
            _ if verdict.doubtful => if_partial,
            Class::Invisible if verdict.inheritable => None,
            _ => self.wanted_split(receiver, source, &figures, false),
        };
        match split {
            Some(split) => {
                let below = PairState {
                    visible: (verdict.class == Class::Visible && verdict.inheritable)
                        .then_some(verdict.certified),
                    inheritance: Inheritance {
                        candidates: narrowed.as_ref().unwrap_or(state.inheritance.candidates),
                        blocker: verdict.blocker,
                    },
                };
                self.split(receiver, source, split, figures.power, below, output);
            }
            // Where a split was in question, what the rays agree on is believed for good.
            None if verdict.class == Class::Invisible
                && (verdict.certified || verdict.inheritable && subdivided) =>
            {
                output.counters.invisible += 1;
                output.counters.certified_invisible += u64::from(verdict.certified);
            }
            None if verdict.class == Class::Invisible => {
                link.factor = factor_to_keep(&figures, receiver, source);
                output.pairs.blocked.push(Blocked::from(&link));
            }
            None => {
                link.factor = factor_to_keep(&figures, receiver, source);
                link.visibility = verdict.fraction;
                link.class = match (verdict.class, verdict.certified) {
                    (Class::Visible, true) => LinkClass::CertifiedVisible,
                    (Class::Visible, false) => LinkClass::Visible,
                    _ => LinkClass::Partial,
                };
                if verdict.class == Class::Visible || self.is_classic() || source.is_uniform() {
                    link.quarters = quarters(receiver, source, self.forest);
                }
                output.pairs.links.push(link);
            }
        }
        if let Some(set) = narrowed {
            output.worker.recycle(set);
        }
    }

    /// Describes a pair to the visibility test.
    fn with_pair<T>(
        &self,
        receiver: &Party,
        source: &Party,
        figures: &Estimate,
        inherited: Inheritance<'_>,
        subdivided: bool,
        test: impl FnOnce(&Pair<'_>) -> T,
    ) -> T {
        let limits = self.limits(receiver);
        let (lit, shining) = (receiver.part_facing(source), source.part_facing(receiver));
        let shading = Shading { source, forest: self.forest, light: self.light };
        test(&Pair {
            receiver: &receiver.end(lit.as_ref()),
            source: &source.end(shining.as_ref()),
            seed: hash_pair(receiver.key(), source.key()),
            inherited,
            subdivided,
            importance: figures.power * self.thresholds.coarseness / limits.power,
            prominence: self.prominence(figures, &limits),
            brightness: (!self.is_classic() && !source.is_uniform()).then_some(&shading),
        })
    }

    /// The split that would make the pair better, or `None` when it is good enough or cannot be split.
    fn wanted_split(
        &self,
        receiver: &Party,
        source: &Party,
        figures: &Estimate,
        partial: bool,
    ) -> Option<Split> {
        let limits = self.limits(receiver);
        let classic = self.is_classic();
        let (can_receiver, can_source) = (self.can_split(receiver), self.can_split(source));
        // A cluster lit as one, or anything lit by a cluster it lies in: that shows on the receiver,
        // however little power it is. So does a shadow.
        let bright = 0.5 * figures.irradiance > limits.irradiance;
        let seen =
            receiver.radius(self.hierarchy) * 2.0 > self.thresholds.min_size && !is_same(receiver, source);
        if bright
            && seen
            && figures.near
            && source.radius(self.hierarchy) > receiver.radius(self.hierarchy)
            && can_source
        {
            return Some(Split::Source);
        }
        if bright && seen && matches!(receiver, Party::Cluster(_)) {
            return Some(Split::Receiver);
        }
        // What the rest of the scene gets. The larger node is split: splitting the smaller one makes
        // more links, each as wrong as before.
        let larger_source = source.radius(self.hierarchy) > receiver.radius(self.hierarchy);
        // A source that reaches behind a wall is not as bright as it is here: that shows, too.
        let uneven =
            figures.source_error > limits.power.min(limits.irradiance * receiver.area(self.hierarchy));
        let kernel = figures.kernel_error > limits.power;
        let occluded = partial && !classic;
        let heavy = occluded && 0.25 * figures.power > limits.power;
        let shadow = heavy || occluded && bright;
        match (receiver, source) {
            (Party::Element { .. }, Party::Element { .. }) => {
                if uneven && can_source && figures.source_error > figures.kernel_error {
                    return Some(Split::Source);
                }
                if kernel && can_receiver {
                    return Some(Split::Receiver);
                }
                if uneven && can_source {
                    return Some(Split::Source);
                }
                match (can_receiver, can_source) {
                    // A shadow is drawn by small receivers, not by small pieces of a lamp.
                    (true, _) if shadow && self.prominence(figures, &limits) > 2.0 => Some(Split::Receiver),
                    (_, true) if heavy && larger_source => Some(Split::Source),
                    (true, _) if heavy => Some(Split::Receiver),
                    _ => None,
                }
            }
            _ if !(kernel || shadow) => None,
            _ if is_same(receiver, source) => Some(Split::Both),
            (Party::Cluster(_), Party::Cluster(_)) => {
                Some(if larger_source { Split::Source } else { Split::Receiver })
            }
            (Party::Cluster(_), element) | (element, Party::Cluster(_)) => {
                let receiver_is_cluster = matches!(receiver, Party::Cluster(_));
                // The form factor of an element that sends is exact, whatever its size.
                if !self.can_split(element) || receiver_is_cluster && !figures.near {
                    return Some(if receiver_is_cluster { Split::Receiver } else { Split::Source });
                }
                Some(if larger_source { Split::Source } else { Split::Receiver })
            }
        }
    }

    /// Whether partial occlusion is allowed to stay (paper §2.1).
    fn is_classic(&self) -> bool {
        self.tester.options().strategy == Strategy::Sampled
    }

    fn can_split(&self, party: &Party) -> bool {
        match party {
            Party::Element { piece, .. } => piece.polygon.longest_edge() > self.thresholds.min_size,
            Party::Cluster(_) => true,
        }
    }

    fn split(
        &self,
        receiver: &Party,
        source: &Party,
        split: Split,
        power: f64,
        state: PairState<'_>,
        output: &mut Output,
    ) {
        let divided = if split == Split::Source { source } else { receiver };
        let parts = divided.parts(self.hierarchy, self.forest, self.light);
        let pairs: Vec<(&Party, &Party)> = match split {
            Split::Receiver => parts.iter().map(|r| (r, source)).collect(),
            Split::Source => parts.iter().map(|s| (receiver, s)).collect(),
            Split::Both => {
                let all = parts.iter().flat_map(|r| parts.iter().map(move |s| (r, s)));
                all.filter(|(r, s)| !share_facet(r, s)).collect()
            }
        };
        if power > PARALLEL_IMPORTANCE * self.limits(receiver).power {
            let tasks: Vec<Output> = pairs
                .par_iter()
                .with_max_len(1)
                .map(|(r, s)| {
                    let _work = Work::begin(self.progress, "refine");
                    let mut output = self.output();
                    self.pair(r, s, state, &mut output);
                    output
                })
                .collect();
            tasks.into_iter().for_each(|task| output.absorb(task));
        } else {
            for (r, s) in &pairs {
                self.pair(r, s, state, output);
            }
        }
    }
}
