//! A penumbra that is known exactly: a board with one straight edge, parallel to the edges of a
//! rectangular lamp, hangs over a floor. From each point the plane through point and edge cuts the lamp,
//! and what is visible of it is a rectangle again. A failure means that shadows are too wide, too narrow,
//! or in the wrong place.

use std::f64::consts::PI;

use glam::DVec3;
use lightshaft::gather::Irradiance;
use lightshaft::probe::{check_points, read_points, read_reference};
use lightshaft::visibility::Strategy;

use crate::asking::{Point, SAMPLES, gather, tracers};
use crate::boxes::Rectangles;
use crate::lambert::level_rectangle;
use crate::solving::{Case, rough};

const RADIANCE: f64 = 5.0;
const LAMP: f64 = 2.0;

/// Height of the board and where its edge is; it covers all smaller x.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Board {
    pub(crate) height: f64,
    pub(crate) edge: f64,
}

/// The lamp is the unit square at height 2.
pub(crate) fn scene(board: Board) -> Case {
    let mut scene = Rectangles::new("penumbra");
    let (black, lamp) = (scene.material(0.0, 0.0), scene.material(0.0, RADIANCE as f32));
    scene.quad([[-4.0, -4.0, 0.0], [5.0, -4.0, 0.0], [5.0, 5.0, 0.0], [-4.0, 5.0, 0.0]], black);
    scene.quad([[0.0, 0.0, LAMP], [0.0, 1.0, LAMP], [1.0, 1.0, LAMP], [1.0, 0.0, LAMP]], lamp);
    let Board { height, edge } = board;
    scene.quad([[-4.0, -4.0, height], [edge, -4.0, height], [edge, 5.0, height], [-4.0, 5.0, height]], black);
    Case::of(scene.finish(), false)
}

/// Irradiance at (x, y) on the floor without the board, with it, and the share of the lamp that is seen.
pub(crate) fn exact(board: Board, x: f64, y: f64) -> (f64, f64, f64) {
    let irradiance = |from: f64| PI * RADIANCE * level_rectangle([from - x, 1.0 - x], [-y, 1.0 - y], LAMP);
    // The line from the point over the edge meets the lamp's plane here.
    let first_seen = (x + (board.edge - x) * LAMP / board.height).clamp(0.0, 1.0);
    (irradiance(0.0), irradiance(first_seen), 1.0 - first_seen)
}

/// Across the whole penumbra and some way into light and shadow on both sides.
pub(crate) fn points(board: Board) -> Vec<Point> {
    let across = 81;
    let shift = |lamp: f64| lamp + (board.edge - lamp) * LAMP / (LAMP - board.height);
    let (from, to) = (shift(1.0) - 0.1, shift(0.0) + 0.1);
    (0..across)
        .flat_map(|i| {
            let x = from + (to - from) * i as f64 / (across - 1) as f64;
            [-0.7, 0.1, 0.5, 1.9].map(|y| (DVec3::new(x, y, 0.0), DVec3::Z))
        })
        .collect()
}

/// The largest errors.
#[derive(Debug, Default)]
struct Errors {
    /// Over the irradiance without the board.
    of_unblocked: f64,
    /// Relative, where at least a quarter of the lamp is seen.
    relative: f64,
    lit: usize,
    dark: usize,
    between: usize,
}

/// Compares what is found under one board with what is exact for another.
fn errors(found: &[[f64; 2]], points: &[Point], board: Board) -> Errors {
    let mut errors = Errors::default();
    for ((point, _), [_, direct]) in points.iter().zip(found) {
        let (unblocked, exact, seen) = exact(board, point.x, point.y);
        errors.of_unblocked = errors.of_unblocked.max((direct - exact).abs() / unblocked);
        if seen >= 0.25 {
            errors.relative = errors.relative.max((direct / exact - 1.0).abs());
        }
        errors.lit += usize::from(seen == 1.0);
        errors.dark += usize::from(seen == 0.0);
        errors.between += usize::from(seen > 0.0 && seen < 1.0);
    }
    errors
}

pub(crate) const BOARDS: [Board; 3] =
    [Board { height: 1.0, edge: 0.5 }, Board { height: 0.3, edge: 0.77 }, Board { height: 1.6, edge: 0.2 }];

/// One per cent, as promised for direct light. Rays find the edge of the board: with 4096 of them about
/// 64 parts of the lamp are cut by it, each decided as a whole, which makes some 0.1 % at random.
#[test]
fn light_in_a_penumbra_is_exact_to_a_hundredth() {
    for board in BOARDS {
        let case = scene(board);
        let points = points(board);
        for tracer in tracers(&case) {
            let found = gather(&case, tracer.as_ref(), &rough(Strategy::Adaptive), SAMPLES, &points);
            let errors = errors(&found, &points, board);
            println!("{board:?}, {}: {errors:?}", tracer.name());
            assert!(errors.of_unblocked < 0.01, "{board:?}, {}: {errors:?}", tracer.name());
            assert!(errors.relative < 0.01, "{board:?}, {}: {errors:?}", tracer.name());
            assert!(errors.lit > 5 && errors.dark > 5 && errors.between > 100, "{errors:?}");
        }
    }
}

/// The tables beside the scene `penumbra` are those of a lamp with radiance 5 4 3 and the first of the boards.
#[test]
fn the_table_of_the_scene_is_exact() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/penumbra");
    let points = read_points(&folder.join("points.txt")).expect("points");
    let reference = read_reference(&folder.join("irradiance.csv")).expect("values");
    check_points(&folder, &reference, &points).expect("values of these points");
    assert!(points.len() > 100);
    for (point, value) in points.iter().zip(&reference) {
        let (_, exact, _) = exact(BOARDS[0], point.position.x, point.position.y);
        let exact = DVec3::new(5.0, 4.0, 3.0) * exact / RADIANCE;
        let Irradiance { total, direct } = value.irradiance;
        let off = (total - exact).abs().max_element();
        assert!(off < 1e-8 && total == direct, "{point:?}: {value:?} for {exact}");
        assert_eq!(value.error, Irradiance::default());
    }
}

/// The check itself: an edge that is off by a fiftieth of the lamp has to be noticed.
#[test]
fn a_shifted_edge_is_noticed() {
    let [board, ..] = BOARDS;
    let case = scene(board);
    let points = points(board);
    let found = gather(&case, &case.fallback(), &rough(Strategy::Adaptive), SAMPLES, &points);
    for shift in [-0.02, 0.02] {
        let errors = errors(&found, &points, Board { edge: board.edge + shift, ..board });
        println!("shifted by {shift}: {errors:?}");
        assert!(errors.of_unblocked > 0.01 && errors.relative > 0.01, "{errors:?}");
    }
}
