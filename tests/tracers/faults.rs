//! Faults planted in a tracer: a check that finds nothing here would find nothing anywhere.

use glam::Vec3;
use lightshaft::compare::{Family, distance_to_change, segments};
use lightshaft::hierarchy::TOLERANCE;
use lightshaft::tracer::{
    BruteTracer, Candidates, FallbackTracer, FilterAudit, Hit, Interval, NO_FACET, Ray, Segment, Tracer,
};

use crate::first_hits::{compare_hits, first_hits, ray_along};
use crate::meshes::soup;
use crate::verdict::{blockers, compare};

/// A tracer with a fault.
struct Faulty<'a> {
    tracer: &'a dyn Tracer,
    /// This segment is traced beside where it is, by so much; so is the ray from its first end to the other.
    offset: Option<(Segment, Vec3)>,
    /// This facet is not among the candidates, as if it had been culled.
    dropped: u32,
}

impl Faulty<'_> {
    fn traced(&self, ray: Ray) -> Ray {
        match self.offset {
            Some((which, by)) if ray_along(&which) == ray => Ray { origin: ray.origin + by, ..ray },
            _ => ray,
        }
    }

    /// What a ray meets behind the dropped facet.
    fn behind(&self, ray: &Ray, dropped: Hit) -> Option<Hit> {
        let step = dropped.t + 1e-5 / ray.direction.length();
        let mut hits = [None];
        self.tracer.first_hits(&[Ray { origin: ray.origin + ray.direction * step, ..*ray }], &mut hits);
        hits[0].map(|hit| Hit { t: hit.t + step, ..hit })
    }
}

impl Tracer for Faulty<'_> {
    fn name(&self) -> &'static str {
        self.tracer.name()
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        assert!(matches!(candidates, Candidates::All));
        let traced: Vec<Segment> = segments
            .iter()
            .map(|&s| match self.offset {
                Some((which, by)) if which == s => Segment { from: s.from + by, to: s.to + by, ..s },
                _ => s,
            })
            .collect();
        let left = [
            Interval { start: 0, end: self.dropped },
            Interval { start: self.dropped.saturating_add(1), end: u32::MAX },
        ];
        self.tracer.blockers(&traced, Candidates::Only(&left), blockers, audit);
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let traced: Vec<Ray> = rays.iter().map(|&ray| self.traced(ray)).collect();
        self.tracer.first_hits(&traced, hits);
        for (ray, hit) in traced.iter().zip(hits) {
            if let Some(dropped) = hit.filter(|hit| hit.facet == self.dropped) {
                *hit = self.behind(ray, dropped);
            }
        }
    }
}

/// One segment out of 4000, beside where it should be by a two-thousandth of the scene.
#[test]
fn one_offset_segment_is_noticed() {
    let mesh = soup(300, 51);
    let tracer = FallbackTracer::new(&mesh);
    let segments = segments(&mesh, Family::Beside(5e-4), 4000, 52);
    let judge = BruteTracer::new(&mesh);
    let right = blockers(&judge, &segments, Candidates::All);
    let by = Vec3::new(0.6e-3, -0.6e-3, 0.5e-3);
    let moved: Vec<Segment> =
        segments.iter().map(|&s| Segment { from: s.from + by, to: s.to + by, ..s }).collect();
    let other = blockers(&judge, &moved, Candidates::All);
    // The offset matters to those that it carries over an edge and that are not within rounding of another.
    let is_clear_cut =
        |segment: &Segment| (0..300).all(|facet| distance_to_change(&mesh, facet, segment) > TOLERANCE);
    let over_an_edge: Vec<usize> = (0..segments.len())
        .filter(|&i| (right[i] == NO_FACET) != (other[i] == NO_FACET))
        .filter(|&i| is_clear_cut(&segments[i]) && is_clear_cut(&moved[i]))
        .collect();
    assert!(over_an_edge.len() > 100, "{}", over_an_edge.len());
    for i in over_an_edge.into_iter().step_by(20) {
        let faulty = Faulty { tracer: &tracer, offset: Some((segments[i], by)), dropped: NO_FACET };
        let verdicts = compare(&mesh, &faulty, &segments);
        assert_eq!(verdicts.wrong, 1, "{i}: {verdicts}");
    }
}

/// Each of the facets in turn, every one of which some segments cross.
#[test]
fn one_dropped_candidate_is_noticed() {
    let mesh = soup(60, 53);
    let tracer = FallbackTracer::new(&mesh);
    let segments = segments(&mesh, Family::Grazing(1e-3), 4000, 54);
    assert_eq!(compare(&mesh, &tracer, &segments).wrong, 0);
    for dropped in 0..60 {
        let verdicts = compare(&mesh, &Faulty { tracer: &tracer, offset: None, dropped }, &segments);
        assert!(verdicts.wrong > 0, "facet {dropped} is missing: {verdicts}");
    }
}

/// One ray out of 4000, from beside where it begins by a two-thousandth of the scene.
#[test]
fn one_offset_ray_is_noticed() {
    let mesh = soup(300, 55);
    let tracer = FallbackTracer::new(&mesh);
    let segments = segments(&mesh, Family::Beside(5e-4), 4000, 56);
    let rays: Vec<Ray> = segments.iter().map(ray_along).collect();
    assert_eq!(compare_hits(TOLERANCE, &mesh, &tracer, &rays).wrong, 0);
    let by = Vec3::new(0.6e-3, -0.6e-3, 0.5e-3);
    let moved: Vec<Ray> = rays.iter().map(|&ray| Ray { origin: ray.origin + by, ..ray }).collect();
    // Where the offset leads to another facet, or to none.
    let [right, other] = [&rays, &moved].map(|rays| first_hits(&tracer, rays));
    let facet = |hit: Option<Hit>| hit.map(|hit| hit.facet);
    let differing: Vec<usize> = (0..rays.len()).filter(|&i| facet(right[i]) != facet(other[i])).collect();
    assert!(differing.len() > 100, "{}", differing.len());
    let noticed = |&&i: &&usize| {
        let faulty = Faulty { tracer: &tracer, offset: Some((segments[i], by)), dropped: NO_FACET };
        compare_hits(TOLERANCE, &mesh, &faulty, &rays).wrong == 1
    };
    let asked: Vec<&usize> = differing.iter().step_by(20).collect();
    let count = asked.iter().filter(|i| noticed(i)).count();
    assert_eq!(count, asked.len());
}

/// Along itself a ray meets the same facet, but nearer than it is.
#[test]
fn one_wrong_distance_is_noticed() {
    let mesh = soup(300, 55);
    let tracer = FallbackTracer::new(&mesh);
    let segments = segments(&mesh, Family::Beside(1e-3), 4000, 59);
    let rays: Vec<Ray> = segments.iter().map(ray_along).collect();
    let right = first_hits(&tracer, &rays);
    let meeting: Vec<usize> = (0..rays.len()).filter(|&i| right[i].is_some()).collect();
    for &i in meeting.iter().step_by(100) {
        let by = rays[i].direction.normalize() * 1e-3;
        let faulty = Faulty { tracer: &tracer, offset: Some((segments[i], by)), dropped: NO_FACET };
        let found = compare_hits(TOLERANCE, &mesh, &faulty, &rays);
        assert_eq!(found.wrong, 1, "{i}: {found:?}");
    }
}

/// Each of the facets in turn, every one of which some rays meet first.
#[test]
fn one_dropped_facet_is_noticed_by_its_rays() {
    let mesh = soup(60, 57);
    let tracer = FallbackTracer::new(&mesh);
    let rays: Vec<Ray> = segments(&mesh, Family::Grazing(1e-3), 4000, 58).iter().map(ray_along).collect();
    assert_eq!(compare_hits(TOLERANCE, &mesh, &tracer, &rays).wrong, 0);
    for dropped in 0..60 {
        let faulty = Faulty { tracer: &tracer, offset: None, dropped };
        let found = compare_hits(TOLERANCE, &mesh, &faulty, &rays);
        assert!(found.wrong > 0, "facet {dropped} is missing: {found:?}");
    }
}
