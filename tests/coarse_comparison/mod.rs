//! How two tracers are compared where a coarse draft of a small scene is enough to see a fault that was planted. Tests of
//! the library and the page that `tests/pages` looks at share it.

use lightshaft::compare::CompareOptions;
use lightshaft::image::{RenderOptions, View};
use lightshaft::radiosity::{Record, SolveOptions};
use lightshaft::scene::{Camera, Scene};
use lightshaft::visibility::{Strategy, VisibilityOptions};

/// A side of the short box of the Cornell box, which throws a shadow.
pub(crate) const BOX_SIDE: u32 = 14;

/// All done once, with square pictures of so many pixels from the first camera.
pub(crate) fn coarse(scene: &Scene, strategy: Strategy, pixels: u32) -> CompareOptions {
    CompareOptions {
        solve: SolveOptions {
            epsilon: 2e-2,
            contrast: 0.8,
            min_size: None,
            resolution: 16.0,
            iterations: 200,
            visibility: VisibilityOptions { strategy, rays: 4, certify: false },
            record: Record::Nothing,
        },
        rays: 2000,
        repeats: 1,
        solves: 1,
        camera: Camera { width: pixels, height: pixels, ..scene.cameras[0].clone() },
        render: RenderOptions { samples: 1, view: View::Shaded },
        square_meters: 1.0,
    }
}
