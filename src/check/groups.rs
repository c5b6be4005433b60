//! Light on groups of surfaces that face alike, over links and by rays: where light ends up, not only how much of it
//! there is.

use super::finding::root;
use super::flights::{Landing, flights};
use super::subject::Subject;

/// Rays in all. Deviations of 1.5 % show where there are many groups.
const RAYS: u32 = 1 << 19;

/// Rays that a group receives: a thirty-second of its light is noise.
const RAYS_EACH: f64 = 1024.0;

/// Standard errors of the noise that are taken off with it.
const CERTAIN: f64 = 3.0;

/// How far the light of groups is from what rays bring them, relative to the light of a group.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    /// Groups that were compared.
    pub(super) count: u64,
    /// Root of the mean square that is left beyond the noise of the rays, weighted by light.
    pub(super) deviation: f64,
    /// The group with the most light too much or too little, and its brightest element.
    pub(super) worst: Option<(f64, u32)>,
}

/// Leaf elements that face alike and lie beside each other.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    /// Powers, local areas.
    received: f64,
    /// By each half of the rays.
    landed: [f64; 2],
    /// The element that receives most, and how much.
    brightest: (f64, u32),
}

impl Group {
    /// Its light, over links or by rays: whichever is more, for the other may be lost.
    fn size(&self) -> f64 {
        self.received.max(self.landed[0] + self.landed[1])
    }

    fn merge(&mut self, o: &Group) {
        self.received += o.received;
        self.landed[0] += o.landed[0];
        self.landed[1] += o.landed[1];
        if o.brightest.0 > self.brightest.0 {
            self.brightest = o.brightest;
        }
    }
}

/// Compares the irradiance of a solution with rays that carry its exitance one step.
pub(super) fn spread(subject: &Subject<'_>) -> Spread {
    let flights = flights(subject, RAYS);
    let mut landed = vec![[0.0; 2]; subject.solution.forest.len()];
    for (index, flight) in flights.all.iter().enumerate() {
        if let Landing::On(leaf) = flight.landing {
            landed[leaf as usize][index % 2] += flights.power;
        }
    }
    let least = RAYS_EACH * flights.power;
    let groups = groups(subject, &landed, least);
    let light: f64 = groups.iter().map(Group::size).sum();
    if light <= 0.0 {
        return Spread::default();
    }
    let (mut worst, mut squares, mut noises) = (None, 0.0, 0.0);
    for group in &groups {
        let [a, b] = group.landed;
        // Halves are independent: their sum varies as much as their difference.
        let (off, noise) = (group.received - (a + b), a - b);
        // What is left at the end of a way may be next to nothing.
        let size = group.size().max(least);
        squares += off * off / size;
        noises += noise * noise / size;
        if worst.is_none_or(|(most, ..): (f64, f64, u32)| off.abs() > most) {
            worst = Some((off.abs(), off / group.size(), group.brightest.1));
        }
    }
    // The difference of two squares of noise varies by twice their mean, so the sum over groups by this.
    let uncertain = 2.0 * noises / (groups.len() as f64).sqrt();
    Spread {
        count: groups.len() as u64,
        deviation: root((squares - noises - CERTAIN * uncertain) / light),
        worst: worst.map(|(_, off, element)| (off, element)),
    }
}

/// Groups with a light of `power` or little more each. Elements beside each other in a tree of the scene have ids that
/// follow each other; what is left at the end belongs to the group before.
fn groups(subject: &Subject<'_>, landed: &[[f64; 2]], power: f64) -> Vec<Group> {
    let (forest, irradiance) = (&subject.solution.forest, &subject.solution.light.irradiance);
    let mut open = [Group::default(); 6];
    let mut last = [None::<usize>; 6];
    let mut groups: Vec<Group> = Vec::new();
    for &leaf in &subject.leaves {
        let normal = subject.hierarchy.side_normal(forest.side(forest.side_of(leaf)));
        let axis = normal.abs().max_position();
        let way = 2 * axis + usize::from(normal[axis] < 0.0);
        let received = irradiance[leaf as usize].element_sum() as f64 * subject.area(leaf);
        open[way].merge(&Group { received, landed: landed[leaf as usize], brightest: (received, leaf) });
        if open[way].size() >= power {
            last[way] = Some(groups.len());
            groups.push(std::mem::take(&mut open[way]));
        }
    }
    for (group, last) in open.iter().zip(last) {
        match last {
            Some(last) => groups[last].merge(group),
            None if group.size() == 0.0 => (),
            None => groups.push(*group),
        }
    }
    groups
}
