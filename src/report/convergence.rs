//! Error against time: one solution of a scene after the other, each more exact, and how far each is from a
//! reference.

use crate::probe::Deviation;
use serde::Serialize;

/// All solutions of one scene.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Convergence {
    /// The scene's name.
    pub scene: String,
    /// What cast the rays.
    pub tracer: String,
    /// How many points were compared.
    pub points: usize,
    /// From the coarsest setting to the finest.
    pub rungs: Vec<Rung>,
}

/// One solution.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rung {
    /// As `--epsilon`.
    pub epsilon: f64,
    /// Share of a receiver's irradiance above which its shadows are followed.
    pub contrast: f64,
    /// Elements across two walls of a room, at most.
    pub resolution: f64,
    /// As `--rays`.
    pub rays: u32,
    /// Elements of the solution.
    pub elements: u64,
    /// Links of the solution.
    pub links: u64,
    /// Wall-clock seconds of refinement and iteration.
    pub seconds: f64,
    /// Largest resident memory so far, bytes: it never falls from one setting to the next.
    pub peak_rss_bytes: u64,
    /// Energy balance of the solution.
    pub balance_error: f64,
    /// All light against the reference.
    pub total: Deviation,
    /// Light straight from emitters against the reference.
    pub direct: Deviation,
}

impl Convergence {
    /// For people; errors and bias in per cent of the mean irradiance.
    pub fn table(&self) -> String {
        let mut text = format!("{}: {} points, tracer {}\n", self.scene, self.points, self.tracer);
        text +=
            " epsilon  rays  elements      links  time (s)  memory (MB)  balance (%)  error (%)  bias (%)\n";
        for rung in &self.rungs {
            text += &format!(
                "{:8.1e}  {:4}  {:8}  {:9}  {:8.2}  {:11}  {:11.2}  {:9.2}  {:+8.2}\n",
                rung.epsilon,
                rung.rays,
                rung.elements,
                rung.links,
                rung.seconds,
                rung.peak_rss_bytes >> 20,
                100.0 * rung.balance_error,
                100.0 * rung.total.rms,
                100.0 * rung.total.bias
            );
        }
        text
    }
}
