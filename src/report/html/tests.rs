//! What pages hold, and that nothing in them comes from elsewhere or from a name.

use super::super::compare::CompareReport;
use super::super::compare::tests::report;
use super::super::detail::{RunDetail, Seconds};
use super::super::profile::{Profile, ProfiledRun, Spread};
use super::super::setup::Setting;
use super::*;
use crate::radiosity::VisibilityError;

/// What a scene might call itself.
const HOSTILE: &str = "</title></style><script>alert(1)</script><img src=x onerror=alert(2)>\"'&--><b>";

fn compare_page(mut report: CompareReport, name: &str) -> String {
    report.scene = name.to_owned();
    report.exitance.worst = name.to_owned();
    report.links.worst = name.to_owned();
    report.worst.iter_mut().for_each(|worst| worst.answers = [name, name].map(str::to_owned));
    let shown = Shown { size: [2, 1], files: [vec![1, 2, 3], vec![4], vec![5]], gain: 16.0 };
    compare::page(&report, shown).expect("a page").markup(&setup(name)).into_string()
}

fn profile_page(runs: Vec<ProfiledRun>, name: &str) -> String {
    let found = Profile { scene: name.to_owned(), runs, repeats: 3, ..Profile::default() };
    profile::page(&found, Vec::new()).expect("a page").markup(&setup(name)).into_string()
}

fn setup(name: &str) -> Setup {
    Setup {
        command: format!("lightshaft compare '{name}'"),
        values: vec![Setting::new("scene", name)],
        ..Setup::default()
    }
}

fn run(name: &str, seconds: f64, error: f64) -> ProfiledRun {
    ProfiledRun {
        strategy: name.to_owned(),
        tracer: name.to_owned(),
        rays: 16,
        links: 1,
        visibility_seconds: Spread { min: seconds, median: seconds, max: seconds },
        visibility_error: VisibilityError { mean: error, ..VisibilityError::default() },
        ..ProfiledRun::default()
    }
}

/// All pages, made of this name.
fn pages(name: &str) -> [String; 3] {
    let runs = vec![run(name, 1.0, 0.02), run("root", 2.0, 0.01)];
    [compare_page(report(0, 0.001), name), compare_page(report(3, 0.1), name), profile_page(runs, name)]
}

#[test]
fn names_become_text_whatever_is_in_them() {
    for (hostile, plain) in pages(HOSTILE).iter().zip(&pages("plain")) {
        // Whatever opens an element, names add none.
        let opened = |page: &str| page.matches('<').count();
        assert_eq!(opened(hostile), opened(plain));
        assert!(!hostile.contains("<script>alert") && !hostile.contains("<img src=x"), "{hostile}");
        assert!(hostile.contains("&lt;script&gt;alert(1)&lt;/script&gt;"), "{hostile}");
        // An attribute ends at the quote that begins it, nowhere within a name.
        assert_eq!(hostile.matches('"').count() % 2, 0, "{hostile}");
    }
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    for page in pages("room") {
        let inside = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for part in ["http:", "https:", "url(", "@import", "<link", " href="] {
            assert!(!inside.contains(part), "{part} is in {inside}");
        }
        let sources = inside.split(" src=\"").skip(1);
        assert!(sources.clone().all(|source| source.starts_with("data:image/png;base64,")), "{inside}");
        assert!(page.contains(POLICY) && page.starts_with("<!DOCTYPE html>"), "{page}");
    }
}

#[test]
fn the_verdict_stands_before_everything_else() {
    let [agrees, disagrees, _] = pages("room");
    for (page, class, words) in [
        (&agrees, "good", "The tracers agree."),
        (&disagrees, "bad", "The tracers disagree: 3 of 900 rays are wrong in fallback"),
    ] {
        let verdict = page.find(&format!("<p class=\"verdict {class}\">{words}")).expect("a verdict");
        assert!(verdict < page.find("<section").expect("a section"), "{page}");
    }
    assert!(disagrees.contains("<details open>") && agrees.contains("<details>"));
}

#[test]
fn figures_that_are_not_numbers_and_no_runs_at_all_make_a_page() {
    for runs in [
        Vec::new(),
        vec![run("adaptive", f64::NAN, f64::INFINITY)],
        vec![run("a", 0.0, 0.0), run("b", f64::INFINITY, f64::NAN)],
    ] {
        let page = profile_page(runs, "room");
        assert!(page.trim_end().ends_with("</html>"), "{page}");
    }
    let page = compare_page(report(0, f64::NAN), "room");
    assert!(page.contains("The tracers disagree: the light differs by NaN %"), "{page}");
}

#[test]
fn a_profile_of_one_run_names_what_takes_the_most() {
    let seconds = |name, seconds| Seconds { name, seconds };
    let detail = RunDetail {
        phases: vec![seconds("refine", 3.0), seconds("gather", 1.0)],
        steps: vec![seconds("rays", 1.0), seconds("culling", 4.0)],
        ..RunDetail::default()
    };
    let page = profile_page(vec![ProfiledRun { detail, ..run("adaptive", 5.0, 0.02) }], "room");
    for part in [
        "one run, made 3 times. Times are medians.",
        "5.000 s in visibility",
        "Of the time by the clock 75 % goes to refine.",
        "Of the time in visibility 80 % goes to culling.",
    ] {
        assert!(page.contains(part), "{part} is missing: {page}");
    }
    assert!(!page.contains("fastest") && !page.contains("The aim is"), "{page}");
}

#[test]
fn a_profile_of_several_has_ratios_and_what_the_aim_takes() {
    let page = profile_page(vec![run("adaptive", 1.0, 0.02), run("root", 2.0, 0.01)], "room");
    for part in [
        ">ratio</button>",
        ">filter calls</button>",
        "The aim is the visibility error of adaptive, adaptive, 16 rays (2.000 %).",
        "<li>root, root, 16 rays: 2.000 s in visibility, 2.00 times as long; 0.00 s in all, 0.00 times</li>",
        "The yardstick, to which ratios of time are, is adaptive, adaptive, 16 rays",
    ] {
        assert!(page.contains(part), "{part} is missing: {page}");
    }
}

#[test]
fn every_colour_of_a_plot_has_one_for_dark_pages() {
    let rules = plot_colours();
    for index in 0..COLOURS.len() {
        assert_eq!(rules.matches(&format!("--c{index}:")).count(), 2, "light and dark: {rules}");
    }
    assert!(rules.contains("figure svg [fill=\"#005AB5\"]{fill:var(--c0)}"), "{rules}");
}
