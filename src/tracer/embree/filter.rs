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
    /// Where a hit counts, by ray id: [`Segment::open_part`](crate::tracer::Segment::open_part).
    pub(super) open_part: [[f32; 2]; PACKET],
    /// Accepted facet by ray id, [`NO_FACET`] where none was.
    pub(super) blockers: [u32; PACKET],
    /// What was seen in this packet.
    pub(super) audit: FilterAudit,
}

impl<'a> FilterContext<'a> {
    pub(super) fn new(facet_of_triangle: &'a [u32], candidates: Candidates<'a>) -> Self {
        FilterContext {
            query: raw::RTCRayQueryContext { instID: [u32::MAX], instPrimID: [u32::MAX] },
            facet_of_triangle,
            candidates,
            skip: [[NO_FACET; 2]; PACKET],
            open_part: [[0.0, 1.0]; PACKET],
            blockers: [NO_FACET; PACKET],
            audit: FilterAudit::default(),
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
        self.audit.calls += 1;
        let skip = self.skip.get(id as usize);
        let open_part = self.open_part.get(id as usize);
        let facet = self.facet_of_triangle.get(triangle as usize);
        if let (Some(skip), Some(&[near, far]), Some(&facet)) = (skip, open_part, facet)
            && t > near
            && t < far
            && !skip.contains(&facet)
        {
            if self.candidates.contains(facet) {
                if let Some(blocker) = self.blockers.get_mut(id as usize) {
                    *blocker = facet;
                }
                return true;
            }
            self.audit.note_outsider(facet);
        }
        self.audit.rejects += 1;
        false
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
    for lane in 0..lanes {
        // SAFETY: `valid` has N entries, and the rows of rays and hits N words each; at the ray's
        // `tfar` is the distance of the hit, a float of the same size.
        unsafe {
            let valid = arguments.valid.add(lane);
            if *valid == 0 {
                continue;
            }
            let id = *ray.add(row::RAY_ID * lanes + lane);
            let t = f32::from_bits(*ray.add(row::RAY_TFAR * lanes + lane));
            let triangle = *hit.add(row::HIT_PRIMITIVE * lanes + lane);
            if !context.accepts(id, triangle, t) {
                *valid = 0;
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
        let mut context = FilterContext::new(&facets, Candidates::Only(&only));
        for (id, triangle, t) in [(16, 0, 0.5), (u32::MAX, 1, 0.5), (0, 2, 0.5), (0, u32::MAX, 0.5)] {
            assert!(!context.accepts(id, triangle, t));
        }
        context.open_part = [[0.25, 0.75]; PACKET];
        for t in [f32::NAN, f32::INFINITY, -1.0, 0.0, 0.25, 0.75, 1.0] {
            assert!(!context.accepts(0, 1, t), "an end point or nonsense at {t} must not block");
        }
        assert_eq!(context.audit, FilterAudit { calls: 11, rejects: 11, ..FilterAudit::default() });
        assert_eq!(context.blockers, [NO_FACET; PACKET]);
    }
}
