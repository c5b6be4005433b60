//! From linear radiance to the 8 bits of a screen: exposure, a tone curve that keeps colours, sRGB
//! and a dither against banding.

use super::picture::{Picture, luminance};
use crate::math::srgb_from_linear;

/// How radiance is scaled before the tone curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Chosen from the picture by [`automatic_exposure`].
    Automatic,
    /// This multiplier on linear radiance, finite and > 0; doubling it is one stop brighter.
    Fixed(f32),
}

impl Exposure {
    /// The multiplier on linear radiance for `picture`.
    pub fn multiplier(self, picture: &Picture) -> f32 {
        match self {
            Exposure::Automatic => automatic_exposure(picture),
            Exposure::Fixed(multiplier) => multiplier,
        }
    }
}

/// What the log-average of a picture is exposed to: photography's middle grey.
const MIDDLE_GREY: f32 = 0.18;
/// Part of the lit pixels at either end that the log-average leaves out.
const TRIMMED: f32 = 0.05;
/// The quantile that is kept below [`BRIGHT_LIMIT`], so that a room seen from a dark corner does not
/// burn out.
const BRIGHT_QUANTILE: f32 = 0.75;
const BRIGHT_LIMIT: f32 = 0.8;

/// The multiplier that exposes the lit part of `picture` well.
///
/// Pixels that are black or not finite do not count (background). Of the rest the log-average,
/// without the darkest and the brightest twentieth, becomes middle grey: so a small lamp has no
/// influence however bright it is. Three quarters of the lit pixels stay below the shoulder's upper
/// part. 1 when nothing is lit. Scaling the picture by k scales the answer by 1/k.
pub fn automatic_exposure(picture: &Picture) -> f32 {
    let mut lit: Vec<f32> =
        picture.pixels.iter().map(|&p| luminance(p)).filter(|&l| l > 0.0 && l.is_finite()).collect();
    if lit.is_empty() {
        return 1.0;
    }
    lit.sort_unstable_by(f32::total_cmp);
    let cut = (lit.len() as f32 * TRIMMED) as usize;
    let middle = &lit[cut..lit.len() - cut];
    let log_sum: f64 = middle.iter().map(|&l| f64::from(l).ln()).sum();
    let log_average = (log_sum / middle.len() as f64).exp() as f32;
    let bright = lit[((lit.len() - 1) as f32 * BRIGHT_QUANTILE) as usize];
    let multiplier = (MIDDLE_GREY / log_average).min(BRIGHT_LIMIT / bright);
    if multiplier.is_finite() && multiplier > 0.0 { multiplier } else { 1.0 }
}

/// Where the tone curve leaves the straight line.
const KNEE: f32 = 0.45;

/// The tone curve: the identity up to [`KNEE`], then an exponential shoulder towards 1 that
/// continues it with the same slope.
fn curve(x: f32) -> f32 {
    if x <= KNEE { x } else { KNEE + (1.0 - KNEE) * (1.0 - (-(x - KNEE) / (1.0 - KNEE)).exp()) }
}

/// Maps exposed linear RGB to displayable linear RGB in `[0, 1]`.
///
/// The curve is applied to the largest channel and the others follow, so hue and saturation stay;
/// what the shoulder compresses strongly turns white, as a lamp does on film. Values that are
/// negative or not a number count as 0, infinity as very bright.
pub fn tone_map(rgb: [f32; 3]) -> [f32; 3] {
    let rgb = rgb.map(|c| if c > 0.0 { c.min(1e30) } else { 0.0 });
    let peak = rgb[0].max(rgb[1]).max(rgb[2]);
    if peak <= KNEE {
        return rgb;
    }
    let mapped = curve(peak);
    let scale = mapped / peak;
    let whiteness = (1.0 - scale) * (1.0 - scale);
    rgb.map(|c| {
        let kept = c * scale;
        (kept + (mapped - kept) * whiteness).clamp(0.0, 1.0)
    })
}

/// How exposed radiance becomes displayable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// With [`tone_map`].
    Filmic,
    /// As it is, up to 1; what is brighter is cut off, channel by channel.
    Plain,
}

impl Tone {
    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Tone::Filmic => "filmic",
            Tone::Plain => "plain",
        }
    }

    /// Exposed linear RGB as displayable linear RGB in `[0, 1]`; what is not a number counts as 0.
    pub fn displayable(self, rgb: [f32; 3]) -> [f32; 3] {
        match self {
            Tone::Filmic => tone_map(rgb),
            Tone::Plain => rgb.map(|c| if c > 0.0 { c.min(1.0) } else { 0.0 }),
        }
    }
}

/// The exposed picture without a tone curve: its colours from 0 to 1 as they are, for a display without an exposure. What
/// is not a number counts as 0.
pub fn plain(picture: &Picture, exposure: f32) -> Picture {
    let shown = |rgb: &[f32; 3]| Tone::Plain.displayable(rgb.map(|c| c * exposure));
    let pixels = picture.pixels.iter().map(shown).collect();
    Picture { pixels, ..*picture }
}

/// The dither threshold of a pixel, in `[0, 1)`: an additive sequence over the plane whose values
/// are spread evenly in every neighbourhood. The same for all channels, so grey stays grey.
fn dither(x: u32, y: u32) -> f32 {
    // 2³² / p and 2³² / p² with p³ = p + 1, the two-dimensional counterpart of the golden ratio.
    let phase = x.wrapping_mul(0xC13F_A9A9).wrapping_add(y.wrapping_mul(0x91E1_0DA5));
    (phase >> 8) as f32 / (1u32 << 24) as f32
}

/// 8-bit sRGB, three bytes a pixel, row by row from the top.
///
/// `exposure` multiplies linear radiance before the tone curve; without one, colours from 0 to 1 stay as they are. The
/// same picture gives the same bytes on every run.
pub fn srgb_bytes(picture: &Picture, exposure: Option<f32>) -> Vec<u8> {
    let width = picture.width.max(1) as usize;
    let mut bytes = Vec::with_capacity(picture.pixels.len() * 3);
    for (index, pixel) in picture.pixels.iter().enumerate() {
        let threshold = dither((index % width) as u32, (index / width) as u32);
        let shown = exposure.map_or(*pixel, |exposure| tone_map(pixel.map(|c| c * exposure)));
        bytes.extend(shown.map(|c| (srgb_from_linear(c) * 255.0 + threshold).floor().min(255.0) as u8));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(levels: &[f32]) -> Picture {
        let pixels = levels.iter().map(|&l| [l; 3]).collect();
        Picture { width: levels.len() as u32, height: 1, pixels }
    }

    #[test]
    fn a_small_lamp_does_not_darken_the_room() {
        let room = vec![0.5; 1000];
        let mut with_lamp = room.clone();
        with_lamp[..30].fill(1e5);
        let (without, with) = (automatic_exposure(&grey(&room)), automatic_exposure(&grey(&with_lamp)));
        assert!((with / without - 1.0).abs() < 1e-3, "{without} {with}");
        assert!((without * 0.5 - MIDDLE_GREY).abs() < 1e-4);
    }

    #[test]
    fn background_does_not_count() {
        let mut levels = vec![0.2; 100];
        let room = automatic_exposure(&grey(&levels));
        levels.extend([0.0; 900]);
        levels.push(f32::NAN);
        levels.push(f32::INFINITY);
        assert_eq!(automatic_exposure(&grey(&levels)), room);
        assert_eq!(automatic_exposure(&grey(&[0.0, 0.0])), 1.0);
    }

    #[test]
    fn exposure_follows_the_scale_of_the_scene() {
        let levels: Vec<f32> = (1..200).map(|i| (i as f32 * 0.37).sin().abs() + 0.01).collect();
        let base = automatic_exposure(&grey(&levels));
        for k in [1e-6f32, 0.1, 30.0, 1e6] {
            let scaled: Vec<f32> = levels.iter().map(|l| l * k).collect();
            assert!((automatic_exposure(&grey(&scaled)) * k / base - 1.0).abs() < 1e-3, "k = {k}");
        }
    }

    #[test]
    fn a_bright_half_does_not_burn_out() {
        // A dark corner fills 60 %, a wall a thousand times brighter the rest.
        let mut levels = vec![0.001; 600];
        levels.extend([1.0; 400]);
        assert!(automatic_exposure(&grey(&levels)) <= BRIGHT_LIMIT + 1e-6);
    }

    #[test]
    fn the_curve_rises_smoothly_to_white() {
        let (mut last, mut last_slope) = (0.0, 1.0 + 1e-3);
        for i in 1..4000 {
            let x = i as f32 * 1e-3;
            let y = curve(x);
            let slope = (y - last) / 1e-3;
            assert!(y > last && y < 1.0, "x = {x}");
            assert!(slope <= last_slope + 2e-3, "kink at x = {x}: {last_slope} then {slope}");
            (last, last_slope) = (y, slope);
        }
        assert_eq!(curve(MIDDLE_GREY), MIDDLE_GREY);
    }

    #[test]
    fn colours_keep_their_hue_and_lamps_turn_white() {
        let wall = tone_map([0.9, 0.3, 0.1]);
        assert!(wall[0] / wall[1] > 2.5, "the red wall has faded: {wall:?}");
        let lamp = tone_map([170.0, 120.0, 40.0]);
        assert!(lamp.iter().all(|&c| c > 0.95), "{lamp:?}");
        for odd in [[f32::NAN; 3], [-1.0; 3], [f32::NEG_INFINITY; 3]] {
            assert_eq!(tone_map(odd), [0.0; 3]);
        }
        assert!(tone_map([f32::INFINITY, 0.0, 1.0]).iter().all(|c| (0.0..=1.0).contains(c)));
    }

    #[test]
    fn plain_colours_stay_as_they_are_up_to_white() {
        let odd = [f32::NAN, -1.0, f32::INFINITY];
        let picture = Picture { width: 3, height: 1, pixels: vec![[0.05, 0.125, 0.2], [9.0, 0.4, 0.0], odd] };
        let shown = plain(&picture, 2.0);
        assert_eq!(shown.pixels, [[0.1, 0.25, 0.4], [1.0, 0.8, 0.0], [0.0, 0.0, 1.0]]);
        // The curve leaves what is dark alone, and keeps more of a bright hue.
        let [filmic, plain] = [srgb_bytes(&picture, Some(2.0)), srgb_bytes(&shown, None)];
        assert_eq!(filmic[..3], plain[..3]);
        assert_ne!(filmic[3..6], plain[3..6]);
    }

    #[test]
    fn dither_keeps_the_mean_and_the_ends() {
        let flat = Picture { width: 64, height: 64, pixels: vec![[0.2; 3]; 64 * 64] };
        let bytes = srgb_bytes(&flat, Some(1.0));
        let mean = bytes.iter().map(|&b| f64::from(b)).sum::<f64>() / bytes.len() as f64;
        let exact = f64::from(srgb_from_linear(0.2)) * 255.0;
        assert!((mean - exact).abs() < 0.02, "{mean} for {exact}");
        assert!(bytes.iter().any(|&b| f64::from(b) < exact) && bytes.iter().any(|&b| f64::from(b) > exact));
        assert!(srgb_bytes(&Picture::black(32, 32), Some(1.0)).iter().all(|&b| b == 0));
        let white = Picture { width: 32, height: 32, pixels: vec![[1e20; 3]; 32 * 32] };
        assert!(srgb_bytes(&white, Some(1.0)).iter().all(|&b| b == 255));
        assert!(bytes.chunks(3).all(|p| p[0] == p[1] && p[1] == p[2]), "grey got a tint");
    }
}
