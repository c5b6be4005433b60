//! The check of a solution: right solutions pass, and every planted fault is noticed by the finding that
//! is there for it.

use glam::Vec3;
use lightshaft::check::{Check, Finding, Limits, Verdict, check};
use lightshaft::progress::Silent;
use lightshaft::radiosity::{LinkClass, LinkSet, Solution, SolveOptions};
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, OWN_SCENES, normal, options};

/// The settings of the quality `draft`.
fn draft() -> SolveOptions {
    let mut draft = options(Strategy::Adaptive);
    draft.visibility.rays = 4;
    SolveOptions { epsilon: 5e-3, contrast: 0.8, iterations: 50, ..draft }
}

/// A room whose six walls shine, with few links: each carries much.
fn bare_room() -> Case {
    let mut room = Rectangles::new("bare room");
    let grey = room.material(0.5, 1.0);
    room.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
    Case::of(room.finish(), true)
}

/// A case with its solution, for faults to be planted in.
struct Planted {
    case: Case,
    solution: Solution,
}

impl Planted {
    fn new(case: Case, options: &SolveOptions) -> Planted {
        let solution = case.solve(&case.fallback(), options);
        let planted = Planted { case, solution };
        planted.passes(&Limits::NORMAL);
        planted
    }

    fn check(&self, limits: &Limits) -> Check {
        check(&self.case.hierarchy, &self.case.fallback(), &self.solution, limits, &Silent)
    }

    fn passes(&self, limits: &Limits) {
        let found = self.check(limits);
        for finding in &found.findings {
            println!(
                "{:12} {:40} {:.3e} of {:.1e}",
                finding.group, finding.name, finding.value, finding.limit
            );
        }
        // Links both ways are rare: there may be none to look at.
        let is_right = |f: &Finding| match f.verdict {
            Verdict::NotLookedAt => f.name == "reciprocity, mean difference" && f.looked_at == 0,
            verdict => verdict == Verdict::Passed,
        };
        let wrong: Vec<_> = found.findings.iter().filter(|f| !is_right(f)).collect();
        assert!(found.passed() && wrong.is_empty(), "{}: {wrong:#?}", self.case.scene.name);
    }

    /// Fails the test unless the finding of this group and name failed.
    fn is_noticed(&self, group: &str, name: &str) -> Finding {
        let found = self.check(&Limits::NORMAL);
        assert!(!found.passed());
        let finding = found.findings.iter().find(|f| f.group == group && f.name == name);
        let finding = finding.unwrap_or_else(|| panic!("no finding {group}: {name}"));
        assert_eq!(finding.verdict, Verdict::Failed, "{finding:?}");
        finding.clone()
    }

    /// Fails the test unless the finding of this group and name passed.
    fn keeps(&self, group: &str, name: &str) {
        let found = self.check(&Limits::NORMAL);
        let finding = found.findings.iter().find(|f| f.group == group && f.name == name);
        assert_eq!(finding.map(|f| f.verdict), Some(Verdict::Passed), "{finding:?}");
    }

    /// The link that carries most between elements, of those that `is_wanted` wants.
    fn strongest(&self, is_wanted: impl Fn(&LinkSet, usize) -> bool) -> usize {
        let (hierarchy, solution) = (&self.case.hierarchy, &self.solution);
        let clusters = hierarchy.nodes.len() as u32;
        let power = |index: usize| {
            let link = &solution.links.links[index];
            if link.receiver < clusters || link.source < clusters || !is_wanted(&solution.links, index) {
                return 0.0;
            }
            let area = solution.forest.area[(link.receiver - clusters) as usize];
            solution.light.carried(hierarchy, &solution.forest, link).element_sum() * area
        };
        let count = solution.links.links.len();
        let strongest = (0..count).max_by(|&a, &b| power(a).total_cmp(&power(b))).expect("links");
        assert!(power(strongest) > 0.0);
        strongest
    }

    fn replace_links(&mut self, change: impl FnOnce(&mut Vec<lightshaft::radiosity::Link>)) {
        let mut links = self.solution.links.links.clone();
        change(&mut links);
        self.solution.links =
            LinkSet::new(links, self.case.hierarchy.nodes.len() + self.solution.forest.len());
    }

    /// A leaf element that shines by itself.
    fn shining_leaf(&self) -> usize {
        let solution = &self.solution;
        let is_shining = |&e: &usize| {
            let side = solution.forest.side(solution.forest.side_of(e as u32));
            solution.forest.second[e] == 0
                && !side.back
                && self.case.hierarchy.material(side.facet).is_emitter()
        };
        (0..solution.forest.len()).find(is_shining).expect("a lamp")
    }
}

fn any(_: &LinkSet, _: usize) -> bool {
    true
}

fn own_scenes_pass(options: &SolveOptions, limits: &Limits) {
    for name in OWN_SCENES {
        let case = Case::load(name);
        let solution = case.solve(&case.fallback(), options);
        println!("{name}");
        Planted { case, solution }.passes(limits);
    }
}

#[test]
fn drafts_of_the_scenes_of_the_project_pass() {
    own_scenes_pass(&draft(), &Limits::DRAFT);
}

#[test]
fn scenes_of_the_project_pass() {
    own_scenes_pass(&normal(), &Limits::NORMAL);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let case = Case::load("paper-3");
    let solution = case.solve(&case.fallback(), &draft());
    let found = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let limits = Limits::DRAFT;
        let found = pool.install(|| check(&case.hierarchy, &case.fallback(), &solution, &limits, &Silent));
        format!("{found:?}")
    };
    assert_eq!(found(1), found(3));
}

#[test]
fn links_too_many_and_too_few_are_noticed() {
    let mut planted = Planted::new(bare_room(), &options(Strategy::Adaptive));
    let strongest = planted.strongest(any);
    planted.replace_links(|links| links.push(links[strongest]));
    planted.is_noticed("links", "pairs of elements with several links");
    // The doubled link has to go, and its double.
    planted.replace_links(|links| drop(links.drain(strongest..strongest + 2)));
    planted.is_noticed("light", "irradiance against links");
    // All that one wall receives.
    let receiver = planted.solution.links.links[strongest].receiver;
    let side = planted.solution.forest.side_of(receiver - planted.case.hierarchy.nodes.len() as u32);
    let first = planted.case.hierarchy.nodes.len() as u32 + planted.solution.forest.first_element[side];
    let end = planted.case.hierarchy.nodes.len() as u32 + planted.solution.forest.first_element[side + 1];
    planted.replace_links(|links| links.retain(|link| !(first..end).contains(&link.receiver)));
    planted.is_noticed("links", "light between pairs without a link");
    planted.is_noticed("links", "light lost or made by kind of link");
    planted.is_noticed("form factors", "row sums against rays");
}

#[test]
fn a_wrong_form_factor_is_noticed() {
    let mut planted = Planted::new(bare_room(), &options(Strategy::Adaptive));
    let strongest = planted.strongest(any);
    let right = planted.solution.links.links[strongest];
    let mut plant = |factor: f32, name: &str| {
        planted.solution.links.links[strongest].factor = factor;
        planted.is_noticed("form factors", name);
    };
    for wrong in [-right.factor, f32::NAN, f32::INFINITY] {
        plant(wrong, "negative or no number");
    }
    plant(f32::NAN, "row sums of single elements");
    plant(1.5, "above 1 between elements");
    for wrong in [3.0 * right.factor, 0.3 * right.factor] {
        plant(wrong, "light that one of them gets wrong");
    }
    planted.solution.links.links[strongest] = right;
    for link in &mut planted.solution.links.links {
        link.factor *= 1.1;
    }
    planted.is_noticed("form factors", "against contour integrals, mean");
    planted.is_noticed("form factors", "row sums above 1.05, mean excess");
}

#[test]
fn a_broken_reciprocity_is_noticed() {
    let mut planted = Planted::new(Case::load("cornell-box"), &normal());
    for link in planted.solution.links.links.iter_mut().filter(|link| link.receiver < link.source) {
        link.factor *= 1.02;
    }
    planted.is_noticed("form factors", "reciprocity, mean difference");
}

#[test]
fn wrong_visibility_is_noticed() {
    // Coarse, so that clusters send much of the light: other findings are rough, these are not.
    let case = Case::load("paper-3");
    let solution = case.solve(&case.fallback(), &options(Strategy::Adaptive));
    let mut planted = Planted { case, solution };
    planted.keeps("links", "proved visible, yet blocked");
    planted.keeps("form factors", "light beyond the unobstructed");
    let hidden = planted.strongest(|links, index| {
        let link = &links.links[index];
        link.class == LinkClass::Partial && link.visibility < 0.7
    });
    let right = planted.solution.links.links[hidden];
    planted.solution.links.links[hidden].class = LinkClass::CertifiedVisible;
    planted.is_noticed("links", "proved visible, yet blocked");
    planted.solution.links.links[hidden] = right;
    // Of elements the solver takes no more than their brightest part; clusters may seem brighter than they are.
    let clusters = planted.case.hierarchy.nodes.len() as u32;
    for link in planted.solution.links.links.iter_mut().filter(|link| link.source < clusters) {
        link.visibility = 3.0;
    }
    planted.is_noticed("form factors", "light beyond the unobstructed");
}

#[test]
fn wrong_light_is_noticed() {
    let mut planted = Planted::new(bare_room(), &options(Strategy::Adaptive));
    let leaf = planted.shining_leaf();
    let right = planted.solution.light.exitance[leaf];
    for wrong in [Vec3::NAN, Vec3::INFINITY, Vec3::new(right.x, right.y, -1e-6)] {
        planted.solution.light.exitance[leaf] = wrong;
        planted.is_noticed("light", "exitance negative or no number");
    }
    planted.solution.light.exitance[leaf] = Vec3::new(right.x, 0.3 * right.y, right.z);
    planted.is_noticed("light", "darker than its emission");
    planted.is_noticed("light", "exitance against irradiance");
    planted.solution.light.exitance[leaf] = right;
    let received = planted.solution.light.irradiance[leaf];
    planted.solution.light.irradiance[leaf] = Vec3::NAN;
    planted.is_noticed("light", "light on groups of surfaces");
    planted.solution.light.irradiance[leaf] = received;
    // Light that fades on its way.
    for irradiance in &mut planted.solution.light.irradiance {
        *irradiance *= 0.98;
    }
    planted.is_noticed("light", "energy balance");
    planted.is_noticed("light", "held back by row sums");
    planted.solution.energy.error = 0.02 * planted.solution.energy.emitted;
    planted.is_noticed("light", "still changing");
}

/// Errors that cancel out in all sums: some elements see too much of others, and as many too little.
#[test]
fn rows_that_are_wrong_only_one_by_one_are_noticed() {
    let mut planted = Planted::new(bare_room(), &options(Strategy::Adaptive));
    let clusters = planted.case.hierarchy.nodes.len() as u32;
    // The scene's middle is the origin: half of the room sees too little, the other half too much.
    for link in planted.solution.links.links.iter_mut().filter(|link| link.receiver >= clusters) {
        link.factor *= if planted.solution.forest.center[(link.receiver - clusters) as usize].x < 0.0 {
            0.75
        } else {
            1.25
        };
    }
    planted.is_noticed("form factors", "row sums of single elements");
    planted.keeps("form factors", "row sums against rays");
}

/// Multiplies the irradiance of every element by a factor that depends on its normal.
fn dim(planted: &mut Planted, factor: impl Fn(Vec3) -> f32) {
    let forest = &planted.solution.forest;
    for (element, irradiance) in planted.solution.light.irradiance.iter_mut().enumerate() {
        let side = forest.side(forest.side_of(element as u32));
        *irradiance *= factor(planted.case.hierarchy.side_normal(side).as_vec3());
    }
}

/// Light that fell on one wall instead of the one that faces it: none is lost.
#[test]
fn light_in_the_wrong_place_is_noticed() {
    let mut planted = Planted::new(bare_room(), &options(Strategy::Adaptive));
    dim(&mut planted, |normal| 1.0 + 0.2 * normal.x);
    planted.is_noticed("light", "light on groups of surfaces");
    planted.keeps("light", "energy balance");
}

/// The only wall that faces its way gets next to nothing, then nothing at all: no more than all is missing there.
#[test]
fn a_dark_wall_is_noticed() {
    for left in [1e-3, 0.0] {
        let mut planted = Planted::new(bare_room(), &options(Strategy::Adaptive));
        dim(&mut planted, |normal| if normal.x > 0.9 { left } else { 1.0 });
        let finding = planted.is_noticed("light", "light on groups of surfaces");
        assert!(finding.value > 0.2 && finding.value < 0.6, "{finding:?}");
        assert!(
            finding.detail.starts_with("-100.0 %") || finding.detail.starts_with("-99.9 %"),
            "{finding:?}"
        );
    }
}

#[test]
fn a_draft_is_rough_but_not_wrong() {
    let mut planted = Planted::new(bare_room(), &options(Strategy::Adaptive));
    for link in &mut planted.solution.links.links {
        link.factor *= 1.05;
    }
    let found = planted.check(&Limits::DRAFT);
    let contours = found.findings.iter().find(|f| f.name == "against contour integrals, mean");
    assert_eq!(contours.expect("the finding").verdict, Verdict::Rough);
}
