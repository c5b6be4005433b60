//! A picture against one that is known to be right but for noise, such as a path-traced one.

use super::flip::mean_flip;
use crate::image::picture::Picture;
use crate::image::tone::Exposure;
use serde::{Deserialize, Serialize};

/// Pixels in a row and rows of the box filter: noise of single pixels becomes a quarter of itself.
const BOX: usize = 4;

/// How far a picture is from a reference.
///
/// Radiance counts up to what the exposure that is chosen for the reference shows as white, in both: lamps seen
/// directly would outweigh everything else.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthDifference {
    /// Root mean square difference over pixels and channels, relative to the mean of the reference.
    pub relative_rmse: f64,
    /// Mean difference, likewise; negative when light is missing.
    pub relative_bias: f64,
    /// Mean FLIP of the tone-mapped pictures: 0 when they look the same, 1 at most.
    pub flip: f64,
    /// The first of these after a box filter of 4 × 4 pixels that both pictures pass, which leaves little of the noise.
    pub smoothed_relative_rmse: f64,
    /// Mean FLIP after it.
    pub smoothed_flip: f64,
}

impl TruthDifference {
    /// Of a picture from a reference of the same size.
    pub fn of(picture: &Picture, reference: &Picture) -> TruthDifference {
        debug_assert!(picture.width == reference.width && picture.height == reference.height);
        let white = 1.0 / Exposure::Automatic.multiplier(reference);
        let [picture, reference] = [picture, reference].map(|picture| {
            let pixels = picture.pixels.iter().map(|pixel| pixel.map(|c| c.clamp(0.0, white))).collect();
            Picture { pixels, ..*picture }
        });
        let smoothed = [&reference, &picture].map(smoothed);
        let (relative_rmse, relative_bias) = relative(&picture, &reference);
        TruthDifference {
            relative_rmse,
            relative_bias,
            flip: mean_flip([&reference, &picture]),
            smoothed_relative_rmse: relative(&smoothed[1], &smoothed[0]).0,
            smoothed_flip: mean_flip(smoothed.each_ref()),
        }
    }
}

/// Root mean square and mean of the difference, relative to the mean of the reference.
fn relative(picture: &Picture, reference: &Picture) -> (f64, f64) {
    let (mut squares, mut sum, mut all) = (0.0, 0.0, 0.0);
    for (&found, &right) in picture.pixels.iter().flatten().zip(reference.pixels.iter().flatten()) {
        let difference = f64::from(found) - f64::from(right);
        squares += difference * difference;
        sum += difference;
        all += f64::from(right);
    }
    let count = (3 * reference.pixels.len()).max(1) as f64;
    let mean = (all / count).max(f64::MIN_POSITIVE);
    ((squares / count).sqrt() / mean, sum / count / mean)
}

/// Each pixel the mean of those around it, fewer at the borders.
fn smoothed(picture: &Picture) -> Picture {
    let (width, height) = (picture.width as usize, picture.height as usize);
    // The box reaches one pixel further to the right and down.
    let around = |at: usize, count: usize| at.saturating_sub(BOX / 2 - 1)..(at + BOX / 2 + 1).min(count);
    let pixels = (0..width * height).map(|index| {
        let (rows, columns) = (around(index / width, height), around(index % width, width));
        let count = (rows.len() * columns.len()) as f32;
        let inside =
            rows.flat_map(|row| columns.clone().map(move |column| picture.pixels[row * width + column]));
        let sum =
            inside.fold([0.0; 3], |sum: [f32; 3], p| [0, 1, 2].map(|channel| sum[channel] + p[channel]));
        sum.map(|c| c / count)
    });
    Picture { width: picture.width, height: picture.height, pixels: pixels.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(value: impl Fn(usize, usize) -> f32) -> Picture {
        let pixels = (0..40 * 30).map(|i| [value(i % 40, i / 40); 3]).collect();
        Picture { width: 40, height: 30, pixels }
    }

    #[test]
    fn an_even_difference_is_rmse_and_bias() {
        let (right, found) = (picture(|_, _| 2.0), picture(|_, _| 1.8));
        let difference = TruthDifference::of(&found, &right);
        assert!((difference.relative_bias + 0.1).abs() < 1e-6, "{difference:?}");
        assert!((difference.relative_rmse - 0.1).abs() < 1e-6, "{difference:?}");
        assert!(
            (difference.smoothed_relative_rmse - 0.1).abs() < 1e-6 && difference.flip > 0.0,
            "{difference:?}"
        );
        assert_eq!(TruthDifference::of(&right, &right), TruthDifference::default());
    }

    #[test]
    fn noise_counts_much_less_when_smoothed() {
        let noise = |x: usize, y: usize| 1.0 + 0.2 * ((x * 7 + y * 13) % 5) as f32;
        let difference = TruthDifference::of(&picture(|_, _| 1.4), &picture(noise));
        assert!(difference.relative_rmse > 0.1, "{difference:?}");
        assert!(difference.smoothed_relative_rmse < 0.3 * difference.relative_rmse, "{difference:?}");
        assert!(difference.smoothed_flip < difference.flip, "{difference:?}");
    }

    #[test]
    fn lamps_count_as_white_however_bright() {
        let lit = |x: usize, lamp: f32| if x == 0 { lamp } else { 1.0 };
        let (dim, bright) = (picture(|x, _| lit(x, 10.0)), picture(|x, _| lit(x, 1e4)));
        assert_eq!(TruthDifference::of(&bright, &dim).relative_rmse, 0.0);
    }
}
