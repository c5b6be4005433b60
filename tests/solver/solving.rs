//! Loading, tracing and solving for the tests of this suite.

use std::path::Path;

use lightshaft::hierarchy::Hierarchy;
use lightshaft::progress::Silent;
use lightshaft::radiosity::{self, Record, Solution, SolveOptions};
use lightshaft::scene::{self, Scene};
use lightshaft::tracer::{FallbackTracer, Tracer};
use lightshaft::visibility::{Strategy, VisibilityOptions};

/// The scenes of the project.
pub(crate) const OWN_SCENES: [&str; 4] = ["cornell-box", "paper-1", "paper-2", "paper-3"];

/// Every strategy.
pub(crate) const STRATEGIES: [Strategy; 5] =
    [Strategy::All, Strategy::Root, Strategy::Shaft, Strategy::Adaptive, Strategy::Sampled];

/// A scene with the hierarchy over it.
pub(crate) struct Case {
    pub(crate) scene: Scene,
    pub(crate) hierarchy: Hierarchy,
}

impl Case {
    /// One of [`OWN_SCENES`].
    pub(crate) fn load(name: &str) -> Case {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).join("scene.toml");
        let scene = scene::load(&path, &Default::default(), &Silent).expect("a scene of the project loads");
        Case::of(scene, false)
    }

    pub(crate) fn of(scene: Scene, one_sided: bool) -> Case {
        let hierarchy = Hierarchy::build(&scene, one_sided, &Silent);
        hierarchy.validate().expect("the hierarchy keeps its rules");
        Case { scene, hierarchy }
    }

    pub(crate) fn fallback(&self) -> FallbackTracer {
        FallbackTracer::new(&self.hierarchy.mesh)
    }

    pub(crate) fn solve(&self, tracer: &dyn Tracer, options: &SolveOptions) -> Solution {
        let square_meters = self.hierarchy.square_meters_per_unit(self.scene.meters_per_unit);
        radiosity::solve(&self.hierarchy, tracer, options, square_meters, &Silent)
    }

    /// Mean irradiance over the fronts of one material.
    pub(crate) fn mean_irradiance(&self, solution: &Solution, material: u32) -> f64 {
        let forest = &solution.forest;
        let (mut power, mut area) = (0.0, 0.0);
        for side in 0..forest.side_count() {
            let named = forest.side(side);
            if !named.back && self.hierarchy.facets[named.facet as usize].material == material {
                let root = forest.first_element[side] as usize;
                power += (solution.light.irradiance[root].x * forest.area[root]) as f64;
                area += forest.area[root] as f64;
            }
        }
        power / area
    }
}

/// Settings near the quality `draft`, a little finer.
pub(crate) fn rough(strategy: Strategy) -> SolveOptions {
    SolveOptions {
        epsilon: 2e-3,
        contrast: 0.4,
        min_size: None,
        resolution: 48.0,
        iterations: 50,
        visibility: VisibilityOptions { strategy, rays: 4, certify: false },
        record: Record::Nothing,
    }
}

/// Settings near the quality `normal`, a little coarser.
pub(crate) fn options(strategy: Strategy) -> SolveOptions {
    SolveOptions {
        epsilon: 1e-3,
        contrast: 0.2,
        min_size: None,
        resolution: 64.0,
        iterations: 100,
        visibility: VisibilityOptions { strategy, rays: 16, certify: false },
        record: Record::Nothing,
    }
}

/// The same, ended when links have been refined and light has begun to settle: for what is asked of links.
pub(crate) fn links_only(options: SolveOptions) -> SolveOptions {
    SolveOptions { iterations: 12, ..options }
}

/// The settings of the quality `normal`.
pub(crate) fn normal() -> SolveOptions {
    SolveOptions { epsilon: 5e-5, contrast: 0.1, resolution: 128.0, ..options(Strategy::Adaptive) }
}
