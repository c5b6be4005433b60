//! Rays a second of both tracers on the same segments.

use super::rays::Batch;
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment, Tracer};
use std::time::Instant;

/// Segments that are timed in a turn, about; all of them several times when there are fewer.
const TIMED: usize = 1 << 18;

/// Rays a second of one thread, one number a repeat; the tracers take turns, and so does who begins.
pub fn rays_per_second(
    tracers: [&dyn Tracer; 2],
    batch: &Batch<Segment>,
    repeats: u32,
    advance: &dyn Fn(u64),
) -> [Vec<f64>; 2] {
    let mut rates = [Vec::new(), Vec::new()];
    let all: usize = batch.packets.iter().map(Vec::len).sum();
    if all == 0 {
        return rates;
    }
    let step = (all / TIMED).max(1);
    let packets: Vec<&[Segment]> = batch.packets.iter().step_by(step).map(Vec::as_slice).collect();
    let count: usize = packets.iter().map(|packet| packet.len()).sum();
    let rounds = TIMED.div_ceil(count);
    // The first turn of each warms up.
    for repeat in 0..=repeats {
        let order = if repeat % 2 == 0 { [0, 1] } else { [1, 0] };
        for side in order {
            let seconds = seconds_of(tracers[side], &packets, rounds);
            if repeat > 0 {
                rates[side].push((rounds * count) as f64 / seconds.max(f64::MIN_POSITIVE));
            }
        }
        advance(1);
    }
    rates
}

fn seconds_of(tracer: &dyn Tracer, packets: &[&[Segment]], rounds: usize) -> f64 {
    let mut blockers = [NO_FACET; PACKET];
    let start = Instant::now();
    for packet in (0..rounds).flat_map(|_| packets) {
        let blockers = &mut blockers[..packet.len()];
        tracer.blockers(packet, Candidates::All, blockers, &mut FilterAudit::default());
        std::hint::black_box(blockers);
    }
    start.elapsed().as_secs_f64()
}
