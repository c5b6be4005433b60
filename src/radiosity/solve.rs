//! From a hierarchy to a solution: refine and iterate until the energy error is small.

use super::approach::Approach;
use super::conservation::{Arrived, Conservation};
use super::display::DisplayMesh;
use super::flight::{flight, rooms};
use super::forest::Forest;
use super::gains::{Gains, Surplus};
use super::links::{Link, LinkSet, Pairs, renamed};
use super::openness::Openness;
use super::refine::{RefineCounters, Refiner, Thresholds};
use super::strays::Watched;
use super::transport::{Damping, Further, Light, Materials, Receiving, Surface};
use crate::hierarchy::Hierarchy;
use crate::progress::Progress;
use crate::tracer::Tracer;
use crate::visibility::{Strategy, Tester, VisibilityOptions};
use glam::{DVec3, Vec3};
use std::time::Instant;

/// Refinement runs at these multiples of the threshold, then at the threshold itself: what is split
/// at a coarse one need not be looked at again.
const SCHEDULE: [f64; 2] = [16.0, 4.0];

/// Surfaces darker than this share of the typical irradiance get no more power right for being darker
/// still: there are many of them, and little depends on each.
const DARK: f64 = 0.3;

/// Below this share shadows need not be right either: a picture that shows the rest shows them black.
const BLACK: f64 = 0.03;

/// Refinement has settled when it adds fewer links than this share.
const SETTLED: f64 = 1e-2;

/// If it does not settle, it ends after this many iterations.
const REFINED_AT_MOST: usize = 32;

/// Light that does not settle over links that are there already is waited for so many iterations.
const WAITED_AT_MOST: u32 = 2000;

/// Iteration ends when this share of the emitted power is still to come, if changes go on shrinking as they
/// do.
const CONVERGED: f64 = 5e-5;

/// How exact the solution has to be.
#[derive(Clone, Copy, Debug)]
pub struct SolveOptions {
    /// Power a link may get wrong, relative to the power that the receiver's irradiance would bring to a
    /// wall of the room.
    pub epsilon: f64,
    /// Irradiance a link may get wrong, relative to the receiver's.
    pub contrast: f64,
    /// Smallest element edge, in scene units; `None` derives it from the size of the rooms and
    /// `resolution`.
    pub min_size: Option<f64>,
    /// Elements across two walls of a room, when `min_size` is `None`.
    pub resolution: f64,
    /// Most iterations.
    pub iterations: u32,
    /// How visibility is decided.
    pub visibility: VisibilityOptions,
    /// What is kept of the way to the solution besides the counters.
    pub record: Record,
}

/// What is kept of the way to a solution; it costs a little time and does not change the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Record {
    /// Nothing.
    #[default]
    Nothing,
    /// Where the work of visibility tests goes: [`RefineCounters::detail`].
    Steps,
    /// How much of it was done for each receiver: [`Solution::work`].
    Work,
}

/// Watts, summed over channels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Energy {
    /// Emitted.
    pub emitted: f64,
    /// Absorbed by surfaces.
    pub absorbed: f64,
    /// Left the scene, found with rays.
    pub escaped: f64,
    /// Of the light that surfaces receive, what was added to that which links bring, so that none is lost; negative
    /// when it was taken away, so that none is made.
    pub corrected: f64,
    /// What still changed in the last iteration.
    pub error: f64,
}

impl Energy {
    /// What links lose or make over all bounces, before it is made up for:
    /// `|emitted + corrected − absorbed − escaped| / emitted`.
    pub fn balance_error(&self) -> f64 {
        (self.lost() + self.corrected).abs() / self.emitted.max(f64::MIN_POSITIVE)
    }

    /// Emitted, but neither absorbed nor escaped; negative when light is made.
    pub fn lost(&self) -> f64 {
        self.emitted - self.absorbed - self.escaped
    }
}

/// The light of a scene, ready to be looked at from anywhere.
#[derive(Debug)]
pub struct Solution {
    /// Elements.
    pub forest: Forest,
    /// Light on them.
    pub light: Light,
    /// Links it came over.
    pub links: LinkSet,
    /// How what clusters and elements receive falls on the leaf elements below.
    pub openness: Openness,
    /// What elements receive over what links bring, so that light falls where rays find that it does.
    pub gains: Gains,
    /// What all received light was scaled by, so that none is lost or made.
    pub factor: f32,
    /// Finer elements to show by interpolation, if there are any; light between surfaces knows nothing of them.
    pub display: Option<DisplayMesh>,
    /// Pairs that are not stored, and the work done.
    pub counters: RefineCounters,
    /// Work of all visibility tests with each node as receiver, in rays, by node id as links have it; empty if it was
    /// not asked for.
    pub work: Vec<u64>,
    /// Gather and push-pull iterations.
    pub iterations: u32,
    /// Where the power went.
    pub energy: Energy,
    /// Smallest element edge used, scene units.
    pub min_size: f64,
    /// Seconds spent refining, weighing links and looking for stray light.
    pub refine_seconds: f64,
    /// Seconds spent on everything else.
    pub solve_seconds: f64,
}

impl Solution {
    /// The light after one more gather over all links and push-pull, for measuring what that costs.
    pub fn after_one_more_bounce(&self, hierarchy: &Hierarchy) -> Light {
        let materials = Materials { hierarchy, forest: &self.forest };
        let damping = Damping::none(self.forest.len());
        let (openness, gains, factor) = (&self.openness, &self.gains, self.factor);
        let receiving = Receiving { factor, ..Receiving::of_links(&damping, openness, gains) };
        let dark = Light::dark(self.forest.len());
        self.light.iterate(hierarchy, &self.forest, &self.links, &materials, receiving, dark)
    }

    /// Triangles of the final mesh: the leaf elements, triangulated.
    pub fn triangle_count(&self, hierarchy: &Hierarchy) -> u64 {
        let mut count = 0;
        self.forest.for_each_element(hierarchy, |piece| {
            if self.forest.second[piece.id as usize] == 0 {
                count += piece.polygon.vertices().len() as u64 - 2;
            }
        });
        count
    }

    /// Irradiance a node receives directly over links of each class, largest channel: untested, visible,
    /// certified visible, partial.
    pub fn irradiance_by_class(&self, hierarchy: &Hierarchy, node: u32) -> [f32; 4] {
        let mut shares = [0.0; 4];
        for link in self.links.of(node) {
            shares[link.class as usize] += self.light.carried(hierarchy, &self.forest, link).max_element();
        }
        shares
    }

    /// Bytes of elements, those for display too, and clusters.
    pub fn elements_bytes(&self) -> u64 {
        let display = self.display.as_ref().map_or(0, DisplayMesh::bytes);
        self.forest.bytes() + self.light.bytes() + self.openness.bytes() + display
    }
}

/// Computes the light of a scene. `square_meters` is the area of one local unit of area.
pub fn solve(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    options: &SolveOptions,
    square_meters: f64,
    progress: &dyn Progress,
) -> Solution {
    let begun = Instant::now();
    let forest = Forest::new(hierarchy);
    // A single facet has nothing to exchange light with.
    let first = if hierarchy.nodes[0].is_leaf() { Vec::new() } else { vec![SELF_LINK] };
    let beginning = Beginning {
        begun,
        links: LinkSet::new(first, hierarchy.nodes.len() + forest.len()),
        openness: Openness::found(hierarchy, &forest, tracer, progress),
        factor: 1.0,
        counters: RefineCounters::default(),
        min_size: None,
        is_refined: None,
        forest,
    };
    iterate(hierarchy, tracer, beginning, options, square_meters, progress)
}

/// What iteration begins with: one link, or those of a solution whose light is to be another.
pub(super) struct Beginning<'a> {
    pub(super) begun: Instant,
    pub(super) forest: Forest,
    pub(super) links: LinkSet,
    pub(super) openness: Openness,
    /// See [`Solution::factor`].
    pub(super) factor: f32,
    pub(super) counters: RefineCounters,
    /// See [`Solution::min_size`]; `None` before it is known.
    pub(super) min_size: Option<f64>,
    /// Asked, where links are there already, when their light has settled: whether they have to be refined. Without a
    /// question they are refined from the first iteration on.
    pub(super) is_refined: Option<Question<'a>>,
}

/// Something that is asked of links and their light.
pub(super) type Question<'a> = &'a dyn Fn(&Forest, &LinkSet, &Light) -> bool;

/// Refines links and lets light flow over them until it has settled.
pub(super) fn iterate(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    beginning: Beginning<'_>,
    options: &SolveOptions,
    square_meters: f64,
    progress: &dyn Progress,
) -> Solution {
    let Beginning { begun, mut forest, mut links, mut openness, mut counters, min_size, .. } = beginning;
    let tester = Tester::new(hierarchy, tracer, options.visibility).detailed(options.record == Record::Steps);
    let materials = Materials { hierarchy, forest: &forest };
    let mut light = Light::emitted(hierarchy, &forest, &materials, Light::dark(forest.len()));
    let (mut gains, mut surplus) = (Gains::none(forest.len()), Surplus::default());
    let mut damping = match beginning.is_refined {
        None => Damping::none(forest.len()),
        Some(_) => Damping::new(hierarchy, &forest, &links, (&openness, &gains), Damping::MANY, progress),
    };

    let mut wall_area = 1.0;
    let mut blocked = Vec::new();
    let mut conservation = Conservation::beginning_with(beginning.factor);
    let emitted = emitted_power(hierarchy, &forest);
    let mut work = Vec::new();
    let mut refine_seconds = 0.0;
    let (mut iterations, mut error, mut factor) = (0, f64::MAX, conservation.factor);
    let (mut settled, mut since_settled, mut looks) = (false, 0, 0);
    let (mut is_waiting, mut refinements) = (beginning.is_refined, 0);
    // A fraction that knows nothing of brightness does not change.
    let weighs_again = options.visibility.strategy != Strategy::Sampled;
    let rooms_lit = rooms(hierarchy, &forest, &light, tracer).count;
    let mut thresholds = first_thresholds(emitted.max_element(), rooms_lit, hierarchy, options);

    let mut approach = Approach::new(CONVERGED * emitted.element_sum());

    while iterations < options.iterations.max(1)
        && !(settled && (looks == LOOKED.len() || !weighs_again) && approach.has_arrived())
    {
        // How fast changes shrink is known after two of them.
        if let Some(is_refined) = is_waiting
            && (approach.has_arrived() || iterations >= WAITED_AT_MOST)
        {
            is_waiting = None;
            settled = !is_refined(&forest, &links, &light);
            if settled {
                // What rays find now changes the light.
                approach.disturb();
                wall_area = rooms(hierarchy, &forest, &light, tracer).wall_area;
                thresholds =
                    final_thresholds(hierarchy, &forest, &light, wall_area, options).unwrap_or(thresholds);
            }
        }
        let is_time = |&(to_come, waited): &(f64, u32)| {
            approach.is_within(to_come * emitted.element_sum()) || since_settled >= waited
        };
        let looks_now = weighs_again && settled && LOOKED.get(looks).is_some_and(is_time);
        // The last light is that of the gains it has, and no other than links bring.
        let is_last = iterations + 1 >= options.iterations;
        let mut strays = None;
        let start = Instant::now();
        if looks_now {
            looks += 1;
            approach.disturb();
            progress.start("weigh", links.links.len() as u64);
            let refiner = Refiner {
                hierarchy,
                forest: &forest,
                light: &light,
                tester: &tester,
                thresholds,
                record: options.record,
                progress,
            };
            let (counted, done) = refiner.weigh_again(&mut links.links);
            counters += counted;
            done.add_to(&mut work);
            progress.finish();
            if !is_last {
                let watched = Watched { hierarchy, forest: &forest, light: &light, links: &links, tracer };
                let rays = STRAY_RAYS * options.visibility.rays;
                let known = surplus.as_gains(&gains, &forest, &light, |_| 1.0);
                strays = Some(watched.strays(wall_area, rays, &known, progress));
            }
        }
        refine_seconds += start.elapsed().as_secs_f64();
        if !settled && is_waiting.is_none() {
            let start = Instant::now();
            approach.disturb();
            let links_before = links.links.len();
            let pairs =
                Pairs { links: std::mem::take(&mut links.links), blocked: std::mem::take(&mut blocked) };
            progress.start("refine", pairs.len() as u64);
            let refiner = Refiner {
                hierarchy,
                forest: &forest,
                light: &light,
                tester: &tester,
                thresholds,
                record: options.record,
                progress,
            };
            let (mut refined, counted, mut done) = refiner.refine(pairs);
            progress.finish();
            counters += counted;
            let after = refined.links.len();
            let new_from_old = forest.renumber(hierarchy);
            refined.rename(hierarchy.nodes.len() as u32, &new_from_old);
            if options.record == Record::Work {
                work = renumbered(&work, hierarchy.nodes.len(), forest.len(), &new_from_old);
                done.rename(hierarchy.nodes.len() as u32, &new_from_old);
                done.add_to(&mut work);
            }
            light = light.renumbered(&forest, &new_from_old);
            openness = openness.refined(hierarchy, &forest, &new_from_old, tracer, progress);
            drop(new_from_old);
            let added = after.abs_diff(links_before) as f64;
            settled = refinements > SCHEDULE.len() && added <= SETTLED * after as f64
                || refinements >= REFINED_AT_MOST;
            let is_final = settled || is_last;
            blocked = refined.blocked;
            if is_final {
                counters.invisible += blocked.len() as u64;
                blocked = Vec::new();
            }
            links = LinkSet::new(refined.links, hierarchy.nodes.len() + forest.len());
            gains = Gains::none(forest.len());
            surplus = Surplus::default();
            // Where rays will look, the light that stays is damped once more.
            let stays = is_final && !(settled && weighs_again);
            let bounces = if stays { Damping::MANY } else { Damping::FEW };
            damping = Damping::new(hierarchy, &forest, &links, (&openness, &gains), bounces, progress);
            refine_seconds += start.elapsed().as_secs_f64();
        }
        factor = conservation.factor;
        approach.show(progress);
        // There is room for little more than one whole light in large scenes: of the old one only what links need stays.
        light = light.into_sent();
        let receiving = Receiving {
            damping: &damping,
            openness: &openness,
            gains: &gains,
            surplus: &surplus,
            factor,
            further: if is_last { Further::NONE } else { approach.further() },
            progress,
        };
        let materials = Materials { hierarchy, forest: &forest };
        let dark = Light::dark(forest.len());
        let next = light.iterate(hierarchy, &forest, &links, &materials, receiving, dark);
        let sent = light.sent(&forest);
        let is_shared = strays.is_some();
        if settled {
            if let Some(strays) = strays {
                let over = (links.links.len(), looks as u32);
                conservation.look(hierarchy, &forest, &light, tracer, over, progress);
                let arrived = Arrived {
                    hierarchy,
                    forest: &forest,
                    light: &next,
                    damping: &damping,
                    gains: &gains,
                    surplus: &surplus,
                    strays: &strays,
                };
                (gains, surplus) = conservation.shared(&arrived);
            } else if conservation.is_blind() {
                conservation.learn(flight(hierarchy, &forest, &light, tracer));
            }
            conservation.follow(&forest, sent, &next);
        }
        error = changed_power(&materials, &light, &next);
        approach.step(error, sent, progress);
        approach.leave(std::mem::replace(&mut light, next).exitance);
        if is_shared {
            // What links bring has changed, and with it what could grow.
            approach.disturb();
            damping = Damping::new(hierarchy, &forest, &links, (&openness, &gains), Damping::MANY, progress);
        }
        iterations += 1;
        since_settled += u32::from(settled);
        if !settled && is_waiting.is_none() {
            refinements += 1;
            wall_area = rooms(hierarchy, &forest, &light, tracer).wall_area;
            if let Some(lit) = lit_irradiance(&light, &forest) {
                thresholds = thresholds_for(refinements, lit, wall_area, hierarchy, options);
            }
        }
    }

    progress.finish();
    let gains = surplus.as_gains(&gains, &forest, &light, |leaf| damping.share(leaf));
    let energy = balance(hierarchy, &forest, &light, tracer, error, factor, square_meters);
    let refined_to = thresholds.min_size * hierarchy.frame.scene_units_per_local();
    let min_size = match min_size {
        Some(before) if refinements == 0 => before,
        Some(before) => before.min(refined_to),
        None => refined_to,
    };
    Solution {
        forest,
        light,
        links,
        openness,
        gains,
        factor,
        display: None,
        counters,
        work,
        iterations,
        energy,
        min_size,
        refine_seconds,
        solve_seconds: begun.elapsed().as_secs_f64() - refine_seconds,
    }
}

/// The scene lights itself: the one link everything starts from.
const SELF_LINK: Link = Link::untested(0, 0, 0.0, 0.0);

/// Work by node id, with other element ids.
fn renumbered(work: &[u64], clusters: usize, elements: usize, new_from_old: &[u32]) -> Vec<u64> {
    let mut renumbered = vec![0; clusters + elements];
    for (old, &done) in work.iter().enumerate() {
        renumbered[renamed(old as u32, clusters as u32, new_from_old) as usize] = done;
    }
    renumbered
}

/// Emitted power, local areas.
fn emitted_power(hierarchy: &Hierarchy, forest: &Forest) -> DVec3 {
    let materials = Materials { hierarchy, forest };
    (0..forest.side_count())
        .map(|side| {
            let area = forest.area[forest.first_element[side] as usize];
            materials.of(side).0.as_dvec3() * area as f64
        })
        .sum()
}

/// Before it is known where the light falls: a coarse start. Many rooms share the power, so each has but a
/// small part of it: the threshold follows the share of one.
fn first_thresholds(emitted: f64, rooms: f64, hierarchy: &Hierarchy, options: &SolveOptions) -> Thresholds {
    let min_size = options.min_size.map_or(1.0 / 32.0, |size| hierarchy.frame.local_length(size));
    Thresholds {
        coarseness: SCHEDULE[0],
        area: (options.epsilon * SCHEDULE[0]).max(1e-3) / rooms,
        contrast: f64::INFINITY,
        dark: emitted,
        black: emitted,
        min_size,
    }
}

/// Thresholds relative to the light as it falls, and to the size of the rooms it falls in: so neither
/// the size of a building nor the fineness of its triangles matters.
fn thresholds_for(
    refinements: usize,
    lit: f64,
    wall_area: f64,
    hierarchy: &Hierarchy,
    options: &SolveOptions,
) -> Thresholds {
    let factor = SCHEDULE.get(refinements).copied().unwrap_or(1.0);
    let min_size = options.min_size.map_or_else(
        || 2.0 * wall_area.sqrt() / options.resolution,
        |size| hierarchy.frame.local_length(size),
    );
    Thresholds {
        coarseness: factor,
        area: options.epsilon * factor * wall_area,
        contrast: options.contrast * factor,
        dark: DARK * lit,
        black: BLACK * lit,
        min_size: min_size.max(MIN_LOCAL_SIZE),
    }
}

/// Those of the end, for light that has settled; `None` when all is dark.
pub(super) fn final_thresholds(
    hierarchy: &Hierarchy,
    forest: &Forest,
    light: &Light,
    wall_area: f64,
    options: &SolveOptions,
) -> Option<Thresholds> {
    let lit = lit_irradiance(light, forest)?;
    Some(thresholds_for(SCHEDULE.len(), lit, wall_area, hierarchy, options))
}

/// Geometric mean of the irradiance, weighted by the power it brings; `None` when all is dark.
fn lit_irradiance(light: &Light, forest: &Forest) -> Option<f64> {
    let (mut power, mut logarithms) = (0.0, 0.0);
    for element in forest.leaves() {
        let irradiance = light.irradiance[element].max_element() as f64;
        if irradiance > 0.0 {
            let received = irradiance * forest.area[element] as f64;
            power += received;
            logarithms += received * irradiance.ln();
        }
    }
    (power > 0.0).then(|| (logarithms / power).exp())
}

/// When refinement has settled, links of clusters are weighed again and rays look where light lands, each time that no
/// more than this share of the emitted power is still to come, or after so many iterations.
const LOOKED: [(f64, u32); 2] = [(0.1, 32), (0.005, 128)];

/// Rays for a group of surfaces in which stray light is looked for, over those of a pair.
const STRAY_RAYS: u32 = 16;

/// No element gets smaller than this, local length: a few hundred roundings.
pub const MIN_LOCAL_SIZE: f64 = 5e-5;

/// Power whose place or amount one flight over the links changed, summed over channels, local areas.
fn changed_power(materials: &Materials<'_>, before: &Light, after: &Light) -> f64 {
    let Materials { forest, .. } = *materials;
    let of_side = |side: usize| -> f64 {
        let (emission, reflectance) = materials.of(side);
        forest
            .leaves_of(side)
            .map(|e| {
                let sent = emission + reflectance.of(e as u32) * after.irradiance[e];
                ((sent - before.exitance[e]).abs().element_sum() * forest.area[e]) as f64
            })
            .sum()
    };
    (0..forest.side_count()).map(of_side).sum()
}

/// Follows the power: what is emitted is absorbed or escapes.
///
/// What escapes, or ends on a back that takes no part, is found with rays and not with the links, so the
/// balance shows what the links get wrong; `factor` made up for that.
fn balance(
    hierarchy: &Hierarchy,
    forest: &Forest,
    light: &Light,
    tracer: &dyn Tracer,
    error: f64,
    factor: f32,
    square_meters: f64,
) -> Energy {
    let materials = Materials { hierarchy, forest };
    let mut energy = Energy::default();
    for side in 0..forest.side_count() {
        let (emission, reflectance) = materials.of(side);
        for element in forest.leaves_of(side) {
            let area = forest.area[element] as f64 * square_meters;
            let sum = |v: Vec3| (v.x + v.y + v.z) as f64 * area;
            energy.emitted += sum(emission);
            energy.absorbed += sum(light.irradiance[element] * (Vec3::ONE - reflectance.of(element as u32)));
        }
    }
    let flight = flight(hierarchy, forest, light, tracer);
    let sent = light.sent(forest) * square_meters;
    energy.escaped = flight.escaped * sent;
    energy.absorbed += flight.on_backs * sent;
    energy.corrected = light.received(forest) * (1.0 - 1.0 / f64::from(factor)) * square_meters;
    energy.error = error * square_meters;
    energy
}
