//! The rays of real work: a tracer that keeps some of the packets it is asked about.

use crate::math::hash_pair;
use crate::tracer::{Candidates, FilterAudit, Hit, NO_FACET, Ray, Segment, Tracer};
use glam::Vec3;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Packets that are kept, at most.
const KEPT: usize = 1 << 16;

/// The packets whose hashes are smallest: the same ones whatever the number of threads and the order.
#[derive(Debug)]
pub struct KeptPackets<T> {
    by_hash: Mutex<BTreeMap<u64, Vec<T>>>,
    /// Hashes from here on are of no use.
    most: AtomicU64,
}

impl<T> Default for KeptPackets<T> {
    fn default() -> KeptPackets<T> {
        KeptPackets { by_hash: Mutex::default(), most: AtomicU64::new(u64::MAX) }
    }
}

impl<T: Clone> KeptPackets<T> {
    /// The packets, as they were cast.
    pub fn into_packets(self) -> Vec<Vec<T>> {
        self.by_hash.into_inner().unwrap_or_else(PoisonError::into_inner).into_values().collect()
    }

    /// The hash is that of the first of a packet.
    fn keep(&self, hash: u64, packet: &[T]) {
        if hash >= self.most.load(Ordering::Relaxed) {
            return;
        }
        let mut kept = self.by_hash.lock().unwrap_or_else(PoisonError::into_inner);
        // Those of a pair begin alike: the longest says most.
        let longest = kept.entry(hash).or_default();
        if longest.len() < packet.len() {
            *longest = packet.to_vec();
        }
        if kept.len() > KEPT
            && let Some((largest, _)) = kept.pop_last()
        {
            self.most.store(largest, Ordering::Relaxed);
        }
    }
}

/// Answers with a tracer, and keeps some of what it is asked.
pub struct Recorder<'a> {
    /// Who answers.
    pub tracer: &'a dyn Tracer,
    /// Where packets of segments go.
    pub segments: &'a KeptPackets<Segment>,
    /// Where packets of rays go.
    pub rays: &'a KeptPackets<Ray>,
}

fn hash_of(a: Vec3, b: Vec3, skip: [u32; 2]) -> u64 {
    let words = [a.x, a.y, a.z, b.x, b.y, b.z].map(f32::to_bits);
    let pair = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
    let [a, b, c] = [pair(words[0], words[1]), pair(words[2], words[3]), pair(words[4], words[5])];
    hash_pair(hash_pair(a, b), hash_pair(c, pair(skip[0], skip[1])))
}

impl Tracer for Recorder<'_> {
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
        if let Some(first) = segments.first() {
            self.segments.keep(hash_of(first.from, first.to, first.skip), segments);
        }
        self.tracer.blockers(segments, candidates, blockers, audit);
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        if let Some(first) = rays.first() {
            self.rays.keep(hash_of(first.origin, first.direction, [NO_FACET; 2]), rays);
        }
        self.tracer.first_hits(rays, hits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::random_segments;
    use crate::tracer::{FallbackTracer, PACKET, TraceMesh};

    fn kept(order: impl Iterator<Item = usize>, packets: &[&[Segment]]) -> Vec<Vec<Segment>> {
        let empty = FallbackTracer::new(&TraceMesh {
            positions: vec![glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y],
            triangles: vec![[0, 1, 2]],
            first_triangle: vec![0, 1],
            facet_of_triangle: vec![0],
        });
        let (all, rays) = (KeptPackets::default(), KeptPackets::default());
        let recorder = Recorder { tracer: &empty, segments: &all, rays: &rays };
        for index in order {
            let mut blockers = vec![NO_FACET; packets[index].len()];
            recorder.blockers(packets[index], Candidates::All, &mut blockers, &mut FilterAudit::default());
        }
        all.into_packets()
    }

    #[test]
    fn the_same_packets_are_kept_in_any_order() {
        let segments = random_segments(3 * KEPT * 2, 7);
        let packets: Vec<&[Segment]> = segments.chunks(2).collect();
        let forwards = kept(0..packets.len(), &packets);
        assert_eq!(forwards.len(), KEPT);
        assert_eq!(forwards, kept((0..packets.len()).rev(), &packets));
        let again = (0..packets.len()).chain(0..packets.len());
        assert_eq!(forwards, kept(again, &packets), "what is cast twice is kept once");
    }

    #[test]
    fn of_packets_that_begin_alike_the_longest_is_kept() {
        let segments = random_segments(PACKET, 8);
        let packets = [&segments[..4], &segments[..], &segments[..1]];
        assert_eq!(kept(0..3, &packets), std::slice::from_ref(&segments));
    }
}
