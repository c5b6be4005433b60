//! The sRGB transfer function (IEC 61966-2-1), both ways.

/// Linear `[0, 1]` to encoded `[0, 1]`.
pub fn srgb_from_linear(linear: f32) -> f32 {
    // 1.055 p − 0.055, arranged so that 1 gives exactly 1.
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.0 + 1.055 * (linear.powf(1.0 / 2.4) - 1.0) }
}

/// Encoded `[0, 1]` to linear `[0, 1]`.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_is_the_standard_one() {
        for (linear, encoded) in [(0.0, 0.0), (0.001, 0.012_92), (0.214_041_14, 0.5), (1.0, 1.0)] {
            assert!((srgb_from_linear(linear) - encoded).abs() < 1e-5, "{linear}");
        }
        let joint = 0.003_130_8;
        assert!((srgb_from_linear(joint) - srgb_from_linear(joint + 1e-6)).abs() < 1e-4);
    }

    #[test]
    fn a_byte_there_and_back_is_the_same() {
        for byte in 0..=255u8 {
            let linear = linear_from_srgb(f32::from(byte) / 255.0);
            assert_eq!((255.0 * srgb_from_linear(linear)).round() as u8, byte);
        }
    }
}
