//! Illuminance from irradiance in linear RGB.

use glam::DVec3;

/// Luminous efficacy, lm/W: by definition that of light of 555 nm, here given to all luminance.
const EFFICACY: f64 = 683.0;

/// Photometric weights of linear Rec. 709 red, green and blue (ITU-R BT.709).
const WEIGHTS: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Illuminance in lux of an irradiance in W/m².
///
/// The convention: 683 lm/W times the photometric weights of linear Rec. 709. It takes every channel as
/// power that the eye is as sensitive to as its weight says, so 1 W/m² of white is 683 lx. Renderers that
/// reckon with 179 lm/W (daylight spread over the visible spectrum) give 0.262 of that.
pub fn illuminance(irradiance: DVec3) -> f64 {
    EFFICACY * WEIGHTS.dot(irradiance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_watt_of_white_is_683_lux_and_most_of_it_is_green() {
        assert!((illuminance(DVec3::ONE) - 683.0).abs() < 1e-9);
        assert!(
            illuminance(DVec3::Y) > illuminance(DVec3::X) && illuminance(DVec3::X) > illuminance(DVec3::Z)
        );
    }
}
