//! The local pass: what interpolation shows of a coarse solution after it, against closed forms and against rays over the
//! whole hemisphere. A failure means that elements for display have the wrong light, or lie in the wrong places.

use glam::DVec3;
use lightshaft::gather::{Reconstruction, local_pass};
use lightshaft::progress::Silent;
use lightshaft::radiosity::{DisplayMesh, Solution};
use lightshaft::tracer::Tracer;
use lightshaft::visibility::Strategy;
use rayon::ThreadPoolBuilder;

use crate::asking::Point;
use crate::boxes::Rectangles;
use crate::final_gather::{off_rays, off_shadow, seen, sides};
use crate::penumbra::{self, BOARDS};
use crate::solving::{Case, rough};

const RAYS: u32 = 64;

/// A solution with elements for display.
fn solved(case: &Case, tracer: &dyn Tracer) -> Solution {
    let mut solution = case.solve(tracer, &rough(Strategy::Adaptive));
    solution.display = local_pass(&case.hierarchy, tracer, &solution, RAYS, &Silent);
    solution
}

/// Irradiance at points as it is shown, and as the elements have it that links have: first channel.
fn both(case: &Case, tracer: &dyn Tracer, solution: &Solution, points: &[Point]) -> Vec<[f64; 2]> {
    let made = [Reconstruction::shown, Reconstruction::new].map(|make| make(&case.hierarchy, solution));
    let at = |made: &Reconstruction<'_>, (side, point)| {
        f64::from(made.look_up(side, point).expect("a side that takes part").irradiance.x)
    };
    sides(case, tracer, points).into_iter().map(|place| [0, 1].map(|i| at(&made[i], place))).collect()
}

/// As many elements as it takes to show the half shadow of a board are made, not more.
#[test]
fn elements_are_divided_until_interpolation_shows_a_shadow() {
    for board in BOARDS {
        let case = penumbra::scene(board);
        let points = penumbra::points(board);
        let tracer = case.fallback();
        let solution = solved(&case, &tracer);
        let found = both(&case, &tracer, &solution, &points);
        let [shown, linked] = [0, 1].map(|which| off_shadow(board, &points, &found, which));
        let count = |forest: &lightshaft::radiosity::Forest| forest.leaves().count();
        let mesh = solution.display.as_ref().expect("made above");
        let counts = [count(&mesh.forest), count(&solution.forest)];
        println!("{board:?}: {shown:.4}, without {linked:.4}; leaves {counts:?}");
        assert!(shown < 0.05 && shown < 0.6 * linked, "{board:?}: {shown}, without {linked}");
        assert!(counts[0] > counts[1] && counts[0] < 64 * counts[1], "{board:?}: {counts:?}");
    }
}

#[test]
fn what_is_shown_agrees_with_rays_over_the_hemisphere() {
    let case = Case::load("cornell-box");
    let tracer = case.fallback();
    let solution = solved(&case, &tracer);
    let points = seen(&case, &tracer);
    let found = both(&case, &tracer, &solution, &points);
    let [shown, linked] = off_rays(&case, &tracer, &solution, &points, &found);
    println!("{shown:.4}, without {linked:.4}");
    assert!(shown < 0.05 && shown < 0.6 * linked, "{shown}, without {linked}");
}

/// And elements for display divide those that links have.
#[test]
fn it_is_the_same_for_any_number_of_threads() {
    let case = Case::load("paper-1");
    let tracer = case.fallback();
    let bits = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let solution = pool.install(|| solved(&case, &tracer));
        let DisplayMesh { forest, irradiance, linked } = solution.display.expect("made above");
        // Elements that are not divided are those of the solution, and all others lie in one of its leaves.
        for (own, &element) in linked.iter().enumerate() {
            let (own, theirs) = (forest.second[own], solution.forest.second[element as usize]);
            assert!(own != 0 || theirs == 0, "{element} is divided for links and not for display");
        }
        let areas: Vec<f32> =
            (0..forest.side_count()).map(|side| forest.area[forest.first_element[side] as usize]).collect();
        assert!(forest.len() > solution.forest.len() && areas.iter().all(|&area| area > 0.0));
        let light =
            irradiance.iter().flat_map(|light| light.to_array().map(f32::to_bits)).collect::<Vec<_>>();
        (forest.second, light, linked)
    };
    let once = bits(1);
    assert!(once == bits(3));
}

/// What gets next to no light lies hidden below what stands there, and does not darken what is seen beside it; a shadow
/// does.
#[test]
fn what_is_hidden_darkens_nothing_beside_it() {
    let mut room = Rectangles::new("a floor");
    let (white, lamp) = (room.material(0.5, 0.0), room.material(0.0, 10.0));
    room.quad([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]], white);
    room.quad([[1.0, 1.0, 3.0], [1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [2.0, 1.0, 3.0]], lamp);
    let case = Case::of(room.finish(), false);
    let tracer = case.fallback();
    let mut solution = case.solve(&tracer, &rough(Strategy::Adaptive));
    let middle = DVec3::new(2.0, 2.0, 0.0);
    for (dark, expected) in [(0.02, 1.0), (0.5, 0.75)] {
        let all = vec![true; solution.forest.len()];
        let forest = solution.forest.divided(&case.hierarchy, &all);
        let is_dark =
            |center: &glam::Vec3| case.hierarchy.frame.scene_from_local(center.as_dvec3()).x < middle.x;
        let light = |center| glam::Vec3::splat(if is_dark(center) { dark } else { 1.0 });
        let irradiance = forest.center.iter().map(light).collect();
        solution.display = DisplayMesh::new(forest, irradiance, &solution.forest);
        let beside = (middle + DVec3::X * 1e-3, DVec3::Z);
        let [shown, _] = both(&case, &tracer, &solution, &[beside])[0];
        assert!((shown - expected).abs() < 0.02, "beside {dark}: {shown}, not {expected}");
    }
}
