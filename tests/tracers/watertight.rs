//! No light leaves a closed shell, not even through an edge or a corner where facets meet. A failure means
//! bright lines along the edges of closed rooms.

use lightshaft::compare::Numbers;
use lightshaft::tracer::{Candidates, NO_FACET, Segment};

use crate::meshes::shell;
use crate::tracers;
use crate::verdict::blockers;

/// Segments of each kind.
const COUNT: usize = 20_000;

/// Exact, without tolerance: an edge belongs to two facets, and whatever rounding does, one of them has to
/// be hit. Where six facets meet in a corner, Embree lets 5 of 20 000 segments through that are aimed at
/// the very corner; they are bounded, and none is allowed through edges or with the tracer in Rust.
#[test]
fn no_segment_leaves_a_closed_shell() {
    for (name, mesh) in [("box", shell(true)), ("ball", shell(false))] {
        let at = |v: u32| mesh.positions[v as usize];
        for kind in ["corners", "edges", "facets"] {
            let mut numbers = Numbers(41);
            let segments: Vec<Segment> = (0..COUNT)
                .map(|_| {
                    let [a, b, c] = mesh.triangles[numbers.below(mesh.triangles.len())].map(at);
                    let (s, t) = (numbers.next_number(), numbers.next_number());
                    let target = match kind {
                        "corners" => a,
                        "edges" => a.lerp(b, s),
                        _ => c.lerp(a.lerp(b, s), t),
                    };
                    let from = numbers.point() * 0.2;
                    let to = from + (target - from) * (2.0 + numbers.next_number());
                    Segment { from, to, skip: [NO_FACET; 2] }
                })
                .collect();
            for tracer in tracers(&mesh) {
                let found = blockers(tracer.as_ref(), &segments, Candidates::All);
                let leaks = found.iter().filter(|&&blocker| blocker == NO_FACET).count();
                let what = format!("{name}, {kind}, {}: {leaks} of {COUNT} get out", tracer.name());
                println!("{what}");
                let is_corner = kind == "corners" && tracer.name() == "embree";
                assert!(leaks <= if is_corner { COUNT / 2000 } else { 0 }, "{what}");
            }
        }
    }
}

/// The check itself: one facet less, and segments get out.
#[test]
fn a_hole_is_noticed() {
    let mut mesh = shell(false);
    mesh.triangles.pop();
    mesh.facet_of_triangle.pop();
    let at = |v: u32| mesh.positions[v as usize];
    let hole = shell(false).triangles.pop().map(|t| t.map(at)).expect("a shell has facets");
    let middle = (hole[0] + hole[1] + hole[2]) / 3.0;
    let segment = Segment { from: middle * 0.1, to: middle * 2.0, skip: [NO_FACET; 2] };
    for tracer in tracers(&mesh) {
        assert_eq!(blockers(tracer.as_ref(), &[segment], Candidates::All), [NO_FACET], "{}", tracer.name());
    }
}
