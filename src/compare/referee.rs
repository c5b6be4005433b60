//! Who is right when two tracers disagree about a segment: within rounding of an edge or an end both may be,
//! anywhere else one is wrong. The referee tests every triangle in double precision.

use super::distance::{distance_between, distance_from_plane, distance_to_change, is_edge_on};
use crate::hierarchy::TOLERANCE;
use crate::tracer::{BruteTracer, Candidates, Hit, NO_FACET, Ray, Segment, TraceMesh, Tracer};
use glam::DVec3;
use serde::Serialize;

/// What an answer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Standing {
    /// The referee says so too.
    Right,
    /// The referee says otherwise, but the segment is within the tolerance of the edge or the end that decides.
    Tolerance,
    /// The referee says otherwise, and the facet is seen nearly edge-on: the ray goes along an edge, or in the plane
    /// of the facet, and on which side it passes has been rounded away.
    #[serde(rename = "edge-on")]
    EdgeOn,
    /// The referee says otherwise, and rounding does not explain it.
    Wrong,
}

/// The referee on one answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ruling {
    /// What the answer is.
    pub standing: Standing,
    /// How far the segment is from where the answer would be right, local units; 0 when it is.
    pub distance: f64,
    /// The facet that was missed or that does not block; [`NO_FACET`] when the answer is right.
    pub facet: u32,
}

impl Ruling {
    /// The answer is the referee's.
    pub const RIGHT: Ruling = Ruling { standing: Standing::Right, distance: 0.0, facet: NO_FACET };
}

/// The largest coordinate of a segment where that is more than 1: what rounding of its ends is relative to.
fn reach(segment: &Segment) -> f64 {
    segment.from.abs().max(segment.to.abs()).max_element().max(1.0) as f64
}

/// How near to an edge or an end rounding may decide, local units: the tolerance of the whole program, which is a
/// few roundings of single precision, and more for a segment that goes far beyond the scene.
pub fn tolerance_for(segment: &Segment) -> f64 {
    TOLERANCE * reach(segment)
}

/// The same for a ray; the scene goes from about −1 to 1.
pub fn tolerance_for_ray(ray: &Ray) -> f64 {
    TOLERANCE * ray.origin.abs().max_element().max(1.0) as f64
}

/// Further than anything in a scene is from anything else, in units of the largest coordinate.
const FAR: f64 = 10.0;

fn point_at(ray: &Ray, hit: Hit) -> DVec3 {
    ray.origin.as_dvec3() + ray.direction.as_dvec3() * hit.t as f64
}

/// Settles disagreements on one mesh.
pub struct Referee<'a> {
    mesh: &'a TraceMesh,
    judge: BruteTracer,
}

impl<'a> Referee<'a> {
    /// A referee for `mesh`.
    pub fn new(mesh: &'a TraceMesh) -> Referee<'a> {
        Referee { mesh, judge: BruteTracer::new(mesh) }
    }

    /// Every facet of these that blocks a segment, ascending.
    pub fn blockers(&self, segment: &Segment, within: Candidates<'_>) -> Vec<u32> {
        let mut found = self.judge.all_blockers(segment);
        found.retain(|&facet| within.contains(facet));
        found
    }

    /// Judges what two tracers say blocks a segment: a facet or [`NO_FACET`]; they were asked about the facets `within`.
    /// `tolerance` is a local length.
    ///
    /// A facet that is named has to block. Where both say that the segment is clear nobody is asked.
    pub fn rule(
        &self,
        segment: &Segment,
        answers: [u32; 2],
        within: Candidates<'_>,
        tolerance: f64,
    ) -> [Ruling; 2] {
        if answers == [NO_FACET; 2] {
            return [Ruling::RIGHT; 2];
        }
        let may_block = |facet: u32| within.contains(facet) && !segment.skip.contains(&facet);
        let confirmed = answers
            .map(|facet| facet != NO_FACET && may_block(facet) && self.judge.is_blocked_by(segment, facet));
        if confirmed == [true; 2] {
            return [Ruling::RIGHT; 2];
        }
        let named =
            answers.into_iter().zip(confirmed).find_map(|(facet, is_right)| is_right.then_some(facet));
        let mut missed = None;
        [0, 1].map(|side| match answers[side] {
            _ if confirmed[side] => Ruling::RIGHT,
            NO_FACET => *missed.get_or_insert_with(|| self.missed(segment, named, within, tolerance)),
            // By the id rule and the candidate rule no distance excuses it.
            facet if !may_block(facet) => Ruling {
                standing: Standing::Wrong,
                distance: segment.from.distance(segment.to).into(),
                facet,
            },
            facet => self.off(segment, facet, tolerance),
        })
    }

    /// The first thing that a ray meets.
    pub fn first_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut hits = [None];
        self.judge.first_hits(&[*ray], &mut hits);
        hits[0]
    }

    /// Judges what two tracers say a ray meets first. `tolerance` is a local length.
    ///
    /// Where both name the same facet and meet it in its plane nobody is asked.
    pub fn rule_hits(&self, ray: &Ray, answers: [Option<Hit>; 2], tolerance: f64) -> [Ruling; 2] {
        let facets = answers.map(|hit| hit.map(|hit| hit.facet));
        let is_on_it = |hit: Hit| distance_from_plane(self.mesh, hit.facet, point_at(ray, hit)) <= tolerance;
        if facets[0] == facets[1] && answers.iter().flatten().all(|&hit| is_on_it(hit)) {
            return [Ruling::RIGHT; 2];
        }
        let expected = self.first_hit(ray);
        answers.map(|got| {
            let facet = got.or(expected).map_or(NO_FACET, |hit| hit.facet);
            let distance = self.hit_off_by(ray, got, expected);
            let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let is_seen_edge_on = |hit: Hit| is_edge_on(self.mesh, hit.facet, origin, direction, tolerance);
            let is_same = got.map(|hit| hit.facet) == expected.map(|hit| hit.facet);
            let standing = match distance <= tolerance {
                true if is_same => return Ruling::RIGHT,
                true => Standing::Tolerance,
                false if got.or(expected).is_some_and(is_seen_edge_on) => Standing::EdgeOn,
                false => Standing::Wrong,
            };
            Ruling { standing, distance, facet }
        })
    }

    /// How far a ray is from the outline of a facet, and its start from the facet itself.
    pub fn distance_from_outline(&self, ray: &Ray, facet: u32) -> f64 {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize_or_zero());
        let far = FAR * origin.abs().max_element().max(1.0);
        distance_between(self.mesh, facet, [origin, origin + direction * far])
    }

    /// How far a ray, or what it meets, would have to be moved to make an answer the expected one.
    fn hit_off_by(&self, ray: &Ray, got: Option<Hit>, expected: Option<Hit>) -> f64 {
        let to_outline = |hit: Hit| self.distance_from_outline(ray, hit.facet);
        let to_plane = |of: Hit, at: Hit| distance_from_plane(self.mesh, of.facet, point_at(ray, at));
        match (got, expected) {
            (Some(g), Some(e)) if g.facet == e.facet => to_plane(e, g),
            // One is a false hit or the other was missed, unless they are met in the same place.
            (Some(g), Some(e)) => {
                let is_met = self.judge.hit_on(ray, g.facet).is_some();
                let same_place = if is_met { to_plane(e, g).max(to_plane(g, e)) } else { f64::INFINITY };
                same_place.min(to_outline(if g.t < e.t { g } else { e }))
            }
            (Some(hit), None) | (None, Some(hit)) => to_outline(hit),
            (None, None) => 0.0,
        }
    }

    /// The ruling on "clear"; `named` is a facet that the other tracer says blocks and that does.
    fn missed(
        &self,
        segment: &Segment,
        named: Option<u32>,
        within: Candidates<'_>,
        tolerance: f64,
    ) -> Ruling {
        let by_named = named.map(|facet| self.off(segment, facet, tolerance));
        match by_named {
            Some(ruling) if ruling.standing == Standing::Wrong => ruling,
            // It was missed with everything else that blocks.
            _ => self
                .blockers(segment, within)
                .into_iter()
                .map(|facet| self.off(segment, facet, tolerance))
                .max_by(|a, b| a.standing.cmp(&b.standing).then(a.distance.total_cmp(&b.distance)))
                .unwrap_or(Ruling::RIGHT),
        }
    }

    /// The ruling on an answer that is not the referee's because of one facet.
    fn off(&self, segment: &Segment, facet: u32, tolerance: f64) -> Ruling {
        let distance = distance_to_change(self.mesh, facet, segment);
        let [from, to] = [segment.from, segment.to].map(|end| end.as_dvec3());
        let standing = if distance <= tolerance {
            Standing::Tolerance
        } else if is_edge_on(self.mesh, facet, from, to - from, tolerance) {
            Standing::EdgeOn
        } else {
            Standing::Wrong
        };
        Ruling { standing, distance, facet }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracer::Interval;
    use glam::Vec3;

    /// Two squares of side 2 across the z axis, at z = 0 and z = 1.
    fn squares() -> TraceMesh {
        let mut mesh = TraceMesh { first_triangle: vec![0], ..TraceMesh::default() };
        for z in [0.0, 1.0] {
            let base = mesh.positions.len() as u32;
            mesh.positions.extend(
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, z)),
            );
            mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
            mesh.facet_of_triangle.extend([base / 4; 2]);
            mesh.first_triangle.push(mesh.triangles.len() as u32);
        }
        mesh
    }

    fn along_z(x: f32, from: f32, to: f32) -> Segment {
        Segment { from: Vec3::new(x, 0.1, from), to: Vec3::new(x, 0.1, to), skip: [NO_FACET; 2] }
    }

    fn standings(segment: Segment, answers: [u32; 2]) -> [Standing; 2] {
        within(segment, answers, Candidates::All)
    }

    fn within(segment: Segment, answers: [u32; 2], list: Candidates<'_>) -> [Standing; 2] {
        let mesh = squares();
        let rulings = Referee::new(&mesh).rule(&segment, answers, list, tolerance_for(&segment));
        rulings.map(|ruling| ruling.standing)
    }

    #[test]
    fn any_facet_that_blocks_may_be_named() {
        assert_eq!(standings(along_z(0.5, -1.0, 2.0), [0, 1]), [Standing::Right; 2]);
        assert_eq!(standings(along_z(1.5, -1.0, 2.0), [NO_FACET; 2]), [Standing::Right; 2]);
    }

    #[test]
    fn what_is_no_candidate_does_not_block() {
        let (through, first) = (along_z(0.5, -1.0, 2.0), [Interval { start: 0, end: 1 }]);
        let list = Candidates::Only(&first);
        assert_eq!(within(through, [0, NO_FACET], list), [Standing::Right, Standing::Wrong]);
        assert_eq!(within(through, [1, 0], list), [Standing::Wrong, Standing::Right]);
        let second_only = along_z(0.5, 0.5, 2.0);
        assert_eq!(within(second_only, [1, NO_FACET], list), [Standing::Wrong, Standing::Right]);
        assert_eq!(standings(second_only, [1, NO_FACET]), [Standing::Right, Standing::Wrong]);
    }

    #[test]
    fn what_is_missed_or_made_up_far_from_every_edge_is_wrong() {
        assert_eq!(standings(along_z(0.5, -1.0, 2.0), [0, NO_FACET]), [Standing::Right, Standing::Wrong]);
        assert_eq!(standings(along_z(1.5, -1.0, 2.0), [0, NO_FACET]), [Standing::Wrong, Standing::Right]);
        assert_eq!(standings(along_z(0.5, -1.0, 0.5), [1, 0]), [Standing::Wrong, Standing::Right]);
    }

    #[test]
    fn what_is_within_rounding_of_an_edge_or_an_end_may_be_either() {
        let beside = along_z(1.000_001, -1.0, 2.0);
        assert_eq!(standings(beside, [0, NO_FACET]), [Standing::Tolerance, Standing::Right]);
        let inside = along_z(0.999_999, -1.0, 2.0);
        assert_eq!(standings(inside, [NO_FACET, 1]), [Standing::Tolerance, Standing::Right]);
        let short = along_z(0.5, -1.0, 1e-6);
        assert_eq!(standings(short, [0, NO_FACET]), [Standing::Tolerance, Standing::Right]);
    }

    /// Near the edge of the facet that the other names, but another one was missed far from its edges.
    #[test]
    fn one_missed_facet_is_enough_to_be_wrong() {
        let mut mesh = squares();
        mesh.positions[5].x = 3.0;
        mesh.positions[6].x = 3.0;
        let segment = along_z(0.999_999, -1.0, 2.0);
        let [left, right] = Referee::new(&mesh).rule(&segment, [0, NO_FACET], Candidates::All, TOLERANCE);
        assert_eq!((left, right.standing, right.facet), (Ruling::RIGHT, Standing::Wrong, 1));
    }

    #[test]
    fn in_the_plane_of_a_facet_nothing_can_be_told() {
        let beside =
            Segment { from: Vec3::new(1.5, -1.0, 1.0), to: Vec3::new(1.6, 1.0, 1.0), skip: [NO_FACET; 2] };
        assert_eq!(standings(beside, [1, NO_FACET]), [Standing::EdgeOn, Standing::Right]);
        assert_eq!(standings(beside, [0, NO_FACET]), [Standing::Wrong, Standing::Right]);
    }

    /// At an angle to its plane, but so that a thin triangle looks thinner than rounding, and beyond its tip.
    #[test]
    fn a_sliver_seen_edge_on_cannot_be_told_from_its_lines() {
        let mut mesh = squares();
        let sliver = [Vec3::new(0.0, 0.0, 0.5), Vec3::new(0.0, 1e-4, 0.5), Vec3::new(0.01, 0.0, 0.5)];
        mesh.positions.extend(sliver);
        mesh.triangles.push([8, 9, 10]);
        mesh.facet_of_triangle.push(2);
        mesh.first_triangle.push(5);
        // Along the short side, beyond the end of the long one.
        let standing = |tilt: f32, above: f32| {
            let (middle, along) = (Vec3::new(-2e-5, 0.0, 0.5 + above), Vec3::new(0.0, 0.4, 0.4 * tilt));
            let segment = Segment { from: middle - along, to: middle + along, skip: [NO_FACET; 2] };
            Referee::new(&mesh).rule(&segment, [2, NO_FACET], Candidates::All, TOLERANCE)[0].standing
        };
        assert_eq!(standing(5e-3, 0.0), Standing::EdgeOn);
        assert_eq!(standing(5e-3, 1e-5), Standing::Wrong, "it passes above");
        assert_eq!(standing(0.5, 0.0), Standing::Wrong, "the short side is seen too");
    }

    /// A long triangle met at an angle of 1e-4, nearly along its long side, inside.
    #[test]
    fn along_an_edge_rounding_is_worth_more_than_the_distance() {
        let mut mesh = squares();
        mesh.positions.extend([(-0.9, 0.0), (0.9, 0.0), (0.0, 0.4)].map(|(x, y)| Vec3::new(x, y, 0.5)));
        mesh.triangles.push([8, 9, 10]);
        mesh.facet_of_triangle.push(2);
        mesh.first_triangle.push(5);
        let standing = |turn: f32, slope: f32, inside: f32| {
            let (middle, along) = (Vec3::new(0.0, inside, 0.5), Vec3::new(1.0, turn, slope));
            let segment = Segment { from: middle - along, to: middle + along, skip: [NO_FACET; 2] };
            assert!(BruteTracer::new(&mesh).is_blocked_by(&segment, 2));
            Referee::new(&mesh).rule(&segment, [NO_FACET, 2], Candidates::All, TOLERANCE)[0].standing
        };
        assert_eq!(standing(0.0, 1e-4, 4e-3), Standing::EdgeOn);
        assert_eq!(standing(0.5, 1e-4, 4e-3), Standing::Tolerance, "across the edge it is as near as that");
        assert_eq!(standing(0.0, 5e-4, 4e-3), Standing::Wrong);
        assert_eq!(standing(0.5, 2e-2, 4e-3), Standing::Wrong);
    }

    #[test]
    fn a_facet_that_an_end_lies_on_never_blocks() {
        let segment = Segment { skip: [0, NO_FACET], ..along_z(0.5, 0.0, 2.0) };
        assert_eq!(standings(segment, [0, 1]), [Standing::Wrong, Standing::Right]);
    }

    #[test]
    fn first_hits_are_judged_by_where_they_are() {
        let mesh = squares();
        let referee = Referee::new(&mesh);
        let ray = |x: f32| Ray { origin: Vec3::new(x, 0.1, -1.0), direction: Vec3::new(0.0, 0.0, 0.5) };
        let hit = |facet: u32, t: f32| Some(Hit { facet, triangle: 2 * facet, t });
        let standings = |x: f32, answers| referee.rule_hits(&ray(x), answers, TOLERANCE).map(|r| r.standing);
        assert_eq!(standings(0.5, [hit(0, 2.0), hit(0, 2.000_002)]), [Standing::Right; 2]);
        assert_eq!(standings(0.5, [hit(0, 2.0), hit(0, 2.1)]), [Standing::Right, Standing::Wrong]);
        assert_eq!(standings(0.5, [hit(1, 4.0), hit(0, 2.0)]), [Standing::Wrong, Standing::Right]);
        assert_eq!(standings(0.5, [None, hit(0, 2.0)]), [Standing::Wrong, Standing::Right]);
        assert_eq!(standings(1.5, [None, hit(0, 2.0)]), [Standing::Right, Standing::Wrong]);
        assert_eq!(standings(0.999_999, [hit(1, 4.0), hit(0, 2.0)]), [Standing::Tolerance, Standing::Right]);
        assert_eq!(standings(1.000_001, [None, hit(0, 2.0)]), [Standing::Right, Standing::Tolerance]);
    }

    #[test]
    fn far_from_the_scene_rounding_is_larger() {
        let far = along_z(1.000_5, -1000.0, 2.0);
        assert_eq!(standings(far, [0, NO_FACET]), [Standing::Tolerance, Standing::Right]);
        assert_eq!(standings(along_z(1.000_5, -1.0, 2.0), [0, NO_FACET]), [Standing::Wrong, Standing::Right]);
    }
}
