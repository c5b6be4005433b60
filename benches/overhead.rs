//! What it costs to keep the detail of visibility tests: a scene is solved with and without, in turns.
//!
//! `cargo bench --bench overhead`, or with a scene: `cargo bench --bench overhead -- room.toml`. One thread; the
//! seconds are those that the thread was given by the processor, where the system tells (Linux), so that others who
//! work on the machine do not count in full.

use std::path::{Path, PathBuf};
use std::time::Instant;

use lightshaft::hierarchy::Hierarchy;
use lightshaft::progress::Silent;
use lightshaft::radiosity::{self, Record, SolveOptions};
use lightshaft::scene;
use lightshaft::tracer::embree::{EmbreeLibrary, EmbreeOptions, EmbreeTracer};
use lightshaft::tracer::{FallbackTracer, Tracer};
use lightshaft::visibility::{Strategy, VisibilityOptions};

/// How often each is solved.
const TURNS: usize = 7;

/// Seconds of this thread so far.
fn seconds(begun: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| begun.elapsed().as_secs_f64(), |count| count * 1e-9)
}

fn tracer(hierarchy: &Hierarchy) -> Box<dyn Tracer> {
    let embree = EmbreeLibrary::find(None).and_then(|library| {
        EmbreeTracer::new(&library, &hierarchy.mesh, EmbreeOptions { threads: 1, ..EmbreeOptions::default() })
    });
    match embree {
        Ok(tracer) => Box::new(tracer),
        Err(_) => Box::new(FallbackTracer::new(&hierarchy.mesh)),
    }
}

fn measure(path: &Path) {
    let scene = scene::load(path, &scene::LoadOptions::default(), &Silent).expect("a scene");
    let hierarchy = Hierarchy::build(&scene, false, &Silent);
    let tracer = tracer(&hierarchy);
    let square_meters = hierarchy.square_meters_per_unit(scene.meters_per_unit);
    println!("{}, {}: seconds without and with detail, ratio", scene.name, tracer.name());
    for strategy in [Strategy::Adaptive, Strategy::Root, Strategy::Shaft, Strategy::Sampled] {
        let mut times = [const { Vec::new() }; 2];
        for turn in 0..2 * TURNS {
            // Now one first, now the other.
            let which = (turn + turn / 2) % 2;
            let options = SolveOptions {
                epsilon: 5e-5,
                contrast: 0.1,
                min_size: None,
                resolution: 128.0,
                iterations: 2000,
                visibility: VisibilityOptions { strategy, rays: 16, certify: false },
                record: [Record::Nothing, Record::Steps][which],
            };
            let begun = Instant::now();
            let before = seconds(begun);
            radiosity::solve(&hierarchy, tracer.as_ref(), &options, square_meters, &Silent);
            times[which].push(seconds(begun) - before);
        }
        let [without, with] = times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[TURNS / 2]
        });
        println!("  {:<8}  {without:8.3}  {with:8.3}  {:.3}", strategy.name(), with / without);
    }
}

fn main() {
    let named: Vec<PathBuf> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).map(PathBuf::from).collect();
    let own = || {
        let scenes = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes");
        ["cornell-box", "paper-2"].map(|name| scenes.join(name).join("scene.toml")).to_vec()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| if named.is_empty() { own() } else { named }.iter().for_each(|path| measure(path)));
}
