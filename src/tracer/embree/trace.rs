//! The tracer: packets of segments and rays on one mesh.

use std::{ptr, sync::Arc};

use embree4_sys as raw;

use super::{
    EmbreeError, EmbreeLibrary, EmbreeOptions,
    filter::FilterContext,
    packet::{ActiveLanes, Lane, no_hit16, packet},
    scene::TriangleScene,
};
use crate::tracer::{
    Candidates, FilterAudit, Hit, NO_FACET, PACKET, Ray, Segment, TraceMesh, Tracer, open_part,
};

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
        let (active, mut rays) = packet(segments.iter().map(lane_of_segment), open_part);
        // SAFETY: null arguments are the defaults.
        unsafe { self.occlude(&active, &mut rays, ptr::null_mut()) };
        std::array::from_fn(|lane| active.0[lane] != 0 && rays.tfar[lane] == f32::NEG_INFINITY)
    }

    /// Asks which rays of a packet are blocked.
    ///
    /// # Safety
    /// `arguments` is null, or they and what they point to are valid, and nothing else refers to them until
    /// the call returns.
    unsafe fn occlude(
        &self,
        active: &ActiveLanes,
        rays: &mut raw::RTCRay16,
        arguments: *mut raw::RTCOccludedArguments,
    ) {
        // SAFETY: the scene is committed, the packet and its lanes are aligned to 64 bytes by their types; for the
        // arguments the caller answers.
        unsafe { self.scene.api().rtcOccluded16(active.0.as_ptr(), self.scene.raw(), rays, arguments) };
    }

    fn block_packet(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        let mut context = FilterContext::new(&self.facet_of_triangle, candidates, audit);
        for (skip, segment) in context.skip.iter_mut().zip(segments) {
            *skip = segment.skip;
        }
        if let [segment] = segments {
            let (lane, open_part) = (lane_of_segment(segment), segment.open_part());
            if lane.is_valid() {
                [context.near[0], context.far[0]] = open_part;
                let (mut ray, this) = (lane.ray(open_part), &raw mut context);
                let mut arguments = FilterContext::arguments(this);
                // SAFETY: the scene is committed, the ray and the arguments are ours, and `this` is the
                // only way to the context until the call returns.
                unsafe {
                    self.scene.api().rtcOccluded1(self.scene.raw(), &raw mut ray, &raw mut arguments);
                }
            }
        } else {
            let (active, mut rays) = packet(segments.iter().map(lane_of_segment), open_part);
            (context.near, context.far) = (rays.tnear, rays.tfar);
            let mut arguments = FilterContext::arguments(&raw mut context);
            // SAFETY: the arguments and the context are ours, and nothing else refers to them until the call returns.
            unsafe { self.occlude(&active, &mut rays, &raw mut arguments) };
        }
        blockers.copy_from_slice(&context.blockers[..blockers.len()]);
    }

    fn hit_packet(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        // From just after the origin, so that `t > 0`, to infinity.
        let lanes = rays.iter().map(|ray| Lane { origin: ray.origin, direction: ray.direction });
        let (active, ray) = packet(lanes, |_| [f32::MIN_POSITIVE, f32::INFINITY]);
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

fn lane_of_segment(segment: &Segment) -> Lane {
    Lane { origin: segment.from, direction: segment.to - segment.from }
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
