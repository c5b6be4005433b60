//! The same work on two tracers: do their rays, links, light and pictures agree, and which is faster? Every ray of
//! both solutions is asked of both, with the same candidates; where they disagree the exhaustive tracer says who is right.
//!
//! The first of the two is called the native tracer, the second the other. Everything but times and memory is the same
//! for any number of threads. `docs/compare.md` explains every figure.

mod distance;
mod exitance;
mod flip;
mod hard;
mod links;
mod picture;
mod rays;
mod referee;
mod replay;
mod sample;
mod speed;
mod tally;
mod truth;
mod witness;

pub use distance::{between_segments, distance_to_change};
pub use exitance::ExitanceDifference;
pub use hard::{FAMILIES, Family, Numbers, far_segments, random_segments, segments};
pub use links::{LinkDifferences, NamedLinks};
pub use picture::{PictureDifference, difference_picture};
pub use rays::{Batch, Judged, ask, compare_rays, made_batches};
pub use referee::{Referee, Ruling, Standing, tolerance_for, tolerance_for_ray};
pub use replay::{ReplayError, ReplayFile, Replayed, write_replay};
pub use sample::{Sample, Sampled};
pub use speed::{Speed, rays_per_second, warm_up};
pub use tally::{Disagreement, Question, RayComparison, Tally, candidates};
pub use truth::TruthDifference;
pub use witness::{Account, Witness};

use crate::hierarchy::Hierarchy;
use crate::image::picture::Picture;
use crate::image::{self, RenderOptions};
use crate::progress::Progress;
use crate::radiosity::{self, SolveOptions};
use crate::scene::Camera;
use crate::tracer::Tracer;

/// Without rays that were answered differently, the mean difference of exitance may be no more than this, relative to what
/// surfaces reflect in the mean.
pub const EXITANCE_LIMIT: f64 = 0.005;

/// Kinds of rays that the solutions follow from.
const OF_SOLUTIONS: [&str; 2] = ["shadow rays", "rays that carry light"];

/// What is done with both tracers.
#[derive(Clone, Debug)]
pub struct CompareOptions {
    /// How both solve.
    pub solve: SolveOptions,
    /// Segments made by rule, about.
    pub rays: usize,
    /// Times some of the segments of the solutions are traced to see how long it takes.
    pub repeats: u32,
    /// Times the scene is solved and rendered with each to see how long it takes.
    pub solves: u32,
    /// What both render.
    pub camera: Camera,
    /// How.
    pub render: RenderOptions,
    /// Square metres in one local unit of area.
    pub square_meters: f64,
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
    /// Times and memory.
    pub speed: Speed,
}

impl Comparison {
    /// Whether no ray was wrong.
    pub fn rays_agree(&self) -> bool {
        self.rays.total().wrong == [0, 0]
    }

    /// Whether a ray of the solutions was answered differently: then links and light may differ, as much as it matters.
    fn rays_differ(&self) -> bool {
        let is_of_solution = |tally: &&Tally| OF_SOLUTIONS.contains(&tally.name.as_str());
        self.rays.tallies.iter().filter(is_of_solution).any(|tally| tally.differing > 0)
    }

    /// Whether the light is a number everywhere, and differs by no more than [`EXITANCE_LIMIT`] or because rays do.
    pub fn light_is_explained(&self) -> bool {
        let mean = self.exitance.relative(self.exitance.mean);
        mean <= EXITANCE_LIMIT || mean.is_finite() && self.rays_differ()
    }

    /// Whether the links are the same, or differ because rays do: nothing else may make them differ.
    pub fn links_are_explained(&self) -> bool {
        self.links.are_same() || self.rays_differ()
    }

    /// Whether the tracers agree.
    pub fn agrees(&self) -> bool {
        self.rays_agree() && self.light_is_explained() && self.links_are_explained()
    }
}

/// Solves and renders with both tracers and compares what they give; also the two pictures.
pub fn compare(
    hierarchy: &Hierarchy,
    tracers: [&dyn Tracer; 2],
    options: &CompareOptions,
    progress: &dyn Progress,
) -> (Comparison, [Picture; 2]) {
    let mut speed = Speed::of_solving(hierarchy, tracers, options, progress);
    let referee = Referee::new(&hierarchy.mesh);
    let [shadow_rays, light_rays, no_segments, camera_rays] =
        [OF_SOLUTIONS[0], OF_SOLUTIONS[1], "", "camera rays"].map(Account::new);
    let (sample, none) = (Sample::default(), Sample::default());
    let solutions = [0, 1].map(|side| {
        let (segments, rays, sample) = (&shadow_rays, &light_rays, &sample);
        let witness = Witness { tracers, side, referee: &referee, segments, rays, sample };
        radiosity::solve(hierarchy, &witness, &options.solve, options.square_meters, progress)
    });
    let pictures = [0, 1].map(|side| {
        let (segments, rays, sample) = (&no_segments, &camera_rays, &none);
        let witness = Witness { tracers, side, referee: &referee, segments, rays, sample };
        let (camera, solution) = (&options.camera, &solutions[side]);
        image::render(hierarchy, &witness, solution, camera, options.render, progress)
    });
    speed.solution_bytes =
        solutions.each_ref().map(|solution| solution.links.bytes() + solution.elements_bytes());

    progress.start("race", options.repeats.into());
    let packets = sample.into_packets();
    speed.timed_rays = packets.iter().map(|packet| packet.segments.len() as u64).sum();
    speed.rays_per_second =
        rays_per_second(tracers, &packets, options.repeats, &|done| progress.advance(done));
    progress.finish();

    let batches = made_batches(&hierarchy.mesh, options.rays);
    let count = batches.iter().map(|batch| batch.packets.len()).sum::<usize>();
    progress.start("compare", count as u64);
    let mut rays = RayComparison::default();
    shadow_rays.settle(&mut rays);
    rays.extend(compare_rays(&referee, tracers, &batches, &|done| progress.advance(done)));
    light_rays.settle(&mut rays);
    camera_rays.settle(&mut rays);
    progress.finish();
    let [native, other] = &solutions;
    let comparison = Comparison {
        rays,
        links: NamedLinks::of(hierarchy, native).compare(&NamedLinks::of(hierarchy, other)),
        exitance: ExitanceDifference::between(hierarchy, [native, other]),
        picture: PictureDifference::between(pictures.each_ref()),
        speed,
    };
    (comparison, pictures)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that differs by `mean`, and links that do or not; of the shadow rays some were answered differently.
    fn found(differing: u64, mean: f64, only: u64) -> Comparison {
        let name = OF_SOLUTIONS[0].to_owned();
        let tally = Tally { name, traced: 100, differing, renamed: 7, ..Tally::default() };
        Comparison {
            rays: RayComparison { tallies: vec![tally], ..RayComparison::default() },
            links: LinkDifferences { only: [only, 0], ..LinkDifferences::default() },
            exitance: ExitanceDifference { mean_reflected: 1.0, mean, ..ExitanceDifference::default() },
            ..Comparison::default()
        }
    }

    #[test]
    fn what_no_ray_explains_is_a_disagreement() {
        assert!(found(0, 0.0, 0).agrees() && found(0, 0.004, 0).agrees());
        assert!(!found(0, 0.1, 0).agrees() && !found(0, 0.0, 1).agrees());
        assert!(found(1, 0.1, 1).agrees(), "a ray within the tolerance may change links and light");
        assert!(!found(1, f64::NAN, 0).agrees() && !found(1, f64::INFINITY, 0).agrees());
    }
}
