//! A profile in words: what most come for, first.

use super::super::detail::Seconds;
use super::super::text::counted;
use super::{Profile, ProfiledRun, SAME};

/// Whole solutions whose times differ by no more than this share are as quick as each other.
const AS_QUICK: f64 = 0.05;

fn seconds(run: &ProfiledRun) -> f64 {
    run.visibility_seconds.median
}

fn total(run: &ProfiledRun) -> f64 {
    run.total_seconds.median
}

fn error(run: &ProfiledRun) -> f64 {
    run.visibility_error.mean
}

impl Profile {
    /// The cheapest run at equal error and what its whole solution takes, or how long the one run took; then what lost all
    /// light. A paragraph each.
    pub(in super::super) fn headline(&self) -> Vec<String> {
        match &self.runs[..] {
            [] => Vec::new(),
            [only] => only.words().into_iter().chain(self.lost()).collect(),
            _ => self.cheapest().into_iter().chain(self.lost()).collect(),
        }
    }

    /// The cheapest of all runs that are no further off than the aim, by their time in visibility, and where its time goes;
    /// then the whole solutions, which may say otherwise. Nothing where the aim lost all light.
    fn cheapest(&self) -> Vec<String> {
        let Some(aim) = self.runs.get(self.aim).filter(|aim| aim.has_light()) else { return Vec::new() };
        let is_exact = |run: &&ProfiledRun| run.has_light() && error(run) <= error(aim) * (1.0 + SAME);
        let least = |time: fn(&ProfiledRun) -> f64| {
            self.runs.iter().filter(is_exact).min_by(|a, b| time(a).total_cmp(&time(b)))
        };
        let (Some(cheapest), Some(quickest)) = (least(seconds), least(total)) else { return Vec::new() };
        let of_aim = |time: fn(&ProfiledRun) -> f64, run| time(run) / time(aim).max(f64::MIN_POSITIVE);
        let is_aim = std::ptr::eq(cheapest, aim);
        let against = match is_aim {
            true => "which is the aim itself".to_owned(),
            false => format!("{:.2} of the time of the aim, {}", of_aim(seconds, cheapest), aim.name()),
        };
        let step = cheapest.detail.largest_step().map_or_else(String::new, |(name, share)| {
            format!(" Of that {:.0} % goes to {name}, the largest step.", 100.0 * share)
        });
        let first = format!(
            "Cheapest at equal error: {} with {:.3} s in visibility, {against}, and an error of {:.3} %.{step}",
            cheapest.name(),
            seconds(cheapest),
            100.0 * error(cheapest)
        );
        let mut whole = format!("Its whole solution takes {:.2} s by the clock", total(cheapest));
        if !is_aim {
            whole += &format!(", {:.2} times that of the aim", of_aim(total, cheapest));
        }
        // Visibility is not all there is: what is cheap there may make more links, or need more iterations.
        whole += &match total(quickest) < (1.0 - AS_QUICK) * total(cheapest) {
            true => format!(
                "; the quickest as a whole at equal error is {} with {:.2} s, of which it has {:.3} s in visibility.",
                quickest.name(),
                total(quickest),
                seconds(quickest)
            ),
            false => ", and none at equal error is clearly quicker as a whole.".to_owned(),
        };
        vec![first, whole]
    }

    /// The runs that have no links, and so no light but that of the lamps.
    fn lost(&self) -> Option<String> {
        let lost: Vec<String> =
            self.runs.iter().filter(|run| !run.has_light()).map(ProfiledRun::name).collect();
        if lost.is_empty() {
            return None;
        }
        let are = if lost.len() == 1 { "It is" } else { "They are" };
        let what = match self.runs.get(self.aim).is_some_and(|aim| !aim.has_light()) && self.runs.len() > 1 {
            true => " The aim is among them: nothing can be compared with it.",
            false => "",
        };
        Some(format!(
            "Without links, so that all light is lost: {}. {are} compared with nothing.{what}",
            lost.join("; ")
        ))
    }
}

impl ProfiledRun {
    /// How long it took, how exact it is, and what took the most.
    fn words(&self) -> Vec<String> {
        let part = |whole: &str, parts: &[Seconds]| {
            let all: f64 = parts.iter().map(|part| part.seconds).sum();
            let most = parts
                .iter()
                .max_by(|a, b| a.seconds.total_cmp(&b.seconds))
                .filter(|most| most.seconds > 0.0)?;
            Some(format!("Of the {whole} {:.0} % goes to {}.", 100.0 * most.seconds / all, most.name))
        };
        let told = format!(
            "{}: {:.3} s in visibility, summed over threads, and {:.2} s in all by the clock; {}{}.",
            self.name(),
            seconds(self),
            total(self),
            counted(self.links, "link"),
            match self.has_light() {
                true => format!(", and the error of visibility is {:.3} %", 100.0 * error(self)),
                false => String::new(),
            }
        );
        let step = part("time in visibility", &self.detail.steps);
        let phase = part("time by the clock", &self.detail.phases);
        [Some(told), step, phase].into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::detail::RunDetail;
    use super::super::Spread;
    use super::super::tests::run;
    use super::*;

    fn profile(runs: Vec<ProfiledRun>, aim: usize) -> Profile {
        Profile { runs, aim, ..Profile::default() }
    }

    #[test]
    fn the_cheapest_of_all_comes_first_with_its_largest_step() {
        let seconds = |name, seconds| Seconds { name, seconds };
        let steps = vec![seconds("points", 0.5), seconds("rays", 1.5)];
        let runs = vec![
            run("adaptive", 4, 1.0, 0.05),
            run("adaptive", 16, 4.0, 0.02),
            ProfiledRun { detail: RunDetail { steps, ..RunDetail::default() }, ..run("root", 64, 2.0, 0.02) },
            run("sampled", 16, 1.0, 0.03),
        ];
        let mut profile = profile(runs, 1);
        let words = profile.headline();
        for part in [
            "root, embree, 64 rays with 2.000 s",
            "0.50 of the time of the aim, adaptive, embree, 16 rays",
            "75 % goes to rays",
        ] {
            assert!(words[0].contains(part), "{part} is missing: {words:?}");
        }
        assert!(
            words[1].contains("takes 4.00 s by the clock, 0.50 times that of the aim, and none"),
            "{words:?}"
        );
        let table = profile.table();
        assert_eq!(table.lines().skip(1).take(2).collect::<Vec<_>>(), words, "{table}");
        profile.aim = 0;
        assert!(profile.headline()[0].contains("which is the aim itself"), "as fast");
    }

    #[test]
    fn a_whole_solution_that_is_slower_is_told() {
        let slow = ProfiledRun { total_seconds: Spread::of(vec![2.3]), ..run("root", 16, 0.4, 0.02) };
        let words = profile(vec![run("adaptive", 16, 0.5, 0.02), slow], 0).headline();
        assert!(words[0].contains("root, embree, 16 rays with 0.400 s"), "{words:?}");
        for part in ["takes 2.30 s by the clock, 2.30 times", "adaptive, embree, 16 rays with 1.00 s"] {
            assert!(words[1].contains(part), "{part} is missing: {words:?}");
        }
    }

    #[test]
    fn a_run_without_links_is_called_that_and_never_the_best() {
        let lost = || ProfiledRun { links: 0, ..run("sampled", 8, 0.001, 0.0) };
        let found = profile(vec![run("adaptive", 4, 1.0, 0.05), run("root", 4, 2.0, 0.04), lost()], 0);
        let words = found.headline();
        assert!(words[0].contains("which is the aim itself"), "{words:?}");
        assert!(words.iter().any(|line| line.contains("all light is lost: sampled, embree, 8 rays. It is")));
        let table = found.table();
        assert!(table.contains("sampled, embree: without links"), "{table}");
        let row = table.lines().find(|line| line.starts_with("sampled")).expect("a row");
        assert!(row.contains("no links") && !row.contains(" 0.000 0.00"), "{row}");
        let aim = profile(vec![lost(), run("root", 4, 2.0, 0.04)], 0).headline();
        assert!(aim.len() == 1 && aim[0].contains("The aim is among them"), "{aim:?}");
        let alone = profile(vec![lost()], 0).headline();
        assert!(
            alone[0].contains("0 links.") && !alone.iter().any(|line| line.contains("The aim")),
            "{alone:?}"
        );
    }

    #[test]
    fn one_run_has_words_too() {
        let table = profile(vec![run("adaptive", 4, 1.0, 0.05)], 0).table();
        let words = "adaptive, embree, 4 rays: 1.000 s in visibility, summed over threads, and 2.00 s in all by the clock; \
                     1 link, and the error of visibility is 5.000 %.";
        assert_eq!(table.lines().nth(1), Some(words), "{table}");
    }
}
