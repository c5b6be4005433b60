//! The page of two tracers side by side; `docs/compare.md` explains the figures.

use std::path::Path;

use maud::{Markup, html};

use super::super::bars::{Bar, Group};
use super::super::compare::{CompareReport, DescribedDisagreement};
use super::super::look::Look;
use super::super::profile::Spread;
use super::super::text::{counted, times as times_of};
use super::figures::{Image, bar_chart, picture, wipe};
use super::table::{Cell, table};
use super::{Page, Section};
use crate::compare::{Standing, Tally};
use crate::image::write::OutputError;

/// Answers that are listed one by one; the record has them all.
const LISTED: usize = 40;

/// The pictures as they are shown, PNG: native, fallback, and their difference.
pub struct Shown {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// The files.
    pub files: [Vec<u8>; 3],
    /// How much brighter the picture of the difference is.
    pub gain: f32,
}

/// Writes the page to `path`, whole or not at all.
///
/// # Errors
/// When `path` cannot be written.
pub fn write_compare(path: &Path, report: &CompareReport, shown: Shown) -> Result<(), OutputError> {
    let page =
        page(report, shown).map_err(|message| OutputError::Encode { path: path.to_owned(), message })?;
    page.write(path, &report.setup)
}

pub(super) fn page(report: &CompareReport, shown: Shown) -> Result<Page, String> {
    let [native, other] = &report.tracers;
    let verdict = match report.objection() {
        None => (true, "The tracers agree.".to_owned()),
        Some(objection) => (false, format!("The tracers disagree: {objection}.")),
    };
    let mut summary: Vec<String> = report.words().lines().map(str::to_owned).collect();
    summary.push(format!(
        "The same scene was solved and rendered with both; where rays differ, an exhaustive third tracer in double \
         precision says who is right. {}.",
        counted(report.threads as u64, "thread")
    ));
    Ok(Page {
        title: format!("{}: {native} and {other}", report.scene),
        verdict: Some(verdict),
        summary,
        sections: vec![
            Section { heading: "Pictures", body: pictures(report, shown) },
            Section { heading: "Rays", body: rays(report)? },
            Section { heading: "Worst answers", body: worst(report) },
            Section { heading: "Links, light and pictures", body: differences(report) },
            Section { heading: "Speed and memory", body: speed(report)? },
        ],
    })
}

fn pictures(report: &CompareReport, shown: Shown) -> Markup {
    let difference = &report.picture;
    let [native, other] = &report.tracers;
    let names = [native.clone(), other.clone(), format!("difference of {native} and {other}")];
    let [a, b, both] = shown.files;
    let [a, b, both] = [(a, 0), (b, 1), (both, 2)].map(|(png, i)| Image { png, name: names[i].clone() });
    let at = difference.worst.map_or_else(String::new, |[x, y]| format!(" at pixel {x} {y}"));
    let words = format!(
        "The difference, {} times as bright. Root mean square {:.4} % of the mean radiance, largest {:.4} %{at}; mean FLIP {}.",
        shown.gain,
        100.0 * difference.relative(difference.rmse),
        100.0 * difference.relative(difference.max),
        report.flip()
    );
    html! {
        div.pictures {
            (wipe([&a, &b], shown.size, "Both with the exposure of the first. Move the slider, or drag on the picture."))
            (picture(&both, shown.size, &words))
        }
    }
}

/// What the looks of bars mean.
fn legend(report: &CompareReport) -> [(String, Look); 2] {
    [0, 1].map(|side| (report.tracers[side].clone(), Look::filled(side)))
}

/// Answers of each tracer that are not the referee's.
fn off(tally: &Tally) -> [u64; 2] {
    [0, 1].map(|side| tally.tolerance[side] + tally.edge_on[side] + tally.wrong[side])
}

fn rays(report: &CompareReport) -> Result<Markup, String> {
    let group = |tally: &Tally| {
        let bar = |side: usize| {
            let (off, wrong) = (off(tally)[side], tally.wrong[side]);
            let value = 1e6 * off as f64 / (tally.traced as f64).max(1.0);
            let wrong = if wrong > 0 { format!(", {wrong} WRONG") } else { String::new() };
            Bar { value, range: None, text: format!("{value:.1} ({off}{wrong})"), look: Look::filled(side) }
        };
        Group { name: tally.name.clone(), bars: vec![bar(0), bar(1)] }
    };
    let groups: Vec<Group> = report.rays.iter().filter(|tally| off(tally) != [0, 0]).map(group).collect();
    let of = |what: &str, side: usize| format!("{}: {what}", report.tracers[side]);
    let mut heads = ["rays", "traced", "blocked", "differing"].map(str::to_owned).to_vec();
    heads
        .extend([0, 1].iter().flat_map(|&side| ["tolerance", "edge-on", "WRONG"].map(|what| of(what, side))));
    let row = |tally: &Tally| {
        let mut cells = vec![Cell::words(&tally.name)];
        cells.extend([tally.traced, tally.blocked, tally.differing].map(Cell::count));
        for side in [0, 1] {
            cells.extend(
                [tally.tolerance, tally.edge_on, tally.wrong].map(|counts| Cell::count(counts[side])),
            );
        }
        cells
    };
    let (last, kinds) =
        report.rays.split_last().map_or((None, &[][..]), |(last, kinds)| (Some(row(last)), kinds));
    let rows: Vec<Vec<Cell>> = kinds.iter().map(row).collect();
    Ok(html! {
        p {
            "Differing: one tracer calls the ray blocked and the other clear, or they meet different facets first. "
            "Tolerance and edge-on: not what the referee says, but no more than rounding. WRONG: all else."
        }
        @if groups.is_empty() {
            p { "Every answer is the referee's." }
        } @else {
            (bar_chart("Answers that are not the referee's, per million rays of their kind, and in brackets how many", &legend(report), &groups)?)
        }
        (table("By kind of ray", &heads, &rows, last.as_deref()))
    })
}

fn worst(report: &CompareReport) -> Markup {
    let mut heads = vec!["rays".to_owned(), "candidates".to_owned()];
    for tracer in &report.tracers {
        heads.extend([format!("{tracer} says"), format!("{tracer} is"), "off by".to_owned()]);
    }
    heads.extend(["from", "to"].map(str::to_owned));
    let row = |worst: &DescribedDisagreement| {
        let candidates = worst.candidates.map_or_else(|| Cell::words("all"), Cell::count);
        let mut cells = vec![Cell::words(&worst.kind), candidates];
        for side in [0, 1] {
            let distance = worst.distances[side];
            cells.extend([
                Cell::words(&worst.answers[side]),
                Cell::words(standing(worst.standings[side])),
                Cell::number(
                    distance,
                    if distance == 0.0 { "0".to_owned() } else { format!("{distance:.1e}") },
                ),
            ]);
        }
        cells.extend([worst.from, worst.to].map(|[x, y, z]| Cell::words(format!("{x:.4} {y:.4} {z:.4}"))));
        cells
    };
    let rows: Vec<Vec<Cell>> = report.worst.iter().take(LISTED).map(row).collect();
    html! {
        @if rows.is_empty() {
            p { "There are none: every answer is the referee's." }
        } @else {
            // Open where there is something to see: rounding alone is no news.
            details open[report.worst[0].standings.contains(&Standing::Wrong)] {
                summary { (rows.len()) " of the answers that are not the referee's, worst first" }
                p {
                    "Places and distances in scene units. "
                    @if report.worst.len() > LISTED {
                        code { "--json" } " writes all " (report.worst.len()) " that were kept."
                    }
                }
                (table("Answers that are not the referee's", &heads, &rows, None))
            }
        }
    }
}

fn standing(standing: Standing) -> &'static str {
    match standing {
        Standing::Right => "right",
        Standing::Tolerance => "within the tolerance",
        Standing::EdgeOn => "seen edge-on",
        Standing::Wrong => "WRONG",
    }
}

fn differences(report: &CompareReport) -> Markup {
    let heads = heads_of(report, "where");
    let rows = read(report.difference_rows());
    html! {
        p { "Light relative to what surfaces reflect in the mean, pictures to the mean of the first." }
        (table("What differs, and where most", &heads, &rows, None))
    }
}

/// Every column has a name here, since it is pressed.
fn heads_of(report: &CompareReport, last: &str) -> Vec<String> {
    let mut heads = report.work_heads();
    (heads[0], heads[4]) = ("of".to_owned(), last.to_owned());
    heads.to_vec()
}

fn read(rows: Vec<[String; 5]>) -> Vec<Vec<Cell>> {
    rows.into_iter().map(|row| row.into_iter().map(Cell::read).collect()).collect()
}

fn speed(report: &CompareReport) -> Result<Markup, String> {
    let pair =
        |name: &str, bar: &dyn Fn(usize) -> Bar| Group { name: name.to_owned(), bars: vec![bar(0), bar(1)] };
    let rate = |side: usize| {
        let spread = report.rays_per_second[side];
        let text = format!("{:.2} M", 1e-6 * spread.median);
        Bar { value: spread.median, range: Some((spread.min, spread.max)), text, look: Look::filled(side) }
    };
    let seconds = |all: [Spread; 2]| {
        move |side: usize| {
            let Spread { min, median, max } = all[side];
            let text = format!("{median:.2} s");
            Bar { value: median, range: Some((min, max)), text, look: Look::filled(side) }
        }
    };
    let rates = [pair("shadow rays a second and thread", &rate)];
    let times =
        [pair("solve", &seconds(report.solve_seconds)), pair("render", &seconds(report.render_seconds))];
    let is_spread = report.repeats > 1 || report.solves > 1;
    let range = if is_spread { "; the thin line goes from least to most" } else { "" };
    let megabytes = |all: [u64; 2]| {
        move |side: usize| {
            let value = all[side] as f64 / f64::from(1 << 20);
            Bar { value, range: None, text: format!("{value:.1} MB"), look: Look::filled(side) }
        }
    };
    let memory = [
        pair("the tracer itself: its tree, and copies of the mesh", &megabytes(report.tracer_bytes)),
        pair("solving, above what there was", &megabytes(report.solving_bytes)),
        pair("the solution: links and elements", &megabytes(report.solution_bytes)),
    ];
    let (legend, mut heads, rows) =
        (legend(report), heads_of(report, "spread, or what it is"), read(report.speed_rows()));
    heads[3] = "ratio".to_owned();
    let medians = format!(
        "Medians. {} of the solutions, a sample, were traced {}, and the scene was solved and rendered {} with each, \
         in turns.",
        counted(report.timed_rays, "shadow ray"),
        times_of(report.repeats),
        times_of(report.solves)
    );
    Ok(html! {
        p { (medians) }
        (bar_chart(&format!("Shadow rays: more is better{range}"), &legend, &rates)?)
        (bar_chart(&format!("Wall-clock time, all threads: less is better{range}"), &legend, &times)?)
        (bar_chart("Memory: less is better", &legend, &memory)?)
        (table("Speed and memory", &heads, &rows, None))
    })
}
