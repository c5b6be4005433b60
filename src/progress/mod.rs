//! How far a long step has come, told to whoever watches. Steps report to a [`Progress`]; whether
//! that draws a bar ([`TerminalProgress`]) or does nothing ([`Silent`]) is chosen once by the caller.

mod timeline;

pub use timeline::{Span, Timeline};

use std::io::{IsTerminal, Write};
use std::sync::{PoisonError, RwLock};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Receives the progress of one phase after another; called from any thread.
pub trait Progress: Sync {
    /// A phase of `total` units of work begins; 0 when the amount is not known. Ends the one before.
    fn start(&self, phase: &'static str, total: u64);
    /// `done` more units are finished (not the sum so far).
    fn advance(&self, done: u64);
    /// The phase is over, whatever was reported.
    fn finish(&self);
    /// A line for whoever watches, besides how far it has come.
    fn say(&self, _line: &str) {}
    /// The calling thread begins a piece of work of at least some microseconds; see [`Work`].
    fn begin_work(&self) {}
    /// The calling thread has done the piece that it began last; `phase` is what it belongs to.
    fn end_work(&self, _phase: &'static str) {}
}

/// A piece of work of one thread, from when this is made to when it is dropped, on that thread.
pub struct Work<'a> {
    progress: &'a dyn Progress,
    phase: &'static str,
}

impl<'a> Work<'a> {
    /// Begins now, as part of a phase.
    pub fn begin(progress: &'a dyn Progress, phase: &'static str) -> Work<'a> {
        progress.begin_work();
        Work { progress, phase }
    }
}

impl Drop for Work<'_> {
    fn drop(&mut self) {
        self.progress.end_work(self.phase);
    }
}

/// Reports nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn start(&self, _phase: &'static str, _total: u64) {}
    fn advance(&self, _done: u64) {}
    fn finish(&self) {}
}

/// Passes everything on to two others.
pub struct Both<'a>(pub &'a dyn Progress, pub &'a dyn Progress);

impl Progress for Both<'_> {
    fn start(&self, phase: &'static str, total: u64) {
        self.0.start(phase, total);
        self.1.start(phase, total);
    }

    fn advance(&self, done: u64) {
        self.0.advance(done);
        self.1.advance(done);
    }

    fn finish(&self) {
        self.0.finish();
        self.1.finish();
    }

    fn say(&self, line: &str) {
        self.0.say(line);
        self.1.say(line);
    }

    fn begin_work(&self) {
        self.0.begin_work();
        self.1.begin_work();
    }

    fn end_work(&self, phase: &'static str) {
        self.0.end_work(phase);
        self.1.end_work(phase);
    }
}

/// A bar with the remaining time on standard error, one phase at a time, removed when the phase
/// ends. Draws nothing when standard error is not a terminal; lines are written there all the same.
#[derive(Debug)]
pub struct TerminalProgress {
    is_drawn: bool,
    bar: RwLock<Option<ProgressBar>>,
}

impl TerminalProgress {
    /// Looks once whether standard error is a terminal.
    pub fn new() -> Self {
        Self { is_drawn: std::io::stderr().is_terminal(), bar: RwLock::new(None) }
    }

    fn replace(&self, bar: Option<ProgressBar>) {
        let mut slot = self.bar.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(old) = std::mem::replace(&mut *slot, bar) {
            old.finish_and_clear();
        }
    }
}

impl Default for TerminalProgress {
    fn default() -> Self {
        Self::new()
    }
}

impl Progress for TerminalProgress {
    fn start(&self, phase: &'static str, total: u64) {
        if !self.is_drawn {
            return;
        }
        let length = (total > 0).then_some(total);
        let bar = ProgressBar::with_draw_target(length, ProgressDrawTarget::stderr_with_hz(5));
        bar.set_style(style(total > 0));
        bar.set_message(phase);
        self.replace(Some(bar));
    }

    fn advance(&self, done: u64) {
        if let Some(bar) = &*self.bar.read().unwrap_or_else(PoisonError::into_inner) {
            bar.inc(done);
        }
    }

    fn finish(&self) {
        self.replace(None);
    }

    fn say(&self, line: &str) {
        let say = || {
            // Who closed standard error does not want to know.
            let _ = writeln!(std::io::stderr(), "{line}");
        };
        match &*self.bar.read().unwrap_or_else(PoisonError::into_inner) {
            Some(bar) => bar.suspend(say),
            None => say(),
        }
    }
}

impl Drop for TerminalProgress {
    fn drop(&mut self) {
        self.finish();
    }
}

const KNOWN_TOTAL: &str = "{msg:>10} [{bar:30}] {percent:>3}%  {elapsed} elapsed, {eta} left";
const UNKNOWN_TOTAL: &str = "{msg:>10} {spinner} {elapsed} elapsed";

fn style(has_total: bool) -> ProgressStyle {
    let template = if has_total { KNOWN_TOTAL } else { UNKNOWN_TOTAL };
    // A template we cannot parse is our fault, and the default bar is still a bar.
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_parse() {
        for template in [KNOWN_TOTAL, UNKNOWN_TOTAL] {
            assert!(ProgressStyle::with_template(template).is_ok(), "{template}");
        }
    }

    #[test]
    fn phases_may_overlap_and_be_advanced_from_threads() {
        let progress = TerminalProgress { is_drawn: true, bar: RwLock::new(None) };
        // A hidden bar in place of a drawn one: the test must not write on the terminal.
        progress.replace(Some(ProgressBar::hidden()));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..100).for_each(|_| progress.advance(2)));
            }
        });
        let position =
            progress.bar.read().unwrap_or_else(PoisonError::into_inner).as_ref().map(ProgressBar::position);
        assert_eq!(position, Some(800));
        progress.finish();
        progress.advance(1);
        assert!(progress.bar.read().unwrap_or_else(PoisonError::into_inner).is_none());
    }

    #[test]
    fn nothing_is_kept_when_not_a_terminal() {
        let progress = TerminalProgress { is_drawn: false, bar: RwLock::new(None) };
        progress.start("refine", 10);
        progress.advance(3);
        assert!(progress.bar.read().unwrap_or_else(PoisonError::into_inner).is_none());
    }
}
