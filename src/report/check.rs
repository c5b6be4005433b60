//! The findings of a check as a table for people and as a JSON file; `docs/check.md` explains both.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use super::json::write_json;
use super::text::aligned;
use crate::check::{Check, Finding, Unit, Verdict};
use crate::image::write::OutputError;

/// The check of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// `draft`, `normal` or `high`: whose limits hold.
    pub quality: &'a str,
    /// `"embree"` or `"fallback"`.
    pub tracer: &'a str,
    /// Whether nothing failed.
    pub passed: bool,
    /// What was found.
    #[serde(flatten)]
    pub check: &'a Check,
}

impl CheckReport<'_> {
    /// Writes the report to `path` as JSON, whole or not at all, replacing what is there.
    ///
    /// # Errors
    /// When the folder is missing or not writable or the disk is full.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        write_json(path, self)
    }

    /// The report as a table; ends with a newline.
    pub fn table(&self) -> String {
        let findings = &self.check.findings;
        let rows: Vec<[String; 6]> = findings.iter().map(row).collect();
        let heads = ["", "", "value", "limit", "looked at", ""].map(str::to_owned);
        let mut text = format!("{}, limits of --quality {}, {}\n\n", self.scene, self.quality, self.tracer);
        text.push_str(&aligned(&heads, &rows));
        let is_shown = |f: &&Finding| f.tells || matches!(f.verdict, Verdict::Rough | Verdict::Failed);
        let details: Vec<&Finding> =
            findings.iter().filter(is_shown).filter(|f| !f.detail.is_empty()).collect();
        // Writing to a string cannot fail.
        for finding in details {
            let _ = writeln!(text, "\n{}: {}\n  {}", finding.group, finding.name, finding.detail);
        }
        let kinds: Vec<[String; 4]> = self
            .check
            .kinds
            .iter()
            .map(|kind| {
                let shares = [kind.linked, kind.found].map(|share| format!("{:.3} %", 100.0 * share));
                let off = format!("{:+.3} %", 100.0 * (kind.linked - kind.found));
                let [linked, found] = shares;
                [kind.name.clone(), linked, found, off]
            })
            .collect();
        text.push('\n');
        let heads = ["light from element or cluster", "by links", "by rays", "difference"];
        text.push_str(&aligned(&heads.map(str::to_owned), &kinds));
        let count = |verdict| findings.iter().filter(|finding| finding.verdict == verdict).count();
        let _ = writeln!(
            text,
            "\n{} of {} passed, {} rough, {} failed, {} not looked at",
            count(Verdict::Passed),
            findings.len(),
            count(Verdict::Rough),
            count(Verdict::Failed),
            count(Verdict::NotLookedAt)
        );
        text
    }
}

/// Group, name, value, limit, number looked at, verdict.
fn row(finding: &Finding) -> [String; 6] {
    let figure = |value: f64| match finding.unit {
        Unit::Count => format!("{value:.0}"),
        Unit::Share => format!("{:.4} %", 100.0 * value),
    };
    let verdict = match finding.verdict {
        Verdict::Passed => "passed",
        Verdict::Rough => "rough",
        Verdict::Failed => "FAILED",
        Verdict::NotLookedAt => "not looked at",
    };
    [
        finding.group.to_owned(),
        finding.name.to_owned(),
        figure(finding.value),
        figure(finding.limit),
        finding.looked_at.to_string(),
        verdict.to_owned(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::KindOfLink;

    fn finding(name: &'static str, value: f64, verdict: Verdict) -> Finding {
        let detail = format!("at {name}");
        Finding {
            group: "light",
            name,
            unit: Unit::Share,
            value,
            limit: 0.01,
            verdict,
            looked_at: 9,
            detail,
            tells: false,
        }
    }

    fn sample() -> Check {
        Check {
            findings: vec![
                finding("one", 0.005, Verdict::Passed),
                finding("two", 0.02, Verdict::Rough),
                finding("three", f64::NAN, Verdict::Failed),
                finding("four", 0.0, Verdict::NotLookedAt),
            ],
            kinds: vec![KindOfLink { name: "no link".into(), linked: 0.0, found: 0.001 }],
        }
    }

    #[test]
    fn the_table_has_every_finding_and_the_place_of_those_that_did_not_pass() {
        let check = sample();
        let report = CheckReport {
            scene: "room",
            quality: "draft",
            tracer: "fallback",
            passed: check.passed(),
            check: &check,
        };
        let text = report.table();
        let last = "1 of 4 passed, 1 rough, 1 failed, 1 not looked at";
        for part in
            ["0.5000 %", "rough", "FAILED", "at two", "at three", "-0.100 %", "9  not looked at", last]
        {
            assert!(text.contains(part), "{part} is missing:\n{text}");
        }
        assert!(!text.contains("at one") && !text.contains("at four"), "{text}");
        let value = serde_json::to_value(&report).expect("serialisable");
        assert_eq!(value["passed"], false);
        assert_eq!(value["findings"][1]["verdict"], "rough");
        assert!(value["findings"][2]["value"].is_null());
    }
}
