//! Light of every leaf element: finite, not negative, not darker than it shines by itself, and what its
//! links bring.

use super::carried::irradiance;
use super::flights::{Flights, Landing};
use super::subject::Subject;

/// An element that receives less than its links carry by more than this share had light held back;
/// below, it is the light that still changes.
const HELD_BACK: f32 = 1e-3;

/// What is wrong with the light of single leaf elements.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Elements {
    /// Whose exitance or irradiance is negative or no finite number, and one of them.
    pub(super) not_finite: u64,
    pub(super) one_not_finite: Option<u32>,
    /// Whose exitance is below their emission in some channel, and one of them.
    pub(super) darker: u64,
    pub(super) one_darker: Option<u32>,
    /// Largest relative difference between exitance and emission + reflectance × irradiance, and where.
    pub(super) reflection: f64,
    pub(super) one_reflection: Option<u32>,
}

pub(super) fn elements(subject: &Subject<'_>) -> Elements {
    let light = &subject.solution.light;
    let mut found = Elements::default();
    for &leaf in &subject.leaves {
        let (emitted, reflectance) = subject.surface_of(leaf);
        let (exitance, irradiance) = (light.exitance[leaf as usize], light.irradiance[leaf as usize]);
        let is_right = |v: glam::Vec3| v.is_finite() && v.min_element() >= 0.0;
        if !is_right(exitance) || !is_right(irradiance) {
            found.not_finite += 1;
            found.one_not_finite.get_or_insert(leaf);
            continue;
        }
        if (exitance - emitted).min_element() < 0.0 {
            found.darker += 1;
            found.one_darker.get_or_insert(leaf);
        }
        let expected = emitted + reflectance * irradiance;
        let largest = expected.max(exitance).max_element().max(f32::MIN_POSITIVE);
        let off = ((exitance - expected).abs().max_element() / largest) as f64;
        if off > found.reflection {
            (found.reflection, found.one_reflection) = (off, Some(leaf));
        }
    }
    found
}

/// Irradiance of the solution against what its links carry: power, local areas.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Residual {
    /// Of elements that received less than their links carry: light held back.
    pub(super) withheld: f64,
    /// Element with the most of it.
    pub(super) most_withheld: Option<u32>,
    /// Of all others, more and less.
    pub(super) changing: f64,
}

pub(super) fn residual(subject: &Subject<'_>) -> Residual {
    let light = &subject.solution.light;
    let carried = irradiance(subject);
    let (mut found, mut most) = (Residual::default(), 0.0);
    for &leaf in &subject.leaves {
        let received = light.irradiance[leaf as usize];
        let gain = subject.solution.gains.of(leaf) * subject.solution.factor;
        let carried = carried[leaf as usize] * gain;
        let less = (carried - received).element_sum();
        if less > HELD_BACK * carried.element_sum() {
            let power = less as f64 * subject.area(leaf);
            found.withheld += power;
            if power > most {
                (most, found.most_withheld) = (power, Some(leaf));
            }
        } else {
            found.changing += (carried - received).abs().element_sum() as f64 * subject.area(leaf);
        }
    }
    found
}

/// Where the light of all surfaces goes: power, local areas.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Balance {
    /// By all surfaces, emitted or reflected.
    pub(super) sent: f64,
    /// By themselves.
    pub(super) emitted: f64,
    /// By all surfaces, over links.
    pub(super) received: f64,
    /// By rays.
    pub(super) escaped: f64,
    /// By rays, on backs that take no part.
    pub(super) on_backs: f64,
}

impl Balance {
    pub(super) fn of(subject: &Subject<'_>, flights: &Flights) -> Balance {
        let irradiance = &subject.solution.light.irradiance;
        let mut balance = Balance {
            sent: flights.sent(),
            escaped: flights.power_of(|flight| flight.landing == Landing::Escaped),
            on_backs: flights.power_of(|flight| flight.landing == Landing::OnBack),
            ..Balance::default()
        };
        for &leaf in &subject.leaves {
            let over_links = irradiance[leaf as usize].element_sum() / subject.solution.factor;
            balance.received += over_links as f64 * subject.area(leaf);
            balance.emitted += subject.surface_of(leaf).0.element_sum() as f64 * subject.area(leaf);
        }
        balance
    }

    /// A power relative to all that is sent.
    pub(super) fn share(&self, power: f64) -> f64 {
        power / self.sent.max(f64::MIN_POSITIVE)
    }

    /// Power that is lost between leaving and arriving; negative when it is made.
    pub(super) fn lost(&self) -> f64 {
        self.sent - self.escaped - self.on_backs - self.received
    }
}
