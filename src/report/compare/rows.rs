//! A comparison as tables for people.

use super::super::profile::Spread;
use super::super::text::aligned;
use super::CompareReport;

impl CompareReport {
    pub(super) fn ray_table(&self) -> String {
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

    pub(super) fn work_table(&self) -> String {
        let rows = [self.difference_rows(), self.speed_rows()].concat();
        aligned(&self.work_heads(), &rows)
    }

    /// Heads of the rows below.
    pub(in super::super) fn work_heads(&self) -> [String; 5] {
        let [native, other] = self.tracers.clone();
        [String::new(), native, other, "difference".to_owned(), String::new()]
    }

    /// Links, light and pictures: what each tracer gives, the difference, and where it is.
    pub(in super::super) fn difference_rows(&self) -> Vec<[String; 5]> {
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
            alone("exitance, mean", percent(light.relative(light.mean)), String::new()),
            alone("exitance, root mean square", percent(light.relative_rms()), String::new()),
            alone("exitance, second brighter", percent(light.relative(light.bias)), String::new()),
            alone("exitance, largest", percent(light.relative_max()), light.worst.clone()),
            row(
                "exitance, factor on all",
                light.factors.map(|factor| format!("{factor:.4}")),
                percent(light.factors[1] / light.factors[0].max(f64::MIN_POSITIVE) - 1.0),
                String::new(),
            ),
            alone("exitance, area above 1 %", percent(light.noticed_area), String::new()),
            alone("picture, root mean square", percent(picture.relative(picture.rmse)), String::new()),
            alone(
                "picture, largest",
                percent(picture.relative(picture.max)),
                picture.worst.map_or_else(String::new, |[x, y]| format!("pixel {x} {y}")),
            ),
            alone("picture, mean FLIP", self.flip(), String::new()),
        ]
    }

    /// How fast each tracer is and what memory it takes, the ratio, and how far measurements spread.
    pub(in super::super) fn speed_rows(&self) -> Vec<[String; 5]> {
        let row = |name: &str, [a, b]: [String; 2], ratio: f64, spread: String| {
            let ratio =
                if ratio.is_finite() && ratio > 0.0 { format!("{ratio:.2} times") } else { String::new() };
            [name.to_owned(), a, b, ratio, spread]
        };
        let spread = |spreads: [Spread; 2], count: u32| match count {
            0 | 1 => String::new(),
            _ => spreads.map(|spread| format!("±{:.1} %", 100.0 * spread.relative())).join(", "),
        };
        let seconds = |name: &str, times: [Spread; 2]| {
            let [a, b] = times.map(|time| time.median);
            row(name, [a, b].map(|s| format!("{s:.3}")), b / a, spread(times, self.solves))
        };
        let megabytes = |name: &str, [a, b]: [u64; 2], what: &str| {
            let shown = [a, b].map(|bytes| match bytes as f64 / f64::from(1 << 20) {
                small if small < 1.0 => format!("{small:.3}"),
                other => format!("{other:.1}"),
            });
            row(name, shown, b as f64 / a as f64, what.to_owned())
        };
        let rates = self.rays_per_second;
        let [a, b] = rates.map(|rate| rate.median);
        vec![
            row(
                "shadow rays a second and thread (M)",
                [a, b].map(|rate| format!("{:.3}", 1e-6 * rate)),
                a / b,
                spread(rates, self.repeats),
            ),
            seconds("solve (s)", self.solve_seconds),
            seconds("render (s)", self.render_seconds),
            megabytes(
                "memory of the tracer (MB)",
                self.tracer_bytes,
                "its tree and copies of the mesh, counted",
            ),
            megabytes("memory of solving (MB)", self.solving_bytes, "at most, above what there was before"),
            megabytes("memory of the solution (MB)", self.solution_bytes, "links and elements, counted"),
        ]
    }
}
