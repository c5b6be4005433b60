//! Light on groups of surfaces that face alike, over links and by rays: where light ends up, not only how much of it
//! there is.

use super::flights::{Flights, Landing};
use super::subject::Subject;

/// Rays that a group is expected to receive.
const RAYS_EACH: f64 = 256.0;

/// How far the light of groups is from what rays bring them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    /// Groups that were compared.
    pub(super) count: u64,
    /// Relative deviation beyond the noise of the rays: root of the mean square, weighted by light.
    pub(super) deviation: f64,
    /// The group with the most light too much or too little: that relative to its light, and its brightest element.
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
pub(super) fn spread(subject: &Subject<'_>, flights: &Flights) -> Spread {
    let mut landed = vec![[0.0; 2]; subject.solution.forest.len()];
    for (index, flight) in flights.all.iter().enumerate() {
        if let Landing::On(leaf) = flight.landing {
            landed[leaf as usize][index % 2] += flights.power;
        }
    }
    let (mut found, mut squares, mut light, mut most) = (Spread::default(), 0.0, 0.0, 0.0);
    for group in groups(subject, &landed, RAYS_EACH * flights.power) {
        let [a, b] = group.landed;
        // Halves are independent: their sum varies as much as their difference.
        let (off, noise) = (group.received - (a + b), a - b);
        squares += (off * off - noise * noise) / group.received;
        light += group.received;
        found.count += 1;
        if off.abs() > most {
            (most, found.worst) = (off.abs(), Some((off / group.received, group.brightest.1)));
        }
    }
    if light > 0.0 {
        found.deviation = (squares / light).max(0.0).sqrt();
    }
    found
}

/// Groups that receive `power` or little more each. Elements beside each other in a tree of the scene have ids that
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
        if open[way].received >= power {
            last[way] = Some(groups.len());
            groups.push(std::mem::take(&mut open[way]));
        }
    }
    for (group, last) in open.iter().zip(last) {
        match last {
            Some(last) => groups[last].merge(group),
            None if group.received > 0.0 => groups.push(*group),
            None => (),
        }
    }
    groups
}
