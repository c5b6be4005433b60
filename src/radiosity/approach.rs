//! How far iteration has come, and how to get there sooner.
//!
//! What is still to come follows from how much less changes every time. Where surfaces are bright that is hardly less: of
//! what changes, all but a few per cent changes again. Once it is known how slowly that fades, each iteration goes further
//! than it would by itself, away from the light before: Chebyshev's semi-iteration, which needs about the square root of
//! the iterations. How slowly changes fade is learnt on the way, from what is left of them (Golub and Varga, *Chebyshev
//! semi-iterative methods*, 1961; Hageman and Young, *Applied Iterative Methods*, 1981, chapters 4 to 6).

use super::transport::{Damping, Further};
use crate::progress::Progress;
use glam::Vec3;

/// Changes are taken to shrink at least by this factor.
const SLOWEST: f64 = 0.999;

/// So many iterations of a run tell whether it is as fast as it should be.
const TELLING: i32 = 4;

/// Changes of this share of all light are rounding.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// A run that is slower than this share of the speed it should have, in digits an iteration, begins anew.
const SLOW: f64 = 0.75;

/// How near the light is to where iteration takes it.
pub(super) struct Approach {
    /// Power still to come that is little enough.
    little: f64,
    /// Power that changed in the last iteration; `None` before what changes now has begun to.
    change: Option<f64>,
    /// Power still to come.
    to_come: f64,
    /// The most that it has been.
    most: f64,
    /// The share of what changes that changes again, as far as it is known.
    fading: f64,
    /// Iterations that go further than they would by themselves.
    run: Option<Run>,
    /// What surfaces sent out one iteration ago, which the next goes further away from; empty where it does not.
    before: Vec<Vec3>,
    /// Whether the last has.
    went_further: bool,
    /// Whether such iterations have not helped.
    walks: bool,
    /// Parts of the way that the bar shows; `None` while it shows something else.
    pub(super) shown: Option<u64>,
}

/// Iterations of Chebyshev's, for one estimate of how changes fade.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Power that changed when it began.
    first: f64,
    /// Iterations since then.
    count: i32,
    /// How far the next goes, where 1 is as far as by itself.
    reach: f64,
}

impl Run {
    /// What is left of changes after the iterations so far, if no more of them than `fading` changes again.
    fn left(&self, fading: f64) -> f64 {
        1.0 / (f64::from(self.count) * (1.0 / fading).acosh()).cosh()
    }

    /// How changes fade, when this share of them is left.
    fn fading(&self, assumed: f64, left: f64) -> f64 {
        assumed * ((left / self.left(assumed)).max(1.0).acosh() / f64::from(self.count)).cosh()
    }
}

impl Approach {
    /// Parts of the way, as progress shows them.
    const STEPS: f64 = 1000.0;

    pub(super) fn new(little: f64) -> Approach {
        Approach {
            little,
            change: None,
            to_come: f64::MAX,
            most: 0.0,
            fading: 0.0,
            run: None,
            before: Vec::new(),
            went_further: false,
            walks: false,
            shown: None,
        }
    }

    /// Whether the light is there, and what surfaces send out is what they receive.
    pub(super) fn has_arrived(&self) -> bool {
        self.to_come <= self.little && !self.went_further
    }

    /// Whether no more than this power is still to come.
    pub(super) fn is_within(&self, power: f64) -> bool {
        self.to_come <= power
    }

    /// What changes now begins anew: how fast that shrinks is known after two iterations.
    pub(super) fn disturb(&mut self) {
        self.to_come = f64::MAX;
        self.change = None;
        self.run = None;
        self.before = Vec::new();
        self.walks = false;
        self.shown = None;
    }

    /// How much further the next iteration goes than by itself, as a share of what it changes since the light before
    /// the last.
    fn ahead(&self) -> f32 {
        self.run.map_or(0.0, |run| run.reach - 1.0) as f32
    }

    /// How much further the next iteration goes, from the light that [`Self::leave`] has left behind.
    pub(super) fn further(&self) -> Further<'_> {
        Further { than: &self.before, by: self.ahead() }
    }

    /// Keeps what surfaces sent out before the last iteration, if the next goes further away from it.
    pub(super) fn leave(&mut self, exitance: Vec<Vec3>) {
        self.before = if self.run.is_some() { exitance } else { Vec::new() };
    }

    /// The way done, of [`Self::STEPS`]; changes shrink by the same factor every time.
    fn done(&self) -> u64 {
        let way = (self.most / self.little.max(f64::MIN_POSITIVE)).ln();
        let left = (self.to_come / self.little.max(f64::MIN_POSITIVE)).ln();
        if way > 0.0 { ((1.0 - left / way).clamp(0.0, 1.0) * Self::STEPS) as u64 } else { 0 }
    }

    /// Iterations begin, or go on.
    pub(super) fn show(&mut self, progress: &dyn Progress) {
        self.shown.get_or_insert_with(|| {
            progress.start("gather", Self::STEPS as u64);
            0
        });
    }

    /// One iteration changed this much power of what surfaces send out, without what it went further.
    pub(super) fn step(&mut self, change: f64, sent: f64, progress: &dyn Progress) {
        let had_gone_further = std::mem::replace(&mut self.went_further, self.run.is_some());
        let before = self.change.replace(change);
        let Some(before) = before else { return };
        let factor = change / before;
        let again = if self.went_further { self.fading } else { factor.max(self.fading).min(SLOWEST) };
        self.to_come = if change <= ROUNDING * sent { 0.0 } else { change * again / (1.0 - again) };
        self.most = self.most.max(self.to_come);
        self.run = match self.run {
            _ if self.walks => None,
            // What is left after an iteration that went further says nothing of how changes fade.
            None => self.begun(change, if had_gone_further { self.fading } else { factor }),
            Some(run) => self.gone_on(run, change),
        };
        let done = self.done();
        let shown = self.shown.unwrap_or(0);
        progress.advance(done.saturating_sub(shown));
        self.shown = Some(done.max(shown));
    }

    /// A run, where it gets further than iterations by themselves, which leave this share of changes.
    fn begun(&mut self, change: f64, factor: f64) -> Option<Run> {
        if self.to_come <= self.little || factor >= 1.0 {
            return None;
        }
        let fading = self.fading.max(factor).min(f64::from(Damping::MOST));
        let speed = (1.0 - (1.0 - fading * fading).sqrt()) / fading;
        (factor > speed).then(|| {
            self.fading = fading;
            Run { first: change, count: 1, reach: 2.0 / (2.0 - fading * fading) }
        })
    }

    /// The run, if it goes on.
    fn gone_on(&mut self, run: Run, change: f64) -> Option<Run> {
        // The last iteration goes no further, so that all light is what links bring.
        if self.to_come <= self.little {
            return None;
        }
        let left = change / run.first;
        if run.count >= TELLING && left > run.left(self.fading).powf(SLOW) {
            self.walks = left >= 1.0;
            if left < 1.0 {
                self.fading = run.fading(self.fading, left).min(f64::from(Damping::MOST));
            }
            return None;
        }
        let reach = 4.0 / (4.0 - self.fading * self.fading * run.reach);
        Some(Run { count: run.count + 1, reach, ..run })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    /// Iterates lights that are each reflected into themselves by a share, from nothing; how many iterations it takes, and
    /// how far all light together is off, relative to what comes of it.
    fn settled(shares: &[f64], helped: bool) -> (u32, f64) {
        let mut approach = Approach { walks: !helped, ..Approach::new(1e-6) };
        let (mut light, mut before) = (vec![0.0; shares.len()], vec![0.0; shares.len()]);
        let mut count = 0;
        while !approach.has_arrived() && count < 10_000 {
            let ahead = f64::from(approach.ahead());
            let bounced: Vec<f64> =
                light.iter().zip(shares).map(|(light, share)| 1.0 + share * light).collect();
            let change: f64 = bounced.iter().zip(&light).map(|(after, before)| (after - before).abs()).sum();
            let next =
                bounced.iter().zip(&before).map(|(bounced, before)| bounced + (bounced - before) * ahead);
            before = std::mem::replace(&mut light, next.collect());
            approach.step(change, light.iter().sum(), &Silent);
            count += 1;
            if approach.has_arrived() {
                assert_eq!(ahead, 0.0, "the last iteration goes no further than by itself");
            }
        }
        let exact: Vec<f64> = shares.iter().map(|share| 1.0 / (1.0 - share)).collect();
        let off: f64 = light.iter().zip(&exact).map(|(light, exact)| (light - exact).abs()).sum();
        (count, off / exact.iter().sum::<f64>())
    }

    #[test]
    fn bright_rooms_settle_in_far_fewer_iterations() {
        for slowest in [0.5, 0.8, 0.9, 0.97, 0.99] {
            let shares = [slowest, 0.7 * slowest, 0.3, 0.0, -0.2, -0.6 * slowest];
            let ((alone, off_alone), (helped, off)) = (settled(&shares, false), settled(&shares, true));
            // The square root of as many, and what it takes to learn how changes fade.
            let most = 8.0 * f64::from(alone).sqrt();
            assert!(helped < alone && f64::from(helped) < most, "{slowest}: {helped} for {alone}");
            assert!(off_alone < 1e-5 && off < 1e-5, "{slowest}: {off_alone}, {off}");
        }
    }

    #[test]
    fn what_goes_round_in_a_circle_settles_all_the_same() {
        // Three surfaces that light each other in turn: a run goes away from that light, and is given up.
        let mut approach = Approach::new(1e-6);
        let (mut light, mut before) = ([0.0f64; 3], [0.0f64; 3]);
        let mut count = 0;
        while !approach.has_arrived() && count < 10_000 {
            let ahead = f64::from(approach.ahead());
            let bounced: [f64; 3] = std::array::from_fn(|i| f64::from(i == 0) + 0.95 * light[(i + 2) % 3]);
            let change = (0..3).map(|i| (bounced[i] - light[i]).abs()).sum();
            let next = std::array::from_fn(|i| bounced[i] + (bounced[i] - before[i]) * ahead);
            before = std::mem::replace(&mut light, next);
            approach.step(change, light.iter().sum(), &Silent);
            count += 1;
        }
        let off = (light.iter().sum::<f64>() - 20.0).abs() / 20.0;
        assert!(off < 1e-5 && count < 1000, "{off} after {count}");
    }
}
