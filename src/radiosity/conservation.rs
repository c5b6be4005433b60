//! No light is lost or made on the way: what surfaces send out arrives, but for what rays find to escape.
//!
//! Links get a per cent or two of it wrong in a draft, and bounces multiply that: where all surfaces reflect 0.9, light
//! that is lost or made in one flight is so ten times over. So all that surfaces receive is scaled by one factor. Where
//! much light escapes, rays know less about the rest than links do: the factor follows what is beyond their noise.

use super::flight::{Flight, flight};
use super::forest::Forest;
use super::transport::Light;
use crate::hierarchy::Hierarchy;
use crate::tracer::Tracer;

/// The factor stays within this and its inverse: beyond, links do not say where light goes.
const MOST: f64 = 2.0;

/// Half of what is off by this many standard errors of the rays is corrected, of less hardly any.
const NOISE: f64 = 3.0;

/// What light that is received is scaled by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conservation {
    /// The factor.
    pub(super) factor: f32,
    /// Where all light goes; `None` before rays have found it.
    flight: Option<Flight>,
}

impl Conservation {
    /// Nothing is known yet but a factor to begin with: that of the light before, or 1.
    pub(super) fn beginning_with(factor: f32) -> Conservation {
        Conservation { factor, flight: None }
    }

    /// Finds with rays how much light ends on surfaces, if nothing is known or light has `changed`.
    pub(super) fn look(
        &mut self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        light: &Light,
        tracer: &dyn Tracer,
        changed: bool,
    ) {
        if changed || self.flight.is_none() {
            self.flight = Some(flight(hierarchy, forest, light, tracer));
        }
    }

    /// Corrects the factor by what came of the light `before` an iteration `after` it.
    pub(super) fn follow(&mut self, forest: &Forest, before: &Light, after: &Light) {
        let Some(flight) = self.flight else { return };
        let landing = (1.0 - flight.escaped - flight.on_backs).max(0.0);
        let over_links = after.received(forest) / f64::from(self.factor);
        let off = landing * before.sent(forest) / over_links - 1.0;
        let noise = NOISE * NOISE * (1.0 - landing) / (landing * f64::from(flight.rays));
        let share = off * off / (off * off + noise);
        // Nothing is off, or nothing is on its way.
        let factor = if share.is_finite() { 1.0 + off * share } else { 1.0 };
        self.factor = factor.clamp(1.0 / MOST, MOST) as f32;
    }
}
