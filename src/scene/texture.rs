//! Pictures on surfaces: PNG and JPEG files as base colours, and how they lie on a plane.

use std::fmt;
use std::io::Cursor;
use std::sync::{Arc, LazyLock};

use glam::{DVec2, DVec3};
use image::{ImageFormat, ImageReader, Limits};

use crate::math::{hash_pair, linear_from_srgb};

/// Most pixels of one picture, and of all of a scene together.
const MOST_PIXELS: u64 = 1 << 26;
pub(super) const MOST_PIXELS_OF_ALL: u64 = 1 << 28;
/// Most samples along the longest edge of a triangle whose colours are averaged; where there are more pixels, samples are
/// shaken, so that what repeats is not always met at the same place.
const MOST_SAMPLES: f64 = 64.0;
/// Likewise of a part of a surface, of which there are many.
const MOST_OF_PART: f64 = 16.0;

/// How a JPEG begins.
const JPEG_START: &[u8] = &[0xff, 0xd8];

static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0)));

/// A picture in 8-bit sRGB; what is transparent in it counts as its colour.
#[derive(PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    /// Three bytes each, row by row from the top.
    texels: Vec<u8>,
    /// Of all of it, linear.
    mean: [f64; 3],
    /// Of its size and pixels.
    fingerprint: u64,
}

impl fmt::Debug for Texture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Texture of {} × {}", self.width, self.height)
    }
}

/// What a picture goes on with beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// From its beginning.
    Repeat,
    /// With the pixels at its edge.
    Clamp,
    /// Backwards.
    Mirror,
}

impl Texture {
    /// Decodes a PNG or JPEG file; `room` is how many pixels it may have.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn decode(bytes: &[u8], room: u64) -> Result<Texture, String> {
        let reader = || {
            let mut reader =
                ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
            let mut limits = Limits::default();
            limits.max_alloc = Some(16 * MOST_PIXELS);
            reader.limits(limits);
            match reader.format() {
                Some(ImageFormat::Png | ImageFormat::Jpeg) => Ok(reader),
                _ => Err("is neither PNG nor JPEG".to_owned()),
            }
        };
        let fault = |error: image::ImageError| {
            let text: String =
                error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            format!("cannot be decoded ({})", text.chars().take(100).collect::<String>())
        };
        let (width, height) = reader()?.into_dimensions().map_err(fault)?;
        let pixels = u64::from(width) * u64::from(height);
        let most = MOST_PIXELS.min(room);
        if pixels == 0 || pixels > most {
            return Err(format!("has {width} × {height} pixels, and at most {most} are read"));
        }
        if bytes.starts_with(JPEG_START) && !is_whole_jpeg(bytes) {
            return Err("is cut off".to_owned());
        }
        let picture = reader()?.decode().map_err(fault)?.into_rgb8();
        Ok(Texture::new(width, height, picture.into_raw()))
    }

    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    fn new(width: u32, height: u32, texels: Vec<u8>) -> Texture {
        let mut counts = [[0u64; 256]; 3];
        for texel in texels.as_chunks::<3>().0 {
            (0..3).for_each(|channel| counts[channel][usize::from(texel[channel])] += 1);
        }
        let mean = counts.map(|counts| {
            let sum: f64 =
                counts.iter().zip(*LINEAR).map(|(&count, linear)| count as f64 * f64::from(linear)).sum();
            sum / (texels.len() / 3) as f64
        });
        let words = texels.chunks(8).map(|bytes| bytes.iter().fold(0, |word, &b| word << 8 | u64::from(b)));
        let fingerprint = [u64::from(width), u64::from(height)].into_iter().chain(words).fold(0, hash_pair);
        Texture { width, height, texels, mean, fingerprint }
    }

    /// Of all of it, linear.
    pub(super) fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// Linear colour at a place of the picture, 0 to 1 from the left and from the top, between the nearest four pixels.
    fn at(&self, place: DVec2, wrap: [Wrap; 2]) -> [f32; 3] {
        let [(left, right, across), (top, bottom, down)] =
            [neighbours(place.x, self.width, wrap[0]), neighbours(place.y, self.height, wrap[1])];
        let texels = self.texels.as_chunks::<3>().0;
        let texel = |x: u32, y: u32| texels[y as usize * self.width as usize + x as usize];
        let [a, b, c, d] = [texel(left, top), texel(right, top), texel(left, bottom), texel(right, bottom)];
        std::array::from_fn(|channel| {
            let [a, b, c, d] = [a, b, c, d].map(|texel| LINEAR[usize::from(texel[channel])]);
            let (upper, lower) = (a + (b - a) * across, c + (d - c) * across);
            upper + (lower - upper) * down
        })
    }
}

/// Whether a JPEG has the marker of its end (ITU-T T.81, B.1.1): where it is cut off, the decoder makes up what is missing and
/// says nothing.
fn is_whole_jpeg(bytes: &[u8]) -> bool {
    let mut at = JPEG_START.len();
    while let Some(rest) = bytes.get(at..) {
        // What comes before the next marker is light, in which 0 follows 0xff but for restarts.
        let is_marker = |two: &[u8]| two[0] == 0xff && !matches!(two[1], 0 | 0xd0..=0xd7 | 0xff);
        let Some(found) = rest.windows(2).position(is_marker) else { return false };
        if rest[found + 1] == 0xd9 {
            return true;
        }
        // Segments say how long they are; a picture within one has an end of its own.
        let length =
            rest.get(found + 2..found + 4).map_or(0, |two| usize::from(two[0]) << 8 | usize::from(two[1]));
        at += found + 2 + length;
    }
    false
}

/// The pixels on both sides of a place along an axis, and the share of the second one.
fn neighbours(place: f64, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    // Whole turns do not count; beyond some millions of them there are no digits left for the rest.
    let place = match wrap {
        Wrap::Clamp => place.clamp(0.0, 1.0),
        Wrap::Repeat => place.rem_euclid(1.0),
        Wrap::Mirror => place.rem_euclid(2.0),
    };
    let at = place * f64::from(size) - 0.5;
    let (size, low) = (i64::from(size), at.floor());
    let pixel = |index: i64| {
        let index = match wrap {
            Wrap::Clamp => index.clamp(0, size - 1),
            Wrap::Repeat => index.rem_euclid(size),
            Wrap::Mirror => {
                let index = index.rem_euclid(2 * size);
                index.min(2 * size - 1 - index)
            }
        };
        index as u32
    };
    (pixel(low as i64), pixel(low as i64 + 1), (at - low) as f32)
}

/// A picture on surfaces of one plane, or of any where it happens to lie in the same way.
#[derive(Clone, Debug, PartialEq)]
pub struct Painting {
    texture: Arc<Texture>,
    wrap: [Wrap; 2],
    /// Multiplies the picture, linear.
    factor: [f64; 3],
    /// A point of the plane, scene units, and where it is on the picture.
    origin: DVec3,
    place: DVec2,
    /// How the place changes with the point, per scene unit.
    across: DVec3,
    down: DVec3,
}

impl Painting {
    /// A picture that lies on a triangle so that its corners are at these places; none for a triangle without area.
    pub(super) fn on(
        picture: &Picture,
        factor: [f64; 3],
        corners: [DVec3; 3],
        places: [DVec2; 3],
    ) -> Option<Painting> {
        let ([a, b, c], [at_a, at_b, at_c]) = (corners, places);
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let square = normal.length_squared();
        // Dual to the edges, in the plane: each changes along one of them only.
        let (along_ab, along_ac) = (ac.cross(normal) / square, normal.cross(ab) / square);
        let gradient = |along_b: f64, along_c: f64| along_ab * along_b + along_ac * along_c;
        let (to_b, to_c) = (at_b - at_a, at_c - at_a);
        let (across, down) = (gradient(to_b.x, to_c.x), gradient(to_b.y, to_c.y));
        let is_whole = square > 0.0 && across.is_finite() && down.is_finite();
        is_whole.then(|| Painting {
            texture: picture.texture.clone(),
            wrap: picture.wrap,
            factor,
            origin: a,
            place: at_a,
            across,
            down,
        })
    }

    fn place(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        self.place + DVec2::new(offset.dot(self.across), offset.dot(self.down))
    }

    /// Whether the picture lies on another triangle in the same way, to a twentieth of a pixel.
    pub(super) fn fits(&self, corners: [DVec3; 3], places: [DVec2; 3]) -> bool {
        let size = DVec2::new(f64::from(self.texture.width), f64::from(self.texture.height));
        corners.into_iter().zip(places).all(|(corner, place)| {
            let off = (self.place(corner) - place) * size;
            off.abs().max_element() < 0.05
        })
    }

    /// Linear, not yet clamped.
    fn colour(&self, point: DVec3) -> [f64; 3] {
        let texel = self.texture.at(self.place(point), self.wrap);
        [0, 1, 2].map(|channel| self.factor[channel] * f64::from(texel[channel]))
    }

    /// What a point of the surface reflects, as far as surfaces may.
    pub fn reflectance_at(&self, point: DVec3) -> [f32; 3] {
        self.colour(point).map(|rho| rho.min(super::validate::HIGHEST_REFLECTANCE) as f32)
    }

    /// The mean over a triangle, linear, not yet clamped.
    pub(super) fn mean(&self, corners: [DVec3; 3]) -> [f64; 3] {
        self.mean_of(corners, MOST_SAMPLES, |point| self.colour(point))
    }

    /// What a flat convex part of the surface reflects as a whole, by its corners: the mean of what its points reflect.
    pub fn mean_reflectance(&self, corners: &[DVec3]) -> [f32; 3] {
        let (mut sum, mut area, mut any) = ([0.0; 3], 0.0, [0.0; 3]);
        for i in 1..corners.len().saturating_sub(1) {
            let triangle = [corners[0], corners[i], corners[i + 1]];
            let part = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).length();
            any = self.mean_of(triangle, MOST_OF_PART, |point| self.reflectance_at(point).map(f64::from));
            sum = [0, 1, 2].map(|channel| sum[channel] + any[channel] * part);
            area += part;
        }
        // Of what has no area, some of it.
        (if area > 0.0 { sum.map(|channel| channel / area) } else { any }).map(|channel| channel as f32)
    }

    fn mean_of(&self, [a, b, c]: [DVec3; 3], most: f64, colour: impl Fn(DVec3) -> [f64; 3]) -> [f64; 3] {
        let size = DVec2::new(f64::from(self.texture.width), f64::from(self.texture.height));
        let [at_a, at_b, at_c] = [a, b, c].map(|corner| self.place(corner) * size);
        let longest = (at_b - at_a).length().max((at_c - at_b).length()).max((at_a - at_c).length());
        let count = longest.ceil().clamp(1.0, most) as u32;
        let seed = a.to_array().into_iter().map(f64::to_bits).fold(0, hash_pair);
        // One in each of count² equal triangles, in the middle while there is one for each pixel.
        let mut sum = [0.0; 3];
        let mut add = |i: u32, j: u32, is_upper: bool| {
            let mut at = DVec2::splat(1.0 / 3.0);
            if longest > most {
                let bits = hash_pair(seed, u64::from(i) << 32 | u64::from(j) << 1 | u64::from(is_upper));
                at = DVec2::new((bits >> 32) as f64, (bits as u32).into()) / f64::from(u32::MAX);
                at = if at.x + at.y > 1.0 { DVec2::ONE - at } else { at };
            }
            let at = DVec2::new(i.into(), j.into()) + if is_upper { DVec2::ONE - at } else { at };
            let at = at / f64::from(count);
            let colour = colour(a + (b - a) * at.x + (c - a) * at.y);
            sum = [0, 1, 2].map(|channel| sum[channel] + colour[channel]);
        };
        for i in 0..count {
            for j in 0..count - i {
                add(i, j, false);
                if i + j + 1 < count {
                    add(i, j, true);
                }
            }
        }
        sum.map(|channel| channel / f64::from(count * count))
    }

    /// A fingerprint of all that it makes surfaces reflect.
    pub fn fingerprint(&self) -> u64 {
        let Painting { texture, wrap, factor, origin, place, across, down } = self;
        let vectors = [DVec3::from(*factor), *origin, place.extend(0.0), *across, *down];
        let numbers = vectors.into_iter().flat_map(|vector| vector.to_array()).map(f64::to_bits);
        let wrap = wrap.map(|wrap| wrap as u64);
        [texture.fingerprint].into_iter().chain(wrap).chain(numbers).fold(0, hash_pair)
    }
}

/// A texture with what it does beyond its edges.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    pub(super) texture: Arc<Texture>,
    pub(super) wrap: [Wrap; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(wrap: Wrap) -> Picture {
        let texels = vec![255, 0, 0, 0, 0, 0, 0, 255, 0, 0, 0, 255];
        Picture { texture: Arc::new(Texture::new(2, 2, texels)), wrap: [wrap; 2] }
    }

    fn corners() -> [DVec3; 3] {
        [DVec3::new(1.0, 5.0, 2.0), DVec3::new(5.0, 5.0, 2.0), DVec3::new(1.0, 7.0, 2.0)]
    }

    #[test]
    fn a_picture_lies_as_its_corners_say_and_goes_on_as_it_is_told() {
        let places = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let at = |wrap, x: f64, y: f64| {
            let painting = Painting::on(&picture(wrap), [0.5; 3], corners(), places).expect("a triangle");
            painting.reflectance_at(DVec3::new(1.0 + 4.0 * x, 5.0 + 2.0 * y, 2.0))
        };
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            assert_eq!(at(wrap, 0.25, 0.25), [0.5, 0.0, 0.0], "{wrap:?}");
            assert_eq!(at(wrap, 0.25, 0.75), [0.0, 0.5, 0.0], "{wrap:?}");
            assert_eq!(at(wrap, 0.75, 0.75), [0.0, 0.0, 0.5], "{wrap:?}");
            assert_eq!(at(wrap, 0.5, 0.25), [0.25, 0.0, 0.0], "{wrap:?} in the middle");
        }
        assert_eq!(at(Wrap::Repeat, 3.25, -0.75), [0.5, 0.0, 0.0]);
        assert_eq!(at(Wrap::Mirror, 3.75, -0.25), [0.5, 0.0, 0.0]);
        assert_eq!(at(Wrap::Mirror, 1.25, 0.75), [0.0, 0.0, 0.5]);
        assert_eq!(at(Wrap::Clamp, 9.0, 9.0), [0.0, 0.0, 0.5]);
        assert_eq!(at(Wrap::Clamp, f64::NAN, 1e300).map(f32::is_nan), [false; 3]);
    }

    #[test]
    fn the_mean_is_that_of_the_area() {
        let places = [DVec2::ZERO, DVec2::X * 8.0, DVec2::Y * 8.0];
        let painting = Painting::on(&picture(Wrap::Repeat), [1.0; 3], corners(), places).expect("a triangle");
        // 28 whole pictures and 8 halves along the slanted edge, which have all of red, half of green, nothing of blue.
        for (channel, expected) in painting.mean(corners()).into_iter().zip([9.0 / 32.0, 0.25, 7.0 / 32.0]) {
            assert!((channel - expected).abs() < 0.01, "{channel} instead of {expected}");
        }
        assert_eq!(painting.texture.mean(), [0.25; 3]);
        assert!(painting.fits(corners(), places));
        assert!(!painting.fits(corners(), [places[0], places[1], places[2] + DVec2::X]));
        assert!(Painting::on(&picture(Wrap::Clamp), [1.0; 3], [DVec3::ONE; 3], places).is_none());
    }

    #[test]
    fn parts_have_their_own_mean_and_what_repeats_is_not_always_met_at_one_place() {
        let of = |repeats: f64| {
            let places = [DVec2::ZERO, DVec2::X * repeats, DVec2::Y * repeats];
            Painting::on(&picture(Wrap::Repeat), [1.0; 3], corners(), places).expect("a triangle")
        };
        let part = |from: f64, to: f64| {
            let corner = |x: f64, y: f64| DVec3::new(1.0 + 4.0 * x, 5.0 + 2.0 * y, 2.0);
            of(1.0).mean_reflectance(&[
                corner(from, 0.3),
                corner(to, 0.3),
                corner(to, 0.2),
                corner(from, 0.2),
            ])
        };
        // Around the middle of the upper pixels, red and black, of which a tenth comes from the lower ones at most.
        let (left, right) = (part(0.2, 0.3), part(0.7, 0.8));
        assert!(left[0] > 0.88 && right[0] < 0.1, "{left:?} and {right:?}");
        let both = part(0.2, 0.8);
        assert!((both[0] - 0.475).abs() < 0.02, "{both:?}");
        // A picture for each of 64 samples along the edge, and for every second one.
        for repeats in [64.0, 128.0] {
            for channel in of(repeats).mean(corners()) {
                assert!((channel - 0.25).abs() < 0.03, "{repeats}: {channel}");
            }
        }
        let [a, b, _] = corners();
        assert!(of(1.0).mean_reflectance(&[a, b, b]).iter().all(|channel| channel.is_finite()));
    }
}
