//! Writes the page of two tracers that disagree, one of which does not see a side of a box: `disagreement PAGE.html`.
//! `run.py` looks at it; tracers that people have make no such page.

#[path = "../coarse_comparison/mod.rs"]
mod coarse_comparison;
#[path = "../faulty_tracers/mod.rs"]
mod faulty_tracers;

use std::path::Path;

use coarse_comparison::{BOX_SIDE, coarse};
use faulty_tracers::Blind;
use lightshaft::compare::{compare, difference_picture};
use lightshaft::hierarchy::Hierarchy;
use lightshaft::image::picture::Picture;
use lightshaft::image::tone::Exposure;
use lightshaft::image::write::png_bytes;
use lightshaft::progress::Silent;
use lightshaft::report::compare::CompareReport;
use lightshaft::report::html::{Shown, write_compare};
use lightshaft::scene;
use lightshaft::tracer::FallbackTracer;
use lightshaft::visibility::Strategy;

/// How much brighter the picture of the difference is.
const GAIN: f32 = 16.0;

fn main() {
    let page = std::env::args().nth(1).expect("a page to write");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.toml");
    let scene = scene::load(&path, &Default::default(), &Silent).expect("a scene of the project");
    let hierarchy = Hierarchy::build(&scene, false, &Silent);
    let options = coarse(&scene, Strategy::Adaptive, 160);
    let tracer = FallbackTracer::new(&hierarchy.mesh);
    let blind = Blind::to(&tracer, BOX_SIDE);
    let (found, pictures) = compare(&hierarchy, [&tracer, &blind], &options, &Silent);
    let report = CompareReport::new(&scene.name, ["fallback", "blind"], 1, &hierarchy, &found);
    assert!(!report.agree, "one of them is blind");
    let exposure = Exposure::Automatic.multiplier(&pictures[0]);
    let png = |picture: &Picture| png_bytes(picture, Some(exposure)).expect("a picture");
    let [native, other] = &pictures;
    let difference = difference_picture([native, other], GAIN);
    let shown = Shown {
        size: [native.width, native.height],
        files: [png(native), png(other), png(&difference)],
        gain: GAIN,
    };
    write_compare(Path::new(&page), &report, shown).expect("a page");
}
