//! Two tracers side by side: in words, as tables, and as a record; `docs/compare.md` explains the figures.

use std::fmt::Write;

use glam::Vec3;
use serde::Serialize;

use super::profile::Spread;
use super::setup::Setup;
use super::text::counted;
use crate::compare::{
    Comparison, Disagreement, EXITANCE_LIMIT, ExitanceDifference, LinkDifferences, PictureDifference,
    Question, Standing, Tally,
};
use crate::hierarchy::{Hierarchy, Interval};
use crate::tracer::NO_FACET;

mod rows;

/// Differences of light above this share of what is reflected where light falls are worth a word even where they are rare.
const NOTICED: f64 = 0.1;

/// Light that is brighter or darker as a whole by more than this share is worth a word.
const FELT: f64 = 1e-3;

/// One ray of a replay file, traced again.
pub struct ReplayedRay {
    /// What each tracer said of it in a packet of two of it, and the referee of that.
    pub in_packet: Disagreement,
    /// What each says of it alone, likewise.
    pub alone: Disagreement,
    /// What the referee says blocks it, or is met first, and how far from there that would change, local units.
    pub expected: Vec<(u32, f64)>,
}

impl ReplayedRay {
    /// The worst of all answers.
    pub fn standing(&self) -> Standing {
        self.in_packet.severity().0.max(self.alone.severity().0)
    }

    /// Several lines; ends with a newline.
    pub fn text(&self, hierarchy: &Hierarchy, tracers: [&str; 2]) -> String {
        let found = DescribedDisagreement::new(hierarchy, &self.in_packet);
        let [from, to] = ends(&self.in_packet.question);
        // Writing to a string cannot fail.
        let mut text = format!("{}\n", found.line(&tracers.map(str::to_owned)));
        let _ = writeln!(text, "  local {:?} to {:?}", from.to_array(), to.to_array());
        if let Question::Segment(segment) = self.in_packet.question {
            for facet in segment.skip.into_iter().filter(|&facet| facet != NO_FACET) {
                let _ = writeln!(text, "  an end is on {}", facet_name(hierarchy, facet));
            }
        }
        if let Some(count) = found.candidates {
            let _ = writeln!(text, "  within {}", counted(count, "candidate"));
        }
        let alone = DescribedDisagreement::new(hierarchy, &self.alone);
        for (side, tracer) in tracers.into_iter().enumerate() {
            if (&alone.answers[side], alone.standings[side]) != (&found.answers[side], found.standings[side])
            {
                let _ = writeln!(text, "  {tracer}, alone: {}", alone.answer(side));
            }
        }
        if self.expected.is_empty() {
            let _ = writeln!(text, "  referee: clear");
        }
        for &(facet, distance) in &self.expected {
            let distance = distance * hierarchy.frame.scene_units_per_local();
            let name = facet_name(hierarchy, facet);
            let _ = writeln!(text, "  referee: {name}; its nearest edge or end is {distance:.1e} away");
        }
        text
    }
}

/// Both ends of a segment, or where a ray starts and a point on its way.
fn ends(question: &Question) -> [Vec3; 2] {
    match *question {
        Question::Segment(segment) => [segment.from, segment.to],
        Question::Ray(ray) => [ray.origin, ray.origin + ray.direction],
    }
}

/// The comparison of one scene; of two values the first is for the native tracer.
#[derive(Clone, Debug, Serialize)]
pub struct CompareReport {
    /// Version of the record, [`CompareReport::FORMAT`].
    pub format: u32,
    /// What the comparison was made with.
    pub setup: Setup,
    /// Name of the scene.
    pub scene: String,
    /// Names of the tracers.
    pub tracers: [String; 2],
    /// Worker threads.
    pub threads: usize,
    /// Whether no ray was wrong, and rays explain what of links and light differs.
    pub agree: bool,
    /// Whether links differ though no ray was answered differently.
    pub unexplained_links: bool,
    /// The light differs by more than [`EXITANCE_LIMIT`] or is no number, though no ray of the solutions was answered
    /// differently.
    pub unexplained_light: bool,
    /// By kind of ray, and all together.
    pub rays: Vec<Tally>,
    /// The worst answers, worst first.
    pub worst: Vec<DescribedDisagreement>,
    /// Links.
    pub links: LinkDifferences,
    /// Light.
    pub exitance: ExitanceDifference,
    /// Pictures.
    pub picture: PictureDifference,
    /// Shadow rays that were timed, a sample of those of the solutions.
    pub timed_rays: u64,
    /// Times they were timed.
    pub repeats: u32,
    /// Shadow rays a second of one thread.
    pub rays_per_second: [Spread; 2],
    /// Times the scene was solved and rendered for the times below.
    pub solves: u32,
    /// Wall-clock seconds to solve.
    pub solve_seconds: [Spread; 2],
    /// Wall-clock seconds to render.
    pub render_seconds: [Spread; 2],
    /// What each tracer keeps besides the mesh.
    pub tracer_bytes: [u64; 2],
    /// How far resident memory was while solving, at most, above that before.
    pub solving_bytes: [u64; 2],
    /// What links and elements take.
    pub solution_bytes: [u64; 2],
}

/// A disagreement for people.
#[derive(Clone, Debug, Serialize)]
pub struct DescribedDisagreement {
    /// The kind of ray.
    pub kind: String,
    /// Where it begins, scene units.
    pub from: [f64; 3],
    /// Where it ends, or a point on its way if it has no end.
    pub to: [f64; 3],
    /// Facets that could block; none for the whole scene.
    pub candidates: Option<u64>,
    /// What each tracer says.
    pub answers: [String; 2],
    /// What the referee says of each.
    pub standings: [Standing; 2],
    /// How far each is off, scene units.
    pub distances: [f64; 2],
}

impl DescribedDisagreement {
    /// With places in scene units.
    pub fn new(hierarchy: &Hierarchy, disagreement: &Disagreement) -> DescribedDisagreement {
        let frame = &hierarchy.frame;
        let [from, to] =
            ends(&disagreement.question).map(|p| frame.scene_from_local(p.as_dvec3()).to_array());
        DescribedDisagreement {
            kind: disagreement.kind.clone(),
            from,
            to,
            candidates: disagreement.within.as_ref().map(|list| {
                let count = |interval: &Interval| u64::from(interval.end - interval.start);
                list.iter().map(count).sum()
            }),
            answers: disagreement.answers.map(|facet| facet_name(hierarchy, facet)),
            standings: disagreement.rulings.map(|ruling| ruling.standing),
            distances: disagreement.rulings.map(|ruling| ruling.distance * frame.scene_units_per_local()),
        }
    }

    /// On one line.
    pub fn line(&self, tracers: &[String; 2]) -> String {
        let of = |side: usize| format!("{}: {}", tracers[side], self.answer(side));
        let point = |p: [f64; 3]| format!("({:.6} {:.6} {:.6})", p[0], p[1], p[2]);
        let within =
            self.candidates.map_or_else(String::new, |count| format!(" ({})", counted(count, "candidate")));
        format!("{}{within}, {} to {}; {}; {}", self.kind, point(self.from), point(self.to), of(0), of(1))
    }

    /// What one tracer says, and the referee of that.
    fn answer(&self, side: usize) -> String {
        let distance = self.distances[side];
        let standing = match self.standings[side] {
            Standing::Right => "right".to_owned(),
            Standing::Tolerance => format!("off by {distance:.1e}, within the tolerance"),
            Standing::EdgeOn => format!("off by {distance:.1e}, the facet is seen edge-on"),
            Standing::Wrong => format!("WRONG by {distance:.1e}"),
        };
        format!("{} ({standing})", self.answers[side])
    }
}

/// A facet as people can find it.
pub fn facet_name(hierarchy: &Hierarchy, facet: u32) -> String {
    if facet == NO_FACET {
        return "clear".to_owned();
    }
    let center = hierarchy.frame.scene_from_local(hierarchy.polygon(facet).center());
    let material = &hierarchy.material(facet).name;
    format!("facet {facet} at ({:.4} {:.4} {:.4}), material {material}", center.x, center.y, center.z)
}

impl CompareReport {
    /// Version of the record; another one where a field has another meaning or is gone.
    pub const FORMAT: u32 = 3;

    /// What was found, with places in scene units; not what it was made with.
    pub fn new(
        scene: &str,
        tracers: [&str; 2],
        threads: usize,
        hierarchy: &Hierarchy,
        found: &Comparison,
    ) -> CompareReport {
        let mut rays = found.rays.tallies.clone();
        rays.push(found.rays.total());
        let speed = found.speed.clone();
        CompareReport {
            format: Self::FORMAT,
            setup: Setup::default(),
            scene: scene.to_owned(),
            tracers: tracers.map(str::to_owned),
            threads,
            agree: found.agrees(),
            unexplained_links: !found.links_are_explained(),
            unexplained_light: !found.light_is_explained(),
            rays,
            worst: found
                .rays
                .worst
                .iter()
                .map(|worst| DescribedDisagreement::new(hierarchy, worst))
                .collect(),
            links: found.links.clone(),
            exitance: found.exitance.clone(),
            picture: found.picture.clone(),
            timed_rays: speed.timed_rays,
            repeats: speed.rays_per_second[0].len() as u32,
            rays_per_second: speed.rays_per_second.map(Spread::of),
            solves: speed.solve_seconds[0].len() as u32,
            solve_seconds: speed.solve_seconds.map(Spread::of),
            render_seconds: speed.render_seconds.map(Spread::of),
            tracer_bytes: speed.tracer_bytes,
            solving_bytes: speed.solving_bytes,
            solution_bytes: speed.solution_bytes,
        }
    }

    /// What is wrong, in one sentence; nothing when the tracers agree.
    pub fn objection(&self) -> Option<String> {
        if self.agree {
            return None;
        }
        let mut reasons = Vec::new();
        if let Some(total) = self.rays.last() {
            for (tracer, wrong) in self.tracers.iter().zip(total.wrong).filter(|&(_, wrong)| wrong > 0) {
                let is = if wrong == 1 { "is" } else { "are" };
                reasons.push(format!("{wrong} of {} {is} wrong in {tracer}", counted(total.traced, "ray")));
            }
        }
        if self.unexplained_light {
            let light = &self.exitance;
            reasons.push(format!(
                "the light differs by {:.3} % (at most {} %) though every ray was answered alike, most at {}",
                100.0 * light.relative(light.mean),
                100.0 * EXITANCE_LIMIT,
                light.worst
            ));
        }
        if self.unexplained_links {
            reasons
                .push(format!("links differ though every ray was answered alike, most {}", self.links.worst));
        }
        let worst = self.worst.first().filter(|worst| worst.standings.contains(&Standing::Wrong));
        let place = worst.map_or_else(String::new, |worst| format!("; worst: {}", worst.line(&self.tracers)));
        Some(reasons.join(", and ") + &place)
    }

    /// In words, then as tables; ends with a newline.
    pub fn text(&self) -> String {
        let [native, other] = &self.tracers;
        let mut text =
            format!("{}: {native} and {other}, {}\n\n", self.scene, counted(self.threads as u64, "thread"));
        match self.objection() {
            None => text += "The tracers agree. ",
            Some(objection) => text += &format!("THE TRACERS DISAGREE: {objection}.\n"),
        }
        text += &self.words();
        text.push('\n');
        text += &self.ray_table();
        text.push('\n');
        text += &self.work_table();
        let shown: Vec<_> =
            self.worst.iter().filter(|w| w.standings.contains(&Standing::Wrong)).take(5).collect();
        if !shown.is_empty() {
            text += "\nWrong answers, worst first:\n";
            shown.iter().for_each(|worst| text += &format!("  {}\n", worst.line(&self.tracers)));
        }
        text
    }

    /// The summary, without the verdict.
    pub(super) fn words(&self) -> String {
        let total = self.rays.last().cloned().unwrap_or_default();
        let [tolerance, edge_on, wrong] =
            [total.tolerance, total.edge_on, total.wrong].map(|counts| counts.iter().sum::<u64>());
        let (light, picture) = (&self.exitance, &self.picture);
        let percent = |share: f64| format!("{:.4} %", 100.0 * share);
        let times_or_share = |share: f64| match share > 1.0 {
            true => format!("{share:.1} times"),
            false => format!("{} of", percent(share)),
        };
        // Writing to a string cannot fail.
        let mut text = String::new();
        let _ = writeln!(
            text,
            "Of {} they decide {} differently: every ray of both solutions and pictures, as often as it was cast, and \
             others made by rule. The referee finds {} off by rounding, {edge_on} where a facet is seen edge-on, and \
             {wrong} wrong.",
            counted(total.traced, "ray"),
            total.differing,
            counted(tolerance, "answer"),
        );
        let most = match light.max > 0.0 {
            true => format!(
                "; at the worst place it differs by {} what is reflected where light falls",
                times_or_share(light.relative_max())
            ),
            false => String::new(),
        };
        let _ = writeln!(
            text,
            "The light differs by {} of what is reflected, in the mean over the area{most}.{}",
            percent(light.relative(light.mean)),
            self.sensitive()
        );
        let _ = writeln!(
            text,
            "The pictures differ by {} (root mean square); to the eye by {} on a scale from 0 to 1 (mean FLIP).",
            percent(picture.relative(picture.rmse)),
            self.flip()
        );
        text + &self.pace()
    }

    /// Why the light differs where no ray is wrong.
    fn sensitive(&self) -> String {
        let light = &self.exitance;
        let mut text = String::new();
        if self.rays.last().is_none_or(|total| total.wrong != [0, 0]) {
            return text;
        }
        let (all, [a, b]) = (light.relative(light.bias), light.factors);
        if all.abs() > FELT && light.bias.abs() > 0.5 * light.mean && (b - a) * all > 0.0 {
            let than = if all > 0.0 { "brighter" } else { "darker" };
            text += &format!(
                " Most of the difference is a factor on all light, which keeps any from being lost: rays find it, {a:.4} and {b:.4}, \
                 and with its bounces the light of the second is {:.2} % {than} in the mean.",
                100.0 * all.abs()
            );
        }
        if light.relative_max() > NOTICED {
            text += &format!(
                " No ray is wrong: few rays decide at the worst place, and what rounding makes of one of them matters: {}.",
                light.worst
            );
        }
        text
    }

    /// How the tracers compare in speed; medians, and half of the range of the ratio.
    fn pace(&self) -> String {
        let [native, other] = &self.tracers;
        let times = |[a, b]: [Spread; 2]| {
            let spread = a.relative() + b.relative();
            let range = if spread > 0.0 { format!(" (±{:.0} %)", 100.0 * spread) } else { String::new() };
            (b.median / a.median, range)
        };
        let [ray, solve, render] = [
            self.rays_per_second.map(|rate| Spread {
                min: 1.0 / rate.max,
                median: 1.0 / rate.median,
                max: 1.0 / rate.min,
            }),
            self.solve_seconds,
            self.render_seconds,
        ]
        .map(times);
        if ![ray.0, solve.0, render.0].iter().all(|ratio| ratio.is_finite() && *ratio > 0.0) {
            return String::new();
        }
        let [ray, solve, render] =
            [ray, solve, render].map(|(ratio, range)| format!("{ratio:.2} times{range}"));
        format!(
            "{native} casts {ray} as many shadow rays a second as {other}, and is {solve} as fast in solving and {render} \
             in rendering (medians of {} and {}, in turns).\n",
            self.repeats, self.solves
        )
    }

    /// Mean FLIP, with as many digits as say something.
    pub(super) fn flip(&self) -> String {
        match self.picture.flip {
            small if small > 0.0 && small < 1e-3 => format!("{small:.1e}"),
            other => format!("{other:.4}"),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) fn report(wrong: u64, mean: f64) -> CompareReport {
        let tally = Tally { name: "all".to_owned(), traced: 900, wrong: [0, wrong], ..Tally::default() };
        let exitance = ExitanceDifference {
            mean_reflected: 2.0,
            rms_reflected: 2.0,
            lit_reflected: 2.0,
            factors: [1.0; 2],
            mean,
            rms: 2.0 * mean,
            max: 3.0 * mean,
            worst: "(1 2 3), material wall".to_owned(),
            ..ExitanceDifference::default()
        };
        let standing = if wrong > 0 { Standing::Wrong } else { Standing::Tolerance };
        let worst = DescribedDisagreement {
            kind: "shadow rays".to_owned(),
            from: [0.0; 3],
            to: [1.0, 0.5, 0.25],
            candidates: Some(12),
            answers: ["facet 7".to_owned(), "clear".to_owned()],
            standings: [Standing::Right, standing],
            distances: [0.0, 0.125],
        };
        CompareReport {
            format: CompareReport::FORMAT,
            setup: Setup::default(),
            scene: "room".to_owned(),
            tracers: ["embree", "fallback"].map(str::to_owned),
            threads: 2,
            agree: wrong == 0 && mean <= 0.01,
            unexplained_links: false,
            unexplained_light: mean > 0.01 || mean.is_nan(),
            rays: vec![tally],
            worst: vec![worst],
            links: LinkDifferences { links: [10, 11], only: [0, 1], ..LinkDifferences::default() },
            exitance,
            picture: PictureDifference::default(),
            timed_rays: 1000,
            repeats: 2,
            rays_per_second: [Spread::of(vec![4e6]), Spread::of(vec![2e6])],
            solves: 2,
            solve_seconds: [Spread::of(vec![0.9, 1.1]), Spread::of(vec![2.0])],
            render_seconds: [Spread::of(vec![0.5]); 2],
            tracer_bytes: [3 << 20, 2 << 20],
            solving_bytes: [9 << 20, 0],
            solution_bytes: [4 << 20; 2],
        }
    }

    #[test]
    fn words_come_first_and_say_that_the_tracers_agree() {
        let text = report(0, 0.001).text();
        assert!(text.starts_with("room: embree and fallback, 2 threads\n\nThe tracers agree."), "{text}");
        for part in [
            "Of 900 rays",
            "The light differs by 0.0500 % of what is reflected, in the mean over the area; at the worst place it differs by \
             0.1500 % of what is reflected where light falls.",
            "0 where a facet is seen edge-on, and 0 wrong",
            "embree casts 2.00 times as many",
            "is 2.00 times (±10 %) as fast in solving and 1.00 times in rendering",
            "solve (s)",
            "memory of solving (MB)",
        ] {
            assert!(text.contains(part), "{part} is missing:\n{text}");
        }
        assert!(!text.contains("Wrong answers"), "{text}");
        let mut once = CompareReport { repeats: 1, solves: 1, threads: 1, ..report(0, 0.001) };
        once.solve_seconds[0] = Spread::of(vec![1.0]);
        let once = once.text();
        assert!(text.contains('±') && !once.contains('±') && once.contains(", 1 thread\n"), "{once}");
    }

    #[test]
    fn wrong_rays_are_named_with_their_side_and_place() {
        let report = report(3, 0.001);
        let objection = report.objection().expect("an objection");
        for part in [
            "3 of 900 rays are wrong in fallback",
            "shadow rays (12 candidates)",
            "(1.000000 0.500000 0.250000)",
            "clear (WRONG by",
        ] {
            assert!(objection.contains(part), "{part} is missing: {objection}");
        }
        assert!(report.text().contains("THE TRACERS DISAGREE"));
        let one = super::tests::report(1, 0.001).objection().expect("an objection");
        assert!(one.starts_with("1 of 900 rays is wrong in fallback"), "{one}");
    }

    #[test]
    fn flip_is_given_with_digits_that_say_something() {
        let mut report = report(0, 0.001);
        for (value, text) in [(0.0, "0.0000"), (4.67e-7, "4.7e-7"), (0.012_34, "0.0123"), (1.0, "1.0000")] {
            report.picture.flip = value;
            assert_eq!(report.flip(), text);
        }
    }

    #[test]
    fn light_that_differs_is_named_with_its_place() {
        for mean in [0.1, f64::NAN] {
            let objection = report(0, mean).objection().expect("an objection");
            assert!(
                objection.contains("though every ray was answered alike")
                    && objection.contains("material wall"),
                "{objection}"
            );
            assert!(!objection.contains("worst:"), "{objection}");
        }
        let said = "few rays decide at the worst place";
        let explained = CompareReport { agree: true, unexplained_light: false, ..report(0, 0.1) }.text();
        assert!(explained.contains("The tracers agree.") && explained.contains(said), "{explained}");
        assert!(!report(1, 0.1).text().contains(said) && !report(0, 0.001).text().contains(said));
        let mut darker = report(0, 0.02);
        (darker.exitance.bias, darker.exitance.factors) = (-0.016, [1.02, 1.01]);
        let words = darker.words();
        assert!(words.contains("1.0200 and 1.0100") && words.contains("0.80 % darker"), "{words}");
        darker.exitance.factors = [1.01, 1.02];
        assert!(!darker.words().contains("a factor on all light"), "that would make it brighter");
    }

    #[test]
    fn links_that_no_ray_explains_are_an_objection() {
        let report = CompareReport { agree: false, unexplained_links: true, ..report(0, 0.001) };
        let objection = report.objection().expect("an objection");
        assert!(objection.contains("links differ though every ray was answered alike"), "{objection}");
    }
}
