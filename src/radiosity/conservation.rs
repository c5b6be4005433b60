//! No light is lost or made on the way: what surfaces send out arrives, but for what rays find to escape, and it arrives
//! where rays find that it does.
//!
//! Links get a per cent or two of it wrong in a draft, and bounces multiply that: where all surfaces reflect 0.9, light
//! that is lost or made in one flight is so ten times over. So all that surfaces receive is scaled by one factor. Where
//! much light escapes, rays know less about the rest than links do: the factor follows what is beyond their noise.
//!
//! Links get more of it wrong from place to place: one that is partly blocked brings light to all of a large receiver
//! alike, be it to two rooms of which the source sees one; and what no link carries, because the few rays of a pair saw
//! no way through, brings next to nothing for each pair, but there are very many of them. So light is shared out anew from
//! the scene down, through clusters, sides and elements, as the rays of one flight land. They are few where little light
//! falls: each time the halves follow the rays as far as these differ from the links by more than noise.

use super::flight::{Flight, Landings, landings};
use super::forest::Forest;
use super::gains::{Gains, Surplus};
use super::transport::{Damping, Light};
use crate::hierarchy::{Hierarchy, NodeKind};
use crate::progress::Progress;
use crate::tracer::Tracer;
use std::iter::Sum;

/// The factor stays within this and its inverse: beyond, links do not say where light goes.
const MOST: f64 = 2.0;

/// Half of what is off by this many standard errors of the rays is corrected, of less hardly any.
const NOISE: f64 = 3.0;

/// Rays of a flight for each link.
const RAYS_PER_LINK: usize = 16;

/// Where links are few there are rays to spare: so many for each link, until they are [`MANY_RAYS`].
const RAYS_PER_LINK_OF_FEW: usize = 32;

/// See [`RAYS_PER_LINK_OF_FEW`].
const MANY_RAYS: usize = 1 << 19;

/// Most rays of a flight.
const MOST_RAYS: usize = 1 << 24;

/// Where fewer rays than this land is not looked at more closely.
const FEWEST_LANDED: u32 = 64;

/// What is off by no more than the first of these, in standard errors of the rays, counts as chance: there are very many
/// halves, and what chance moves shows as noise. From the second on halves are as the rays say.
const CHANCE: [f64; 2] = [3.0, 5.0];

/// No part of the scene receives more than this times what links and stray light bring.
const MOST_GAINED: f64 = 4.0;

/// No element receives less than this times what its links bring: of nothing it would not be known what they bring.
const LEAST_GAINED: f32 = 1e-6;

/// What light that is received is scaled by, and what rays have found so far.
#[derive(Clone, Debug)]
pub(super) struct Conservation {
    /// The factor.
    pub(super) factor: f32,
    /// Where all light goes; `None` before rays have found it.
    flight: Option<Flight>,
    /// How many rays have landed on each leaf element.
    landed: Vec<u32>,
    /// How many would have, by what links bring.
    expected: Vec<f32>,
}

impl Conservation {
    /// Nothing is known yet but a factor to begin with: that of the light before, or 1.
    pub(super) fn beginning_with(factor: f32) -> Conservation {
        Conservation { factor, flight: None, landed: Vec::new(), expected: Vec::new() }
    }

    /// Takes what rays have found of all light together.
    pub(super) fn learn(&mut self, flight: Flight) {
        self.flight = Some(flight);
    }

    /// Finds with rays where light goes that comes over so many `links`, for the first time, or the second;
    /// [`Self::shared`] takes what has been found each time.
    pub(super) fn look(
        &mut self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        light: &Light,
        tracer: &dyn Tracer,
        (links, time): (usize, u32),
        progress: &dyn Progress,
    ) {
        let of_few = links.saturating_mul(RAYS_PER_LINK_OF_FEW).min(MANY_RAYS);
        let rays = links.saturating_mul(RAYS_PER_LINK).max(of_few).min(MOST_RAYS) as u32;
        let Landings { flight, on } = landings(hierarchy, forest, light, tracer, (rays, time), progress);
        self.flight = Some(flight);
        self.landed.resize(on.len(), 0);
        for (landed, now) in self.landed.iter_mut().zip(on) {
            *landed += now;
        }
    }

    /// What elements have to receive over what links bring, so that it is shared out as the rays have landed. The light
    /// changes from look to look, but what rays find over what links bring does so little.
    pub(super) fn shared(&mut self, arrived: &Arrived<'_>) -> (Gains, Surplus) {
        let brought: f64 = arrived.forest.leaves().map(|leaf| f64::from(arrived.brought(leaf))).sum();
        let landed: f64 = self.landed.iter().map(|&landed| f64::from(landed)).sum();
        let expected: f64 = self.expected.iter().map(|&expected| f64::from(expected)).sum();
        let rays = if brought > 0.0 { (landed - expected) / brought } else { 0.0 };
        self.expected.resize(self.landed.len(), 0.0);
        for leaf in arrived.forest.leaves() {
            self.expected[leaf] += (f64::from(arrived.brought(leaf)) * rays) as f32;
        }
        Sharing { arrived, landed: &self.landed, expected: &self.expected }.shared()
    }

    /// Whether it has not been looked yet.
    pub(super) fn is_blind(&self) -> bool {
        self.flight.is_none()
    }

    /// Corrects the factor by what came of the power that surfaces `sent` out before an iteration, `after` it.
    pub(super) fn follow(&mut self, forest: &Forest, sent: f64, after: &Light) {
        let Some(flight) = self.flight else { return };
        let landing = (1.0 - flight.escaped - flight.on_backs).max(0.0);
        let over_links = after.received(forest) / f64::from(self.factor);
        let off = landing * sent / over_links - 1.0;
        let noise = NOISE * NOISE * (1.0 - landing) / (landing * f64::from(flight.rays));
        let share = off * off / (off * off + noise);
        // Nothing is off, or nothing is on its way.
        let factor = if share.is_finite() { 1.0 + off * share } else { 1.0 };
        self.factor = factor.clamp(1.0 / MOST, MOST) as f32;
    }
}

/// One flight of light, over links and with rays.
pub(super) struct Arrived<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) forest: &'a Forest,
    /// The light after it, as links have brought it.
    pub(super) light: &'a Light,
    /// What was taken of what links brought.
    pub(super) damping: &'a Damping,
    /// What was over what links brought.
    pub(super) gains: &'a Gains,
    /// Likewise.
    pub(super) surplus: &'a Surplus,
    /// What no link carries, over what links bring: where rays land too seldom to say more, it is as this says.
    pub(super) strays: &'a Gains,
}

impl Arrived<'_> {
    /// Power of a leaf element that links have brought and stray light, summed over channels, local areas.
    fn brought(&self, element: usize) -> f32 {
        self.by_links(element) * self.strays.of(element as u32) * self.forest.area[element]
    }

    /// Irradiance of a leaf element that links have brought, summed over channels, before it was damped.
    fn by_links(&self, element: usize) -> f32 {
        let irradiance = self.light.irradiance[element];
        let gain = self.surplus.gain(element as u32, self.gains, irradiance) * self.damping.share(element);
        irradiance.element_sum() / gain.max(LEAST_GAINED)
    }
}

/// Light is shared out as rays have landed.
struct Sharing<'a> {
    arrived: &'a Arrived<'a>,
    /// How many have, by leaf element.
    landed: &'a [u32],
    /// How many would have by links.
    expected: &'a [f32],
}

impl Sharing<'_> {
    fn shared(&self) -> (Gains, Surplus) {
        let Arrived { hierarchy, forest, .. } = *self.arrived;
        let mut below = Vec::new();
        let of_sides: Vec<Share> = (0..forest.side_count()).map(|side| self.side(side, &mut below)).collect();
        let of_facet = |facet| forest.sides_of(facet).map(|side| of_sides[side]).sum();
        let mut of_clusters = vec![Share::default(); hierarchy.cluster_count()];
        hierarchy.sum_up(&mut of_clusters, of_facet, |sum: &mut Share, below| {
            *sum = [*sum, *below].into_iter().sum();
        });
        let of_node = |node: u32| match hierarchy.nodes[node as usize].kind(node) {
            NodeKind::Leaf(facet) => of_facet(facet),
            NodeKind::Cluster(_) => of_clusters[hierarchy.cluster_place(node)],
        };
        let mut gains = vec![1.0; hierarchy.nodes.len()];
        let mut of_elements = vec![1.0; forest.len()];
        for (index, node) in hierarchy.nodes.iter().enumerate() {
            match node.kind(index as u32) {
                NodeKind::Cluster([a, b]) => {
                    let halves = Share::gains(of_node(a), of_node(b), gains[index]);
                    [gains[a as usize], gains[b as usize]] = halves.map(|half| gains[index] * half);
                }
                NodeKind::Leaf(facet) => {
                    let sides = forest.sides_of(facet);
                    let halves = match of_sides[sides.clone()] {
                        [front, back] => Share::gains(front, back, gains[index]),
                        _ => [1.0; 2],
                    };
                    for (side, half) in sides.zip(halves) {
                        self.share_side(side, gains[index] * half, &mut below, &mut of_elements);
                    }
                }
            }
        }
        self.parted(of_elements)
    }

    /// What comes to each element of a side, and to all of it.
    fn side(&self, side: usize, below: &mut Vec<Share>) -> Share {
        let forest = self.arrived.forest;
        let elements = forest.elements_of(side);
        let first = elements.start;
        below.clear();
        below.resize(elements.len(), Share::default());
        for element in elements.rev() {
            below[element - first] = match forest.second[element] as usize {
                0 => Share { landed: self.landed[element], expected: self.expected[element] },
                second => [below[element + 1 - first], below[second - first]].into_iter().sum(),
            };
        }
        below[0]
    }

    /// The gains of the elements of a side that has this gain itself.
    fn share_side(&self, side: usize, gain: f32, below: &mut Vec<Share>, gains: &mut [f32]) {
        self.side(side, below);
        let forest = self.arrived.forest;
        let elements = forest.elements_of(side);
        let first = elements.start;
        gains[first] = gain;
        for element in elements {
            let second = forest.second[element] as usize;
            if second != 0 {
                let halves = Share::gains(below[element + 1 - first], below[second - first], gains[element]);
                [gains[element + 1], gains[second]] = halves.map(|half| gains[element] * half);
            }
        }
    }

    /// What is less than links bring as a factor, and what is more as an amount.
    fn parted(&self, mut gains: Vec<f32>) -> (Gains, Surplus) {
        let mut surplus = vec![0.0; gains.len()];
        let arrived = self.arrived;
        for leaf in arrived.forest.leaves() {
            let gain = (gains[leaf] * arrived.strays.of(leaf as u32)).max(LEAST_GAINED);
            surplus[leaf] = (gain - 1.0).max(0.0) * arrived.by_links(leaf);
            gains[leaf] = gain.min(1.0);
        }
        (Gains::from_factors(gains), Surplus::of_elements(surplus))
    }
}

/// What comes to a part of the scene in one flight.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    /// Rays that landed there.
    landed: u32,
    /// Rays that would have by links.
    expected: f32,
}

impl Share {
    /// What two halves receive over what they would by their links; `gain` is what both do.
    fn gains(a: Share, b: Share, gain: f32) -> [f32; 2] {
        let both: Share = [a, b].into_iter().sum();
        let expected = [a, b].map(|half| f64::from(half.expected) / f64::from(both.expected));
        if both.landed < FEWEST_LANDED || !(expected[0] > 0.0 && expected[1] > 0.0) {
            return [1.0; 2];
        }
        let rays = f64::from(both.landed);
        let off = f64::from(a.landed) / rays - expected[0];
        // One ray more or less tells nothing where none is expected.
        let chance = rays * expected[0] * expected[1] + CHANCE[0] * CHANCE[0];
        let errors = off.abs() * rays / chance.sqrt();
        let moved = off * ((errors - CHANCE[0]) / (CHANCE[1] - CHANCE[0])).clamp(0.0, 1.0);
        // What the one half cannot take stays with the other.
        let most = (MOST_GAINED / f64::from(gain)).max(1.0) - 1.0;
        let moved = moved.clamp(-most * expected[1], most * expected[0]);
        [1.0 + moved / expected[0], 1.0 - moved / expected[1]].map(|gain| gain.max(0.0) as f32)
    }
}

impl Sum for Share {
    fn sum<I: Iterator<Item = Share>>(shares: I) -> Share {
        shares.fold(Share::default(), |a, b| Share {
            landed: a.landed + b.landed,
            expected: a.expected + b.expected,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::scene;
    use glam::Vec3;
    use std::path::Path;

    #[test]
    fn halves_follow_many_rays_and_few_hardly() {
        let share = |landed, expected| Share { landed, expected };
        // Links bring as much to one half as to the other, rays land three to one.
        let [a, b] = Share::gains(share(75_000, 2.0), share(25_000, 2.0), 1.0);
        assert!((a - 1.5).abs() < 1e-3 && (b - 0.5).abs() < 1e-3, "{a} {b}");
        // What may be chance is left as it is, and light is neither lost nor made.
        assert_eq!(Share::gains(share(5100, 3.0), share(4900, 3.0), 1.0), [1.0; 2]);
        let [a, b] = Share::gains(share(5200, 3.0), share(4800, 3.0), 1.0);
        assert!(a > 1.005 && a < 1.04 && ((a + b) - 2.0).abs() < 1e-6, "{a} {b}");
        assert_eq!(Share::gains(share(40, 1.0), share(0, 1.0), 1.0), [1.0; 2]);
        assert_eq!(Share::gains(share(2, 0.001), share(62, 0.999), 1.0), [1.0; 2]);
        // What no link reaches, no factor lights.
        assert_eq!(Share::gains(share(1000, 1.0), share(1000, 0.0), 1.0), [1.0; 2]);
        assert_eq!(Share::gains(share(1000, 0.0), share(1000, 0.0), 1.0), [1.0; 2]);
        // There is a most, and what is over that stays where it is.
        let [a, b] = Share::gains(share(5000, 1.0), share(5000, 99.0), 2.0);
        assert!((a - 2.0).abs() < 1e-6 && (b - 98.0 / 99.0).abs() < 1e-6, "{a} {b}");
    }

    /// All elements of a scene lit alike, and many more rays on some of them than on others.
    #[test]
    fn light_is_where_rays_land_however_often_it_is_shared_out() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.toml");
        let scene = scene::load(&path, &Default::default(), &Silent).expect("a scene of the project");
        let hierarchy = Hierarchy::build(&scene, false, &Silent);
        let forest = Forest::new(&hierarchy);
        let brought = vec![Vec3::new(1.0, 2.0, 3.0); forest.len()];
        // None on the first quarter, and twice as many on the last as between.
        let times = |element: usize| [0.0, 1.0, 1.0, 2.0][4 * element / forest.len()];
        let landed: Vec<u32> = (0..forest.len()).map(|e| (1e8 * forest.area[e] * times(e)) as u32).collect();
        let strays = Gains::none(forest.len());
        let mut conservation = Conservation::beginning_with(1.0);
        conservation.landed = vec![0; forest.len()];
        let (mut gains, mut surplus) = (Gains::none(forest.len()), Surplus::default());
        let mut before = None;
        for _ in 0..3 {
            let received = |e: usize| surplus.added(e as u32, brought[e] * gains.of(e as u32));
            let irradiance: Vec<Vec3> = (0..forest.len()).map(received).collect();
            let light = Light { irradiance, ..Light::default() };
            let arrived = Arrived {
                hierarchy: &hierarchy,
                forest: &forest,
                light: &light,
                damping: &Damping::none(forest.len()),
                gains: &gains,
                surplus: &surplus,
                strays: &strays,
            };
            conservation.landed.iter_mut().zip(&landed).for_each(|(all, now)| *all += now);
            (gains, surplus) = conservation.shared(&arrived);
            let power = |e: usize| {
                let irradiance = surplus.added(e as u32, brought[e] * gains.of(e as u32));
                f64::from(irradiance.element_sum() * forest.area[e])
            };
            let received: Vec<f64> = forest.leaves().map(power).collect();
            let (all, rays) = (received.iter().sum::<f64>(), forest.leaves().map(|e| landed[e]).sum::<u32>());
            let whole: f64 = forest.leaves().map(|e| f64::from(6.0 * forest.area[e])).sum();
            assert!((all / whole - 1.0).abs() < 1e-4, "{all} of {whole}");
            for (leaf, power) in forest.leaves().zip(&received) {
                let expected = f64::from(landed[leaf]) / f64::from(rays);
                assert!((power / all - expected).abs() < 1e-3, "{leaf}: {} for {expected}", power / all);
            }
            let now = gains.factors().to_vec();
            assert!(
                before.is_none_or(|before: Vec<f32>| before
                    .iter()
                    .zip(&now)
                    .all(|(a, b)| (a - b).abs() < 1e-3))
            );
            before = Some(now);
        }
    }
}
