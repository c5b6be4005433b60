//! How far iteration has come: what is still to come follows from how much less changes every time.

use crate::progress::Progress;

/// Changes are taken to shrink at least by this factor.
const SLOWEST: f64 = 0.999;

/// How near the light is to where iteration takes it.
pub(super) struct Approach {
    /// Power still to come that is little enough.
    little: f64,
    /// Power that changed in the last iteration.
    change: f64,
    /// Power still to come.
    to_come: f64,
    /// The most that it has been.
    most: f64,
    /// Parts of the way that the bar shows; `None` while it shows something else.
    pub(super) shown: Option<u64>,
}

impl Approach {
    /// Parts of the way, as progress shows them.
    const STEPS: f64 = 1000.0;

    pub(super) fn new(little: f64) -> Approach {
        Approach { little, change: f64::MAX, to_come: f64::MAX, most: 0.0, shown: None }
    }

    pub(super) fn has_arrived(&self) -> bool {
        self.to_come <= self.little
    }

    /// What changes now begins anew: how fast that shrinks is known after two iterations.
    pub(super) fn disturb(&mut self) {
        self.to_come = f64::MAX;
        self.shown = None;
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

    /// One iteration changed this much power.
    pub(super) fn step(&mut self, change: f64, progress: &dyn Progress) {
        let factor = (change / self.change).min(SLOWEST);
        self.change = change;
        self.to_come = change * factor / (1.0 - factor);
        self.most = self.most.max(self.to_come);
        let done = self.done();
        let shown = self.shown.unwrap_or(0);
        progress.advance(done.saturating_sub(shown));
        self.shown = Some(done.max(shown));
    }
}
