//! Random numbers that depend on nothing but the seed and the place.

/// SplitMix64: small, and the same on every machine.
pub(super) struct Variation(u64);

impl Variation {
    /// The numbers of one room of one floor.
    pub(super) fn of_room(seed: u64, floor: u32, room: u32) -> Self {
        let mut start = Self(seed);
        for word in [u64::from(floor), u64::from(room)] {
            start.0 ^= start.next().wrapping_add(word);
        }
        start
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In `[low, high)`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// True once in `n` times.
    pub(super) fn once_in(&mut self, n: u64) -> bool {
        self.next().is_multiple_of(n)
    }

    /// One of a few.
    pub(super) fn choose(&mut self, from: &[&'static str]) -> &'static str {
        from[(self.next() % from.len() as u64) as usize]
    }
}
