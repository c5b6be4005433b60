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
    /// Share of the light that gets through. Of a source that is not uniform it may exceed 1: what is seen
    /// of it may be brighter than its mean.
    pub visibility: f32,
    /// Where on the source the light comes from, if the source is an element and `visibility` does not
    /// say.
    pub quarters: Quarters,
    /// How that is known.
    pub class: LinkClass,
    /// See [`Link::work`].
    pub work: LinkWork,
    /// See [`Link::spread`] and [`Link::is_inherited`].
    pub spread: Spread,
}

/// Work of visibility tests, in rays: a number to an eighth of itself in a byte, from below; exact up to 15. Sums lose as
/// much with each that is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkWork(u8);

/// How much a form factor differs, to a part in 256 of itself, and one bit besides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread(u16);

impl Link {
    /// Nothing is known of it yet but the factor and how much that differs.
    pub const fn untested(receiver: u32, source: u32, factor: f32, spread: f32) -> Link {
        Link {
            receiver,
            source,
            factor,
            visibility: 1.0,
            quarters: Quarters::UNIFORM,
            class: LinkClass::Untested,
            work: LinkWork(0),
            spread: Spread::of(spread),
        }
    }

    /// How much the factor differs over the receiver.
    #[inline]
    pub fn spread(&self) -> f32 {
        f32::from_bits(u32::from(self.spread.0 & !Spread::INHERITED) << 16)
    }

    /// The class was taken over from an ancestor pair.
    #[inline]
    pub fn is_inherited(&self) -> bool {
        self.spread.0 & Spread::INHERITED != 0
    }

    /// Takes a class over from an ancestor pair.
    pub(super) fn inherit(&mut self, class: LinkClass) {
        self.class = class;
        self.spread.0 |= Spread::INHERITED;
    }

    /// Work of the tests of this pair.
    pub fn work(&self) -> u32 {
        self.work.rays()
    }

    /// Adds to that.
    pub(super) fn add_work(&mut self, rays: u64) {
        self.work = LinkWork::of(u64::from(self.work()) + rays);
    }
}

impl LinkWork {
    fn of(rays: u64) -> LinkWork {
        let rays = rays.min(u64::from(u32::MAX)) as u32;
        LinkWork(match rays {
            0..16 => rays as u8,
            _ => {
                let power = rays.ilog2();
                (8 * (power - 2) + (rays >> (power - 3) & 7)) as u8
            }
        })
    }

    /// As it is stored.
    pub fn to_bits(self) -> u8 {
        self.0
    }

    /// What was stored, if that stands for a number of rays.
    pub fn from_bits(bits: u8) -> Option<LinkWork> {
        (bits < 8 * (u32::BITS as u8 - 2)).then_some(LinkWork(bits))
    }

    fn rays(self) -> u32 {
        let code = u32::from(self.0);
        if code < 16 { code } else { (8 + code % 8) << (code / 8 - 1) }
    }
}

impl Spread {
    /// Where the sign would be: the class was taken over.
    const INHERITED: u16 = 1 << 15;

    /// The largest that is a number.
    const LARGEST: u16 = 0x7f7f;

    /// As it is stored.
    pub fn to_bits(self) -> u16 {
        self.0
    }

    /// What was stored, if that stands for a number.
    pub fn from_bits(bits: u16) -> Option<Spread> {
        f32::from_bits(u32::from(bits) << 16).is_finite().then_some(Spread(bits))
    }

    /// The upper half of a number, rounded.
    const fn of(spread: f32) -> Spread {
        if spread <= 0.0 {
            return Spread(0);
        }
        let rounded = ((spread.to_bits() + (1 << 15)) >> 16) as u16;
        Spread(if rounded > Spread::LARGEST { Spread::LARGEST } else { rounded })
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
        Blocked { receiver: link.receiver, source: link.source, factor: link.factor, spread: link.spread() }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_has_24_bytes() {
        assert_eq!(size_of::<Link>(), 24);
    }

    #[test]
    fn work_is_known_to_an_eighth_from_below() {
        let mut before = 0;
        for rays in (0..5000).chain([65_535, 65_536, 1 << 31, u64::from(u32::MAX)]) {
            let known = u64::from(LinkWork::of(rays).rays());
            assert!(known <= rays && 8 * (rays - known) <= known && known >= before, "{known} of {rays}");
            before = known;
        }
        let stored: Vec<LinkWork> = (0..=255).map_while(LinkWork::from_bits).collect();
        assert!(stored.iter().all(|&work| LinkWork::of(u64::from(work.rays())) == work));
        assert_eq!(stored.last(), Some(&LinkWork::of(u64::MAX)));
    }

    #[test]
    fn a_spread_is_known_to_a_part_in_256_whatever_is_inherited() {
        for i in 0..2000 {
            let spread = 1e-9 * 1.02f32.powi(i);
            let mut link = Link::untested(0, 1, 1.0, spread);
            assert!((link.spread() - spread).abs() <= spread / 256.0, "{} for {spread}", link.spread());
            assert!(!link.is_inherited());
            let known = link.spread();
            link.inherit(LinkClass::Visible);
            assert!(link.is_inherited() && link.spread() == known);
        }
        assert_eq!(Link::untested(0, 1, 1.0, 0.0).spread(), 0.0);
        for huge in [f32::MAX, f32::INFINITY] {
            let spread = Link::untested(0, 1, 1.0, huge).spread();
            assert!(spread.is_finite() && spread > 0.99 * f32::MAX);
        }
    }
}
