//! Every link against rays: how much light each kind of link carries, and how much of it rays carry
//! between the same nodes. It shows pairs that no link covers or that several do, and which kind of link
//! loses or makes light.

use super::flights::{Flights, Landing};
use super::subject::{Subject, fraction};
use crate::radiosity::{Link, LinkClass, direction};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Links below which a pair of leaf elements is picked, at most; all links of smaller solutions.
const PICKED: usize = 1 << 16;

/// Links handed to a thread at a time.
const CHUNK: usize = 1 << 14;

/// Links that are alike: what their ends are, and how their visibility is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    /// The receiver is a cluster.
    pub(super) to_cluster: bool,
    /// The source is a cluster.
    pub(super) from_cluster: bool,
    /// How the visibility is known.
    pub(super) class: LinkClass,
}

/// Power that arrives over links of one kind, or over none: sum over channels, local areas.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Power {
    /// By the links.
    pub(super) linked: f64,
    /// By rays between the same nodes.
    pub(super) found: f64,
}

/// The answer.
#[derive(Clone, Debug, Default)]
pub(super) struct Audit {
    /// Power by kind of link; none for pairs that no link covers.
    pub(super) kinds: BTreeMap<Option<Kind>, Power>,
    /// Pairs of leaf elements that were looked at.
    pub(super) pairs: u64,
    /// Of those, pairs that several links cover, and one of them, receiver first.
    pub(super) twice: u64,
    pub(super) doubled: Option<(u32, u32)>,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let node = |is_cluster| if is_cluster { "cluster" } else { "element" };
        let class = match self.class {
            LinkClass::Untested => "dark when made",
            LinkClass::Visible => "visible",
            LinkClass::CertifiedVisible => "proved visible",
            LinkClass::Partial => "partial",
        };
        write!(f, "{} to {}, {class}", node(self.from_cluster), node(self.to_cluster))
    }
}

impl Kind {
    fn of(subject: &Subject<'_>, link: &Link) -> Kind {
        let is_cluster = |node| subject.element(node).is_none();
        Kind {
            to_cluster: is_cluster(link.receiver),
            from_cluster: is_cluster(link.source),
            class: link.class,
        }
    }
}

/// Power that every kind of link carries.
fn linked(subject: &Subject<'_>) -> BTreeMap<Kind, f64> {
    let (hierarchy, solution) = (subject.hierarchy, subject.solution);
    let (forest, openness) = (&solution.forest, &solution.openness);
    let add = |mut sums: BTreeMap<Kind, f64>, other: BTreeMap<Kind, f64>| {
        other.into_iter().for_each(|(kind, power)| *sums.entry(kind).or_default() += power);
        sums
    };
    let parts: Vec<BTreeMap<Kind, f64>> = solution
        .links
        .links
        .par_chunks(CHUNK)
        .map(|links| {
            let mut sums = BTreeMap::new();
            for link in links {
                let arriving = solution.light.carried(hierarchy, forest, link).element_sum() as f64;
                let area = match subject.element(link.receiver) {
                    Some(element) => subject.area(element),
                    None => {
                        let towards = direction(hierarchy, forest, link);
                        openness.area(hierarchy, link.receiver).evaluate_signed(towards) as f64
                    }
                };
                *sums.entry(Kind::of(subject, link)).or_default() += arriving * area;
            }
            sums
        })
        .collect();
    // In order, so that the sums do not depend on the threads.
    parts.into_iter().fold(BTreeMap::new(), add)
}

/// Judges the links by the flights.
pub(super) fn audit(subject: &Subject<'_>, flights: &Flights) -> Audit {
    let of_flights: Vec<Option<(u32, u32, Vec<Kind>)>> = flights
        .all
        .par_iter()
        .map(|flight| {
            let Landing::On(receiver) = flight.landing else { return None };
            let kinds = subject.links_between(receiver, flight.from).map(|link| Kind::of(subject, link));
            Some((receiver, flight.from, kinds.collect()))
        })
        .collect();
    let mut audit = Audit::default();
    for (kind, power) in linked(subject) {
        audit.kinds.entry(Some(kind)).or_default().linked = power;
    }
    for (receiver, source, kinds) in of_flights.into_iter().flatten() {
        audit.count(receiver, source, kinds.len());
        audit.kinds.entry(kinds.first().copied()).or_default().found += flights.power;
    }
    let links = &subject.solution.links.links;
    let step = links.len().div_ceil(PICKED).max(1);
    let picked: Vec<(u32, u32, usize)> = (0..links.len().div_ceil(step))
        .into_par_iter()
        .map(|index| {
            let link = &links[index * step];
            let [receiver, source] = [(link.receiver, 1), (link.source, 4)].map(|(node, salt)| {
                let [at, u, v] = [0, 1, 2].map(|i| fraction(index as u64, salt + i));
                subject.spot(&subject.area_of(node), at, (u, v)).leaf
            });
            (receiver, source, subject.links_between(receiver, source).count())
        })
        .collect();
    picked.into_iter().for_each(|(receiver, source, times)| audit.count(receiver, source, times));
    audit
}

impl Audit {
    fn count(&mut self, receiver: u32, source: u32, times: usize) {
        self.pairs += 1;
        if times > 1 {
            self.twice += 1;
            self.doubled.get_or_insert((receiver, source));
        }
    }
}
