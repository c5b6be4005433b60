//! A few segments side by side: each step tests all of them against one box or one triangle. What a
//! test passes over is missed for certain, by the bounds of what single precision rounds away; what it lets
//! through is looked at again, in double precision.

use super::Segment;
use glam::Vec3;

/// What is less in a direction counts as this much.
const LEAST_DIRECTION: f32 = 1e-18;

/// Ranges of a box grow by this share: two subtractions, two inverses and two products, each rounded.
const BOX_SLACK: f32 = 1.0 + 1e-6;

/// Rounding of the side on which a segment passes an edge, relative to the largest of its products: some
/// 40 roundings, of which there are fewer than 30.
const SIDE_SLACK: f32 = 40.0 * f32::EPSILON / 2.0;

/// Segments as lanes: by axis, then by segment.
pub(super) struct Lanes<const N: usize> {
    origin: [[f32; N]; 3],
    direction: [[f32; N]; 3],
    inverse: [[f32; N]; 3],
    /// `origin × direction`: with the direction, the Plücker coordinates of the line.
    moment: [[f32; N]; 3],
    /// Bound of [`SIDE_SLACK`] for an edge whose longest coordinate is 1.
    slack: [f32; N],
    /// 1, or below 0 for a segment that is not looked at any more.
    end: [f32; N],
}

/// An edge as a line: where it goes, and its moment.
struct Edge {
    along: [f32; 3],
    moment: [f32; 3],
}

impl Edge {
    #[inline(always)]
    fn new(from: Vec3, to: Vec3) -> Edge {
        let along = to - from;
        Edge { along: along.to_array(), moment: from.cross(along).to_array() }
    }
}

/// The smaller one; unlike `f32::min` a single instruction, since no lane holds anything but numbers.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// By halves, as vectors are folded.
#[inline(always)]
fn largest<const N: usize>(mut values: [f32; N]) -> f32 {
    let mut half = N / 2;
    while half > 0 {
        for lane in 0..half {
            values[lane] = greater(values[lane], values[lane + half]);
        }
        half /= 2;
    }
    values[0]
}

impl<const N: usize> Lanes<N> {
    /// Lanes of segments in a scene that reaches out to `extent` along every axis.
    pub(super) fn new(segments: &[Segment], extent: f32) -> Lanes<N> {
        let mut lanes = Lanes {
            origin: [[0.0; N]; 3],
            direction: [[0.0; N]; 3],
            inverse: [[0.0; N]; 3],
            moment: [[0.0; N]; 3],
            slack: [0.0; N],
            end: [-1.0; N],
        };
        for (lane, segment) in segments.iter().enumerate() {
            let direction = segment.to - segment.from;
            let moment = segment.from.as_dvec3().cross(direction.as_dvec3()).as_vec3();
            for axis in 0..3 {
                let along = direction[axis];
                let least = if along < 0.0 { -LEAST_DIRECTION } else { LEAST_DIRECTION };
                let safe = if along.abs() < LEAST_DIRECTION { least } else { along };
                lanes.origin[axis][lane] = segment.from[axis];
                lanes.direction[axis][lane] = along;
                lanes.inverse[axis][lane] = 1.0 / safe;
                lanes.moment[axis][lane] = moment[axis];
            }
            let largest = direction.abs().max_element() * extent + moment.abs().max_element();
            lanes.slack[lane] = SIDE_SLACK * largest;
            lanes.end[lane] = 1.0;
        }
        lanes
    }

    /// Does not look at a segment any more.
    pub(super) fn close(&mut self, lane: usize) {
        self.end[lane] = -1.0;
    }

    /// Whether any segment may pass through a box.
    #[inline(always)]
    pub(super) fn enter(&self, min: Vec3, max: Vec3) -> bool {
        let mut enters = [0.0; N];
        let mut leaves = self.end;
        for axis in 0..3 {
            let (origin, inverse) = (&self.origin[axis], &self.inverse[axis]);
            for lane in 0..N {
                let first = (min[axis] - origin[lane]) * inverse[lane];
                let second = (max[axis] - origin[lane]) * inverse[lane];
                enters[lane] = greater(enters[lane], lesser(first, second));
                leaves[lane] = lesser(leaves[lane], greater(first, second));
            }
        }
        let mut room = [0.0; N];
        for lane in 0..N {
            room[lane] = leaves[lane] * BOX_SLACK - enters[lane];
        }
        largest(room) >= 0.0
    }

    /// Which segments' lines may meet a triangle, a bit for each.
    #[inline(always)]
    pub(super) fn meet(&self, [a, b, c]: [Vec3; 3]) -> u32 {
        let edges = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
        let mut longest = 0.0;
        for edge in &edges {
            for along in edge.along {
                longest = greater(longest, along.abs());
            }
        }
        let (mut low, mut high) = ([f32::MAX; N], [f32::MIN; N]);
        for edge in &edges {
            let mut side = [0.0; N];
            for axis in 0..3 {
                for lane in 0..N {
                    side[lane] += self.direction[axis][lane] * edge.moment[axis]
                        + self.moment[axis][lane] * edge.along[axis];
                }
            }
            for lane in 0..N {
                low[lane] = lesser(low[lane], side[lane]);
                high[lane] = greater(high[lane], side[lane]);
            }
        }
        let mut met = [0u32; N];
        for lane in 0..N {
            let slack = self.slack[lane] * longest;
            let is_met = (low[lane] >= -slack || high[lane] <= slack) && self.end[lane] > 0.0;
            met[lane] = u32::from(is_met) << lane;
        }
        let mut all = 0;
        for one in met {
            all |= one;
        }
        all
    }
}
