//! Who worked on what and when, as a file that trace viewers open: complete events of the Chrome trace event format
//! (*Trace Event Format*, Google, 2016), times in microseconds.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use serde::Serialize;

use super::json::write_json;
use crate::image::write::OutputError;
use crate::progress::{Span, Timeline};

/// The row of the phases; the threads follow.
const PHASES: usize = 0;

/// Phases in the file, at most; the longest.
const MOST_PHASES: usize = 10_000;

/// Something that holds phases, such as one of several runs.
#[derive(Clone, Debug)]
pub struct Stage {
    /// What it is.
    pub name: String,
    /// When it began.
    pub start: Duration,
    /// When it ended.
    pub end: Duration,
}

/// The file.
#[derive(Debug, Serialize)]
struct Trace {
    #[serde(rename = "displayTimeUnit")]
    unit: &'static str,
    #[serde(rename = "traceEvents")]
    events: Vec<Event>,
}

/// One event; for all that lasts, the phase `X` of the format, for names of rows `M`.
#[derive(Debug, Serialize)]
struct Event {
    name: String,
    #[serde(rename = "cat", skip_serializing_if = "Option::is_none")]
    kind: Option<&'static str>,
    #[serde(rename = "ph")]
    phase: char,
    #[serde(rename = "ts")]
    start: f64,
    #[serde(rename = "dur", skip_serializing_if = "Option::is_none")]
    length: Option<f64>,
    #[serde(rename = "pid")]
    process: usize,
    #[serde(rename = "tid")]
    row: usize,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    args: BTreeMap<&'static str, String>,
}

impl Event {
    fn lasting(kind: &'static str, row: usize, name: String, [start, end]: [Duration; 2]) -> Event {
        let microseconds = |time: Duration| time.as_nanos() as f64 * 1e-3;
        Event {
            name,
            kind: Some(kind),
            phase: 'X',
            start: microseconds(start),
            length: Some(microseconds(end - start)),
            process: 1,
            row,
            args: BTreeMap::new(),
        }
    }

    fn naming(what: &str, row: usize, name: String) -> Event {
        let args = BTreeMap::from([("name", name)]);
        Event {
            name: what.to_owned(),
            kind: None,
            phase: 'M',
            start: 0.0,
            length: None,
            process: 1,
            row,
            args,
        }
    }
}

/// Writes the phases of a timeline and the stages that hold them as one row, and the work of each thread as another.
///
/// # Errors
/// As [`write_json`].
pub fn write_trace(path: &Path, timeline: &Timeline, stages: &[Stage]) -> Result<(), OutputError> {
    write_json(path, &trace(&timeline.phases(), &timeline.slices(), stages))
}

fn trace(phases: &[Span], slices: &[Vec<Span>], stages: &[Stage]) -> Trace {
    let mut events = vec![
        Event::naming("process_name", PHASES, "lightshaft".to_owned()),
        Event::naming("thread_name", PHASES, "phases".to_owned()),
    ];
    let of = |kind, row| {
        move |span: &Span| Event::lasting(kind, row, span.name.to_owned(), [span.start, span.end])
    };
    events.extend(stages.iter().map(|s| Event::lasting("stage", PHASES, s.name.clone(), [s.start, s.end])));
    events.extend(longest(phases, MOST_PHASES).map(of("phase", PHASES)));
    for (index, slices) in slices.iter().enumerate() {
        let row = index + 1;
        events.push(Event::naming("thread_name", row, format!("thread {row}")));
        events.extend(slices.iter().map(of("work", row)));
    }
    Trace { unit: "ms", events }
}

/// The longest spans, at most so many and in order.
fn longest(spans: &[Span], most: usize) -> impl Iterator<Item = &Span> {
    let mut order: Vec<usize> = (0..spans.len()).collect();
    order.sort_by_key(|&index| std::cmp::Reverse(spans[index].length()));
    order.truncate(most);
    order.sort_unstable();
    order.into_iter().map(|index| &spans[index])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_too_many_phases_the_longest_are_kept() {
        let lengths = [5, 1, 4, 1, 3];
        let spans = lengths.map(|length| Span {
            name: "gather",
            start: Duration::ZERO,
            end: Duration::from_nanos(length),
        });
        let kept = |most| longest(&spans, most).map(|span| span.end.as_nanos()).collect::<Vec<_>>();
        assert_eq!((kept(3), kept(4), kept(9).len()), (vec![5, 4, 3], vec![5, 1, 4, 3], 5));
    }

    #[test]
    fn times_are_microseconds_and_rows_have_names() {
        let at = Duration::from_nanos;
        let span = |name, start, end| Span { name, start: at(start), end: at(end) };
        let stages = [Stage { name: "run".into(), start: at(0), end: at(9000) }];
        let trace = trace(&[span("refine", 1500, 4000)], &[vec![span("refine", 2000, 3250)]], &stages);
        let value = serde_json::to_value(&trace).expect("serialisable");
        let events = value["traceEvents"].as_array().expect("events");
        let lasting: Vec<_> = events
            .iter()
            .filter(|event| event["ph"] == "X")
            .map(|event| {
                (event["name"].as_str(), event["tid"].as_u64(), event["ts"].as_f64(), event["dur"].as_f64())
            })
            .collect();
        let row = |name, row, start, length| (Some(name), Some(row), Some(start), Some(length));
        assert_eq!(
            lasting,
            [row("run", 0, 0.0, 9.0), row("refine", 0, 1.5, 2.5), row("refine", 1, 2.0, 1.25)]
        );
        let names: Vec<_> =
            events.iter().filter(|event| event["ph"] == "M").map(|event| &event["args"]["name"]).collect();
        assert_eq!(names, ["lightshaft", "phases", "thread 1"]);
    }
}
