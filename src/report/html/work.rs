//! Where the work of each run went, on the page of a profile: steps, phases, what settled pairs, their sizes,
//! histograms.

use maud::{Markup, html};

use super::super::bars::{Bar, Group};
use super::super::detail::{RunDetail, Seconds};
use super::super::look::Look;
use super::super::profile::{Profile, ProfiledRun};
use super::figures::bar_chart;
use super::table::{Cell, decimals, table};
use crate::visibility::Bin;

/// Seconds of all runs, by step and by phase.
pub(super) fn seconds(found: &Profile) -> Result<Markup, String> {
    let groups: Vec<Group> = found.runs.iter().map(steps_of).collect();
    let steps = bar_chart("Seconds in visibility tests by step, over all threads", &[], &groups)?;
    Ok(html! {
        p { "Rays include the candidate filter. The steps of one test in sixteen are timed, in all repeats, and stand for all; a test "
            "that another program interrupted cannot change them much." }
        (steps) (phases(found))
    })
}

/// A row for each run, a column for each phase that any of them has.
fn phases(found: &Profile) -> Markup {
    let names = found.phases();
    let row = |run: &ProfiledRun| {
        let of = |name: &&str| run.detail.phases.iter().find(|phase| phase.name == *name);
        let seconds = names.iter().map(|name| decimals(of(name).map_or(0.0, |phase| phase.seconds), 3));
        [Cell::words(run.name())].into_iter().chain(seconds).collect()
    };
    let heads: Vec<String> = ["run"].iter().chain(&names).map(|name| (*name).to_owned()).collect();
    let rows: Vec<Vec<Cell>> = found.runs.iter().map(row).collect();
    table("Seconds by phase, as the clock on the wall tells them", &heads, &rows, None)
}

/// A bar for each step that took any time.
fn steps_of(run: &ProfiledRun) -> Group {
    let steps = &run.detail.steps;
    let all: f64 = steps.iter().map(|step| step.seconds).sum();
    let bar = |step: &Seconds| {
        let share = 100.0 * step.seconds / all.max(f64::MIN_POSITIVE);
        let text = format!("{} {:.3} s, {share:.0} %", step.name, step.seconds);
        Bar { value: step.seconds, range: None, text, look: Look::filled(0) }
    };
    Group { name: run.name(), bars: steps.iter().filter(|step| step.seconds > 0.0).map(bar).collect() }
}

/// What settled the pairs of each run, and their sizes; the aim is open.
pub(super) fn pairs(found: &Profile) -> Result<Markup, String> {
    let runs = found.runs.iter().map(|run| Ok((run.name(), pairs_of(&run.detail)?)));
    let runs: Vec<(String, Markup)> = runs.collect::<Result<_, String>>()?;
    Ok(html! {
        p { "Pairs of nodes that refinement came to. A level halves the size: of level 0 are pairs as large as the scene." }
        @for (index, (name, body)) in runs.iter().enumerate() {
            details open[index == found.aim] { summary { (name) } (body) }
        }
    })
}

fn pairs_of(detail: &RunDetail) -> Result<Markup, String> {
    let words = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<String>>();
    let answers: Vec<Vec<Cell>> = detail
        .answers
        .iter()
        .filter(|row| row.pairs > 0)
        .map(|row| {
            let per_pair = |amount: f64| decimals(amount / row.pairs as f64, 2);
            vec![
                Cell::words(row.name),
                Cell::words(row.class),
                Cell::count(row.pairs),
                Cell::count(row.rays),
                per_pair(row.rays as f64),
                decimals(row.seconds, 3),
                per_pair(1e6 * row.seconds),
            ]
        })
        .collect();
    let levels: Vec<Vec<Cell>> = detail
        .levels
        .iter()
        .map(|row| {
            let counts =
                [row.pairs, row.dark, row.inherited, row.visible, row.invisible, row.partial, row.rays];
            let mut cells = vec![Cell::count(row.level as u64), decimals(row.radius, 3)];
            cells.extend(counts.map(Cell::count));
            cells.push(decimals(row.seconds, 3));
            cells
        })
        .collect();
    let histograms = [
        ("Rays of a pair", &detail.rays_per_pair),
        ("Facets left in a shaft", &detail.candidates_per_shaft),
        ("Calls of the candidate filter for a pair", &detail.filter_calls_per_pair),
    ];
    let histograms = histograms.map(|(name, bins)| histogram(name, bins));
    let histograms = histograms.into_iter().collect::<Result<Vec<Markup>, String>>()?;
    Ok(html! {
        (table(
            "By what settled them",
            &words(&["settled by", "class", "pairs", "rays", "rays a pair", "seconds", "µs a pair"]),
            &answers,
            None,
        ))
        (table(
            "By the size of the larger node; radius in scene units, seconds over all threads",
            &words(&[
                "level", "radius up to", "pairs", "dark", "inherited", "visible", "invisible", "partial", "rays", "seconds",
            ]),
            &levels,
            None,
        ))
        @for histogram in &histograms { (histogram) }
    })
}

/// A bar for each bin; nothing where there are none.
fn histogram(caption: &str, bins: &[Bin]) -> Result<Markup, String> {
    if bins.is_empty() {
        return Ok(html! {});
    }
    let bars = bins.iter().map(|bin| Bar {
        value: bin.count as f64,
        range: None,
        text: match bin.from == bin.to {
            true => format!("{}: {}", bin.from, bin.count),
            false => format!("{} to {}: {}", bin.from, bin.to, bin.count),
        },
        look: Look::filled(0),
    });
    bar_chart(caption, &[], &[Group { name: "value: how often".to_owned(), bars: bars.collect() }])
}
