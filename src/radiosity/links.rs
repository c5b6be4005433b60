//! Links: the stored exchange of light between two nodes, kept with the receiver.

use super::quarters::Quarters;
use rayon::prelude::*;

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

impl Link {
    /// Nothing is known of it yet but the factor and how much that differs.
    pub(super) const fn untested(receiver: u32, source: u32, factor: f32, spread: f32) -> Link {
        Link {
            receiver,
            source,
            factor,
            spread,
            visibility: 1.0,
            quarters: Quarters::UNIFORM,
            class: LinkClass::Untested,
            inherited: false,
            work: 0,
        }
    }
}

/// A pair of which no ray was clear, and nothing proves it: no light comes over it, but while links are refined it is
/// looked at again. There are more of them than links. The figures are those of [`Link`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocked {
    pub(super) receiver: u32,
    pub(super) source: u32,
    pub(super) factor: f32,
    pub(super) spread: f32,
}

impl Blocked {
    /// As the link it would be if some ray were clear, with nothing that gets through.
    pub(super) fn as_link(&self) -> Link {
        let Blocked { receiver, source, factor, spread } = *self;
        let untested = Link::untested(receiver, source, factor, spread);
        Link { visibility: 0.0, class: LinkClass::Partial, ..untested }
    }
}

impl From<&Link> for Blocked {
    fn from(link: &Link) -> Blocked {
        Blocked { receiver: link.receiver, source: link.source, factor: link.factor, spread: link.spread }
    }
}

/// What is known of pairs, in no order.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    pub(super) links: Vec<Link>,
    pub(super) blocked: Vec<Blocked>,
}

impl Pairs {
    pub(super) fn len(&self) -> usize {
        self.links.len() + self.blocked.len()
    }

    /// Gives back room to grow.
    pub(super) fn shrink(&mut self) {
        self.links.shrink_to_fit();
        self.blocked.shrink_to_fit();
    }

    /// Takes over what others have.
    pub(super) fn absorb(&mut self, other: Pairs) {
        self.links.extend(other.links);
        self.blocked.extend(other.blocked);
    }

    /// Replaces provisional element ids.
    pub(super) fn rename(&mut self, clusters: u32, new_from_old: &[u32]) {
        let renamed = |id| renamed(id, clusters, new_from_old);
        self.links.par_iter_mut().with_min_len(4096).for_each(|link| {
            (link.receiver, link.source) = (renamed(link.receiver), renamed(link.source));
        });
        self.blocked.par_iter_mut().with_min_len(4096).for_each(|pair| {
            (pair.receiver, pair.source) = (renamed(pair.receiver), renamed(pair.source));
        });
    }
}

/// An id of a link when elements have other numbers; `clusters` is the first that is of an element.
pub(super) fn renamed(id: u32, clusters: u32, new_from_old: &[u32]) -> u32 {
    id.checked_sub(clusters).map_or(id, |element| clusters + new_from_old[element as usize])
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
