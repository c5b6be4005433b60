//! One iteration of light: gather over the links, push irradiance down to the leaf elements, pull
//! exitance up to the root. [HSA91]

use super::forest::Forest;
use super::gains::{Gains, Surplus};
use super::links::{Link, LinkClass, LinkSet};
use super::openness::{Arriving, Openness};
use super::reflectance::Reflectance;
use crate::hierarchy::Hierarchy;
use crate::math::CosineLobes;
use crate::progress::{Progress, Silent, Work};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Sides handed to a thread at a time.
const BLOCK: usize = 512;

/// A source whose exitance differs by less than this share counts as uniform: rays differ by far more.
const EVEN: f32 = 0.05;

/// Light on every element and cluster. While links are refined and light flows there are lights of which only what links
/// need is known; what else there is of them is empty.
#[derive(Clone, Debug, Default)]
pub struct Light {
    /// Exitance of each element; the area average in inner ones, W/m².
    pub exitance: Vec<Vec3>,
    /// Irradiance of each leaf element; the area average in inner ones, W/m².
    pub irradiance: Vec<Vec3>,
    /// Largest minus smallest exitance of the leaves below each element, in the channel where that is most.
    pub variation: Vec<f32>,
    /// Exitance of the brightest leaf below each element, largest channel.
    pub brightest: Vec<f32>,
    /// Intensity of each cluster towards each direction, by its [place](Hierarchy::cluster_place), W/sr in local areas.
    pub intensity: Vec<CosineLobes>,
    /// Power each node of the hierarchy sends out, largest channel, W in local areas.
    pub power: Vec<f32>,
    /// Largest exitance in each node of the hierarchy, largest channel.
    pub peak: Vec<f32>,
    /// Mean irradiance of all sides in each node of the hierarchy, largest channel.
    pub lit: Vec<f32>,
}

/// The share of what reaches it that each leaf element takes.
///
/// Form factors at a few points, and those of clusters, can add up to more than 1, and where bright surfaces
/// are close to each other light would then grow without end, be it in one dark corner. Row sums say little
/// about that: they are too large in many places from which the light goes on to others. So every surface
/// sends out 1, and the light is followed for some bounces. With x the sum of them all and K one bounce,
/// K x ≤ λ x holds nearly everywhere; where it does not, the element takes so much less that it does. Then no
/// light grows, since the spectral radius of a positive operator is no larger than such a λ
/// (Collatz and Wielandt). Lobes of light that are cut off where they fall below nothing, and sources of which what is
/// seen is brighter than their mean, make K a little less than linear.
#[derive(Clone, Debug)]
pub(super) struct Damping(Vec<f32>);

impl Damping {
    /// λ.
    pub(super) const MOST: f32 = 0.99;

    /// Bounces until rays have looked where light lands: enough to keep it from growing.
    pub(super) const FEW: u32 = 2;

    /// Bounces for the light that stays: with more of them fewer elements take less than reaches them.
    pub(super) const MANY: u32 = 8;

    /// None, for `elements` elements.
    pub(super) fn none(elements: usize) -> Damping {
        Damping(vec![1.0; elements])
    }

    /// The share of one element.
    pub(super) fn share(&self, element: usize) -> f32 {
        self.0[element]
    }

    /// Follows the light over the links, for some bounces.
    pub(super) fn new(
        hierarchy: &Hierarchy,
        forest: &Forest,
        links: &LinkSet,
        (openness, gains): (&Openness, &Gains),
        bounces: u32,
        progress: &dyn Progress,
    ) -> Damping {
        progress.start("damping", 0);
        let damping = Damping::none(forest.len());
        let receiving = Receiving { progress, ..Receiving::of_links(&damping, openness, gains) };
        let glowing = Glowing(Materials { hierarchy, forest });
        let bounced = |light: &Light| {
            let dark = Light::dark_to_links(forest.len());
            Light {
                irradiance: Vec::new(),
                ..light.iterate(hierarchy, forest, links, &glowing, receiving, dark)
            }
        };
        let mut before = Light {
            irradiance: Vec::new(),
            ..Light::emitted(hierarchy, forest, &glowing, Light::dark_to_links(forest.len()))
        };
        let mut after = bounced(&before);
        for _ in 1..bounces {
            before = after;
            after = bounced(&before);
        }
        progress.finish();
        let share = |(before, after): (&Vec3, &Vec3)| {
            let once_more = *after - Vec3::ONE;
            (before * Damping::MOST / once_more.max(Vec3::splat(f32::MIN_POSITIVE))).min_element().min(1.0)
        };
        Damping(before.exitance.iter().zip(&after.exitance).map(share).collect())
    }
}

/// All sides send out 1 besides what they reflect.
struct Glowing<'a>(Materials<'a>);

impl Surface for Glowing<'_> {
    fn of(&self, side: usize) -> (Vec3, Reflectance<'_>) {
        (Vec3::ONE, self.0.of(side).1)
    }
}

/// What elements receive of, and besides, what their links bring; and who is told.
#[derive(Clone, Copy)]
pub(super) struct Receiving<'a> {
    pub(super) damping: &'a Damping,
    pub(super) openness: &'a Openness,
    pub(super) gains: &'a Gains,
    pub(super) surplus: &'a Surplus,
    /// So that no light is lost or made.
    pub(super) factor: f32,
    pub(super) further: Further<'a>,
    /// Told who works when.
    pub(super) progress: &'a dyn Progress,
}

impl<'a> Receiving<'a> {
    /// What links bring, as damping and gains have it, and nothing besides; nobody is told.
    pub(super) fn of_links(damping: &'a Damping, openness: &'a Openness, gains: &'a Gains) -> Receiving<'a> {
        let (surplus, further, progress) = (Surplus::none(), Further::NONE, &Silent);
        Receiving { damping, openness, gains, surplus, factor: 1.0, further, progress }
    }
}

/// How much further what surfaces send out goes than it would by itself.
#[derive(Clone, Copy)]
pub(super) struct Further<'a> {
    /// What each element sent out before, which it goes away from.
    pub(super) than: &'a [Vec3],
    /// By this share of the way from there.
    pub(super) by: f32,
}

impl Further<'_> {
    /// No further.
    pub(super) const NONE: Further<'static> = Further { than: &[], by: 0.0 };

    /// What an element sends out that emits so much and would by itself send out so much.
    #[inline]
    fn of(&self, element: u32, emitted: Vec3, exitance: Vec3) -> Vec3 {
        if self.by == 0.0 {
            return exitance;
        }
        (exitance + (exitance - self.than[element as usize]) * self.by).max(emitted)
    }
}

/// What a surface does with the light that reaches it.
pub(super) trait Surface: Sync {
    /// Own exitance of a side, and what its elements reflect.
    fn of(&self, side: usize) -> (Vec3, Reflectance<'_>);
}

/// The materials of the scene.
pub(super) struct Materials<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) forest: &'a Forest,
}

impl Surface for Materials<'_> {
    fn of(&self, index: usize) -> (Vec3, Reflectance<'_>) {
        let side = self.forest.side(index);
        (self.hierarchy.emitted(side), self.forest.reflectance(self.hierarchy, index))
    }
}

impl Light {
    /// No light on so many elements; nothing yet of clusters.
    pub(super) fn dark(elements: usize) -> Light {
        Light { variation: vec![0.0; elements], ..Light::dark_to_links(elements) }
    }

    /// The same, for what links need of it alone, exitance and intensity, and what these are made from.
    pub(super) fn dark_to_links(elements: usize) -> Light {
        Light {
            exitance: vec![Vec3::ZERO; elements],
            irradiance: vec![Vec3::ZERO; elements],
            brightest: vec![0.0; elements],
            ..Light::default()
        }
    }

    /// The light before the first iteration: emission only. It is written to what there is room for in `light`.
    pub(super) fn emitted(
        hierarchy: &Hierarchy,
        forest: &Forest,
        surface: &dyn Surface,
        mut light: Light,
    ) -> Light {
        let dark = vec![Arriving::default(); hierarchy.cluster_count()];
        let (damping, gains) = (Damping::none(forest.len()), Gains::none(forest.len()));
        let openness = Openness::unknown();
        let receiving = Receiving::of_links(&damping, &openness, &gains);
        light.push_pull(hierarchy, forest, surface, receiving, &dark);
        light
    }

    /// The light of a solution, which follows from the irradiance of its leaf elements, in order.
    pub fn from_leaves(hierarchy: &Hierarchy, forest: &Forest, irradiance: &[Vec3]) -> Light {
        let mut light = Light::dark(forest.len());
        let materials = Materials { hierarchy, forest };
        let mut elements = Elements {
            forest,
            offset: 0,
            exitance: &mut light.exitance,
            irradiance: &mut light.irradiance,
            variation: &mut light.variation,
            brightest: &mut light.brightest,
        };
        let mut leaves = irradiance.iter().rev();
        let mut ranges = Vec::new();
        for side in (0..forest.side_count()).rev() {
            let surface = materials.of(side);
            // Backwards, both halves come before the whole, the first last.
            for element in forest.elements_of(side).rev() {
                let range = if forest.second[element] == 0 {
                    let irradiance = *leaves.next().unwrap_or(&Vec3::ZERO);
                    elements.light_leaf(element as u32, irradiance, surface, Further::NONE)
                } else {
                    let halves = [ranges.pop(), ranges.pop()].map(Option::unwrap_or_default);
                    elements.join_halves(element as u32, halves)
                };
                ranges.push(range);
            }
            ranges.clear();
        }
        light.pull_clusters(hierarchy, forest);
        light
    }

    /// The light that some sides send out, and none from the others.
    pub(super) fn only_of(&self, hierarchy: &Hierarchy, forest: &Forest, is_of: &[bool]) -> Light {
        let mut only = self.clone();
        for side in (0..forest.side_count()).filter(|&side| !is_of[side]) {
            let elements = forest.elements_of(side);
            only.exitance[elements].fill(Vec3::ZERO);
        }
        only.pull_clusters(hierarchy, forest);
        only
    }

    /// What links need of the light, and nothing else.
    pub(super) fn into_sent(self) -> Light {
        let Light { exitance, brightest, intensity, .. } = self;
        Light { exitance, brightest, intensity, ..Light::default() }
    }

    /// What links need of the light, in a new numbering; elements new in it take their parent's.
    pub(super) fn renumbered(self, forest: &Forest, new_from_old: &[u32]) -> Light {
        fn moved<T: Copy>(before: Vec<T>, new_from_old: &[u32], unknown: T, count: usize) -> Vec<T> {
            let mut moved = vec![unknown; count];
            for (value, &new) in before.into_iter().zip(new_from_old) {
                moved[new as usize] = value;
            }
            moved
        }
        let Light { exitance, brightest, intensity, .. } = self.into_sent();
        let mut exitance = moved(exitance, new_from_old, Vec3::NAN, forest.len());
        let mut brightest = moved(brightest, new_from_old, 0.0, forest.len());
        for e in 0..exitance.len() {
            let second = forest.second[e] as usize;
            if second != 0 && exitance[second].is_nan() {
                for half in [e + 1, second] {
                    exitance[half] = exitance[e];
                    brightest[half] = exitance[e].max_element();
                }
            }
        }
        Light { exitance, brightest, intensity, ..Light::default() }
    }

    /// Whether the exitance differs so little below an element that it counts as uniform where rays weigh it.
    pub fn is_even(&self, element: u32) -> bool {
        let element = element as usize;
        self.variation[element] <= EVEN * self.exitance[element].max_element()
    }

    /// Bytes it takes.
    pub(super) fn bytes(&self) -> u64 {
        let Light { exitance, irradiance, variation, brightest, intensity, power, peak, lit } = self;
        let by_element = size_of_val(&exitance[..]) + size_of_val(&irradiance[..]);
        let scalars = [variation, brightest, power, peak, lit].map(|values| size_of_val(&values[..]));
        (by_element + size_of_val(&intensity[..]) + scalars.iter().sum::<usize>()) as u64
    }

    /// Power that all surfaces send out, summed over channels, local areas.
    pub(super) fn sent(&self, forest: &Forest) -> f64 {
        forest.leaves().map(|e| (self.exitance[e].element_sum() * forest.area[e]) as f64).sum()
    }

    /// Power that all surfaces receive, likewise.
    pub(super) fn received(&self, forest: &Forest) -> f64 {
        forest.leaves().map(|e| (self.irradiance[e].element_sum() * forest.area[e]) as f64).sum()
    }

    /// Gathers over all links and updates everything; the new light is written to what there is room for in `next`.
    pub(super) fn iterate(
        &self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        links: &LinkSet,
        surface: &dyn Surface,
        receiving: Receiving<'_>,
        mut next: Light,
    ) -> Light {
        let working = || Work::begin(receiving.progress, "gather");
        let elements = next.exitance.par_iter_mut().zip(&mut next.irradiance).with_min_len(256).enumerate();
        elements.for_each_init(working, |_, (element, (even, uneven))| {
            [*even, *uneven] = self.gathered(hierarchy, forest, links, element as u32);
        });
        let arriving = receiving.openness.arriving(hierarchy, forest, links, self);
        next.push_pull(hierarchy, forest, surface, receiving, &arriving);
        next
    }

    /// What comes to an element over its own links: light that falls on all of it alike, and light that is kept off some of
    /// it, which falls on its parts as they lie open.
    pub fn gathered(
        &self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        links: &LinkSet,
        element: u32,
    ) -> [Vec3; 2] {
        let is_leaf = forest.second[element as usize] == 0;
        let [mut even, mut uneven] = [Vec3::ZERO; 2];
        for link in links.of(hierarchy.nodes.len() as u32 + element) {
            let carried = self.carried(hierarchy, forest, link);
            *(if is_leaf || link.class != LinkClass::Partial { &mut even } else { &mut uneven }) += carried;
        }
        [even, uneven]
    }

    /// Irradiance one link brings, across the direction of the light when the receiver is a cluster.
    #[inline]
    pub fn carried(&self, hierarchy: &Hierarchy, forest: &Forest, link: &Link) -> Vec3 {
        if link.class == LinkClass::Untested {
            return Vec3::ZERO;
        }
        let clusters = hierarchy.nodes.len() as u32;
        if link.source >= clusters {
            let source = link.source - clusters;
            return link.quarters.weigh(forest, &self.exitance, source)
                * (link.factor * self.seen(source, link));
        }
        let factor = link.factor * link.visibility;
        let away = -direction(hierarchy, forest, link);
        let lobes = &self.intensity[hierarchy.cluster_place(link.source)];
        (if away == Vec3::ZERO { lobes.mean() } else { lobes.evaluate(away) }) * factor
    }

    /// Share of a source's light that gets through a link. What is seen of the source was perhaps brighter
    /// than its mean when the link was made; now it is no brighter than its brightest part can be.
    #[inline]
    fn seen(&self, source: u32, link: &Link) -> f32 {
        if link.visibility <= 1.0 {
            return link.visibility;
        }
        let mean = self.exitance[source as usize].max_element();
        link.visibility.min(self.brightest[source as usize] / mean.max(f32::MIN_POSITIVE))
    }

    /// Sends gathered light down to the leaves and the new exitance up again.
    ///
    /// In the places of the exitance and the irradiance of each element is what it [gathered](Self::gathered); `arriving`
    /// is what each cluster and those above it received.
    fn push_pull(
        &mut self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        surface: &dyn Surface,
        receiving: Receiving<'_>,
        arriving: &[Arriving],
    ) {
        let mut blocks = Vec::new();
        let (mut exitance, mut irradiance) = (&mut self.exitance[..], &mut self.irradiance[..]);
        let (mut variation, mut brightest) = (&mut self.variation[..], &mut self.brightest[..]);
        for first in (0..forest.side_count()).step_by(BLOCK) {
            let end = (first + BLOCK).min(forest.side_count());
            let count = (forest.first_element[end] - forest.first_element[first]) as usize;
            let (a, b) = (begin_of(&mut exitance, count), begin_of(&mut irradiance, count));
            let (c, d) = (begin_of(&mut variation, count), begin_of(&mut brightest, count));
            blocks.push((first..end, a, b, c, d));
        }
        blocks.into_par_iter().for_each(|(sides, exitance, irradiance, variation, brightest)| {
            let _work = Work::begin(receiving.progress, "gather");
            let offset = forest.first_element[sides.start] as usize;
            let elements = Elements { forest, offset, exitance, irradiance, variation, brightest };
            let mut block = Block { elements, receiving };
            for index in sides {
                let all = forest.elements_of(index);
                let own = all.start - offset..all.end - offset;
                let Elements { exitance, irradiance, .. } = &mut block.elements;
                let (even, uneven) = (&exitance[own.clone()], &mut irradiance[own]);
                receiving.openness.push(hierarchy, forest, index, arriving, (even, uneven));
                block.pull(forest.first_element[index], surface.of(index));
            }
        });
        self.pull_clusters(hierarchy, forest);
    }

    /// What clusters send and receive, from the light of the elements.
    fn pull_clusters(&mut self, hierarchy: &Hierarchy, forest: &Forest) {
        self.intensity = intensities(hierarchy, forest, &self.exitance);
        if self.variation.is_empty() {
            return;
        }
        self.power = vec![0.0; hierarchy.nodes.len()];
        self.peak = vec![0.0; hierarchy.nodes.len()];
        self.lit = vec![0.0; hierarchy.nodes.len()];
        for index in (0..hierarchy.nodes.len()).rev() {
            let node = &hierarchy.nodes[index];
            if node.is_leaf() {
                for side in forest.sides_of(node.first) {
                    let root = forest.first_element[side] as usize;
                    self.power[index] += (self.exitance[root] * forest.area[root]).max_element();
                    self.lit[index] += self.irradiance[root].max_element() / hierarchy.sides() as f32;
                    self.peak[index] = self.peak[index].max(self.brightest[root]);
                }
            } else {
                for child in node.children(index as u32).map(|c| c as usize) {
                    self.power[index] += self.power[child];
                    self.lit[index] +=
                        self.lit[child] * (hierarchy.nodes[child].area / node.area.max(f32::MIN_POSITIVE));
                    self.peak[index] = self.peak[index].max(self.peak[child]);
                }
            }
        }
    }
}

/// Intensity of each cluster, from the exitance of the elements: see [`Light::intensity`].
pub(crate) fn intensities(hierarchy: &Hierarchy, forest: &Forest, exitance: &[Vec3]) -> Vec<CosineLobes> {
    let mut intensities = vec![CosineLobes::default(); hierarchy.cluster_count()];
    let of_facet = |facet| {
        let mut lobes = CosineLobes::default();
        for side in forest.sides_of(facet) {
            let root = forest.first_element[side] as usize;
            let normal = hierarchy.side_normal(forest.side(side)).as_vec3();
            lobes.add(normal, exitance[root] * forest.area[root] / PI);
        }
        lobes
    };
    hierarchy.sum_up(&mut intensities, of_facet, CosineLobes::merge);
    intensities
}

/// Unit direction from the receiver's centre to the source's; zero when they coincide.
pub fn direction(hierarchy: &Hierarchy, forest: &Forest, link: &Link) -> Vec3 {
    let clusters = hierarchy.nodes.len() as u32;
    let center = |id: u32| {
        if id < clusters {
            hierarchy.nodes[id as usize].center
        } else {
            forest.center[(id - clusters) as usize]
        }
    };
    (center(link.source) - center(link.receiver)).normalize_or_zero()
}

/// A run of sides with its share of the arrays, and what comes to it.
struct Block<'a> {
    elements: Elements<'a>,
    receiving: Receiving<'a>,
}

impl Block<'_> {
    /// Pulls the exitance of one element tree, whose leaves have their irradiance; returns the smallest and
    /// largest exitance of its leaves, by channel.
    fn pull(&mut self, element: u32, surface: (Vec3, Reflectance<'_>)) -> Range {
        let second = self.elements.forest.second[element as usize];
        if second == 0 {
            let irradiance = self.elements.irradiance[element as usize - self.elements.offset];
            let share = self.receiving.damping.share(element as usize) * self.receiving.factor;
            let irradiance = irradiance * (self.receiving.gains.of(element) * share);
            let irradiance = self.receiving.surplus.added(element, irradiance);
            return self.elements.light_leaf(element, irradiance, surface, self.receiving.further);
        }
        let halves = [element + 1, second].map(|half| self.pull(half, surface));
        self.elements.join_halves(element, halves)
    }
}

/// The smallest and largest exitance of some leaf elements, by channel.
type Range = (Vec3, Vec3);

/// Takes `count` values from the beginning of what is left of an array, or none of one without any.
fn begin_of<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let count = count.min(rest.len());
    rest.split_off_mut(..count).unwrap_or_default()
}

/// Light on a run of elements.
struct Elements<'a> {
    forest: &'a Forest,
    /// The first of them.
    offset: usize,
    exitance: &'a mut [Vec3],
    irradiance: &'a mut [Vec3],
    /// Empty if nobody asks.
    variation: &'a mut [f32],
    brightest: &'a mut [f32],
}

impl Elements<'_> {
    /// A leaf receives this irradiance, on a surface with this exitance of its own and reflectance.
    fn light_leaf(
        &mut self,
        element: u32,
        irradiance: Vec3,
        (emitted, reflectance): (Vec3, Reflectance<'_>),
        further: Further<'_>,
    ) -> Range {
        let own = element as usize - self.offset;
        self.irradiance[own] = irradiance;
        self.exitance[own] = further.of(element, emitted, emitted + reflectance.of(element) * irradiance);
        self.brightest[own] = self.exitance[own].max_element();
        (self.exitance[own], self.exitance[own])
    }

    /// An element is lit as its halves are, whose leaves send out so much.
    fn join_halves(&mut self, element: u32, [(low_a, high_a), (low_b, high_b)]: [Range; 2]) -> Range {
        let (own, second) = (element as usize - self.offset, self.forest.second[element as usize] as usize);
        let (a, b) = (own + 1, second - self.offset);
        let share = self.forest.area[element as usize + 1]
            / (self.forest.area[element as usize + 1] + self.forest.area[second]);
        // So written, halves that are alike give exactly what they are, split or not.
        self.irradiance[own] = self.irradiance[b] + (self.irradiance[a] - self.irradiance[b]) * share;
        self.exitance[own] = self.exitance[b] + (self.exitance[a] - self.exitance[b]) * share;
        let (low, high) = (low_a.min(low_b), high_a.max(high_b));
        if let Some(variation) = self.variation.get_mut(own) {
            *variation = (high - low).max_element();
        }
        self.brightest[own] = high.max_element();
        (low, high)
    }
}
