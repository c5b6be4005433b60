//! What elements reflect: what the material of their surface does, or where a picture lies on it, its mean over each element.

use crate::hierarchy::Hierarchy;
use crate::math::Polygon;
use glam::Vec3;
use rayon::prelude::*;

/// Elements are measured in parallel, so many at a time.
const AT_A_TIME: usize = 4096;

/// Where the means of a side begin that has none.
const NONE: u32 = u32::MAX;

/// Shares of light that the elements of a side reflect, `[0, 0.98]` per channel.
#[derive(Clone, Copy, Debug)]
pub enum Reflectance<'a> {
    /// All alike.
    Even(Vec3),
    /// Each the mean of a picture over it.
    Painted {
        /// The first element of the side.
        first: u32,
        /// Of it and those that follow.
        means: &'a [Vec3],
    },
}

impl Reflectance<'_> {
    /// Of an element of the side.
    #[inline]
    pub fn of(self, element: u32) -> Vec3 {
        match self {
            Reflectance::Even(all) => all,
            Reflectance::Painted { first, means } => means[(element - first) as usize],
        }
    }
}

/// The means of all elements with a picture on them. Without pictures nothing is kept.
#[derive(Debug, Default)]
pub(super) struct Means {
    /// Where those of each side begin, or [`NONE`]; empty without pictures.
    first: Vec<u32>,
    /// By element, of sides with a picture one after the other.
    means: Vec<Vec3>,
}

impl Means {
    /// Of a side and those that follow, if there is a picture on it.
    pub(super) fn of_side(&self, side: usize) -> Option<&[Vec3]> {
        let first = self.first.get(side).filter(|&&first| first != NONE)?;
        Some(&self.means[*first as usize..])
    }
}

/// Finds means, for one element after the other.
pub(super) struct Measuring<'a> {
    hierarchy: &'a Hierarchy,
    has_paintings: bool,
    /// Of the side whose elements come now, when there is a picture on it.
    facet: Option<u32>,
    found: Means,
    /// Leaf elements that are still to be measured: place of the mean, facet, outline.
    open: Vec<(u32, u32, Polygon)>,
}

impl<'a> Measuring<'a> {
    /// Nothing is found yet.
    pub(super) fn new(hierarchy: &'a Hierarchy) -> Measuring<'a> {
        let has_paintings = hierarchy.has_paintings();
        Measuring { hierarchy, has_paintings, facet: None, found: Means::default(), open: Vec::new() }
    }

    /// What comes now are the elements of a side of this facet, in order.
    pub(super) fn begin_side(&mut self, facet: u32) {
        if !self.has_paintings {
            return;
        }
        self.facet = self.hierarchy.material(facet).painting.is_some().then_some(facet);
        self.found.first.push(self.facet.map_or(NONE, |_| self.found.means.len() as u32));
    }

    /// The next element; what is asked of it are its outline when it is a leaf, and its mean when that is known.
    pub(super) fn add(&mut self, leaf: Option<&Polygon>, known: impl FnOnce() -> Option<Vec3>) {
        let Some(facet) = self.facet else { return };
        let known = leaf.and_then(|_| known());
        if let Some(outline) = leaf.filter(|_| known.is_none()) {
            self.open.push((self.found.means.len() as u32, facet, *outline));
        }
        self.found.means.push(known.unwrap_or(Vec3::ZERO));
        if self.open.len() == AT_A_TIME {
            self.measure();
        }
    }

    fn measure(&mut self) {
        let mean = |&(place, facet, outline): &(u32, u32, Polygon)| {
            (place, self.hierarchy.mean_reflectance(facet, &outline))
        };
        let measured: Vec<(u32, Vec3)> = self.open.par_iter().map(mean).collect();
        self.open.clear();
        measured.into_iter().for_each(|(place, mean)| self.found.means[place as usize] = mean);
    }

    /// All that was found. What is no leaf reflects what its halves do, of which `halves` gives the elements and areas;
    /// they come after it.
    pub(super) fn finish(
        mut self,
        first_element: &[u32],
        halves: impl Fn(u32) -> Option<[(u32, f32); 2]>,
    ) -> Means {
        self.measure();
        let Means { first, means } = &mut self.found;
        for (side, &first) in first.iter().enumerate().filter(|&(_, &first)| first != NONE) {
            for element in (first_element[side]..first_element[side + 1]).rev() {
                let Some(halves) = halves(element) else { continue };
                let place = |element: u32| (first + element - first_element[side]) as usize;
                let [(a, area_a), (b, area_b)] = halves.map(|(half, area)| (means[place(half)], area));
                means[place(element)] = b + (a - b) * (area_a / (area_a + area_b));
            }
        }
        self.found
    }
}
