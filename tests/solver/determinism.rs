//! The same answer, bit by bit, for any number of threads and in every run. A failure means that
//! something depends on which thread came first.

use std::hash::{DefaultHasher, Hash, Hasher};

use lightshaft::image::{self, RenderOptions, View};
use lightshaft::progress::Silent;
use lightshaft::radiosity::Solution;
use lightshaft::scene::Camera;
use lightshaft::tracer::Tracer;
use lightshaft::visibility::{Strategy, VisibilityCounters};
use rayon::ThreadPoolBuilder;

use crate::embree_or_skip::embree;
use crate::solving::{Case, STRATEGIES, options};

/// Everything that must not change: a hash of each part, so that a failure says which part it is.
#[derive(Debug, PartialEq, Eq)]
struct Fingerprint {
    elements: u64,
    links: u64,
    exitance: u64,
    irradiance: u64,
    energy: u64,
    counters: VisibilityCounters,
    invisible: [u64; 2],
    iterations: u32,
    picture: u64,
    mesh_view: u64,
}

fn hash(bits: impl Iterator<Item = u32>) -> u64 {
    let mut hasher = DefaultHasher::new();
    bits.for_each(|b| b.hash(&mut hasher));
    hasher.finish()
}

fn fingerprint(case: &Case, tracer: &dyn Tracer, solution: &Solution) -> Fingerprint {
    let colors = |values: &[glam::Vec3]| hash(values.iter().flat_map(|v| v.to_array().map(f32::to_bits)));
    let camera = Camera { width: 61, height: 47, ..case.scene.cameras[0].clone() };
    let picture = |view| {
        let options = RenderOptions { samples: 3, view };
        let picture = image::render(&case.hierarchy, tracer, solution, &camera, options, &Silent);
        assert!(picture.pixels.iter().any(|p| p[0] > 0.0), "a black picture shows nothing");
        hash(picture.pixels.iter().flat_map(|p| p.map(f32::to_bits)))
    };
    let counters = &solution.counters;
    let energy = &solution.energy;
    Fingerprint {
        elements: hash(solution.forest.second.iter().copied()),
        links: hash(solution.links.links.iter().flat_map(|l| {
            let known = l.class as u32 * 2 + u32::from(l.is_inherited());
            let quarters = hash(l.quarters.weights().into_iter().map(|w| (w as f32).to_bits()));
            let figures = [l.factor, l.spread(), l.visibility].map(f32::to_bits);
            [l.receiver, l.source, known, quarters as u32].into_iter().chain(figures)
        })),
        exitance: colors(&solution.light.exitance),
        irradiance: colors(&solution.light.irradiance),
        energy: hash(
            [energy.emitted, energy.absorbed, energy.escaped, energy.error]
                .into_iter()
                .flat_map(|w| [w.to_bits() as u32, (w.to_bits() >> 32) as u32]),
        ),
        counters: VisibilityCounters { nanoseconds: 0, ..counters.visibility },
        invisible: [counters.invisible, counters.certified_invisible],
        iterations: solution.iterations,
        picture: picture(View::Shaded),
        mesh_view: picture(View::Mesh),
    }
}

/// Solves and renders from the very beginning with this many threads.
fn run(name: &str, threads: usize, strategy: Strategy, on_embree: bool) -> Option<Fingerprint> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
    pool.install(|| {
        let case = Case::load(name);
        let tracer: Box<dyn Tracer> =
            if on_embree { Box::new(embree(&case.hierarchy.mesh)?) } else { Box::new(case.fallback()) };
        let solution = case.solve(tracer.as_ref(), &options(strategy));
        Some(fingerprint(&case, tracer.as_ref(), &solution))
    })
}

fn check(on_embree: bool) {
    for name in ["cornell-box", "paper-1"] {
        for strategy in STRATEGIES.into_iter().filter(|&s| s != Strategy::All) {
            let Some(alone) = run(name, 1, strategy, on_embree) else { return };
            for threads in [1, 2, 3, 8] {
                let again = run(name, threads, strategy, on_embree);
                assert_eq!(Some(&alone), again.as_ref(), "{name} {} on {threads} threads", strategy.name());
            }
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    check(false);
}

#[test]
fn any_number_of_threads_gives_the_same_bits_on_embree() {
    check(true);
}

/// The check itself: the smallest change of one value has to be noticed.
#[test]
fn one_bit_is_noticed() {
    let case = Case::load("paper-3");
    let tracer = case.fallback();
    let mut solution = case.solve(&tracer, &options(Strategy::Adaptive));
    let before = fingerprint(&case, &tracer, &solution);
    let middle = solution.links.links.len() / 2;
    let factor = &mut solution.links.links[middle].factor;
    *factor = f32::from_bits(factor.to_bits() ^ 1);
    let after = fingerprint(&case, &tracer, &solution);
    assert_ne!(before.links, after.links);
    // The view of the mesh is coloured by the links, so that the bit may show there.
    assert_eq!(Fingerprint { links: before.links, mesh_view: before.mesh_view, ..after }, before);
}
