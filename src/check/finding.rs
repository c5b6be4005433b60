//! One line of the answer: what was measured, and whether it is as it should be.

use super::limits::Limits;
use serde::Serialize;

/// What a value counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Things.
    Count,
    /// A part of a whole, relative to 1.
    Share,
}

/// What a finding means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Within the limit.
    Passed,
    /// Beyond the limit of an approximation, in a draft.
    Rough,
    /// Beyond the limit.
    Failed,
    /// There was nothing to look at.
    #[serde(rename = "not looked at")]
    NotLookedAt,
}

/// One thing that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// `links`, `form factors` or `light`.
    pub group: &'static str,
    /// What is measured.
    pub name: &'static str,
    /// What the value counts.
    pub unit: Unit,
    /// The value.
    pub value: f64,
    /// The largest value that passes.
    pub limit: f64,
    /// What that means.
    pub verdict: Verdict,
    /// Things that were looked at.
    pub looked_at: u64,
    /// The worst place, or more about the value; empty when there is nothing to say.
    pub detail: String,
    /// The detail is worth showing even when nothing is wrong.
    #[serde(skip)]
    pub tells: bool,
}

impl Finding {
    /// Something of which there must be none.
    pub(super) fn none(group: &'static str, name: &'static str, count: u64) -> Finding {
        Finding { unit: Unit::Count, ..Finding::share(group, name, count as f64, 0.0) }
    }

    /// A share that must not exceed its limit.
    pub(super) fn share(group: &'static str, name: &'static str, value: f64, limit: f64) -> Finding {
        // The sum of nothing is -0.
        let value = value + 0.0;
        // What is not a number is not within the limit.
        let verdict = if value <= limit { Verdict::Passed } else { Verdict::Failed };
        let (unit, looked_at, detail) = (Unit::Share, 0, String::new());
        Finding { group, name, unit, value, limit, verdict, looked_at, detail, tells: false }
    }

    /// With the number of things that were looked at; of none nothing passes.
    pub(super) fn of(mut self, looked_at: u64) -> Finding {
        self.looked_at = looked_at;
        if looked_at == 0 && self.verdict == Verdict::Passed {
            self.verdict = Verdict::NotLookedAt;
        }
        self
    }

    /// As an approximation, which may be rough unless the limits are binding.
    pub(super) fn unless_rough(mut self, limits: &Limits) -> Finding {
        if self.verdict == Verdict::Failed && self.value.is_finite() && !limits.is_binding {
            self.verdict = Verdict::Rough;
        }
        self
    }

    /// With a detail that is worth showing even when nothing is wrong.
    pub(super) fn telling(mut self) -> Finding {
        self.tells = true;
        self
    }

    /// With the worst place, if there is one.
    pub(super) fn at(mut self, detail: Option<String>) -> Finding {
        self.detail = detail.unwrap_or_default();
        self
    }
}

/// Root of a mean square from which noise was taken off; what is not a number stays none.
pub(super) fn root(square: f64) -> f64 {
    if square < 0.0 { 0.0 } else { square.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_fails_even_in_a_draft() {
        let finding = |value| Finding::share("light", "a", value, 0.1);
        assert_eq!(finding(0.1).verdict, Verdict::Passed);
        assert_eq!(finding(0.2).verdict, Verdict::Failed);
        assert_eq!(finding(0.2).unless_rough(&Limits::DRAFT).verdict, Verdict::Rough);
        assert_eq!(finding(0.2).unless_rough(&Limits::NORMAL).verdict, Verdict::Failed);
        assert_eq!(finding(f64::NAN).unless_rough(&Limits::DRAFT).verdict, Verdict::Failed);
    }

    #[test]
    fn roots_of_noise_are_nothing_and_of_no_number_none() {
        assert_eq!([root(-1e-9), root(0.0), root(4.0)], [0.0, 0.0, 2.0]);
        assert!(root(f64::NAN).is_nan() && root(f64::INFINITY).is_infinite());
    }

    #[test]
    fn what_looked_at_nothing_does_not_pass() {
        let finding = |value, count| Finding::share("light", "a", value, 0.1).of(count).verdict;
        assert_eq!(finding(0.0, 0), Verdict::NotLookedAt);
        assert_eq!(finding(0.0, 1), Verdict::Passed);
        assert_eq!(finding(f64::NAN, 0), Verdict::Failed);
        assert_eq!(
            Finding::none("light", "a", 0).of(0).unless_rough(&Limits::DRAFT).verdict,
            Verdict::NotLookedAt
        );
        assert_eq!(serde_json::to_value(Verdict::NotLookedAt).expect("JSON"), "not looked at");
    }
}
