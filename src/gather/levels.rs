//! What lights the points of one element: the links of its own and of all nodes it lies in, and what they bring to each
//! point.

use super::final_gather::{FinalGather, Role, VisiblePoint};
use super::parts::{Arriving, SentOut, Source, Spotlit};
use crate::hierarchy::Side;
use crate::math::{PairSequence, hash_pair};
use crate::radiosity::{LinkClass, Piece, Way};
use glam::{DVec3, Vec3};

/// An emitter of which all but this share is proved visible is so.
const NEARLY_ALL: f32 = 1e-3;

/// Where a source is not uniform it is looked at in parts, unless that changes less than this share of the light.
const UNEVEN: f64 = 0.003;

/// Most rays for a point, over those that it gets where all its light is to be looked for with rays.
const MOST_RAYS: f64 = 4.0;

/// A part that brings more shares than this to a point, on an element to whose middle it brings one, is cut again.
const CUT_AGAIN: f64 = 2.0;

/// One source of light for the points of a node.
struct Term {
    source: Source,
    view: InView,
}

impl Term {
    fn new(piece: Piece, view: InView, shining: &SentOut<'_>) -> Term {
        Term { source: Source::new(piece, view == InView::Most, shining), view }
    }
}

/// What a link says about how much of a source is in view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InView {
    /// All of it, from everywhere on the node: that is proved.
    All,
    /// Most of it.
    Most,
    /// Less, or nothing is known.
    Some,
}

/// A node that the points lie in, with what its links say.
struct Level {
    node: u32,
    terms: Vec<Term>,
    /// Lamps with the area of the part that is proved visible.
    clear_lamps: Vec<(u32, f32)>,
}

impl Level {
    /// What the links of one node say.
    fn of(gather: &FinalGather<'_>, node: u32, shining: &SentOut<'_>) -> Level {
        let (hierarchy, forest) = (gather.hierarchy, &gather.solution.forest);
        let clusters = hierarchy.nodes.len() as u32;
        let mut level = Level { node, terms: Vec::new(), clear_lamps: Vec::new() };
        let mut way = Way::new(hierarchy, forest);
        for link in gather.solution.links.of(node) {
            if let Some(element) = link.source.checked_sub(clusters) {
                let is_clear = link.class == LinkClass::CertifiedVisible && node >= clusters;
                match gather.roles[forest.side_of(element)] {
                    Role::Interpolated => {}
                    Role::Source => {
                        let view = match link.visibility > 0.5 {
                            _ if is_clear => InView::All,
                            true => InView::Most,
                            false => InView::Some,
                        };
                        level.terms.push(Term::new(way.to(element).clone(), view, shining));
                    }
                    Role::Lamp(lamp) if is_clear => {
                        level.clear_lamps.push((lamp, forest.area[element as usize]));
                    }
                    Role::Lamp(_) => {}
                }
            } else {
                let cluster = &hierarchy.nodes[link.source as usize];
                let sides = forest.sides_of(cluster.first).start..forest.sides_of(cluster.end - 1).end;
                let first = gather.sources.partition_point(|&side| side < sides.start);
                for &side in gather.sources[first..].iter().take_while(|&&side| side < sides.end) {
                    if gather.roles[side] == Role::Source {
                        let piece = forest.root(hierarchy, side);
                        level.terms.push(Term::new(piece, InView::Some, shining));
                    }
                }
            }
        }
        level
    }
}

/// The nodes above a point, from the root down to its leaf element, and all sources for points on that.
pub(super) struct Levels<'g, 'a> {
    gather: &'g FinalGather<'a>,
    levels: Vec<Level>,
    path: Vec<u32>,
    /// The emitters that are gathered from at all points.
    lamps: Vec<Source>,
    shining: SentOut<'g>,
    sources: Sources,
    /// What each of those that rays are for brings to a point.
    brought: Vec<DVec3>,
}

/// What lights the points of one leaf element.
struct Sources {
    element: Option<u32>,
    /// In full view.
    clear: Vec<Source>,
    /// For rays to find out, in parts of which each brings a share.
    unknown: Vec<Source>,
    /// Irradiance, sum of the channels, that is worth a ray.
    share: f64,
    /// Irradiance that is too little to look at closer.
    little: f64,
}

impl<'g, 'a> Levels<'g, 'a> {
    /// At no element yet.
    pub(super) fn new(gather: &'g FinalGather<'a>) -> Levels<'g, 'a> {
        let shining = SentOut { forest: &gather.solution.forest, light: &gather.light };
        let sources =
            Sources { element: None, clear: Vec::new(), unknown: Vec::new(), share: 0.0, little: 0.0 };
        let lamps = gather.lamps.iter().map(|lamp| Source::new(lamp.clone(), false, &shining)).collect();
        Levels { gather, levels: Vec::new(), path: Vec::new(), lamps, shining, sources, brought: Vec::new() }
    }

    /// Irradiance at a point, W/m².
    pub(super) fn irradiance(&mut self, seen: &VisiblePoint) -> Vec3 {
        if self.sources.element != Some(seen.element) {
            self.go_to(seen.side, seen.element);
            self.find_sources(seen.side, seen.element);
        }
        let Levels { gather, shining, sources, brought, .. } = self;
        let rest = gather.rest.look_up(seen.side, seen.point).map_or(Vec3::ZERO, |spot| spot.irradiance);
        let at = Spotlit::on(gather.hierarchy, seen.side, seen.point);
        let clear: DVec3 =
            sources.clear.iter().map(|source| refined(source, shining, sources.little, at)).sum();
        let sequence = PairSequence::new(hash_pair(seen.seed, 0));
        brought.clear();
        brought.extend(sources.unknown.iter().map(|source| source.irradiance(at)));
        let total: f64 = brought.iter().map(|irradiance| irradiance.element_sum()).sum();
        // Where much more arrives than in the middle of the element, the number of rays stays in bounds.
        let share = sources.share.max(total / (CUT_AGAIN * MOST_RAYS * f64::from(gather.rays)));
        let mut arriving = Arriving::new(gather.tracer, at, share, sequence);
        for (source, &irradiance) in sources.unknown.iter().zip(brought.iter()) {
            let brought = irradiance.element_sum();
            if brought > CUT_AGAIN * share {
                for half in source.halves(shining) {
                    half.cut(share, shining, at, &mut |part| {
                        arriving.add(&part, part.irradiance(at), shining)
                    });
                }
            } else if brought > 0.0 {
                arriving.add(source, irradiance, shining);
            }
        }
        rest + (clear + arriving.sum()).max(DVec3::ZERO).as_vec3()
    }

    /// Collects what the links of all levels say about one element, cut as its middle sees it.
    fn find_sources(&mut self, side: Side, element: u32) {
        let Levels { gather, levels, lamps, shining, sources, .. } = self;
        let forest = &gather.solution.forest;
        let at = Spotlit::on(gather.hierarchy, side, forest.center[element as usize].as_dvec3());
        let known = gather.solution.light.irradiance[element as usize];
        let mut unknown = Vec::new();
        sources.element = Some(element);
        sources.little = UNEVEN * f64::from(known.max_element());
        sources.clear.clear();
        sources.unknown.clear();
        let mut add = |source: &Source, view: InView| {
            if source.piece.side.facet != side.facet {
                let list = if view == InView::All { &mut sources.clear } else { &mut unknown };
                list.push(source.clone());
            }
        };
        for (lamp, source) in (0..).zip(&*lamps) {
            let clear = levels.iter().flat_map(|level| &level.clear_lamps).filter(|clear| clear.0 == lamp);
            let clear: f32 = clear.map(|clear| clear.1).sum();
            let is_clear = clear >= forest.area[source.piece.id as usize] * (1.0 - NEARLY_ALL);
            add(source, if is_clear { InView::All } else { InView::Some });
        }
        for term in levels.iter().flat_map(|level| &level.terms) {
            add(&term.source, term.view);
        }
        let total: f64 = unknown.iter().map(|source| source.irradiance(at).element_sum()).sum();
        let rays = f64::from(gather.rays);
        sources.share = (f64::from(known.element_sum()) / rays).max(total / (MOST_RAYS * rays));
        for source in unknown {
            // What does not reach the middle may reach other points.
            if source.irradiance(at).element_sum() > sources.share {
                source.cut(sources.share, shining, at, &mut |part| sources.unknown.push(part));
            } else {
                sources.unknown.push(source);
            }
        }
    }

    /// Keeps what is above both the last element and this one.
    fn go_to(&mut self, side: Side, element: u32) {
        let (hierarchy, forest) = (self.gather.hierarchy, &self.gather.solution.forest);
        let clusters = hierarchy.nodes.len() as u32;
        self.path.clear();
        self.path.extend(hierarchy.lineage(hierarchy.leaf(side.facet)));
        self.path.reverse();
        if let Some(index) = forest.side_index(side) {
            let mut above = forest.first_element[index];
            self.path.push(clusters + above);
            while above != element {
                let second = forest.second[above as usize];
                above = if element < second { above + 1 } else { second };
                self.path.push(clusters + above);
            }
        }
        let common =
            self.levels.iter().zip(&self.path).take_while(|(level, node)| level.node == **node).count();
        self.levels.truncate(common);
        for &node in &self.path[common..] {
            self.levels.push(Level::of(self.gather, node, &self.shining));
        }
    }
}

/// What a source in full view brings: of one that is not uniform, the sum of its parts.
fn refined(source: &Source, shining: &SentOut<'_>, little: f64, at: Spotlit) -> DVec3 {
    let irradiance = source.irradiance(at);
    let element = source.piece.id as usize;
    let (forest, light) = (shining.forest, shining.light);
    let uneven = f64::from(light.variation[element]) / source.exitance.max_element().max(f64::MIN_POSITIVE);
    if forest.second[element] == 0 || 0.5 * uneven * irradiance.max_element() <= little {
        return irradiance;
    }
    source.halves(shining).iter().map(|half| refined(half, shining, little, at)).sum()
}
