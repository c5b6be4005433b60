//! Elements: the pieces a facet's side is cut into while it is refined.
//!
//! A piece is fixed by the way from its root (every split is fixed by the piece itself),
//! so several threads can grow the same tree and always get the same one; only the provisional ids
//! depend on who came first, and they are replaced after each refinement.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// One side of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// Facet id.
    pub facet: u32,
    /// Seen from behind.
    pub back: bool,
}

/// An element and, once it has been split, its two halves.
#[derive(Debug)]
pub struct ElementTree {
    id: AtomicU32,
    halves: OnceLock<Box<[ElementTree; 2]>>,
}

impl ElementTree {
    /// An undivided element.
    pub fn new(id: u32) -> ElementTree {
        ElementTree { id: AtomicU32::new(id), halves: OnceLock::new() }
    }

    /// Its id.
    #[inline]
    pub fn id(&self) -> u32 {
        self.id.load(Ordering::Relaxed)
    }

    /// Gives it another id.
    pub fn set_id(&self, id: u32) {
        self.id.store(id, Ordering::Relaxed);
    }

    /// Its halves, if it has been split.
    #[inline]
    pub fn halves(&self) -> Option<&[ElementTree; 2]> {
        self.halves.get().map(|h| &**h)
    }

    /// Its halves, splitting it if need be; new elements take their ids from `next_id`.
    pub fn split(&self, next_id: &AtomicU32) -> &[ElementTree; 2] {
        self.halves.get_or_init(|| {
            let id = next_id.fetch_add(2, Ordering::Relaxed);
            Box::new([ElementTree::new(id), ElementTree::new(id + 1)])
        })
    }
}
