//! The links of two solutions of one scene.
//!
//! Element ids depend on every element that exists, so one pair decided differently would rename all
//! others. Here a node is named by its way from the root of its side instead.

use crate::hierarchy::Hierarchy;
use crate::radiosity::{Link, LinkClass, Solution, place};
use rayon::prelude::*;
use serde::Serialize;
use std::cmp::Ordering;
use std::fmt;

/// Whether it is an element, and a name that does not depend on other elements.
type NodeName = (bool, u64);

/// Rays count as much as the source is bright where they end, so one ray decided differently anywhere
/// changes the last digits of many fractions with the light; a ray of the link itself changes more.
const SAME_FRACTION: f32 = 1e-3;

/// The links of a solution by the names of their ends.
pub struct NamedLinks<'a> {
    hierarchy: &'a Hierarchy,
    solution: &'a Solution,
    /// Sorted by name: receiver, source, and the index of the link.
    names: Vec<(NodeName, NodeName, u32)>,
}

/// In what two sets of links differ; of two numbers the first is for the first set.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LinkDifferences {
    /// Links of each.
    pub links: [u64; 2],
    /// Links that only one has.
    pub only: [u64; 2],
    /// Links of both: visible in one, partly visible or dark in the other.
    pub class: u64,
    /// Of the same class, but proved in one and found by rays in the other.
    pub certified: u64,
    /// Of the same class, but the share of the light that gets through differs by more than 0.001.
    pub fraction: u64,
    /// Invisible pairs of each, which are not stored.
    pub invisible: [u64; 2],
    /// Where the difference is that carries the most light; empty when there is none.
    pub worst: String,
}

/// How a link's visibility is known, and whether that is a proof.
fn kind(class: LinkClass) -> (LinkClass, bool) {
    match class {
        LinkClass::CertifiedVisible => (LinkClass::Visible, true),
        other => (other, false),
    }
}

impl<'a> NamedLinks<'a> {
    /// The links of one solution.
    pub fn of(hierarchy: &'a Hierarchy, solution: &'a Solution) -> NamedLinks<'a> {
        let mut keys = vec![0; solution.forest.len()];
        solution.forest.for_each_element(hierarchy, |piece| keys[piece.id as usize] = piece.key);
        let clusters = hierarchy.nodes.len();
        let name = |id: u32| match (id as usize).checked_sub(clusters) {
            None => (false, u64::from(id)),
            Some(element) => (true, keys[element]),
        };
        let links = solution.links.links.par_iter().enumerate();
        let mut names: Vec<_> =
            links.map(|(index, link)| (name(link.receiver), name(link.source), index as u32)).collect();
        names.par_sort_unstable();
        NamedLinks { hierarchy, solution, names }
    }

    /// Compares with another solution of the same scene.
    pub fn compare(&self, other: &NamedLinks<'_>) -> LinkDifferences {
        let sets = [self, other];
        let mut found = LinkDifferences {
            links: sets.map(|set| set.names.len() as u64),
            invisible: sets.map(|set| set.solution.counters.invisible),
            ..LinkDifferences::default()
        };
        let (mut at, mut most) = ([0, 0], 0.0);
        loop {
            let next = [0, 1].map(|side| sets[side].names.get(at[side]));
            let order = match next {
                [None, None] => break,
                [Some(_), None] => Ordering::Less,
                [None, Some(_)] => Ordering::Greater,
                [Some(a), Some(b)] => (a.0, a.1).cmp(&(b.0, b.1)),
            };
            let side = usize::from(order == Ordering::Greater);
            let difference = if order == Ordering::Equal {
                let [a, b] = [0, 1].map(|side| sets[side].link(at[side]));
                at = at.map(|index| index + 1);
                found.count(a, b).map(|what| (0, a, what))
            } else {
                let link = sets[side].link(at[side]);
                at[side] += 1;
                found.only[side] += 1;
                Some((side, link, ["only in the first", "only in the second"][side].to_owned()))
            };
            if let Some((side, link, what)) = difference
                && sets[side].power(link) > most
            {
                most = sets[side].power(link);
                found.worst = format!("{}, {what}", sets[side].places(link));
            }
        }
        found
    }

    fn link(&self, at: usize) -> &'a Link {
        &self.solution.links.links[self.names[at].2 as usize]
    }

    /// Power that a link carries, about: local areas, sum over channels.
    fn power(&self, link: &Link) -> f32 {
        let forest = &self.solution.forest;
        let area = match (link.receiver as usize).checked_sub(self.hierarchy.nodes.len()) {
            Some(element) => forest.area[element],
            None => self.hierarchy.nodes[link.receiver as usize].area,
        };
        self.solution.light.carried(self.hierarchy, forest, link).element_sum() * area
    }

    fn places(&self, link: &Link) -> String {
        let [receiver, source] =
            [link.receiver, link.source].map(|node| place(self.hierarchy, &self.solution.forest, node));
        format!("to {receiver} from {source}")
    }
}

impl LinkDifferences {
    /// Counts a link that both have; says in what it differs.
    fn count(&mut self, a: &Link, b: &Link) -> Option<String> {
        let [(class, proved), (other, other_proved)] = [a, b].map(|link| kind(link.class));
        let (counter, what) = if class != other {
            (&mut self.class, format!("{class:?} and {other:?}"))
        } else if proved != other_proved {
            (&mut self.certified, "proved in one only".to_owned())
        } else if (a.visibility - b.visibility).abs() > SAME_FRACTION {
            (&mut self.fraction, format!("visibility {} and {}", a.visibility, b.visibility))
        } else {
            return None;
        };
        *counter += 1;
        Some(what)
    }

    /// Whether there are no differences of any kind.
    pub fn are_same(&self) -> bool {
        self.count_of_all() == 0 && self.certified == 0 && self.invisible[0] == self.invisible[1]
    }

    /// Links that are not the same on both sides; how they are known does not count.
    pub fn count_of_all(&self) -> u64 {
        self.only[0] + self.only[1] + self.class + self.fraction
    }

    /// That over the number of links.
    pub fn share(&self) -> f64 {
        self.count_of_all() as f64 / self.most_links()
    }

    /// Difference of the numbers of invisible pairs over the number of links.
    pub fn share_of_invisible(&self) -> f64 {
        self.invisible[0].abs_diff(self.invisible[1]) as f64 / self.most_links()
    }

    fn most_links(&self) -> f64 {
        self.links[0].max(self.links[1]).max(1) as f64
    }
}

impl fmt::Display for LinkDifferences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [left, right] = self.only;
        write!(
            f,
            "{} of {} links differ ({left} and {right} on one side only, {} in class, {} in fraction); \
             {} proved in one only; invisible pairs: {} and {}",
            self.count_of_all(),
            self.most_links(),
            self.class,
            self.fraction,
            self.certified,
            self.invisible[0],
            self.invisible[1]
        )
    }
}
