//! What tracers keep is counted: it follows the size of the mesh and nothing else.

use crate::meshes::soup;
use crate::tracers;

#[test]
fn what_a_tracer_keeps_follows_the_mesh() {
    let [small, large] = [20_000, 80_000].map(|facets| soup(facets, 3));
    for (tracer, larger) in tracers(&small).iter().zip(tracers(&large)) {
        let per_triangle =
            [(tracer, &small), (&larger, &large)].map(|(t, mesh)| t.bytes() / mesh.triangles.len() as u64);
        // Corners and ids are 28 bytes or more, and no tree needs a kilobyte.
        assert!(
            per_triangle.iter().all(|bytes| (50..1000).contains(bytes)),
            "{}: {per_triangle:?}",
            tracer.name()
        );
        assert!(per_triangle[0].abs_diff(per_triangle[1]) < 50, "{}: {per_triangle:?}", tracer.name());
    }
    // The same mesh once more, after others were built and dropped; threads may leave parts of Embree's blocks unused.
    for (tracer, again) in tracers(&large).iter().zip(tracers(&large)) {
        let [one, other] = [tracer.bytes(), again.bytes()];
        assert!(one.abs_diff(other) < one / 20, "{}: {one}, {other}", tracer.name());
    }
}
