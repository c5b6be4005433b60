//! How fast both tracers are at the same work, and how much memory it takes.

use super::CompareOptions;
use super::sample::Sampled;
use crate::hierarchy::Hierarchy;
use crate::image;
use crate::memory::Rise;
use crate::progress::{Progress, Silent};
use crate::radiosity::{self, SolveOptions};
use crate::tracer::{FilterAudit, NO_FACET, PACKET, Tracer};
use std::time::Instant;

/// How long it took, and what memory; of two numbers the first is for the native tracer.
#[derive(Clone, Debug, Default)]
pub struct Speed {
    /// Shadow rays that were timed, a sample.
    pub timed_rays: u64,
    /// Shadow rays a second of one thread, one number a repeat.
    pub rays_per_second: [Vec<f64>; 2],
    /// Wall-clock seconds to solve, one number each time.
    pub solve_seconds: [Vec<f64>; 2],
    /// Wall-clock seconds to render, one number each time.
    pub render_seconds: [Vec<f64>; 2],
    /// What each keeps besides the mesh.
    pub tracer_bytes: [u64; 2],
    /// How far resident memory rose while solving, at most.
    pub solving_bytes: [u64; 2],
    /// What links and elements take.
    pub solution_bytes: [u64; 2],
}

impl Speed {
    /// Solves and renders with both tracers, in turns.
    pub(super) fn of_solving(
        hierarchy: &Hierarchy,
        tracers: [&dyn Tracer; 2],
        options: &CompareOptions,
        progress: &dyn Progress,
    ) -> Speed {
        let tracer_bytes = tracers.map(|tracer| tracer.bytes());
        let mut speed = Speed { tracer_bytes, ..Speed::default() };
        tracers.iter().for_each(|tracer| warm_up(hierarchy, *tracer, &options.solve, options.square_meters));
        for side in (0..options.solves).flat_map(turn) {
            let rise = Rise::begin();
            let start = Instant::now();
            let square_meters = options.square_meters;
            let solution =
                radiosity::solve(hierarchy, tracers[side], &options.solve, square_meters, progress);
            speed.solve_seconds[side].push(start.elapsed().as_secs_f64());
            speed.solving_bytes[side] = speed.solving_bytes[side].max(rise.bytes());
            let start = Instant::now();
            image::render(hierarchy, tracers[side], &solution, &options.camera, options.render, progress);
            speed.render_seconds[side].push(start.elapsed().as_secs_f64());
        }
        speed
    }
}

/// Iterations of the warm-up: enough to come to every phase.
const WARM_UP: u32 = 48;

/// Solves as roughly as can be. The first to solve would else be told to need more time and memory, since what a process needs
/// once, such as the pages of its own code, comes with it.
pub fn warm_up(hierarchy: &Hierarchy, tracer: &dyn Tracer, options: &SolveOptions, square_meters: f64) {
    let (epsilon, contrast, iterations) = (1.0, f64::MAX, WARM_UP.min(options.iterations));
    let rough = SolveOptions { epsilon, contrast, iterations, ..*options };
    radiosity::solve(hierarchy, tracer, &rough, square_meters, &Silent);
}

/// Segments that are timed in a turn, about; all of them several times when there are fewer.
const TIMED: usize = 1 << 18;

/// Rays a second of one thread, one number a repeat; the tracers take turns, and so does who begins.
pub fn rays_per_second(
    tracers: [&dyn Tracer; 2],
    packets: &[Sampled],
    repeats: u32,
    advance: &dyn Fn(u64),
) -> [Vec<f64>; 2] {
    let mut rates = [Vec::new(), Vec::new()];
    let count: usize = packets.iter().map(|packet| packet.segments.len()).sum();
    if count == 0 {
        return rates;
    }
    let rounds = TIMED.div_ceil(count);
    // The first turn of each warms up.
    for repeat in 0..=repeats {
        for side in turn(repeat) {
            let seconds = seconds_of(tracers[side], packets, rounds);
            if repeat > 0 {
                rates[side].push((rounds * count) as f64 / seconds.max(f64::MIN_POSITIVE));
            }
        }
        advance(1);
    }
    rates
}

/// Who goes first and who second: now one, now the other.
fn turn(repeat: u32) -> [usize; 2] {
    if repeat.is_multiple_of(2) { [0, 1] } else { [1, 0] }
}

fn seconds_of(tracer: &dyn Tracer, packets: &[Sampled], rounds: usize) -> f64 {
    let mut blockers = [NO_FACET; PACKET];
    let start = Instant::now();
    for packet in (0..rounds).flat_map(|_| packets) {
        let blockers = &mut blockers[..packet.segments.len()];
        tracer.blockers(&packet.segments, packet.candidates(), blockers, &mut FilterAudit::default());
        std::hint::black_box(blockers);
    }
    start.elapsed().as_secs_f64()
}
