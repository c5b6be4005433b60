//! ꟻLIP: how different two pictures look to somebody who flips between them, from 0 (the same) to 1.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, *FLIP: A difference evaluator for alternating
//! images*, Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2), 2020; computed by the
//! authors' code (`nv-flip`).

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, flip};
use rayon::prelude::*;

use crate::image::picture::Picture;
use crate::image::tone::{Exposure, srgb_bytes};

/// Rows that are compared at a time. The library uses one thread, and 72 bytes for each pixel.
const BAND: usize = 64;

/// Rows that a pixel can depend on, at most: its filters reach 3 standard deviations, no more than 0.136 degrees or
/// 10 pixels at [`DEFAULT_PIXELS_PER_DEGREE`].
const REACH: usize = 12;

/// Mean over the pixels of two pictures of one size, tone-mapped with the exposure of the first, seen at 67 pixels
/// per degree: from 0.7 m on a screen of 3840 pixels and 0.7 m.
pub(super) fn mean_flip([first, second]: [&Picture; 2]) -> f64 {
    let exposure = Exposure::Automatic.multiplier(first);
    mean([first, second].map(|picture| srgb_bytes(picture, Some(exposure))), first.width as usize, BAND)
}

/// Of two pictures as 8-bit sRGB, band by band.
fn mean(pictures: [Vec<u8>; 2], width: usize, band: usize) -> f64 {
    let row_bytes = 3 * width;
    let rows = pictures[0].len() / row_bytes.max(1);
    let starts: Vec<usize> = (0..rows).step_by(band).collect();
    let sums: Vec<f64> = starts
        .into_par_iter()
        .map(|start| {
            let (end, from) = ((start + band).min(rows), start.saturating_sub(REACH));
            let to = (end + REACH).min(rows);
            let part = |picture: &[u8]| {
                let bytes = &picture[from * row_bytes..to * row_bytes];
                FlipImageRgb8::with_data(width as u32, (to - from) as u32, bytes)
            };
            let map = flip(part(&pictures[0]), part(&pictures[1]), DEFAULT_PIXELS_PER_DEGREE).to_vec();
            map[(start - from) * width..(end - from) * width].iter().copied().map(f64::from).sum()
        })
        .collect();
    // In order, so that the sum does not depend on the threads.
    sums.iter().sum::<f64>() / ((rows * width) as f64).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 40;

    fn plain(colour: [u8; 3]) -> Vec<u8> {
        colour.repeat(SIDE * SIDE)
    }

    fn of_plain(colours: [[u8; 3]; 2]) -> f64 {
        mean(colours.map(plain), SIDE, BAND)
    }

    /// Something with edges and points, without a pattern.
    fn busy(seed: u32, width: usize, rows: usize) -> Vec<u8> {
        let value = |i: u32| ((i / 7).wrapping_mul(2_654_435_761).wrapping_add(seed) >> 24) as u8;
        (0..(3 * width * rows) as u32).map(value).collect()
    }

    #[test]
    fn the_same_picture_is_0() {
        let picture = busy(1, SIDE, SIDE);
        assert_eq!(mean([picture.clone(), picture], SIDE, BAND), 0.0);
    }

    /// Equations 4 to 6 of the paper for plain pictures, which have no edges: the distance of their colours to the
    /// power of 0.7; up to 0.4 of the largest is mapped to 0 to 0.95, the rest to 1. The largest is that of green and
    /// blue. Black and white are 100 apart in lightness and nothing else.
    #[test]
    fn plain_pictures_have_the_values_of_the_paper() {
        let green_blue = of_plain([[0, 255, 0], [0, 0, 255]]);
        assert!((green_blue - 1.0).abs() < 1e-4, "{green_blue}");
        let green_blue_distance = {
            // CIELAB (D65) of the two, with the chroma scaled by 0.01 L* (Hunt).
            let (green, blue) = ([87.735, -86.183, 83.180], [32.297, 79.188, -107.860]);
            let hunt = |[l, a, b]: [f64; 3]| [l, 0.01 * l * a, 0.01 * l * b];
            let ([l1, a1, b1], [l2, a2, b2]) = (hunt(green), hunt(blue));
            (l1 - l2).abs() + (a1 - a2).hypot(b1 - b2)
        };
        let (most, white) = (f64::powf(green_blue_distance, 0.7), f64::powf(100.0, 0.7));
        let expected = 0.95 + 0.05 * (white - 0.4 * most) / (0.6 * most);
        let black_white = of_plain([[0; 3], [255; 3]]);
        assert!((black_white - expected).abs() < 2e-3, "{black_white}, by hand {expected}");
    }

    #[test]
    fn a_larger_change_counts_more() {
        let values = [1, 2, 4, 8, 16, 32, 64].map(|change| of_plain([[120; 3], [120 + change, 120, 120]]));
        assert!(values[0] > 0.0 && values.windows(2).all(|pair| pair[0] < pair[1]), "{values:?}");
        let spots = [1, 5, 25, 125].map(|count| {
            let mut other = plain([120; 3]);
            (0..count).for_each(|i| other[3 * 11 * i] = 255);
            mean([plain([120; 3]), other], SIDE, BAND)
        });
        assert!(spots[0] > 0.0 && spots.windows(2).all(|pair| pair[0] < pair[1]), "{spots:?}");
    }

    #[test]
    fn bands_do_not_show() {
        let (width, rows) = (30, 150);
        let pictures = || [busy(1, width, rows), busy(77_000_000, width, rows)];
        let whole = mean(pictures(), width, rows);
        assert!(whole > 0.1, "{whole}");
        for band in [1, 7, 64] {
            let banded = mean(pictures(), width, band);
            assert!((banded - whole).abs() < 1e-12, "{band} rows: {banded}, {whole}");
        }
    }

    #[test]
    fn pictures_of_one_pixel_and_of_none_end() {
        let one = |value: f32| Picture { width: 1, height: 1, pixels: vec![[value; 3]] };
        assert!(mean_flip([&one(1.0), &one(0.0)]) > 0.5);
        assert!(mean_flip([&one(f32::NAN), &one(f32::INFINITY)]).is_finite());
        assert_eq!(mean([Vec::new(), Vec::new()], 0, BAND), 0.0);
    }
}
