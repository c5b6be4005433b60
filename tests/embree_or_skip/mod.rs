//! The Embree tracer for tests, where there is an Embree.

use std::io::Write;

use lightshaft::tracer::TraceMesh;
use lightshaft::tracer::embree::{EmbreeLibrary, EmbreeOptions, EmbreeTracer};

/// The Embree tracer for `mesh`; `None`, and a line that says so, where Embree is not usable.
///
/// # Panics
/// Without a usable Embree when `LIGHTSHAFT_REQUIRE_EMBREE` is 1.
pub(crate) fn embree(mesh: &TraceMesh) -> Option<EmbreeTracer> {
    match EmbreeLibrary::find(None) {
        Ok(library) => {
            Some(EmbreeTracer::new(&library, mesh, EmbreeOptions::default()).expect("Embree takes the mesh"))
        }
        Err(error) => {
            let is_required = std::env::var_os("LIGHTSHAFT_REQUIRE_EMBREE").is_some_and(|v| v == "1");
            assert!(!is_required, "LIGHTSHAFT_REQUIRE_EMBREE is set, but {error}");
            let name = std::thread::current().name().unwrap_or("a test").to_owned();
            // Past the test harness, which keeps what passing tests print to itself.
            let _ = writeln!(std::io::stderr(), "skipped {name}: no usable Embree");
            None
        }
    }
}
