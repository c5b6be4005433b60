//! Two pictures of one view, pixel by pixel.

use super::flip::mean_flip;
use crate::image::picture::Picture;
use serde::Serialize;

/// Difference of radiance, W/(m²·sr), and of what is seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PictureDifference {
    /// Mean radiance of the first picture, over pixels and channels: what differences are relative to.
    pub mean: f64,
    /// Root of the mean square difference, over pixels and channels.
    pub rmse: f64,
    /// The largest difference of a channel.
    pub max: f64,
    /// The pixel it is at: column and row, from 0 at the top left; none when there is no difference.
    pub worst: Option<[u32; 2]>,
    /// Mean FLIP of the tone-mapped pictures: 0 when they look the same, 1 at most.
    pub flip: f64,
}

impl PictureDifference {
    /// Compares two pictures of the same size.
    pub fn between([first, second]: [&Picture; 2]) -> PictureDifference {
        debug_assert!(first.width == second.width && first.height == second.height);
        let (mut found, mut sum, mut squares) = (PictureDifference::default(), 0.0, 0.0);
        for (index, (a, b)) in (0..).zip(first.pixels.iter().zip(&second.pixels)) {
            for (&a, &b) in a.iter().zip(b) {
                let difference = (f64::from(a) - f64::from(b)).abs();
                sum += f64::from(a);
                squares += difference * difference;
                if difference > found.max {
                    found.max = difference;
                    found.worst = Some([index % first.width, index / first.width]);
                }
            }
        }
        let count = (first.pixels.len() * 3).max(1) as f64;
        (found.mean, found.rmse) = (sum / count, (squares / count).sqrt());
        found.flip = mean_flip([first, second]);
        found
    }

    /// A difference relative to the mean.
    pub fn relative(&self, difference: f64) -> f64 {
        difference / self.mean.max(f64::MIN_POSITIVE)
    }
}

/// The absolute difference of two pictures of the same size, times `gain`.
pub fn difference_picture([first, second]: [&Picture; 2], gain: f32) -> Picture {
    let pixels = first.pixels.iter().zip(&second.pixels);
    let pixels = pixels.map(|(a, b)| [0, 1, 2].map(|channel| (a[channel] - b[channel]).abs() * gain));
    Picture { width: first.width, height: first.height, pixels: pixels.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_is_found_where_it_is() {
        let first = Picture { width: 3, height: 2, pixels: vec![[2.0; 3]; 6] };
        let mut second = first.clone();
        second.pixels[4][1] = 5.0;
        let found = PictureDifference::between([&first, &second]);
        assert_eq!((found.mean, found.max, found.worst), (2.0, 3.0, Some([1, 1])));
        assert!((found.rmse - (9.0f64 / 18.0).sqrt()).abs() < 1e-12 && found.relative(found.max) == 1.5);
        assert_eq!(PictureDifference::between([&first, &first]).worst, None, "there is no such place");
        assert!(found.flip > 0.0 && PictureDifference::between([&first, &first]).flip == 0.0, "{found:?}");
        assert_eq!(difference_picture([&first, &second], 2.0).pixels[4], [0.0, 6.0, 0.0]);
    }
}
