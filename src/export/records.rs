//! Records of a solution file: plain data of a fixed size, little-endian.

use crate::radiosity::{Kept, Link, LinkClass, LinkWork, Quarters, Spread};
use glam::Vec3;

/// One element of an array in the file.
pub(super) trait Record: Sized {
    /// Size in the file.
    const BYTES: usize;

    /// Writes to [`Self::BYTES`] bytes.
    fn put(&self, to: &mut [u8]);

    /// Reads from as many; `None` for what no solution holds, such as a number that is not finite.
    fn get(from: &[u8]) -> Option<Self>;

    /// Whether it may stand behind another one.
    fn may_follow(&self, _before: &Self) -> bool {
        true
    }
}

/// Four bytes at a place.
fn word(from: &[u8], at: usize) -> [u8; 4] {
    let mut bytes = [0; 4];
    bytes.copy_from_slice(&from[at..at + 4]);
    bytes
}

fn whole(from: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(word(from, at))
}

fn finite(from: &[u8], at: usize) -> Option<f32> {
    Some(f32::from_le_bytes(word(from, at))).filter(|number| number.is_finite())
}

fn put_words<const N: usize>(words: [[u8; 4]; N], to: &mut [u8]) {
    to[..4 * N].copy_from_slice(words.as_flattened());
}

impl Record for u8 {
    const BYTES: usize = 1;

    fn put(&self, to: &mut [u8]) {
        to[0] = *self;
    }

    fn get(from: &[u8]) -> Option<u8> {
        Some(from[0])
    }
}

impl Record for bool {
    const BYTES: usize = 1;

    fn put(&self, to: &mut [u8]) {
        to[0] = u8::from(*self);
    }

    fn get(from: &[u8]) -> Option<bool> {
        [false, true].get(from[0] as usize).copied()
    }
}

impl Record for u64 {
    const BYTES: usize = 8;

    fn put(&self, to: &mut [u8]) {
        to.copy_from_slice(&self.to_le_bytes());
    }

    fn get(from: &[u8]) -> Option<u64> {
        let (low, high) = (whole(from, 0), whole(from, 4));
        Some(u64::from(low) | u64::from(high) << 32)
    }
}

impl Record for f64 {
    const BYTES: usize = 8;

    fn put(&self, to: &mut [u8]) {
        self.to_bits().put(to);
    }

    fn get(from: &[u8]) -> Option<f64> {
        u64::get(from).map(f64::from_bits).filter(|number| number.is_finite())
    }
}

impl Record for f32 {
    const BYTES: usize = 4;

    fn put(&self, to: &mut [u8]) {
        to.copy_from_slice(&self.to_le_bytes());
    }

    fn get(from: &[u8]) -> Option<f32> {
        finite(from, 0)
    }
}

impl Record for Vec3 {
    const BYTES: usize = 12;

    fn put(&self, to: &mut [u8]) {
        put_words(self.to_array().map(f32::to_le_bytes), to);
    }

    fn get(from: &[u8]) -> Option<Vec3> {
        Some(Vec3::new(finite(from, 0)?, finite(from, 4)?, finite(from, 8)?))
    }
}

impl Record for Kept {
    const BYTES: usize = 5;

    fn put(&self, to: &mut [u8]) {
        put_words([{ self.node }.to_le_bytes()], to);
        to[4] = self.rays;
    }

    fn get(from: &[u8]) -> Option<Kept> {
        let rays = from[4];
        (rays <= Kept::RAYS).then(|| Kept { node: whole(from, 0), rays })
    }
}

/// Classes, each at its number in the file.
const CLASSES: [LinkClass; 4] =
    [LinkClass::Untested, LinkClass::Visible, LinkClass::CertifiedVisible, LinkClass::Partial];

impl Record for Link {
    const BYTES: usize = 24;

    fn put(&self, to: &mut [u8]) {
        let [receiver, source] = [self.receiver, self.source].map(u32::to_le_bytes);
        let [factor, visibility] = [self.factor, self.visibility].map(f32::to_le_bytes);
        put_words([receiver, source, factor, visibility, self.quarters.to_bytes()], to);
        (to[20], to[21]) = (self.class as u8, self.work.to_bits());
        to[22..].copy_from_slice(&self.spread.to_bits().to_le_bytes());
    }

    fn get(from: &[u8]) -> Option<Link> {
        Some(Link {
            receiver: whole(from, 0),
            source: whole(from, 4),
            factor: finite(from, 8)?,
            visibility: finite(from, 12)?,
            quarters: Quarters::from_bytes(word(from, 16)),
            class: *CLASSES.get(from[20] as usize)?,
            work: LinkWork::from_bits(from[21])?,
            spread: Spread::from_bits(u16::from_le_bytes([from[22], from[23]]))?,
        })
    }

    /// By receiver, then source, each pair once.
    fn may_follow(&self, before: &Link) -> bool {
        (before.receiver, before.source) < (self.receiver, self.source)
    }
}
