//! One suite for every tracer, with the exhaustive one as the judge: random segments, and those that are
//! hard to decide. Every check is also shown a planted fault that it has to notice.

#[path = "../embree_or_skip/mod.rs"]
mod embree_or_skip;
#[path = "../faulty_tracers/mod.rs"]
mod faulty_tracers;

mod adversarial;
mod bytes;
mod comparison;
mod far_away;
mod faults;
mod first_hits;
mod meshes;
mod random;
mod verdict;
mod watertight;

use embree_or_skip::embree;
use lightshaft::tracer::{FallbackTracer, TraceMesh, Tracer};

/// Every tracer but the judge.
fn tracers(mesh: &TraceMesh) -> Vec<Box<dyn Tracer>> {
    let mut all: Vec<Box<dyn Tracer>> = vec![Box::new(FallbackTracer::new(mesh))];
    all.extend(embree(mesh).map(|tracer| Box::new(tracer) as Box<dyn Tracer>));
    all
}
