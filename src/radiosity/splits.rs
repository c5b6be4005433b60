//! Elements that threads divide since the last numbering.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Each block of halves is as large as all before it together: there are never more.
const BLOCKS: usize = 33;

/// Halves of elements by provisional id. What an element is divided into is fixed by itself, so several threads can divide
/// the same ones and get the same pieces; only the ids depend on who came first, and they are replaced when all are numbered
/// anew.
#[derive(Debug)]
pub(super) struct Splits {
    /// Ids up to this one fill the first block.
    first: u32,
    /// The id of the first half of each element, 0 of those that are not divided; the other half has the next one. Blocks are
    /// made when something in them is divided.
    blocks: [OnceLock<Box<[AtomicU32]>>; BLOCKS],
    next: AtomicU32,
}

impl Splits {
    /// Nothing is divided yet of `count` elements.
    pub(super) fn new(count: u32) -> Splits {
        Splits {
            first: count.max(1),
            blocks: [const { OnceLock::new() }; BLOCKS],
            next: AtomicU32::new(count.max(1)),
        }
    }

    /// No id is as large as this. Some that are smaller may be of no element.
    pub(super) fn end(&self) -> u32 {
        self.next.load(Ordering::Relaxed)
    }

    /// The block of an id, how many ids are in it, and which of them this is.
    fn place(&self, id: u32) -> (usize, u32, u32) {
        match (id / self.first).checked_ilog2() {
            None => (0, self.first, id),
            Some(doublings) => {
                let begin = self.first << doublings;
                (doublings as usize + 1, begin, id - begin)
            }
        }
    }

    /// The halves of an element, if it is divided.
    pub(super) fn halves(&self, id: u32) -> Option<[u32; 2]> {
        let (block, _, at) = self.place(id);
        let half = self.blocks[block].get()?[at as usize].load(Ordering::Relaxed);
        (half != 0).then(|| [half, half + 1])
    }

    /// The halves of an element, which is divided if need be.
    pub(super) fn split(&self, id: u32) -> [u32; 2] {
        let (block, count, at) = self.place(id);
        let block = self.blocks[block].get_or_init(|| (0..count).map(|_| AtomicU32::new(0)).collect());
        let slot = &block[at as usize];
        let half = match slot.load(Ordering::Relaxed) {
            0 => {
                let half = self.next.fetch_add(2, Ordering::Relaxed);
                // Who comes too late leaves two ids that nobody has.
                let earlier = slot.compare_exchange(0, half, Ordering::Relaxed, Ordering::Relaxed).err();
                earlier.unwrap_or(half)
            }
            half => half,
        };
        [half, half + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn all_threads_see_the_same_halves() {
        for count in [1, 3, 1000] {
            let splits = Splits::new(count);
            // Every thread divides all elements down to the tenth halves.
            let below = |root: u32| {
                let mut level = vec![root];
                for _ in 0..10 {
                    level = level.into_iter().flat_map(|id| splits.split(id)).collect();
                }
                level
            };
            let roots = count.min(16);
            let all: Vec<Vec<u32>> = (0..8 * roots).into_par_iter().map(|i| below(i % roots)).collect();
            for (i, leaves) in all.iter().enumerate() {
                assert_eq!(leaves, &all[i % roots as usize]);
                assert!(leaves.iter().all(|&leaf| leaf < splits.end() && splits.halves(leaf).is_none()));
            }
            let mut ids: Vec<u32> = all[..roots as usize].concat();
            ids.sort_unstable();
            ids.dedup();
            assert_eq!(ids.len(), 1024 * roots as usize, "{count}");
        }
    }
}
