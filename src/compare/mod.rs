//! The same work on two tracers: do their rays, links, light and pictures agree, and which is faster? Where rays
//! disagree the exhaustive tracer says who is right.
//!
//! The first of the two is called the native tracer, the second the other. Everything but times is the same for any
//! number of threads. `docs/compare.md` explains every figure.

mod distance;
mod exitance;
mod flip;
mod hard;
mod links;
mod picture;
mod rays;
mod recorder;
mod referee;
mod replay;
mod speed;
mod truth;

pub use distance::{between_segments, distance_to_change};
pub use exitance::ExitanceDifference;
pub use hard::{FAMILIES, Family, Numbers, far_segments, random_segments, segments};
pub use links::{LinkDifferences, NamedLinks};
pub use picture::{PictureDifference, difference_picture};
pub use rays::{Ask, Batch, Disagreement, Question, RayComparison, Tally, compare_rays, made_batches};
pub use recorder::{KeptPackets, Recorder};
pub use referee::{Referee, Ruling, Standing, tolerance_for, tolerance_for_ray};
pub use replay::{ReplayError, ReplayFile, Replayed, write_replay};
pub use speed::rays_per_second;
pub use truth::TruthDifference;

use crate::hierarchy::Hierarchy;
use crate::image::picture::Picture;
use crate::image::{self, RenderOptions};
use crate::progress::Progress;
use crate::radiosity::{self, SolveOptions};
use crate::scene::Camera;
use crate::tracer::Tracer;
use std::time::Instant;

/// The solutions agree when the root mean square difference of their exitance is no more than this, relative to what
/// surfaces reflect in the mean: about the smallest difference in brightness that eyes notice.
pub const EXITANCE_LIMIT: f64 = 0.01;

/// What is done with both tracers.
#[derive(Clone, Debug)]
pub struct CompareOptions {
    /// How both solve.
    pub solve: SolveOptions,
    /// Segments made by rule, about.
    pub rays: usize,
    /// Times the segments of the solves are traced to see how long it takes.
    pub repeats: u32,
    /// What both render.
    pub camera: Camera,
    /// How.
    pub render: RenderOptions,
    /// Square metres in one local unit of area.
    pub square_meters: f64,
}

/// How long it took; of two numbers the first is for the native tracer.
#[derive(Clone, Debug, Default)]
pub struct Speed {
    /// Shadow rays a second of one thread, one number a repeat.
    pub rays_per_second: [Vec<f64>; 2],
    /// Wall-clock seconds to solve.
    pub solve_seconds: [f64; 2],
    /// Wall-clock seconds to render.
    pub render_seconds: [f64; 2],
}

/// The answer.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// Rays.
    pub rays: RayComparison,
    /// Links.
    pub links: LinkDifferences,
    /// Light.
    pub exitance: ExitanceDifference,
    /// Pictures.
    pub picture: PictureDifference,
    /// Times.
    pub speed: Speed,
}

impl Comparison {
    /// Whether no ray was wrong.
    pub fn rays_agree(&self) -> bool {
        self.rays.total().wrong == [0, 0]
    }

    /// Whether the light is the same but for what rounding may bring about.
    pub fn light_agrees(&self) -> bool {
        // What is not a number does not agree.
        self.exitance.relative_rms() <= EXITANCE_LIMIT
    }

    /// Whether the tracers agree.
    pub fn agrees(&self) -> bool {
        self.rays_agree() && self.light_agrees()
    }
}

/// Solves and renders with both tracers and compares what they give; also the two pictures.
pub fn compare(
    hierarchy: &Hierarchy,
    tracers: [&dyn Tracer; 2],
    options: &CompareOptions,
    progress: &dyn Progress,
) -> (Comparison, [Picture; 2]) {
    let (segments, rays) = (KeptPackets::default(), KeptPackets::default());
    let solutions = tracers.map(|tracer| {
        let recorder = Recorder { tracer, segments: &segments, rays: &rays };
        radiosity::solve(hierarchy, &recorder, &options.solve, options.square_meters, progress)
    });
    let [native, other] = &solutions;
    let mut speed = Speed {
        solve_seconds: solutions.each_ref().map(|solution| solution.refine_seconds + solution.solve_seconds),
        ..Speed::default()
    };
    let camera_rays = KeptPackets::default();
    let pictures = [0, 1].map(|side| {
        let start = Instant::now();
        let recorder = Recorder { tracer: tracers[side], segments: &segments, rays: &camera_rays };
        let (camera, solution) = (&options.camera, &solutions[side]);
        let picture = image::render(hierarchy, &recorder, solution, camera, options.render, progress);
        speed.render_seconds[side] = start.elapsed().as_secs_f64();
        picture
    });
    let shadow_rays = Batch { name: "shadow rays", packets: segments.into_packets() };
    progress.start("race", options.repeats.into());
    speed.rays_per_second =
        rays_per_second(tracers, &shadow_rays, options.repeats, &|done| progress.advance(done));
    progress.finish();

    let first_hits = [
        Batch { name: "rays that carry light", packets: rays.into_packets() },
        Batch { name: "camera rays", packets: camera_rays.into_packets() },
    ];
    let mut batches = vec![shadow_rays];
    batches.extend(made_batches(&hierarchy.mesh, options.rays));
    let packets = batches.iter().map(|batch| batch.packets.len());
    let packets = packets.chain(first_hits.iter().map(|batch| batch.packets.len()));
    progress.start("compare", packets.sum::<usize>() as u64);
    let (referee, advance) = (Referee::new(&hierarchy.mesh), |done| progress.advance(done));
    let mut rays = compare_rays(&referee, tracers, &batches, &advance);
    rays.extend(compare_rays(&referee, tracers, &first_hits, &advance));
    progress.finish();
    let comparison = Comparison {
        rays,
        links: NamedLinks::of(hierarchy, native).compare(&NamedLinks::of(hierarchy, other)),
        exitance: ExitanceDifference::between(hierarchy, [native, other]),
        picture: PictureDifference::between(pictures.each_ref()),
        speed,
    };
    (comparison, pictures)
}
