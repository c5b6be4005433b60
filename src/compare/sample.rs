//! Some packets of the segments of real work, to see how long they take.

use super::tally::{candidates, kept};
use crate::math::hash_pair;
use crate::tracer::{Candidates, Interval, Segment};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Packets that are kept, at most.
const PACKETS: usize = 1 << 14;

/// Intervals in their lists of candidates, at most: 32 MB.
const INTERVALS: usize = 1 << 22;

/// A packet, and the facets that could block it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// As they were cast together.
    pub segments: Vec<Segment>,
    within: Option<Vec<Interval>>,
}

impl Sampled {
    /// The facets that may block.
    pub fn candidates(&self) -> Candidates<'_> {
        candidates(&self.within)
    }

    fn intervals(&self) -> usize {
        self.within.as_ref().map_or(0, Vec::len)
    }
}

/// The hash of a packet's first segment, and that of its candidates.
type Key = (u64, u64);

/// The packets whose hashes are smallest, as many as there is room for: the same ones whatever the number of threads
/// and the order.
#[derive(Debug)]
pub struct Sample {
    kept: Mutex<Kept>,
    /// Hashes of first segments above this are of no use.
    most: AtomicU64,
}

#[derive(Debug, Default)]
struct Kept {
    by_key: BTreeMap<Key, Sampled>,
    intervals: usize,
    /// Packets from here on are of no use.
    end: Option<Key>,
}

impl Default for Sample {
    fn default() -> Sample {
        Sample { kept: Mutex::default(), most: AtomicU64::new(u64::MAX) }
    }
}

impl Sample {
    /// The packets, as they were cast.
    pub fn into_packets(self) -> Vec<Sampled> {
        self.kept.into_inner().unwrap_or_else(PoisonError::into_inner).by_key.into_values().collect()
    }

    /// Keeps a packet if it is one of those.
    pub fn offer(&self, segments: &[Segment], within: Candidates<'_>) {
        let Some(first) = segments.first() else { return };
        let hash = hash_of(first);
        if hash > self.most.load(Ordering::Relaxed) {
            return;
        }
        let key = (hash, hash_of_list(within));
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(key, segments, within);
        if let Some((hash, _)) = kept.end {
            self.most.store(hash, Ordering::Relaxed);
        }
    }
}

impl Kept {
    fn insert(&mut self, key: Key, segments: &[Segment], within: Candidates<'_>) {
        if self.end.is_some_and(|end| key >= end) {
            return;
        }
        // Those of a pair begin alike: the longest says most.
        match self.by_key.get_mut(&key) {
            Some(known) if known.segments.len() >= segments.len() => {}
            Some(known) => known.segments = segments.to_vec(),
            None => {
                let new = Sampled { segments: segments.to_vec(), within: kept(within) };
                self.intervals += new.intervals();
                self.by_key.insert(key, new);
            }
        }
        while self.by_key.len() > PACKETS || self.intervals > INTERVALS {
            let Some((key, dropped)) = self.by_key.pop_last() else { return };
            self.intervals -= dropped.intervals();
            self.end = Some(key);
        }
    }
}

fn pair(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

fn hash_of(segment: &Segment) -> u64 {
    let Segment { from, to, skip } = segment;
    let [a, b, c, d, e, f] = [from.x, from.y, from.z, to.x, to.y, to.z].map(f32::to_bits);
    let ends = hash_pair(hash_pair(pair(a, b), pair(c, d)), pair(e, f));
    hash_pair(ends, pair(skip[0], skip[1]))
}

fn hash_of_list(within: Candidates<'_>) -> u64 {
    match within {
        Candidates::All => 0,
        Candidates::Only(list) => list.iter().fold(1, |hash, i| hash_pair(hash, pair(i.start, i.end))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::random_segments;
    use crate::tracer::PACKET;

    fn kept<'a>(packets: impl Iterator<Item = (&'a [Segment], Candidates<'a>)>) -> Vec<Sampled> {
        let sample = Sample::default();
        packets.for_each(|(segments, within)| sample.offer(segments, within));
        sample.into_packets()
    }

    #[test]
    fn the_same_packets_are_kept_in_any_order() {
        let segments = random_segments(3 * PACKETS * 2, 7);
        let packets = || segments.chunks(2).map(|packet| (packet, Candidates::All));
        let forwards = kept(packets());
        assert_eq!(forwards.len(), PACKETS);
        assert_eq!(forwards, kept(packets().rev()));
        assert_eq!(forwards, kept(packets().chain(packets())), "what is cast twice is kept once");
    }

    /// A list in twenty is far longer than the others.
    #[test]
    fn lists_take_no_more_room_than_there_is() {
        let segments = random_segments(4000, 9);
        let list: Vec<Interval> = (0..100_000).map(|i| Interval { start: 2 * i, end: 2 * i + 1 }).collect();
        let packets = || {
            segments.chunks(1).enumerate().map(|(index, packet)| {
                let length = if index % 20 == 0 { list.len() } else { index % 1500 };
                (packet, Candidates::Only(&list[..length]))
            })
        };
        let forwards = kept(packets());
        let intervals: usize = forwards.iter().map(Sampled::intervals).sum();
        assert!(intervals <= INTERVALS && forwards.len() > 100, "{intervals} of {}", forwards.len());
        assert_eq!(forwards, kept(packets().rev()));
    }

    #[test]
    fn of_packets_that_begin_alike_the_longest_is_kept_for_each_list() {
        let (segments, list) = (random_segments(PACKET, 8), [Interval { start: 0, end: 3 }]);
        let packets = [&segments[..4], &segments[..], &segments[..1]];
        let asked = packets.into_iter().flat_map(|p| [(p, Candidates::All), (p, Candidates::Only(&list))]);
        let found = kept(asked);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|sampled| sampled.segments == segments));
        assert!(found.iter().any(|sampled| matches!(sampled.candidates(), Candidates::Only(_))));
    }
}
