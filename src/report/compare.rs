//! Two tracers side by side: in words, as tables, and as a record; `docs/compare.md` explains the figures.

use std::fmt::Write;

use glam::Vec3;
use serde::Serialize;

use super::profile::Spread;
use super::setup::Setup;
use super::text::{aligned, counted};
use crate::compare::{
    Comparison, Disagreement, EXITANCE_LIMIT, ExitanceDifference, LinkDifferences, PictureDifference,
    Question, Standing, Tally,
};
use crate::hierarchy::Hierarchy;
use crate::tracer::NO_FACET;

/// One ray of a replay file, traced again.
pub struct ReplayedRay {
    /// What each tracer said of it in a packet, and the referee of that.
    pub in_packet: Disagreement,
    /// What each says of it alone.
    pub alone: [u32; 2],
    /// What the referee says blocks it, or is met first, and how far from there that would change, local units.
    pub expected: Vec<(u32, f64)>,
}

impl ReplayedRay {
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
        for (side, tracer) in tracers.into_iter().enumerate() {
            if self.alone[side] != self.in_packet.answers[side] {
                let _ = writeln!(text, "  {tracer}, alone: {}", facet_name(hierarchy, self.alone[side]));
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
    /// Whether no ray was wrong and the light is the same.
    pub agree: bool,
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
    /// Times the rays were timed.
    pub repeats: u32,
    /// Shadow rays a second of one thread.
    pub rays_per_second: [Spread; 2],
    /// Wall-clock seconds to solve.
    pub solve_seconds: [f64; 2],
    /// Wall-clock seconds to render.
    pub render_seconds: [f64; 2],
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
            answers: disagreement.answers.map(|facet| facet_name(hierarchy, facet)),
            standings: disagreement.rulings.map(|ruling| ruling.standing),
            distances: disagreement.rulings.map(|ruling| ruling.distance * frame.scene_units_per_local()),
        }
    }

    /// On one line.
    pub fn line(&self, tracers: &[String; 2]) -> String {
        let of = |side: usize| {
            let standing = match self.standings[side] {
                Standing::Right => "right".to_owned(),
                Standing::Tolerance => format!("off by {:.1e}, within the tolerance", self.distances[side]),
                Standing::EdgeOn => {
                    format!("off by {:.1e}, the facet is seen edge-on", self.distances[side])
                }
                Standing::Wrong => format!("WRONG by {:.1e}", self.distances[side]),
            };
            format!("{}: {} ({standing})", tracers[side], self.answers[side])
        };
        let point = |p: [f64; 3]| format!("({:.6} {:.6} {:.6})", p[0], p[1], p[2]);
        format!("{}, {} to {}; {}; {}", self.kind, point(self.from), point(self.to), of(0), of(1))
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
    pub const FORMAT: u32 = 1;

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
        CompareReport {
            format: Self::FORMAT,
            setup: Setup::default(),
            scene: scene.to_owned(),
            tracers: tracers.map(str::to_owned),
            threads,
            agree: found.agrees(),
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
            repeats: found.speed.rays_per_second[0].len() as u32,
            rays_per_second: found.speed.rays_per_second.clone().map(Spread::of),
            solve_seconds: found.speed.solve_seconds,
            render_seconds: found.speed.render_seconds,
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
        let relative = self.exitance.relative_rms();
        // What is not a number is beyond the limit too.
        if !matches!(
            relative.partial_cmp(&EXITANCE_LIMIT),
            Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal)
        ) {
            reasons.push(format!(
                "the light differs by {:.3} % (at most {} %), most at {}",
                100.0 * relative,
                100.0 * EXITANCE_LIMIT,
                self.exitance.worst
            ));
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
        let off: u64 = total.tolerance.iter().chain(&total.edge_on).sum();
        let wrong: u64 = total.wrong.iter().sum();
        let mut text = format!(
            "Of {} they decide {} differently. The referee finds {} off by rounding and {wrong} wrong.\n",
            counted(total.traced, "ray"),
            total.differing,
            counted(off, "answer")
        );
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "The light differs by {:.4} % of what surfaces reflect (root mean square), the pictures by {:.4} %; \
             to the eye by {} on a scale from 0 to 1 (mean FLIP).",
            100.0 * self.exitance.relative_rms(),
            100.0 * self.picture.relative(self.picture.rmse),
            self.flip()
        );
        let [fast, slow] = self.rays_per_second.map(|rate| rate.median);
        if fast > 0.0 && slow > 0.0 {
            let _ = writeln!(
                text,
                "{} casts {:.2} times as many shadow rays a second as {}, and solves in {:.2} of the time.",
                self.tracers[0],
                fast / slow,
                self.tracers[1],
                self.solve_seconds[0] / self.solve_seconds[1].max(f64::MIN_POSITIVE)
            );
        }
        text
    }

    /// Mean FLIP, with as many digits as say something.
    pub(super) fn flip(&self) -> String {
        match self.picture.flip {
            small if small > 0.0 && small < 1e-3 => format!("{small:.1e}"),
            other => format!("{other:.4}"),
        }
    }

    fn ray_table(&self) -> String {
        let rows: Vec<[String; 10]> = self
            .rays
            .iter()
            .map(|t| {
                let [a, b] = [0, 1].map(|side| [t.tolerance[side], t.edge_on[side], t.wrong[side]]);
                let [a1, a2, a3] = a.map(|count| count.to_string());
                let [b1, b2, b3] = b.map(|count| count.to_string());
                let [traced, blocked, differing] =
                    [t.traced, t.blocked, t.differing].map(|count| count.to_string());
                [t.name.clone(), traced, blocked, differing, a1, a2, a3, b1, b2, b3]
            })
            .collect();
        let of = |what: &str, side: usize| format!("{}: {what}", self.tracers[side]);
        let heads = [
            "rays".to_owned(),
            "traced".to_owned(),
            "blocked".to_owned(),
            "differing".to_owned(),
            of("tolerance", 0),
            "edge-on".to_owned(),
            "WRONG".to_owned(),
            of("tolerance", 1),
            "edge-on".to_owned(),
            "WRONG".to_owned(),
        ];
        aligned(&heads, &rows)
    }

    fn work_table(&self) -> String {
        let rows = [self.difference_rows(), self.speed_rows()].concat();
        aligned(&self.work_heads(), &rows)
    }

    /// Heads of the rows below.
    pub(super) fn work_heads(&self) -> [String; 5] {
        let [native, other] = self.tracers.clone();
        [String::new(), native, other, "difference".to_owned(), String::new()]
    }

    /// Links, light and pictures: what each tracer gives, the difference, and where it is.
    pub(super) fn difference_rows(&self) -> Vec<[String; 5]> {
        let (links, light, picture) = (&self.links, &self.exitance, &self.picture);
        let percent = |share: f64| format!("{:.4} %", 100.0 * share);
        let row = |name: &str, [a, b]: [String; 2], difference: String, place: String| {
            [name.to_owned(), a, b, difference, place]
        };
        let counts = |counts: [u64; 2]| counts.map(|count| count.to_string());
        let alone = |name: &str, difference: String, place: String| {
            row(name, [String::new(), String::new()], difference, place)
        };
        vec![
            row("links", counts(links.links), percent(links.share()), links.worst.clone()),
            row("  only in one", counts(links.only), String::new(), String::new()),
            alone("  in another class", links.class.to_string(), String::new()),
            alone("  proved in one only", links.certified.to_string(), String::new()),
            alone("  in another fraction", links.fraction.to_string(), String::new()),
            row(
                "invisible pairs",
                counts(links.invisible),
                percent(links.share_of_invisible()),
                String::new(),
            ),
            alone("exitance, root mean square", percent(light.relative_rms()), String::new()),
            alone("exitance, mean", percent(light.relative(light.bias)), String::new()),
            alone("exitance, largest", percent(light.relative(light.max)), light.worst.clone()),
            alone("exitance, area above 1 %", percent(light.area_above_percent), String::new()),
            alone("picture, root mean square", percent(picture.relative(picture.rmse)), String::new()),
            alone(
                "picture, largest",
                percent(picture.relative(picture.max)),
                format!("pixel {} {}", picture.worst[0], picture.worst[1]),
            ),
            alone("picture, mean FLIP", self.flip(), String::new()),
        ]
    }

    /// How fast each tracer is, the ratio, and how far measurements spread.
    pub(super) fn speed_rows(&self) -> Vec<[String; 5]> {
        let row = |name: &str, [a, b]: [String; 2], ratio: f64, spread: String| {
            [name.to_owned(), a, b, format!("{ratio:.2} times"), spread]
        };
        let seconds = |name: &str, seconds: [f64; 2]| {
            let ratio = seconds[1] / seconds[0].max(f64::MIN_POSITIVE);
            row(name, seconds.map(|s| format!("{s:.3}")), ratio, String::new())
        };
        let rates = self.rays_per_second;
        let ratio = rates[0].median / rates[1].median.max(f64::MIN_POSITIVE);
        let [a, b] = rates.map(|rate| format!("±{:.1} %", 100.0 * rate.relative()));
        let spread = if self.repeats > 1 { format!("{a}, {b}") } else { String::new() };
        let shown = rates.map(|rate| format!("{:.3}", 1e-6 * rate.median));
        vec![
            row("shadow rays a second and thread (M)", shown, ratio, spread),
            seconds("solve (s)", self.solve_seconds),
            seconds("render (s)", self.render_seconds),
        ]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) fn report(wrong: u64, squares: f64) -> CompareReport {
        let tally = Tally { name: "all".to_owned(), traced: 900, wrong: [0, wrong], ..Tally::default() };
        let exitance = ExitanceDifference {
            mean_reflected: 2.0,
            rms: squares,
            worst: "(1 2 3), material wall".to_owned(),
            ..ExitanceDifference::default()
        };
        let standing = if wrong > 0 { Standing::Wrong } else { Standing::Tolerance };
        let worst = DescribedDisagreement {
            kind: "shadow rays".to_owned(),
            from: [0.0; 3],
            to: [1.0, 0.5, 0.25],
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
            agree: wrong == 0 && squares <= 0.02,
            rays: vec![tally],
            worst: vec![worst],
            links: LinkDifferences { links: [10, 11], only: [0, 1], ..LinkDifferences::default() },
            exitance,
            picture: PictureDifference::default(),
            repeats: 2,
            rays_per_second: [Spread::of(vec![4e6]), Spread::of(vec![2e6])],
            solve_seconds: [1.0, 2.0],
            render_seconds: [0.5, 0.5],
        }
    }

    #[test]
    fn words_come_first_and_say_that_the_tracers_agree() {
        let text = report(0, 0.001).text();
        assert!(text.starts_with("room: embree and fallback, 2 threads\n\nThe tracers agree."), "{text}");
        for part in ["900", "0.0500 %", "embree casts 2.00 times", "solve (s)", "2.00 times"] {
            assert!(text.contains(part), "{part} is missing:\n{text}");
        }
        assert!(!text.contains("Wrong answers"), "{text}");
        let once = CompareReport { repeats: 1, threads: 1, ..report(0, 0.001) }.text();
        assert!(text.contains('±') && !once.contains('±') && once.contains(", 1 thread\n"), "{once}");
    }

    #[test]
    fn wrong_rays_are_named_with_their_side_and_place() {
        let report = report(3, 0.001);
        let objection = report.objection().expect("an objection");
        for part in [
            "3 of 900 rays are wrong in fallback",
            "shadow rays",
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
        for rms in [0.1, f64::NAN] {
            let objection = report(0, rms).objection().expect("an objection");
            assert!(
                objection.contains("the light differs") && objection.contains("material wall"),
                "{objection}"
            );
            assert!(!objection.contains("worst:"), "{objection}");
        }
    }
}
