//! The page of strategies and tracers side by side.

use std::path::Path;

use maud::{Markup, html};

use super::super::bars::{Bar, Group};
use super::super::look::Look;
use super::super::plot;
use super::super::profile::{Profile, ProfiledRun};
use super::super::text::{counted, times};
use super::figures::{Image, bar_chart, curves, picture};
use super::table::{Cell, decimals, table};
use super::{Page, Section, work};
use crate::image::Legend;
use crate::image::write::OutputError;

/// A heat map, to be shown on the page.
pub struct ShownMap {
    /// What it shows, in a few words.
    pub name: &'static str,
    /// What its colours stand for.
    pub legend: Legend,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// A PNG file.
    pub png: Vec<u8>,
}

/// Writes the page to `path`, whole or not at all.
///
/// # Errors
/// When `path` cannot be written.
pub fn write_profile(path: &Path, found: &Profile, maps: Vec<ShownMap>) -> Result<(), OutputError> {
    let page = page(found, maps).map_err(|message| OutputError::Encode { path: path.to_owned(), message })?;
    page.write(path, &found.setup)
}

pub(super) fn page(found: &Profile, maps: Vec<ShownMap>) -> Result<Page, String> {
    Ok(Page {
        title: format!("{}: where visibility time goes", found.scene),
        verdict: None,
        summary: summary(found),
        sections: vec![
            Section { heading: "Error against time", body: error_against_time(found)? },
            Section { heading: "Run by run", body: bars(found)? },
            Section { heading: "Where the time goes", body: work::seconds(found)? },
            Section { heading: "What settled pairs, and their sizes", body: work::pairs(found)? },
            Section { heading: "Where in the scene", body: heat_maps(found, maps) },
            Section { heading: "All figures", body: figures(found) },
        ],
    })
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}

/// The look of each run, and what that means.
fn kinds(found: &Profile) -> (Vec<(String, Look)>, Vec<Look>) {
    let kinds = found.kinds();
    let look = |run: &ProfiledRun| kinds.iter().find(|(name, _)| *name == run.kind()).map(|&(_, look)| look);
    let looks = found.runs.iter().filter_map(look).collect();
    (kinds, looks)
}

fn summary(found: &Profile) -> Vec<String> {
    let made = format!("made {}", times(found.repeats));
    let mut words = vec![format!(
        "{}, {}; {}.{}",
        counted(found.triangles, "triangle"),
        counted(found.threads as u64, "thread"),
        match found.runs.len() {
            1 => format!("one run, {made}"),
            count => format!("{}, each {made}, in turns", counted(count as u64, "run")),
        },
        if found.repeats > 1 { " Times are medians." } else { "" }
    )];
    // What most come for is first.
    match found.runs.len() {
        0 | 1 => words.extend(found.headline()),
        _ => words = found.headline().into_iter().chain(words).chain(about_several(found)).collect(),
    }
    words
}

fn about_several(found: &Profile) -> Vec<String> {
    let seconds = |run: &ProfiledRun| run.visibility_seconds.median;
    let error = |run: &ProfiledRun| run.visibility_error.mean;
    let with_light = || found.runs.iter().filter(|run| run.has_light());
    let least =
        |value: &dyn Fn(&ProfiledRun) -> f64| with_light().min_by(|a, b| value(a).total_cmp(&value(b)));
    let Some(yardstick) = found.runs.get(found.yardstick).filter(|run| run.has_light()) else {
        return Vec::new();
    };
    let mut words = vec![format!(
        "The yardstick, to which ratios of time are, is {}: {:.3} s in visibility, with an error of {}.",
        yardstick.name(),
        seconds(yardstick),
        percent(error(yardstick))
    )];
    let mut best = vec![("fastest in visibility", least(&seconds)), ("most exact", least(&error))];
    if let [(_, Some(fast)), (_, Some(exact))] = best[..]
        && std::ptr::eq(fast, exact)
    {
        best = vec![("fastest in visibility and the most exact", Some(fast))];
    }
    for (what, run) in best {
        words.extend(run.map(|run| match std::ptr::eq(run, yardstick) {
            true => format!("The {what} is the yardstick itself."),
            false => format!(
                "The {what} is {}: {:.3} s in visibility, {:.2} of the time of the yardstick, with an error of {}.",
                run.name(),
                seconds(run),
                found.ratio(run),
                percent(error(run))
            ),
        }));
    }
    words
}

/// The maps of the first run.
fn heat_maps(found: &Profile, maps: Vec<ShownMap>) -> Markup {
    html! {
        @if let Some(run) = found.runs.get(found.aim) {
            p { "The scene as " (run.name()) " left it, coloured by what visibility costs where." }
        }
        @for ShownMap { name, legend, size, png } in maps {
            (picture(&Image { png, name: name.to_owned() }, size, name))
            p { (legend.title) }
            ul.legend.scale {
                @for (colour, words) in &legend.entries {
                    li { span.swatch style=(format!("color:{}", hex(*colour))) {} (words) }
                }
            }
        }
    }
}

fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn error_against_time(found: &Profile) -> Result<Markup, String> {
    let (legend, _) = kinds(found);
    let plot = plot::profile(found, String::new());
    let aims = found.at_equal_error();
    Ok(html! {
        p {
            "Further to the left is faster, further down is more exact; points are named by their rays for a pair. The error is how far the visibility of the "
            "links is from that of 256 rays, in the mean over links by the power they carry."
        }
        (curves("Visibility error (%) against seconds in visibility, over all threads", &legend, &plot)?)
        @for aim in &aims {
            p { (aim.words()) }
            ul { @for other in &aim.others { li { (other) } } }
        }
    })
}

/// How long a bar is, from where to where measurements went, and what is written behind it.
type Figure = (f64, Option<(f64, f64)>, String);

/// A chart for each figure, a bar for each run.
fn bars(found: &Profile) -> Result<Markup, String> {
    let (legend, looks) = kinds(found);
    let chart = |caption: &str, bar: &dyn Fn(&ProfiledRun) -> Figure| {
        let groups: Vec<Group> = found
            .runs
            .iter()
            .zip(&looks)
            .map(|(run, &look)| {
                let (value, range, text) = bar(run);
                Group { name: run.name(), bars: vec![Bar { value, range, text, look }] }
            })
            .collect();
        bar_chart(caption, &legend, &groups)
    };
    let range = if found.repeats > 1 { "; the thin line goes from least to most" } else { "" };
    let time = chart(&format!("Time in visibility, over all threads{range}"), &|run| {
        let spread = run.visibility_seconds;
        (spread.median, Some((spread.min, spread.max)), format!("{:.3} s", spread.median))
    })?;
    let error = chart("Visibility error, mean over links by power", &|run| match run.has_light() {
        true => (run.visibility_error.mean, None, percent(run.visibility_error.mean)),
        false => (f64::NAN, None, "no links".to_owned()),
    })?;
    let irradiance = match found.runs.iter().any(|run| run.irradiance_error.is_some()) {
        false => None,
        true => Some(chart("Irradiance error, root mean square over the mean", &|run| {
            let rms = run.irradiance_error.map_or(f64::NAN, |error| error.rms);
            (rms, None, percent(rms))
        })?),
    };
    let memory = chart("Memory: what the run took besides the scene, and its tracer", &|run| {
        let megabytes = run.memory_bytes() as f64 / f64::from(1 << 20);
        (megabytes, None, format!("{megabytes:.0} MB"))
    })?;
    Ok(html! { (time) (error) @if let Some(irradiance) = irradiance { (irradiance) } (memory) })
}

/// A column: its head and how its cell is made.
type Column = (&'static str, fn(&Profile, &ProfiledRun) -> Cell);

const TIMES: [Column; 4] = [
    ("strategy", |_, run| Cell::words(&run.strategy)),
    ("tracer", |_, run| Cell::words(&run.tracer)),
    ("rays for a pair", |_, run| Cell::count(run.rays.into())),
    ("visibility (s)", |_, run| decimals(run.visibility_seconds.median, 3)),
];

/// An error, or that there are no links which could have one.
fn told(run: &ProfiledRun, error: Cell) -> Cell {
    if run.has_light() { error } else { Cell::words("no links") }
}

/// Where there are several measurements.
const SPREAD: Column = ("± %", |_, run| decimals(100.0 * run.visibility_seconds.relative(), 1));

const FIGURES: [Column; 14] = [
    ("ratio", |found, run| decimals(found.ratio(run), 3)),
    ("total (s)", |_, run| decimals(run.total_seconds.median, 2)),
    ("V error (%)", |_, run| told(run, decimals(100.0 * run.visibility_error.mean, 3))),
    ("V 99.9 (%)", |_, run| told(run, decimals(100.0 * run.visibility_error.percentile_999, 2))),
    ("links", |_, run| Cell::count(run.links)),
    ("pairs tested", |_, run| Cell::count(run.pairs_tested)),
    ("rays cast", |_, run| Cell::count(run.rays_cast)),
    ("rays avoided", |_, run| Cell::count(run.rays_avoided)),
    ("filter calls", |_, run| Cell::count(run.detail.filter_calls)),
    ("rejected (%)", |_, run| decimals(100.0 * run.detail.rejected(), 1)),
    ("shafts built", |_, run| Cell::count(run.shafts_built)),
    ("proved (%)", |_, run| decimals(100.0 * run.certified_share, 1)),
    ("memory (MB)", |_, run| Cell::count(run.memory_bytes() >> 20)),
    ("solution (MB)", |_, run| decimals(run.solution_bytes as f64 / f64::from(1 << 20), 1)),
];

/// Where there is a reference.
const IRRADIANCE: Column =
    ("E error (%)", |_, run| decimals(100.0 * run.irradiance_error.map_or(f64::NAN, |error| error.rms), 2));

fn figures(found: &Profile) -> Markup {
    let has_reference = found.runs.iter().any(|run| run.irradiance_error.is_some());
    let spread = (found.repeats > 1).then_some(SPREAD);
    let irradiance = has_reference.then_some(IRRADIANCE);
    let columns: Vec<Column> = TIMES.into_iter().chain(spread).chain(FIGURES).chain(irradiance).collect();
    let heads: Vec<String> = columns.iter().map(|(head, _)| (*head).to_owned()).collect();
    let row = |run: &ProfiledRun| columns.iter().map(|(_, cell)| cell(found, run)).collect();
    let rows: Vec<Vec<Cell>> = found.runs.iter().map(row).collect();
    html! {
        p {
            @if let Some(yardstick) = found.runs.get(found.yardstick) {
                "Ratio: seconds in visibility over those of the yardstick, " (yardstick.name()) ". "
            }
            "V: visibility of the links against 256 rays, the mean and what links with a thousandth of the power exceed; above 100 % "
            "where what a link sees of its source is brighter than all of it, so that more than 1 gets through. "
            @if has_reference { "E: irradiance at the points against the reference. " }
            "Filter: the candidate filter, and the hits it rejected. "
            "Proved: pairs whose visibility is proved, of all that refinement ended at. "
            "Memory: what was resident at most above what had been before the run, and what the tracer keeps; of that the solution "
            "is links and elements."
        }
        (table("A row for each run", &heads, &rows, None))
    }
}
