//! The candidate filter: Embree offers each hit of an occlusion packet, and by its facet's id it is
//! accepted, and then recorded as the blocker, or rejected, and then traversal goes on.

use embree4_sys as raw;

use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET};

/// What the filter of one packet reads and writes. Embree passes its address to the callback.
#[repr(C)]
#[derive(Debug)]
pub(super) struct FilterContext<'a> {
    /// First, because Embree takes the whole for one of these.
    query: raw::RTCRayQueryContext,
    /// Facet of each triangle of the scene.
    pub(super) facet_of_triangle: &'a [u32],
    /// Which facets may block.
    pub(super) candidates: Candidates<'a>,
    /// Facets that do not block, by ray id.
    pub(super) skip: [[u32; 2]; PACKET],
    /// From where on a hit counts, by ray id: [`Segment::open_part`](crate::tracer::Segment::open_part).
    pub(super) near: [f32; PACKET],
    /// And up to where.
    pub(super) far: [f32; PACKET],
    /// Accepted facet by ray id, [`NO_FACET`] where none was.
    pub(super) blockers: [u32; PACKET],
    /// Counts what is seen.
    pub(super) audit: &'a mut FilterAudit,
}

impl<'a> FilterContext<'a> {
    pub(super) fn new(
        facet_of_triangle: &'a [u32],
        candidates: Candidates<'a>,
        audit: &'a mut FilterAudit,
    ) -> Self {
        FilterContext {
            query: raw::RTCRayQueryContext { instID: [u32::MAX], instPrimID: [u32::MAX] },
            facet_of_triangle,
            candidates,
            skip: [[NO_FACET; 2]; PACKET],
            near: [0.0; PACKET],
            far: [1.0; PACKET],
            blockers: [NO_FACET; PACKET],
            audit,
        }
    }

    /// Query arguments that send every hit through this context. The pointer in them is to be used
    /// while nothing else refers to the context.
    pub(super) fn arguments(this: *mut Self) -> raw::RTCOccludedArguments {
        raw::RTCOccludedArguments {
            // Not `COHERENT`: it made widely spread packets up to twice as slow, and there the blocker
            // named for a ray depends on the other rays of its packet.
            flags: raw::RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER,
            feature_mask: raw::RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
            context: this.cast::<raw::RTCRayQueryContext>(),
            filter: Some(filter_hits),
            occluded: None,
        }
    }

    /// Whether the hit of ray `id` on `triangle` at `t` blocks; a blocker is recorded. Total: any
    /// number gives an answer.
    fn accepts(&mut self, id: u32, triangle: u32, t: f32) -> bool {
        let ray = id as usize;
        let is_open = ray < PACKET && t > self.near[ray] && t < self.far[ray];
        let Some(&facet) = self.facet_of_triangle.get(triangle as usize).filter(|_| is_open) else {
            self.audit.calls += 1;
            self.audit.rejects += 1;
            return false;
        };
        let is_accepted = self.audit.accepts(facet, self.skip[ray], &self.candidates);
        if is_accepted {
            self.blockers[ray] = facet;
        }
        is_accepted
    }
}

/// Rows of a packet of N rays (`RTCRayN`) and of its hits (`RTCHitN`), N 32-bit words each.
mod row {
    pub(super) const RAY_TFAR: usize = 8;
    pub(super) const RAY_ID: usize = 10;
    pub(super) const HIT_PRIMITIVE: usize = 5;
}

/// The callback: for each active lane, rejects the hit unless [`FilterContext::accepts`] it. N is
/// whatever Embree chose to trace together, whatever the size of the packet that was asked for.
unsafe extern "C" fn filter_hits(arguments: *const raw::RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes valid arguments, and as context the pointer from `arguments` above, behind
    // which is a context that nothing else refers to during the query; one packet is traced by one
    // thread.
    let (arguments, context) = unsafe {
        let arguments = &*arguments;
        (arguments, &mut *arguments.context.cast::<FilterContext<'_>>())
    };
    let lanes = arguments.N as usize;
    let (ray, hit) = (arguments.ray.cast::<u32>(), arguments.hit.cast::<u32>());
    // SAFETY: `valid` is not null and has N entries.
    let valid = unsafe { std::slice::from_raw_parts_mut(arguments.valid, lanes) };
    for (group, valid) in valid.chunks_mut(PACKET).enumerate() {
        // Most lanes are inactive, and which ones nobody can foresee: bits of a mask need no branch for each.
        let bit = |(lane, &valid): (usize, &i32)| u32::from(valid != 0) << lane;
        let mut active: u32 = valid.iter().enumerate().map(bit).sum();
        while active != 0 {
            let own = active.trailing_zeros() as usize;
            active &= active - 1;
            let lane = group * PACKET + own;
            // SAFETY: the rows of rays and hits have N words each; at the ray's `tfar` is the distance of the hit, a
            // float of the same size.
            let (id, t, triangle) = unsafe {
                (
                    *ray.add(row::RAY_ID * lanes + lane),
                    f32::from_bits(*ray.add(row::RAY_TFAR * lanes + lane)),
                    *hit.add(row::HIT_PRIMITIVE * lanes + lane),
                )
            };
            if !context.accepts(id, triangle, t) {
                valid[own] = 0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracer::Interval;

    #[test]
    fn any_ids_and_distances_get_an_answer() {
        let facets = [0, 1];
        let only = [Interval { start: 1, end: 2 }];
        let mut audit = FilterAudit::default();
        let mut context = FilterContext::new(&facets, Candidates::Only(&only), &mut audit);
        for (id, triangle, t) in [(16, 0, 0.5), (u32::MAX, 1, 0.5), (0, 2, 0.5), (0, u32::MAX, 0.5)] {
            assert!(!context.accepts(id, triangle, t));
        }
        (context.near, context.far) = ([0.25; PACKET], [0.75; PACKET]);
        for t in [f32::NAN, f32::INFINITY, -1.0, 0.0, 0.25, 0.75, 1.0] {
            assert!(!context.accepts(0, 1, t), "an end point or nonsense at {t} must not block");
        }
        assert_eq!(context.blockers, [NO_FACET; PACKET]);
        assert_eq!(*context.audit, FilterAudit { calls: 11, rejects: 11, ..FilterAudit::default() });
        context.candidates = Candidates::All;
        assert!(context.accepts(0, 1, 0.5));
        assert_eq!(context.blockers[0], 1);
    }

    #[test]
    fn active_lanes_alone_are_asked_whatever_the_size_of_the_packet() {
        let facets = [7, 8];
        for lanes in [1, 4, 8, 16, 20] {
            let mut audit = FilterAudit::default();
            let mut context = FilterContext::new(&facets, Candidates::All, &mut audit);
            // Each ray meets one of two facets; ray 2 skips its own, and every third lane is idle.
            let facet = |lane: usize| facets[(lane + 1) % 2];
            let is_asked = |lane: usize| lane % 3 != 1;
            context.skip[2] = [NO_FACET, facet(2)];
            let (mut rays, mut hits) = (vec![0u32; 12 * lanes], vec![0u32; 9 * lanes]);
            let mut valid: Vec<i32> = (0..lanes).map(|lane| -i32::from(is_asked(lane))).collect();
            for lane in 0..lanes {
                rays[row::RAY_TFAR * lanes + lane] = 0.5f32.to_bits();
                rays[row::RAY_ID * lanes + lane] = lane as u32;
                hits[row::HIT_PRIMITIVE * lanes + lane] = (lane as u32 + 1) % 2;
            }
            let arguments = raw::RTCFilterFunctionNArguments {
                valid: valid.as_mut_ptr(),
                geometryUserPtr: std::ptr::null_mut(),
                context: (&raw mut context).cast::<raw::RTCRayQueryContext>(),
                ray: rays.as_mut_ptr().cast(),
                hit: hits.as_mut_ptr().cast(),
                N: lanes as u32,
            };
            // SAFETY: all that the arguments point to is ours, and of N lanes.
            unsafe { filter_hits(&raw const arguments) };
            for (lane, &valid) in valid.iter().enumerate() {
                let is_accepted = is_asked(lane) && lane != 2 && lane < PACKET;
                assert_eq!(valid != 0, is_accepted, "lane {lane} of {lanes}");
                let expected = if is_accepted { facet(lane) } else { NO_FACET };
                assert_eq!(
                    context.blockers.get(lane).copied().unwrap_or(NO_FACET),
                    expected,
                    "lane {lane} of {lanes}"
                );
            }
            assert_eq!(audit.calls, (0..lanes).filter(|&lane| is_asked(lane)).count() as u64);
        }
    }
}
