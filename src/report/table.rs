//! The statistics as a table for people, in the form of Table 1 of Gong et al. 2002: one column for
//! each scene, then what visibility cost and how long each phase took.

use std::fmt::Write;

use super::stats::Stats;

/// One row: its label and how its cell is made.
type Row = (&'static str, fn(&Stats) -> String);

/// The rows of the paper's Table 1, in its order, and the elements.
const PAPER_ROWS: &[Row] = &[
    ("initial triangles", |s| count(s.scene.triangles_initial)),
    ("final triangles", |s| count(s.scene.triangles_final)),
    ("clusters", |s| count(s.scene.clusters)),
    ("patches", |s| count(s.scene.patches)),
    ("elements", |s| count(s.scene.elements)),
    ("links", |s| count(s.links.total)),
    ("- fully visible", |s| count(s.links.visible)),
    ("- invisible", |s| count(s.links.invisible)),
    ("- partial", |s| count(s.links.partial)),
    ("memory (KB)", |s| count((s.memory.links_bytes + s.memory.elements_bytes).div_ceil(1024))),
    ("time (s)", |s| seconds(s.seconds.total)),
    ("iterations", |s| s.iterations.to_string()),
    ("energy error (W)", |s| format!("{:.3e}", s.energy_error_w)),
];

/// Visibility, energy and phases.
const WORK_ROWS: &[Row] = &[
    ("tracer", tracer),
    ("strategy", |s| s.strategy.clone()),
    ("threads", |s| s.threads.to_string()),
    ("certified visible", |s| share(s.links.certified_visible, s.links.visible)),
    ("certified invisible", |s| share(s.links.certified_invisible, s.links.invisible)),
    ("inherited", |s| share(s.links.inherited, s.links.total)),
    ("pairs tested", |s| count(s.visibility.pairs_tested)),
    ("shafts built", |s| count(s.visibility.shafts_built)),
    ("- empty", |s| share(s.visibility.empty_shafts, s.visibility.shafts_built)),
    ("single blockers", |s| count(s.visibility.single_blockers)),
    ("fused blockers", |s| count(s.visibility.fused_blockers)),
    ("rays cast", |s| count(s.visibility.rays_cast)),
    ("rays avoided", |s| count(s.visibility.rays_avoided)),
    ("culling anomalies", |s| count(s.visibility.culling_anomalies)),
    ("visibility (thread s)", |s| seconds(s.visibility.seconds)),
    ("energy balance error", |s| format!("{:.2} %", s.energy.balance_error * 100.0)),
    ("peak memory (MB)", |s| count(s.memory.peak_rss_bytes.div_ceil(1024 * 1024))),
    ("load (s)", |s| seconds(s.seconds.load)),
    ("build (s)", |s| seconds(s.seconds.build)),
    ("refine (s)", |s| seconds(s.seconds.refine)),
    ("solve (s)", |s| seconds(s.seconds.solve)),
    ("local pass (s)", |s| s.local_pass.map_or_else(|| "-".to_owned(), |pass| seconds(pass.seconds))),
    ("render (s)", |s| seconds(s.seconds.render)),
    ("pictures", |s| s.frames.to_string()),
    ("pictures a second", |s| format!("{:.2}", s.frames_per_second)),
];

/// The table of one or more runs, each with the name its column gets; ends with a newline.
pub fn table(runs: &[(&str, &Stats)]) -> String {
    let blocks = [PAPER_ROWS, WORK_ROWS];
    let label_width = blocks.iter().copied().flatten().map(|(label, _)| label.len()).max().unwrap_or(0);
    let widths: Vec<usize> = runs
        .iter()
        .map(|(name, stats)| {
            let cells = blocks.iter().copied().flatten().map(|(_, cell)| cell(stats).chars().count());
            cells.max().unwrap_or(0).max(name.chars().count())
        })
        .collect();
    let rule = "-".repeat(label_width + widths.iter().map(|w| w + 2).sum::<usize>());

    let mut text = String::new();
    line(&mut text, label_width, "", runs.iter().map(|(name, _)| (*name).to_owned()).zip(&widths));
    for rows in blocks {
        text.push_str(&rule);
        text.push('\n');
        for (label, cell) in rows {
            line(&mut text, label_width, label, runs.iter().map(|(_, stats)| cell(stats)).zip(&widths));
        }
    }
    text
}

fn line<'a>(
    text: &mut String,
    label_width: usize,
    label: &str,
    cells: impl Iterator<Item = (String, &'a usize)>,
) {
    // Writing to a string cannot fail.
    let _ = write!(text, "{label:<label_width$}");
    for (cell, width) in cells {
        let _ = write!(text, "  {cell:>width$}");
    }
    text.push('\n');
}

fn tracer(stats: &Stats) -> String {
    match &stats.embree_version {
        Some(version) => format!("{} {version}", stats.tracer),
        None => stats.tracer.clone(),
    }
}

/// A number in groups of three digits, as the paper prints them.
fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::with_capacity(digits.len() * 4 / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    grouped
}

/// A number and how much of the whole it is.
fn share(part: u64, whole: u64) -> String {
    if whole == 0 {
        return count(part);
    }
    format!("{} ({:.0} %)", count(part), 100.0 * part as f64 / whole as f64)
}

fn seconds(seconds: f64) -> String {
    format!("{seconds:.2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Stats {
        let mut stats =
            Stats { tracer: "embree".into(), embree_version: Some("4.4.0".into()), ..Stats::default() };
        stats.scene.triangles_initial = 120;
        stats.links.total = 1_020_758;
        stats.links.visible = 11_285;
        stats.links.certified_visible = 5_643;
        stats.memory.links_bytes = 2048;
        stats.memory.elements_bytes = 1;
        stats.energy_error_w = 5.246e-3;
        stats
    }

    #[test]
    fn has_the_papers_rows_in_the_papers_order() {
        let text = table(&[("scene", &sample())]);
        let rows = [
            "initial triangles",
            "final triangles",
            "clusters",
            "patches",
            "links",
            "- fully visible",
            "- invisible",
            "- partial",
            "memory (KB)",
            "time (s)",
            "iterations",
            "energy error (W)",
        ];
        let mut from = 0;
        for row in rows {
            let at =
                text[from..].find(row).unwrap_or_else(|| panic!("no row {row} after byte {from}:\n{text}"));
            from += at + row.len();
        }
    }

    #[test]
    fn columns_are_aligned_whatever_the_names() {
        let (one, two) = (sample(), Stats::default());
        let text = table(&[("küche", &one), ("a-very-long-scene-name-indeed", &two)]);
        let widths: Vec<usize> = text.lines().map(|l| l.chars().count()).collect();
        assert!(widths.windows(2).all(|w| w[0] == w[1]), "{text}");
    }

    #[test]
    fn cells_read_as_numbers_with_their_units() {
        let text = table(&[("scene", &sample())]);
        for expected in ["1 020 758", "5 643 (50 %)", "embree 4.4.0", "5.246e-3"] {
            assert!(text.contains(expected), "{expected} is missing:\n{text}");
        }
        let memory = text.lines().find(|l| l.starts_with("memory (KB)")).expect("row");
        assert!(memory.ends_with(" 3"), "{memory}");
    }

    #[test]
    fn digits_are_grouped_from_the_right() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1 000"), (12_345_678, "12 345 678")] {
            assert_eq!(count(number), text);
        }
        assert_eq!(share(3, 0), "3");
    }
}
