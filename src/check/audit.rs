//! Every link against rays: at sampled points, what each link brings and what rays find it should bring.
//! It shows pairs that no link covers or that several do, and which kind of link loses or makes light.

use crate::gather::lift;
use crate::hierarchy::{Hierarchy, Side};
use crate::math::{CosineLobes, PairSequence, cosine_direction, hash_pair};
use crate::radiosity::{LinkClass, Solution};
use crate::tracer::{PACKET, Ray, Tracer};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Light that points receive by one kind of link, as shares of all they receive.
#[derive(Clone, Copy, Debug, Default)]
pub struct KindAudit {
    /// Over the links.
    pub linked: f64,
    /// By rays.
    pub found: f64,
}

/// Kinds of links: whether the receiver and the source are clusters, and the class. The last is light
/// that rays find and no link covers.
pub const KINDS: usize = 4 * 5 + 2;

/// The answer.
#[derive(Clone, Debug)]
pub struct Audit {
    /// By kind.
    pub kinds: [KindAudit; KINDS],
    /// Rays that met a surface.
    pub pairs: u64,
    /// Of those, pairs of leaf elements that several links cover.
    pub twice: u64,
}

pub fn name(kind: usize) -> String {
    if kind == KINDS - 1 {
        return "no link".into();
    }
    if kind == KINDS - 2 {
        return "no link, emitter".into();
    }
    let class = ["untested", "visible", "certified", "partial", "invisible"][kind % 5];
    format!("{}<-{} {class}", ["E", "C"][kind / 10], ["E", "C"][kind / 5 % 2])
}

/// Looks at `points` leaf elements, chosen by the light they receive, with `rays` rays each.
pub fn audit(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    solution: &Solution,
    points: u32,
    rays: u32,
    chosen: &[u32],
) -> Audit {
    let (forest, light) = (&solution.forest, &solution.light);
    let clusters = hierarchy.nodes.len() as u32;
    let leaves: Vec<u32> = (0..forest.len() as u32).filter(|&e| forest.second[e as usize] == 0).collect();
    let power = |e: u32| (light.irradiance[e as usize].element_sum() * forest.area[e as usize]) as f64;
    let (total, area) =
        leaves.iter().fold((0.0, 0.0), |(p, a), &e| (p + power(e), a + forest.area[e as usize] as f64));
    let floor = 0.1 * total / area;
    let mut sum = 0.0;
    let sums: Vec<f64> = leaves
        .iter()
        .map(|&e| {
            sum += power(e) + floor * forest.area[e as usize] as f64;
            sum
        })
        .collect();
    // Parent of every element and cluster.
    let mut parents = vec![u32::MAX; clusters as usize + forest.len()];
    for (index, node) in hierarchy.nodes.iter().enumerate() {
        if node.is_leaf() {
            for side in forest.sides_of(node.first) {
                parents[clusters as usize + forest.first_element[side] as usize] = index as u32;
            }
        } else {
            node.children(index as u32).into_iter().for_each(|c| parents[c as usize] = index as u32);
        }
    }
    for e in 0..forest.len() {
        let second = forest.second[e];
        if second != 0 {
            parents[clusters as usize + e + 1] = clusters + e as u32;
            parents[(clusters + second) as usize] = clusters + e as u32;
        }
    }
    let chain = |node: u32| {
        std::iter::successors(Some(node), |&n| Some(parents[n as usize]).filter(|&p| p != u32::MAX))
    };
    let parts: Vec<Audit> = (0..points)
        .into_par_iter()
        .map(|index| {
            let mut audit = Audit { kinds: [KindAudit::default(); KINDS], pairs: 0, twice: 0 };
            let at = (index as f64 + 0.5) / points as f64 * sum;
            let element = if chosen.is_empty() {
                leaves[sums.partition_point(|&s| s <= at).min(leaves.len() - 1)]
            } else {
                chosen[index as usize]
            };
            let piece = forest.piece(hierarchy, element);
            let chance = (power(element) + floor * forest.area[element as usize] as f64) / sum;
            let weight = forest.area[element as usize] as f64 / (chance * points as f64 * total);
            let weight = if chosen.is_empty() {
                weight
            } else {
                1.0 / chosen.iter().map(|&e| light.irradiance[e as usize].element_sum() as f64).sum::<f64>()
            };
            let normal = piece.plane.normal;
            // What covers the sources, by source.
            let mut covers: HashMap<u32, Vec<(u32, usize)>> = HashMap::new();
            for receiver in chain(clusters + element) {
                for link in solution.links.of(receiver) {
                    let kind = 10 * usize::from(receiver < clusters)
                        + 5 * usize::from(link.source < clusters)
                        + link.class as usize;
                    covers.entry(link.source).or_default().push((receiver, kind));
                    let mut carried = light.carried(hierarchy, forest, link);
                    if receiver < clusters {
                        let mut lobes = CosineLobes::default();
                        lobes.add(crate::radiosity::direction(hierarchy, forest, link), carried);
                        carried = lobes.evaluate_signed(normal.as_vec3());
                    }
                    audit.kinds[kind].linked += carried.element_sum() as f64 * weight;
                }
            }
            let sequence = PairSequence::new(hash_pair(index as u64, 3));
            for first in (0..rays).step_by(PACKET) {
                let packet: [Ray; PACKET] = std::array::from_fn(|i| {
                    let [u, v, s, t] = sequence.point(first + i as u32);
                    let origin = lift(piece.polygon.point_at(u, v), normal);
                    Ray { origin: origin.as_vec3(), direction: cosine_direction(normal, s, t) }
                });
                let mut hits = [None; PACKET];
                tracer.first_hits(&packet, &mut hits);
                for (ray, hit) in packet.iter().zip(&hits) {
                    let Some(hit) = hit else { continue };
                    let plane = hierarchy.facets[hit.facet as usize].plane;
                    let back = plane.normal.dot(ray.direction.as_dvec3()) > 0.0;
                    let point = (ray.origin + ray.direction * hit.t).as_dvec3();
                    let Some(source) = forest.leaf_at(hierarchy, Side { facet: hit.facet, back }, point)
                    else {
                        continue;
                    };
                    let exitance: Vec3 = light.exitance[source.id() as usize];
                    let mut kinds = Vec::new();
                    for s in chain(clusters + source.id()) {
                        kinds.extend(covers.get(&s).into_iter().flatten().map(|&(_, kind)| kind));
                    }
                    audit.pairs += 1;
                    audit.twice += u64::from(kinds.len() > 1);
                    let emits = !back && hierarchy.material(hit.facet).is_emitter();
                    let kind = kinds.first().copied().unwrap_or(if emits { KINDS - 2 } else { KINDS - 1 });
                    audit.kinds[kind].found += exitance.element_sum() as f64 * weight / rays as f64;
                }
            }
            audit
        })
        .collect();
    parts.into_iter().fold(
        Audit { kinds: [KindAudit::default(); KINDS], pairs: 0, twice: 0 },
        |mut all, part| {
            for (a, p) in all.kinds.iter_mut().zip(part.kinds) {
                a.linked += p.linked;
                a.found += p.found;
            }
            all.pairs += part.pairs;
            all.twice += part.twice;
            all
        },
    )
}
