//! The tracer: packets of segments and rays on one mesh.

use std::{ptr, sync::Arc};

use embree4_sys as raw;

use super::{
    EmbreeError, EmbreeLibrary, EmbreeOptions,
    filter::FilterContext,
    packet::{ActiveLanes, Lane, no_hit16, packet},
    scene::TriangleScene,
};
use crate::tracer::{Candidates, FilterAudit, Hit, NO_FACET, PACKET, Ray, Segment, TraceMesh, Tracer};

/// Embree on one [`TraceMesh`]. Queries are thread-safe and do not depend on the number of threads,
/// nor a segment's answer on the others of its packet.
#[derive(Debug)]
pub struct EmbreeTracer {
    scene: TriangleScene,
    facet_of_triangle: Vec<u32>,
    /// Keeps the library's description with the tracer; the code itself is never unloaded.
    library: Arc<EmbreeLibrary>,
}

impl EmbreeTracer {
    /// Builds the tree. Copies the mesh, about 28 bytes a triangle and 12 a vertex.
    ///
    /// # Errors
    /// [`EmbreeError::Mesh`] when an index of the mesh is out of range, [`EmbreeError::Failed`] when
    /// Embree reports an error, such as too little memory.
    pub fn new(
        library: &Arc<EmbreeLibrary>,
        mesh: &TraceMesh,
        options: EmbreeOptions,
    ) -> Result<Self, EmbreeError> {
        check_facets(mesh)?;
        let scene = TriangleScene::new(library.api(), &mesh.positions, &mesh.triangles, options)?;
        Ok(EmbreeTracer {
            scene,
            facet_of_triangle: mesh.facet_of_triangle.clone(),
            library: Arc::clone(library),
        })
    }

    /// The library it runs on.
    pub fn library(&self) -> &Arc<EmbreeLibrary> {
        &self.library
    }

    /// Which of up to [`PACKET`] segments something blocks, be it what they start or end on: what Embree does
    /// without our filter, to compare with.
    ///
    /// # Panics
    /// With more than [`PACKET`] segments.
    pub fn blocked_without_filter(&self, segments: &[Segment]) -> [bool; PACKET] {
        assert!(segments.len() <= PACKET, "{} segments", segments.len());
        let lanes = segments.iter().map(lane_of_segment);
        // SAFETY: null arguments are the defaults.
        let (active, rays) = unsafe { self.occlude_packet(lanes, ptr::null_mut()) };
        std::array::from_fn(|lane| active.0[lane] != 0 && rays.tfar[lane] == f32::NEG_INFINITY)
    }

    /// The lanes of a packet, and its rays when Embree is done with them.
    ///
    /// # Safety
    /// `arguments` is null, or they and what they point to are valid, and nothing else refers to them until
    /// the call returns.
    unsafe fn occlude_packet(
        &self,
        lanes: impl Iterator<Item = Lane>,
        arguments: *mut raw::RTCOccludedArguments,
    ) -> (ActiveLanes, raw::RTCRay16) {
        let (active, mut rays) = packet(lanes);
        // SAFETY: the scene is committed, the packet and its lanes are ours and aligned to 64 bytes by their
        // types; for the arguments the caller answers.
        unsafe {
            self.scene.api().rtcOccluded16(active.0.as_ptr(), self.scene.raw(), &raw mut rays, arguments);
        }
        (active, rays)
    }

    fn block_packet(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        let mut context = FilterContext::new(&self.facet_of_triangle, candidates);
        let mut lanes = [Lane::IDLE; PACKET];
        for (id, segment) in segments.iter().enumerate() {
            lanes[id] = lane_of_segment(segment);
            context.skip[id] = segment.skip;
            context.open_part[id] = [lanes[id].near, lanes[id].far];
        }
        let lanes = &lanes[..segments.len()];
        let this = &raw mut context;
        let mut arguments = FilterContext::arguments(this);
        if let [lane] = lanes {
            if lane.is_valid() {
                let mut ray = lane.ray(0);
                // SAFETY: the scene is committed, the ray and the arguments are ours, and `this` is the
                // only way to the context until the call returns.
                unsafe {
                    self.scene.api().rtcOccluded1(self.scene.raw(), &raw mut ray, &raw mut arguments);
                }
            }
        } else {
            // SAFETY: as above.
            unsafe { self.occlude_packet(lanes.iter().copied(), &raw mut arguments) };
        }
        // SAFETY: the query is over; `this` points to the local above.
        let context = unsafe { &*this };
        blockers.copy_from_slice(&context.blockers[..blockers.len()]);
        add(audit, &context.audit);
    }

    fn hit_packet(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let (active, ray) = packet(rays.iter().map(lane_of_ray));
        let mut query = raw::RTCRayHit16 { ray, hit: no_hit16() };
        // SAFETY: the scene is committed, packet and lanes are ours and aligned to 64 bytes by their
        // types; null arguments are the defaults.
        unsafe {
            self.scene.api().rtcIntersect16(
                active.0.as_ptr(),
                self.scene.raw(),
                &raw mut query,
                ptr::null_mut(),
            );
        }
        for (lane, hit) in hits.iter_mut().enumerate() {
            let triangle = query.hit.primID[lane];
            let is_hit = active.0[lane] != 0 && query.hit.geomID[lane] != raw::RTC_INVALID_GEOMETRY_ID;
            let facet = self.facet_of_triangle.get(triangle as usize).filter(|_| is_hit);
            *hit = facet.map(|&facet| Hit { facet, triangle, t: query.ray.tfar[lane] });
        }
    }
}

impl Tracer for EmbreeTracer {
    fn name(&self) -> &'static str {
        "embree"
    }

    fn bytes(&self) -> u64 {
        self.scene.bytes() + size_of_val(&self.facet_of_triangle[..]) as u64
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        debug_assert!(segments.len() <= PACKET && segments.len() == blockers.len());
        for (segments, blockers) in segments.chunks(PACKET).zip(blockers.chunks_mut(PACKET)) {
            self.block_packet(segments, candidates, blockers, audit);
        }
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        debug_assert!(rays.len() <= PACKET && rays.len() == hits.len());
        for (rays, hits) in rays.chunks(PACKET).zip(hits.chunks_mut(PACKET)) {
            self.hit_packet(rays, hits);
        }
    }
}

/// The endpoint rule, in units of the segment's length.
fn lane_of_segment(segment: &Segment) -> Lane {
    let [near, far] = segment.open_part();
    Lane { origin: segment.from, direction: segment.to - segment.from, near, far }
}

/// From just after the origin, so that `t > 0`, to infinity.
fn lane_of_ray(ray: &Ray) -> Lane {
    Lane { origin: ray.origin, direction: ray.direction, near: f32::MIN_POSITIVE, far: f32::INFINITY }
}

fn add(audit: &mut FilterAudit, packet: &FilterAudit) {
    audit.calls += packet.calls;
    audit.rejects += packet.rejects;
    audit.outsiders += packet.outsiders;
    packet.named.facets().iter().for_each(|&facet| audit.named.name(facet));
}

fn check_facets(mesh: &TraceMesh) -> Result<(), EmbreeError> {
    if mesh.facet_of_triangle.len() != mesh.triangles.len() {
        return Err(EmbreeError::Mesh(format!(
            "{} triangles, but facets of {}",
            mesh.triangles.len(),
            mesh.facet_of_triangle.len()
        )));
    }
    match mesh.facet_of_triangle.iter().position(|&facet| facet == NO_FACET) {
        None => Ok(()),
        Some(triangle) => Err(EmbreeError::Mesh(format!("triangle {triangle} belongs to no facet"))),
    }
}
