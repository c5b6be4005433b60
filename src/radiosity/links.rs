//! Links: the stored exchange of light between two nodes, kept with the receiver.

use super::quarters::Quarters;
use rayon::slice::ParallelSliceMut;

/// How a link's visibility is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LinkClass {
    /// The source was dark when the link was made: not tested yet.
    Untested,
    /// All rays were clear.
    Visible,
    /// Proved by an empty shaft.
    CertifiedVisible,
    /// A fraction of the rays was clear.
    Partial,
    /// No ray was clear. Kept while refining, for a closer look later; not part of a solution.
    Invisible,
}

/// Light from one node (the source) to another (the receiver).
///
/// Node ids below the number of hierarchy nodes are clusters; the others are elements plus that
/// number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Node that receives.
    pub receiver: u32,
    /// Node that sends.
    pub source: u32,
    /// Form factor without occlusion. From an element to an element: irradiance per unit of the
    /// source's exitance. With a cluster as source: irradiance per unit of its intensity (1/area).
    /// With a cluster as receiver: irradiance across the direction of the light.
    pub factor: f32,
    /// How much the factor differs over the receiver.
    pub spread: f32,
    /// Share of the light that gets through. Of a source that is not uniform it may exceed 1: what is seen
    /// of it may be brighter than its mean.
    pub visibility: f32,
    /// Where on the source the light comes from, if the source is an element and `visibility` does not
    /// say.
    pub quarters: Quarters,
    /// How that is known.
    pub class: LinkClass,
    /// The class was taken over from an ancestor pair.
    pub inherited: bool,
    /// Work of the tests of this pair, in rays; 65 535 stands for anything above it, too.
    pub work: u16,
}

/// All links, sorted by receiver, then source.
#[derive(Debug, Default)]
pub struct LinkSet {
    /// The links.
    pub links: Vec<Link>,
    /// First link of each node, with the total number at the end.
    pub first: Vec<u32>,
}

impl LinkSet {
    /// Sorts links and finds where each of `nodes` nodes begins.
    pub fn new(mut links: Vec<Link>, nodes: usize) -> LinkSet {
        links.par_sort_unstable_by_key(|l| (l.receiver, l.source));
        let mut first = vec![0u32; nodes + 1];
        for link in &links {
            first[link.receiver as usize + 1] += 1;
        }
        for i in 0..nodes {
            first[i + 1] += first[i];
        }
        LinkSet { links, first }
    }

    /// The links of one receiver.
    #[inline]
    pub fn of(&self, receiver: u32) -> &[Link] {
        &self.links[self.first[receiver as usize] as usize..self.first[receiver as usize + 1] as usize]
    }

    /// Bytes they take.
    pub fn bytes(&self) -> u64 {
        (self.links.len() * size_of::<Link>() + self.first.len() * size_of::<u32>()) as u64
    }
}
