//! What a link between two nodes would carry and how wrong one number for it would be: the figures
//! the refinement oracle decides by.

use super::forest::{Forest, Piece};
use super::form_factor::PolygonSource;
use super::links::Link;
use super::transport::Light;
use crate::hierarchy::{Hierarchy, TOLERANCE};
use crate::math::{Plane, Polygon};
use crate::visibility::NodeEnd;
use glam::DVec3;
use std::f64::consts::PI;

/// A receiver further away than this many times its extent is described by its centre.
const FAR: f64 = 5.0;

/// Form factors that differ by more than this share of their mean between a few points are taken at more.
const UNEVEN: f64 = 0.25;

/// A node of a pair, with the light it sends.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "elements are most of them, and made far too often for a box")]
pub(super) enum Party {
    Element {
        piece: Piece,
        area: f64,
        /// Largest channel of its exitance; of the nearest solved ancestor when it is new.
        exitance: f64,
        /// How much that differs below.
        variation: f64,
    },
    Cluster(u32),
}

impl Party {
    /// The node with this id, as links store it.
    pub(super) fn of_id(id: u32, hierarchy: &Hierarchy, forest: &Forest, light: &Light) -> Party {
        match id.checked_sub(hierarchy.nodes.len() as u32) {
            None => Party::Cluster(id),
            Some(element) => Party::of_piece(forest.piece(hierarchy, element), light),
        }
    }

    pub(super) fn of_piece(piece: Piece, light: &Light) -> Party {
        let id = piece.id as usize;
        let (exitance, variation) = (light.exitance[id].max_element() as f64, light.variation[id] as f64);
        Party::Element { area: piece.polygon.area(), piece, exitance, variation }
    }

    /// The nodes it is split into: two halves, or what the cluster holds.
    pub(super) fn parts(&self, hierarchy: &Hierarchy, forest: &Forest, light: &Light) -> Vec<Party> {
        match self {
            Party::Element { piece, exitance, .. } => piece
                .halves(forest)
                .map(|half| {
                    if (half.id as usize) < light.exitance.len() {
                        Party::of_piece(half, light)
                    } else {
                        Party::Element {
                            area: half.polygon.area(),
                            piece: half,
                            exitance: *exitance,
                            variation: 0.0,
                        }
                    }
                })
                .into(),
            Party::Cluster(node) => hierarchy.nodes[*node as usize]
                .children(*node)
                .into_iter()
                .flat_map(|child| Party::of_node(child, hierarchy, forest, light))
                .collect(),
        }
    }

    /// A cluster, or both sides of a leaf's facet.
    pub(super) fn of_node(node: u32, hierarchy: &Hierarchy, forest: &Forest, light: &Light) -> Vec<Party> {
        let n = &hierarchy.nodes[node as usize];
        if !n.is_leaf() {
            return vec![Party::Cluster(node)];
        }
        let sides = forest.sides_of(n.first);
        sides.map(|side| Party::of_piece(forest.root(hierarchy, side), light)).collect()
    }

    /// What visibility is tested on: all of it, or the `part` of an element.
    pub(super) fn end<'b>(&'b self, part: Option<&'b Polygon>) -> NodeEnd<'b> {
        match self {
            Party::Element { piece, .. } => NodeEnd::Element {
                polygon: part.unwrap_or(&piece.polygon),
                plane: piece.plane,
                facet: piece.side.facet,
            },
            Party::Cluster(node) => NodeEnd::Cluster(*node),
        }
    }

    /// The part that faces `other`, when both are elements.
    pub(super) fn part_facing(&self, other: &Party) -> Option<Polygon> {
        match (self, other) {
            (Party::Element { piece, .. }, Party::Element { piece: other, .. }) => facing_part(piece, other),
            _ => None,
        }
    }

    /// Node id as links store it.
    pub(super) fn id(&self, hierarchy: &Hierarchy) -> u32 {
        match self {
            Party::Element { piece, .. } => hierarchy.nodes.len() as u32 + piece.id,
            Party::Cluster(node) => *node,
        }
    }

    /// A name that does not depend on who made the element first.
    pub(super) fn key(&self) -> u64 {
        match self {
            Party::Element { piece, .. } => piece.key,
            Party::Cluster(node) => *node as u64,
        }
    }

    /// Whether it is known to be equally bright everywhere.
    pub(super) fn is_uniform(&self) -> bool {
        matches!(self, Party::Element { variation, .. } if *variation <= 0.0)
    }

    fn center(&self, hierarchy: &Hierarchy) -> DVec3 {
        match self {
            Party::Element { piece, .. } => piece.polygon.center(),
            Party::Cluster(node) => hierarchy.nodes[*node as usize].center.as_dvec3(),
        }
    }

    /// Radius of a sphere around it.
    pub(super) fn radius(&self, hierarchy: &Hierarchy) -> f64 {
        match self {
            Party::Element { piece, .. } => piece.polygon.extent() * 0.5,
            Party::Cluster(node) => hierarchy.nodes[*node as usize].bounds.radius(),
        }
    }

    pub(super) fn area(&self, hierarchy: &Hierarchy) -> f64 {
        match self {
            Party::Element { area, .. } => *area,
            Party::Cluster(node) => hierarchy.nodes[*node as usize].area as f64,
        }
    }

    /// Power it sends at most, and its largest exitance.
    fn output(&self, light: &Light) -> (f64, f64) {
        match self {
            Party::Element { area, exitance, variation, .. } => (area * exitance, exitance + variation),
            Party::Cluster(node) => (light.power[*node as usize] as f64, light.peak[*node as usize] as f64),
        }
    }

    /// Smallest and largest height above a plane.
    fn heights(&self, hierarchy: &Hierarchy, plane: &Plane) -> (f64, f64) {
        match self {
            Party::Element { piece, .. } => {
                let heights = piece.polygon.vertices().iter().map(|&v| plane.distance(v));
                heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)))
            }
            Party::Cluster(node) => plane.distance_range(&hierarchy.nodes[*node as usize].bounds),
        }
    }

    /// Whether any of it lies in front of an element's plane.
    fn reaches_in_front_of(&self, hierarchy: &Hierarchy, other: &Party) -> bool {
        match other {
            Party::Element { piece, .. } => self.heights(hierarchy, &piece.plane).1 > TOLERANCE,
            Party::Cluster(_) => true,
        }
    }
}

/// Figures of one link.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Estimate {
    /// See [`super::Link::factor`].
    pub(super) factor: f64,
    /// See [`super::Link::spread`].
    pub(super) spread: f64,
    /// Unoccluded power it carries, largest channel, local areas.
    pub(super) power: f64,
    /// Irradiance it brings.
    pub(super) irradiance: f64,
    /// The nodes are too close for a cluster's factor to mean anything.
    pub(super) near: bool,
    /// [`refined_factor`] is better.
    pub(super) rough: bool,
    /// Power that may go wrong because the kernel differs over the receiver (or over a cluster).
    pub(super) kernel_error: f64,
    /// Power that may go wrong because the source is not uniform.
    pub(super) source_error: f64,
}

/// Figures of the link from `source` to `receiver`; `None` when they face away from each other.
pub(super) fn estimate(
    receiver: &Party,
    source: &Party,
    hierarchy: &Hierarchy,
    light: &Light,
) -> Option<Estimate> {
    if !receiver.reaches_in_front_of(hierarchy, source) || !source.reaches_in_front_of(hierarchy, receiver) {
        return None;
    }
    if let (Party::Element { piece: r, area, .. }, Party::Element { piece: s, exitance, variation, .. }) =
        (receiver, source)
    {
        let factor = element_factor(r, s)?;
        return Some(Estimate {
            rough: factor.rough,
            ..element_estimate((factor.mean, factor.spread), *area, (*exitance, *variation))
        });
    }
    Some(cluster_estimate(receiver, source, hierarchy, light))
}

/// Figures of a link that is there already.
pub(super) fn estimate_of_link(
    link: &Link,
    receiver: &Party,
    source: &Party,
    hierarchy: &Hierarchy,
    light: &Light,
) -> Option<Estimate> {
    match (receiver, source) {
        (Party::Element { area, .. }, Party::Element { exitance, variation, .. }) => {
            let factor = (link.factor as f64, link.spread() as f64);
            Some(element_estimate(factor, *area, (*exitance, *variation)))
        }
        _ => estimate(receiver, source, hierarchy, light),
    }
}

/// Figures of a link between elements, from its factor and how much that differs, the area that receives, and the
/// exitance that is sent and how much that differs.
fn element_estimate((factor, spread): (f64, f64), area: f64, (exitance, variation): (f64, f64)) -> Estimate {
    Estimate {
        factor,
        spread,
        power: factor * exitance * area,
        irradiance: factor * exitance,
        near: false,
        rough: false,
        kernel_error: 0.5 * spread * exitance * area,
        source_error: 0.5 * factor * variation * area,
    }
}

/// The form factor of an element to another.
struct Factor {
    mean: f64,
    spread: f64,
    /// It differs so much that more points would give a better mean.
    rough: bool,
}

/// Mean form factor over the receiver by a few points, and how much it differs; `None` when it is 0 everywhere.
fn element_factor(receiver: &Piece, source: &Piece) -> Option<Factor> {
    let (lit, shining) = (facing_part(receiver, source)?, facing_part(source, receiver)?);
    let (area, lit_area) = (receiver.polygon.area(), lit.area());
    let share = lit_area / area;
    let seen = PolygonSource::new(&shining, source.plane);
    let normal = receiver.plane.normal;
    let own = lit.extent();
    let distance = lit.center().distance(seen.center()) - 0.5 * seen.extent();
    if distance > FAR * own {
        let factor = share * seen.form_factor(lit.center(), normal);
        // The kernel falls with the square of the distance and turns with two cosines.
        let spread = factor * (2.0 * own / distance + (1.0 - share));
        return (factor > 0.0).then_some(Factor { mean: factor, spread, rough: false });
    }
    let sampled = Sampled::over(&lit, normal, &seen);
    let near = seen.form_factor(nearest_point(&lit, &receiver.plane, seen.center()), normal);
    // The quadrature points cover the inner part; the corners lie further out.
    let low = if share < 1.0 { 0.0 } else { sampled.low };
    let spread = ((sampled.high - low) / sampled.inset).max((near - sampled.mean).abs());
    let shining_area = shining.area();
    let (mean, rough) = if is_taken_over_source((receiver, lit_area), (source, shining_area)) {
        let back = Sampled::over(&shining, source.plane.normal, &PolygonSource::new(&lit, receiver.plane));
        (back.mean.min(1.0) * shining_area / area, back.is_rough())
    } else {
        (share * sampled.mean, sampled.is_rough())
    };
    (mean > 0.0 || sampled.high > 0.0 || near > 0.0).then_some(Factor { mean, spread, rough })
}

/// The mean form factor over the receiver by more points: where it differs much over the polygon, as near a contact.
pub(super) fn refined_factor(receiver: &Piece, source: &Piece) -> Option<f64> {
    let (lit, shining) = (facing_part(receiver, source)?, facing_part(source, receiver)?);
    let (lit_area, shining_area) = (lit.area(), shining.area());
    let (over, over_area, normal, other) =
        if is_taken_over_source((receiver, lit_area), (source, shining_area)) {
            (&shining, shining_area, source.plane.normal, PolygonSource::new(&lit, receiver.plane))
        } else {
            (&lit, lit_area, receiver.plane.normal, PolygonSource::new(&shining, source.plane))
        };
    Some(refined_mean(over, normal, &other)?.min(1.0) * over_area / receiver.polygon.area())
}

/// The contour formula is exact over the one of larger area, and what the source sends to the receiver is what the
/// receiver gets, `A_i F_ij = A_j F_ji`, so the mean is taken over the smaller one. Of two alike it is the same one both
/// ways.
fn is_taken_over_source((receiver, lit): (&Piece, f64), (source, shining): (&Piece, f64)) -> bool {
    lit > shining || lit == shining && receiver.key > source.key
}

/// The part of a piece that lies in front of the other's plane: the rest has no part in their exchange.
fn facing_part(piece: &Piece, other: &Piece) -> Option<Polygon> {
    let lifted = Plane { offset: other.plane.offset + TOLERANCE, ..other.plane };
    piece.polygon.clipped(&lifted)
}

/// Form factors at a few points of a polygon.
struct Sampled {
    mean: f64,
    low: f64,
    high: f64,
    /// How far out the points lie between centre and corners.
    inset: f64,
}

impl Sampled {
    fn over(polygon: &Polygon, normal: DVec3, other: &PolygonSource<'_>) -> Sampled {
        let (center, vertices) = (polygon.center(), polygon.vertices());
        let inset = if vertices.len() == 3 { 0.5 } else { 1.0 / 3f64.sqrt() };
        let (mut sum, mut low, mut high) = (0.0, f64::MAX, 0.0f64);
        for &v in vertices {
            let f = other.form_factor(center.lerp(v, inset), normal);
            sum += f;
            low = low.min(f);
            high = high.max(f);
        }
        Sampled { mean: sum / vertices.len() as f64, low, high, inset }
    }

    /// Whether they differ so much that their mean may be wrong.
    fn is_rough(&self) -> bool {
        self.high - self.low > UNEVEN * self.mean
    }
}

/// The mean form factor over a polygon by the points of its quarters; `None` if it has no area, as what a plane leaves
/// of one may have none.
fn refined_mean(polygon: &Polygon, normal: DVec3, other: &PolygonSource<'_>) -> Option<f64> {
    let quarters = polygon.bisect().into_iter().flat_map(|half| half.bisect());
    let (sum, area) = quarters.fold((0.0, 0.0), |(sum, area), part| {
        let own = part.area();
        (sum + Sampled::over(&part, normal, other).mean * own, area + own)
    });
    (area > 0.0).then(|| sum / area)
}

/// A point of a polygon near to `target`, a little inside.
fn nearest_point(polygon: &Polygon, plane: &Plane, target: DVec3) -> DVec3 {
    let center = polygon.center();
    let mut point = target - plane.normal * plane.distance(target);
    for (a, b) in polygon.edges() {
        let outward = (b - a).cross(plane.normal);
        let (out, own) = ((point - a).dot(outward), (center - a).dot(outward));
        if out > 0.0 && own < 0.0 {
            point = center + (point - center) * (own / (own - out));
        }
    }
    point.lerp(center, 0.05)
}

/// The part of a node in front of a plane: of a cluster that straddles the horizon only what is above it
/// takes part.
struct InFront {
    /// About how much of it that is.
    share: f64,
    /// Mean height of that part.
    height: f64,
}

impl InFront {
    /// Of a node that reaches in front of the plane.
    fn of(party: &Party, hierarchy: &Hierarchy, plane: &Plane) -> InFront {
        let (low, high) = party.heights(hierarchy, plane);
        let center = plane.distance(party.center(hierarchy));
        if low >= 0.0 {
            return InFront { share: 1.0, height: center };
        }
        InFront { share: high / (high - low), height: high * (center - low) / (high - low) }
    }
}

/// Figures of a link with a cluster at one end or both.
fn cluster_estimate(receiver: &Party, source: &Party, hierarchy: &Hierarchy, light: &Light) -> Estimate {
    let to_source = source.center(hierarchy) - receiver.center(hierarchy);
    let reach = receiver.radius(hierarchy) + source.radius(hierarchy);
    let distance = to_source.length();
    let area = receiver.area(hierarchy);
    let (sent, peak) = source.output(light);
    // A ball that shines evenly lights a point outside as its centre would. Inside each other's spheres
    // the kernel means little: the error says so, and the mean square distance of two points, with one
    // centre about a third of the squared radii, keeps it finite.
    let near = distance < reach;
    let radii = [receiver, source].map(|party| party.radius(hierarchy).powi(2)).iter().sum::<f64>();
    let inside = (1.0 - distance / reach).max(0.0);
    let safe = (distance * distance + inside * radii / 3.0).sqrt().max(f64::MIN_POSITIVE);
    let direction = if distance > 0.0 { to_source / distance } else { DVec3::ZERO };
    let (cosine, above) = match receiver {
        Party::Element { piece, .. } => {
            let seen = InFront::of(source, hierarchy, &piece.plane);
            ((seen.height / safe).clamp(0.0, 1.0) * seen.share, seen.share)
        }
        Party::Cluster(_) => (1.0, 1.0),
    };
    let received = cosine / (safe * safe);
    // No link brings more irradiance than the source has exitance.
    let (factor, intensity, share) = match source {
        Party::Element { piece, exitance, .. } => {
            let polygon = PolygonSource::new(&piece.polygon, piece.plane);
            let lit = InFront::of(receiver, hierarchy, &piece.plane);
            let center = receiver.center(hierarchy);
            let point = center + piece.plane.normal * (lit.height - piece.plane.distance(center));
            let factor = polygon.form_factor(point, (polygon.center() - point).normalize_or_zero());
            (lit.share * factor, *exitance, lit.share)
        }
        Party::Cluster(node) => {
            let received = received.min(PI / source.area(hierarchy).max(f64::MIN_POSITIVE));
            let lobes = &light.intensity[hierarchy.cluster_place(*node)];
            let lobe = if distance > 0.0 { lobes.evaluate((-direction).as_vec3()) } else { lobes.mean() };
            (received, lobe.max_element() as f64, above)
        }
    };
    // More than it sends, or more than its brightest part everywhere, cannot arrive.
    let most = sent.min(peak * area);
    let power = if near { most } else { (factor * intensity * area).min(most) };
    let relative = match source {
        _ if near => 1.0,
        Party::Element { .. } => receiver.radius(hierarchy) / distance,
        Party::Cluster(_) => reach / distance,
    };
    Estimate {
        factor,
        spread: factor * relative,
        power,
        irradiance: power / area.max(f64::MIN_POSITIVE),
        near,
        rough: false,
        kernel_error: (0.5 * power * relative / share).min(most),
        source_error: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit squares with a common edge, at right angles: 0.20004 by the closed form. \[CW93\]
    #[test]
    fn more_points_tell_more_about_squares_that_touch() {
        let square = |other: DVec3| Polygon::new(&[DVec3::ZERO, DVec3::X, DVec3::X + other, other]);
        let (floor, wall) = (square(DVec3::Y), square(DVec3::Z).flipped());
        let source = PolygonSource::new(&wall, Plane::through(DVec3::ZERO, DVec3::Y));
        let sampled = Sampled::over(&floor, DVec3::Z, &source);
        assert!(sampled.is_rough());
        let refined = refined_mean(&floor, DVec3::Z, &source).expect("it has an area");
        let errors = [sampled.mean, refined].map(|mean| (mean / 0.200_043_776 - 1.0).abs());
        assert!(errors[1] < 0.01 && errors[1] < 0.5 * errors[0], "{errors:?}");
    }

    #[test]
    fn a_polygon_without_area_has_no_mean() {
        let line = Polygon::new(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::X * 3.0]);
        let wall = Polygon::new(&[DVec3::ZERO, DVec3::Z, DVec3::Z + DVec3::X, DVec3::X]);
        let source = PolygonSource::new(&wall, Plane::through(DVec3::ZERO, DVec3::Y));
        assert_eq!(refined_mean(&line, DVec3::Z, &source), None);
    }
}
