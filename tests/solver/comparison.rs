//! Comparing the links of two solutions of one scene.
//!
//! Element ids depend on every element that exists, so one pair decided differently would rename all
//! others. Here a node is named by its way from the root of its side instead.

use std::collections::BTreeMap;
use std::fmt;

use lightshaft::hierarchy::Hierarchy;
use lightshaft::radiosity::{Forest, LinkClass, Piece, Solution};

/// Receiver and source, each by a name that does not depend on other elements.
type PairName = ((bool, u64), (bool, u64));

/// What a link says of visibility. How it is known, proved or sampled, is left out: that is what the
/// strategies differ in.
#[derive(Clone, Copy, Debug)]
struct Seen {
    class: Class,
    visibility: f32,
}

/// Rays count as much as the source is bright where they end, so one ray decided differently anywhere
/// changes the last digits of many fractions with the light; a ray of the link itself changes more.
const SAME_FRACTION: f32 = 1e-3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    Untested,
    Visible,
    Partial,
}

/// The links of a solution by the names of their ends.
pub(crate) struct NamedLinks {
    links: BTreeMap<PairName, Seen>,
    invisible: u64,
}

impl NamedLinks {
    /// # Panics
    /// When two links join the same two nodes.
    pub(crate) fn of(hierarchy: &Hierarchy, solution: &Solution) -> NamedLinks {
        let keys = element_keys(hierarchy, &solution.forest);
        let clusters = hierarchy.nodes.len();
        let name = |id: u32| match (id as usize).checked_sub(clusters) {
            None => (true, u64::from(id)),
            Some(element) => (false, keys[element]),
        };
        let links: BTreeMap<PairName, Seen> = solution
            .links
            .links
            .iter()
            .map(|link| {
                let class = match link.class {
                    LinkClass::Untested => Class::Untested,
                    LinkClass::Visible | LinkClass::CertifiedVisible => Class::Visible,
                    LinkClass::Partial => Class::Partial,
                    LinkClass::Invisible => panic!("a solution holds no invisible links"),
                };
                let seen = Seen { class, visibility: link.visibility };
                ((name(link.receiver), name(link.source)), seen)
            })
            .collect();
        assert_eq!(links.len(), solution.links.links.len(), "two links join the same nodes");
        NamedLinks { links, invisible: solution.counters.invisible }
    }

    pub(crate) fn compare(&self, other: &NamedLinks) -> Differences {
        let mut found = Differences {
            links: self.links.len().max(other.links.len()),
            invisible: self.invisible.abs_diff(other.invisible),
            ..Differences::default()
        };
        for (pair, seen) in &self.links {
            match other.links.get(pair) {
                None => found.only_left += 1,
                Some(that) if that.class != seen.class => found.class += 1,
                Some(that) if (that.visibility - seen.visibility).abs() > SAME_FRACTION => {
                    found.fraction += 1
                }
                Some(_) => {}
            }
        }
        found.only_right = other.links.keys().filter(|pair| !self.links.contains_key(pair)).count();
        found
    }
}

/// In what two sets of links differ.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Differences {
    /// Links in the larger set.
    pub(crate) links: usize,
    only_left: usize,
    only_right: usize,
    class: usize,
    fraction: usize,
    /// Difference of the numbers of invisible pairs, which are not stored.
    invisible: u64,
}

impl Differences {
    /// Links that are not the same on both sides.
    pub(crate) fn count(&self) -> usize {
        self.only_left + self.only_right + self.class + self.fraction
    }

    /// [`Differences::count`] over the number of links.
    pub(crate) fn share(&self) -> f64 {
        self.count() as f64 / self.links.max(1) as f64
    }

    /// Difference of the numbers of invisible pairs over the number of links.
    pub(crate) fn share_of_invisible(&self) -> f64 {
        self.invisible as f64 / self.links.max(1) as f64
    }
}

impl fmt::Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} links differ ({} and {} on one side only, {} in class, {} in fraction; invisible pairs: {})",
            self.count(),
            self.links,
            self.only_left,
            self.only_right,
            self.class,
            self.fraction,
            self.invisible
        )
    }
}

/// The lasting name of each element.
fn element_keys(hierarchy: &Hierarchy, forest: &Forest) -> Vec<u64> {
    let mut keys = vec![0; forest.len()];
    for_each_element(hierarchy, forest, |piece| keys[piece.id() as usize] = piece.key);
    keys
}

/// Visits every element, inner and leaf, with its geometry.
pub(crate) fn for_each_element<'a>(
    hierarchy: &Hierarchy,
    forest: &'a Forest,
    mut visit: impl FnMut(&Piece<'a>),
) {
    for side in 0..forest.side_count() {
        let mut stack = vec![forest.root(hierarchy, side)];
        while let Some(piece) = stack.pop() {
            visit(&piece);
            if forest.second[piece.id() as usize] != 0 {
                stack.extend(piece.halves(forest));
            }
        }
    }
}
