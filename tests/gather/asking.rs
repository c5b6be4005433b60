//! The one place where this suite asks for light at points.

use glam::DVec3;
pub(crate) use lightshaft::gather::SAMPLES;
use lightshaft::gather::{Gatherer, Irradiance};
use lightshaft::radiosity::SolveOptions;
use lightshaft::tracer::Tracer;

use crate::embree_or_skip::embree;
use crate::solving::Case;

/// A point and the unit normal of the surface there, scene coordinates.
pub(crate) type Point = (DVec3, DVec3);

/// Irradiance at each point, first channel: total and direct.
pub(crate) fn gather(
    case: &Case,
    tracer: &dyn Tracer,
    options: &SolveOptions,
    samples: u32,
    points: &[Point],
) -> Vec<[f64; 2]> {
    let solution = case.solve(tracer, options);
    let gatherer = Gatherer::new(&case.hierarchy, tracer, &solution, samples);
    points
        .iter()
        .map(|&(point, normal)| {
            let Irradiance { total, direct } = gatherer.irradiance(point, normal);
            [total.x, direct.x]
        })
        .collect()
}

/// The pure-Rust tracer, and Embree where there is one.
pub(crate) fn tracers(case: &Case) -> Vec<Box<dyn Tracer>> {
    let mut all: Vec<Box<dyn Tracer>> = vec![Box::new(case.fallback())];
    all.extend(embree(&case.hierarchy.mesh).map(|tracer| Box::new(tracer) as Box<dyn Tracer>));
    all
}
