//! The page of strategies and tracers side by side.

use std::path::Path;

use maud::{Markup, html};

use super::super::bars::{Bar, Group};
use super::super::plot;
use super::super::profile::{Profile, ProfiledRun};
use super::figures::{Image, bar_chart, curves, picture};
use super::table::{Cell, decimals, table};
use super::{Page, Section, Setup, work};
use crate::image::write::OutputError;

/// A heat map, to be shown on the page.
pub struct ShownMap {
    /// What it shows, in a few words.
    pub name: &'static str,
    /// What its colours mean.
    pub legend: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// A PNG file.
    pub png: Vec<u8>,
}

/// Writes the page to `path`, whole or not at all.
///
/// # Errors
/// When `path` cannot be written.
pub fn write_profile(
    path: &Path,
    found: &Profile,
    maps: Vec<ShownMap>,
    setup: &Setup,
) -> Result<(), OutputError> {
    let page = page(found, maps).map_err(|message| OutputError::Encode { path: path.to_owned(), message })?;
    page.write(path, setup)
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

/// Strategy and tracer of each run, the same ones together, as in the plot: its colour, and what that means.
fn kinds(found: &Profile) -> (Vec<String>, Vec<usize>) {
    let names = found.kinds();
    let colours =
        found.runs.iter().filter_map(|run| names.iter().position(|name| *name == run.kind())).collect();
    (names, colours)
}

fn summary(found: &Profile) -> Vec<String> {
    let mut words = vec![format!(
        "{} triangles, {} threads; {} runs, each made {}, one after the other in turns. Times are medians.",
        found.triangles,
        found.threads,
        found.runs.len(),
        if found.repeats == 1 { "once".to_owned() } else { format!("{} times", found.repeats) },
    )];
    let seconds = |run: &ProfiledRun| run.visibility_seconds.median;
    let error = |run: &ProfiledRun| run.visibility_error.mean;
    let least =
        |value: &dyn Fn(&ProfiledRun) -> f64| found.runs.iter().min_by(|a, b| value(a).total_cmp(&value(b)));
    let Some(yardstick) = found.runs.get(found.yardstick) else { return words };
    let about = |run: &ProfiledRun| {
        let ratio = seconds(run) / seconds(yardstick).max(f64::MIN_POSITIVE);
        format!(
            "{:.3} s in visibility, {ratio:.2} of the time of {}, with an error of {}",
            seconds(run),
            yardstick.name(),
            percent(error(run))
        )
    };
    words.push(format!(
        "What the others are measured by is {}: {:.3} s in visibility, with an error of {}.",
        yardstick.name(),
        seconds(yardstick),
        percent(error(yardstick))
    ));
    for (what, best) in [("fastest", least(&seconds)), ("most exact", least(&error))] {
        words.extend(best.map(|run| match std::ptr::eq(run, yardstick) {
            true => format!("The {what} is {}, by which the others are measured.", run.name()),
            false => format!("The {what} is {}: {}.", run.name(), about(run)),
        }));
    }
    words
}

/// The maps of the first run.
fn heat_maps(found: &Profile, maps: Vec<ShownMap>) -> Markup {
    html! {
        @if let Some(run) = found.runs.first() {
            p { "The scene as " (run.name()) " left it, coloured by what visibility costs where." }
        }
        @for ShownMap { name, legend, size, png } in maps {
            (picture(&Image { png, name: name.to_owned() }, size, name))
            pre { (legend) }
        }
    }
}

fn error_against_time(found: &Profile) -> Result<Markup, String> {
    let (names, _) = kinds(found);
    let plot = plot::profile(found, String::new());
    Ok(html! {
        p {
            "Further to the left is faster, further down is more exact; points are named by their rays for a pair. The error is how far the visibility of the "
            "links is from that of 256 rays, in the mean over links by the power they carry."
        }
        (curves("Visibility error (%) against seconds in visibility, over all threads", &names, &plot)?)
    })
}

/// How long a bar is, from where to where measurements went, and what is written behind it.
type Figure = (f64, Option<(f64, f64)>, String);

/// A chart for each figure, a bar for each run.
fn bars(found: &Profile) -> Result<Markup, String> {
    let (names, colours) = kinds(found);
    let chart = |caption: &str, bar: &dyn Fn(&ProfiledRun) -> Figure| {
        let groups: Vec<Group> = found
            .runs
            .iter()
            .zip(&colours)
            .map(|(run, &colour)| {
                let (value, range, text) = bar(run);
                Group { name: run.name(), bars: vec![Bar { value, range, text, colour }] }
            })
            .collect();
        bar_chart(caption, &names, &groups)
    };
    let time =
        chart("Time in visibility, over all threads; the thin line goes from least to most", &|run| {
            let spread = run.visibility_seconds;
            (spread.median, Some((spread.min, spread.max)), format!("{:.3} s", spread.median))
        })?;
    let error = chart("Visibility error, mean over links by power", &|run| {
        (run.visibility_error.mean, None, percent(run.visibility_error.mean))
    })?;
    let irradiance = match found.runs.iter().any(|run| run.irradiance_error.is_some()) {
        false => None,
        true => Some(chart("Irradiance error, root mean square over the mean", &|run| {
            let rms = run.irradiance_error.map_or(f64::NAN, |error| error.rms);
            (rms, None, percent(rms))
        })?),
    };
    let memory = chart("Largest resident memory", &|run| {
        let megabytes = run.peak_rss_bytes as f64 / f64::from(1 << 20);
        (megabytes, None, format!("{megabytes:.0} MB"))
    })?;
    Ok(html! { (time) (error) @if let Some(irradiance) = irradiance { (irradiance) } (memory) })
}

/// A column: its head and how its cell is made.
type Column = (&'static str, fn(&ProfiledRun) -> Cell);

const COLUMNS: [Column; 15] = [
    ("strategy", |run| Cell::words(&run.strategy)),
    ("tracer", |run| Cell::words(&run.tracer)),
    ("rays for a pair", |run| Cell::count(run.rays.into())),
    ("visibility (s)", |run| decimals(run.visibility_seconds.median, 3)),
    ("± %", |run| decimals(100.0 * run.visibility_seconds.relative(), 1)),
    ("total (s)", |run| decimals(run.total_seconds.median, 2)),
    ("V error (%)", |run| decimals(100.0 * run.visibility_error.mean, 3)),
    ("V 99.9 (%)", |run| decimals(100.0 * run.visibility_error.percentile_999, 2)),
    ("links", |run| Cell::count(run.links)),
    ("pairs tested", |run| Cell::count(run.pairs_tested)),
    ("rays cast", |run| Cell::count(run.rays_cast)),
    ("rays avoided", |run| Cell::count(run.rays_avoided)),
    ("shafts built", |run| Cell::count(run.shafts_built)),
    ("proved (%)", |run| decimals(100.0 * run.certified_share, 1)),
    ("memory (MB)", |run| Cell::count(run.peak_rss_bytes >> 20)),
];

fn figures(found: &Profile) -> Markup {
    let mut heads: Vec<String> = COLUMNS.iter().map(|(head, _)| (*head).to_owned()).collect();
    let has_reference = found.runs.iter().any(|run| run.irradiance_error.is_some());
    if has_reference {
        heads.push("E error (%)".to_owned());
    }
    let row = |run: &ProfiledRun| {
        let mut cells: Vec<Cell> = COLUMNS.iter().map(|(_, cell)| cell(run)).collect();
        if has_reference {
            cells.push(decimals(100.0 * run.irradiance_error.map_or(f64::NAN, |error| error.rms), 2));
        }
        cells
    };
    let rows: Vec<Vec<Cell>> = found.runs.iter().map(row).collect();
    html! {
        p {
            "V: visibility of the links against 256 rays, the mean and what links with a thousandth of the power exceed. "
            @if has_reference { "E: irradiance at the points against the reference. " }
            "Proved: pairs whose visibility is proved, of all that refinement ended at."
        }
        (table("A row for each run", &heads, &rows, None))
    }
}
