//! Other light over the links of a solution is the light that solving anew finds, as far as the links allow.

use lightshaft::check::{self, Limits};
use lightshaft::compare::ExitanceDifference;
use lightshaft::progress::Silent;
use lightshaft::radiosity::{self, Relit, Reuse, Solution, SolveOptions};
use lightshaft::scene::Scene;
use lightshaft::visibility::{Strategy, VisibilityOptions};
use rayon::ThreadPoolBuilder;

use crate::solving::{Case, options as finer, rough};

/// The box, with materials as `change` makes them.
fn changed(scene: &Scene, change: impl Fn(&mut Scene)) -> Case {
    let mut scene = scene.clone();
    change(&mut scene);
    Case::of(scene, false)
}

fn set(scene: &mut Scene, name: &str, reflectance: Option<[f32; 3]>, radiance: Option<[f32; 3]>) {
    let named = scene.materials.iter_mut().filter(|material| material.name == name);
    let mut count = 0;
    for material in named {
        count += 1;
        material.reflectance = reflectance.unwrap_or(material.reflectance);
        material.radiance = radiance.unwrap_or(material.radiance);
    }
    assert!(count > 0, "no material is named {name}");
}

fn relit(case: &Case, solved: Solution, options: &SolveOptions, reuse: Reuse) -> Relit {
    let square_meters = case.hierarchy.square_meters_per_unit(case.scene.meters_per_unit);
    radiosity::relight(&case.hierarchy, &case.fallback(), solved, options, reuse, square_meters, &Silent)
}

/// RMS of exitance relative to what is reflected on average.
fn difference(case: &Case, truth: &Solution, other: &Solution) -> f64 {
    let difference = ExitanceDifference::between(&case.hierarchy, [truth, other]);
    difference.relative(difference.rms)
}

/// The same of means over the elements that both have: where one is finer it may show an edge that the other one cannot.
fn difference_of_means(case: &Case, truth: &Solution, other: &Solution) -> f64 {
    /// Adds squares over the leaves below an element of each that are leaves in one of the two.
    fn add(solutions: [&Solution; 2], [a, b]: [u32; 2], sums: &mut [f64; 2]) {
        let second = [(0, a), (1, b)].map(|(i, element)| solutions[i].forest.second[element as usize]);
        if second.iter().all(|&second| second != 0) {
            add(solutions, [a + 1, b + 1], sums);
            return add(solutions, second, sums);
        }
        let [one, two] =
            [(0, a), (1, b)].map(|(i, element)| solutions[i].light.exitance[element as usize].as_dvec3());
        let (off, area) = ((one - two).abs().max_element(), f64::from(solutions[0].forest.area[a as usize]));
        sums[0] += off * off * area;
        sums[1] += area;
    }
    let mut sums = [0.0; 2];
    for side in 0..truth.forest.side_count() {
        let whole = [truth, other].map(|solution| solution.forest.first_element[side]);
        add([truth, other], whole, &mut sums);
    }
    let [squares, area] = sums;
    ExitanceDifference::between(&case.hierarchy, [truth, other]).relative((squares / area).sqrt())
}

/// A solution that is made with a few more rays: nearer than this need no other be.
fn with_more_rays(case: &Case, options: &SolveOptions) -> Solution {
    let visibility = VisibilityOptions { rays: options.visibility.rays + 3, ..options.visibility };
    case.solve(&case.fallback(), &SolveOptions { visibility, ..*options })
}

#[test]
fn the_same_light_comes_again() {
    for name in ["cornell-box", "paper-3"] {
        let case = Case::load(name);
        let options = rough(Strategy::Adaptive);
        let solve = || case.solve(&case.fallback(), &options);
        let again = relit(&case, solve(), &options, Reuse::Links);
        let off = difference(&case, &solve(), &again.solution);
        assert!(off < 0.01, "{name}: {off}");
        assert_eq!(
            (again.untested, again.solution.links.links.len()),
            (0, solve().links.links.len()),
            "{name}"
        );
    }
}

#[test]
fn brighter_lamps_make_all_as_much_brighter() {
    let case = Case::load("cornell-box");
    let options = rough(Strategy::Adaptive);
    let solved = case.solve(&case.fallback(), &options);
    let brighter = changed(&case.scene, |scene| {
        scene.materials.iter_mut().for_each(|m| m.radiance = m.radiance.map(|radiance| radiance * 8.0));
    });
    let emitted = solved.energy.emitted;
    let irradiance = solved.light.irradiance.clone();
    let Relit { solution, untested, .. } = relit(&brighter, solved, &options, Reuse::Links);
    assert_eq!(untested, 0, "no lamp was dark");
    assert!((solution.energy.emitted / emitted - 8.0).abs() < 1e-6);
    let (mut off, mut sum) = (0.0, 0.0);
    for leaf in solution.forest.leaves() {
        let area = f64::from(solution.forest.area[leaf]);
        off +=
            area * f64::from((solution.light.irradiance[leaf] - irradiance[leaf] * 8.0).abs().element_sum());
        sum += area * f64::from(irradiance[leaf].element_sum() * 8.0);
    }
    assert!(off < 0.01 * sum, "{} off", off / sum);
    assert!(solution.energy.balance_error() < 0.05 && solution.energy.error < 1e-3 * solution.energy.emitted);
}

#[test]
fn other_reflectances_give_the_light_that_solving_anew_gives() {
    let case = Case::load("cornell-box");
    let options = rough(Strategy::Adaptive);
    let before = || case.solve(&case.fallback(), &options);
    let other = changed(&case.scene, |scene| {
        set(scene, "white", Some([0.4, 0.7, 0.8]), None);
        set(scene, "red", Some([0.1, 0.2, 0.8]), None);
        set(scene, "green", Some([0.8, 0.7, 0.1]), None);
    });
    let anew = other.solve(&other.fallback(), &options);
    let was = difference(&other, &anew, &before());
    let links = relit(&other, before(), &options, Reuse::Links);
    let refined = relit(&other, before(), &options, Reuse::Refined);
    let [kept, divided] = [&links, &refined].map(|relit| difference(&other, &anew, &relit.solution));
    let noise = difference(&other, &anew, &with_more_rays(&other, &options));
    assert!(was > 5.0 * noise, "the light must change for this to say anything: {was}, noise {noise}");
    assert!(kept < 2.0 * noise && divided < 1.5 * noise, "{kept} {divided}, noise {noise}");
    assert!(links.coarse < 0.2 && refined.coarse < 0.2, "{} {}", links.coarse, refined.coarse);
    assert!(links.moved < 0.05, "{} moved", links.moved);
    let report = check::check(&other.hierarchy, &other.fallback(), &links.solution, &Limits::DRAFT, &Silent);
    assert!(report.passed(), "{report:?}");
}

/// The box with a black wall, and with one that shines.
fn with_dark_lamp(case: &Case) -> [Case; 2] {
    [[0.0; 3], [30.0, 5.0, 5.0]]
        .map(|radiance| changed(&case.scene, |scene| set(scene, "red", Some([0.0; 3]), Some(radiance))))
}

#[test]
fn what_was_dark_and_shines_is_tested() {
    let case = Case::load("cornell-box");
    let [dark, lit] = with_dark_lamp(&case);
    let options = rough(Strategy::Adaptive);
    let solved = dark.solve(&dark.fallback(), &options);
    let anew = lit.solve(&lit.fallback(), &options);
    let relit = relit(&lit, solved, &options, Reuse::Links);
    assert!(relit.untested > 0);
    // Elements are finer where they were so for the other lamp, too: on the ceiling, where the edge of the lamp's shadow is.
    let more_rays = with_more_rays(&lit, &options);
    let [off, noise] =
        [&relit.solution, &more_rays].map(|solution| difference_of_means(&lit, &anew, solution));
    assert!(off < 1.5 * noise, "{off}, noise {noise}");
    // What is nearer is said by one that is finer than both.
    let fine = lit.solve(&lit.fallback(), &finer(Strategy::Adaptive));
    let [off, off_anew] = [&relit.solution, &anew].map(|solution| difference(&lit, &fine, solution));
    assert!(off < off_anew, "{off}, solved anew {off_anew}");
    let shining = |solution: &Solution| {
        let clusters = lit.hierarchy.nodes.len() as u32;
        let is_lit =
            |source: u32| source >= clusters && solution.light.exitance[(source - clusters) as usize].x > 1.0;
        let links = solution.links.links.iter();
        links.filter(|link| link.class == radiosity::LinkClass::Untested && is_lit(link.source)).count()
    };
    assert_eq!(shining(&relit.solution), 0, "links from the lamp are left untested");
}

#[test]
fn light_from_elsewhere_is_said_to_be_coarse() {
    let case = Case::load("cornell-box");
    let options = rough(Strategy::Adaptive);
    let solve = || case.solve(&case.fallback(), &options);
    let other = changed(&case.scene, |scene| {
        set(scene, "light", None, Some([0.0; 3]));
        set(scene, "green", None, Some([2.0; 3]));
    });
    let anew = other.solve(&other.fallback(), &options);
    let links = relit(&other, solve(), &options, Reuse::Links);
    let refined = relit(&other, solve(), &options, Reuse::Refined);
    let [kept, divided] = [&links, &refined].map(|relit| difference(&other, &anew, &relit.solution));
    assert!(links.coarse > 0.3 && refined.coarse < 0.5 * links.coarse, "{} {}", links.coarse, refined.coarse);
    assert!(kept < 0.4 && divided < 0.7 * kept, "{kept} {divided}");
    assert!(refined.solution.links.links.len() > links.solution.links.links.len());
}

#[test]
fn the_same_for_any_number_of_threads() {
    let case = Case::load("cornell-box");
    let [dark, lit] = with_dark_lamp(&case);
    let options = rough(Strategy::Adaptive);
    let [one, three] = [1, 3].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
        pool.install(|| {
            let solved = dark.solve(&dark.fallback(), &options);
            relit(&lit, solved, &options, Reuse::Links)
        })
    });
    assert_eq!(one.solution.links.links, three.solution.links.links);
    assert_eq!(one.solution.light.exitance, three.solution.light.exitance);
    assert_eq!((one.untested, one.coarse), (three.untested, three.coarse));
}

#[test]
fn no_light_is_lost_or_made_where_visibility_is_sampled() {
    let case = Case::load("cornell-box");
    let options = rough(Strategy::Sampled);
    // Other surfaces lit, so that links lose or make another share of the light.
    let other = changed(&case.scene, |scene| {
        set(scene, "light", None, Some([0.0; 3]));
        set(scene, "green", None, Some([2.0; 3]));
    });
    let solved = case.solve(&case.fallback(), &options);
    let relit = relit(&other, solved, &options, Reuse::Links).solution;
    let lost = relit.energy.lost().abs() / relit.energy.emitted;
    assert!(lost < 5e-3, "{lost}");
}
