//! A few segments side by side: each step tests all of them against one box or one triangle. What a
//! test passes over is missed for certain, by the bounds of what single precision rounds away; what it lets
//! through is looked at again, in double precision.

use super::Segment;
use glam::Vec3;

/// What is less in a direction is as good as 0: its inverse is that of this.
pub(super) const LEAST_DIRECTION: f32 = 1e-18;

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
        let ([dx, dy, dz], [mx, my, mz]) = (&self.direction, &self.moment);
        for Edge { along, moment } in &edges {
            for lane in 0..N {
                let side = dx[lane] * moment[0]
                    + dy[lane] * moment[1]
                    + dz[lane] * moment[2]
                    + mx[lane] * along[0]
                    + my[lane] * along[1]
                    + mz[lane] * along[2];
                low[lane] = lesser(low[lane], side);
                high[lane] = greater(high[lane], side);
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

#[cfg(test)]
mod tests {
    use super::super::{NO_FACET, triangle::Probe};
    use super::*;
    use crate::math::PairSequence;

    const COUNT: usize = 16;

    /// Numbers from −1 to 1, of which some are alike and some 0, so that segments lie in planes and along axes.
    struct Numbers {
        sequence: PairSequence,
        next: u32,
    }

    impl Numbers {
        fn point(&mut self, size: f32) -> Vec3 {
            self.next += 1;
            let [x, y, z, kind] = self.sequence.point(self.next);
            let point = Vec3::new(x as f32, y as f32, z as f32) * 2.0 - 1.0;
            match (kind * 8.0) as u32 {
                0 => (point * 2.0).round() * 0.5 * size,
                1 => Vec3::new(point.x, 0.0, 0.25) * size,
                _ => point * size,
            }
        }

        /// Segments, some of which begin far outside or are short.
        fn segments(&mut self) -> [Segment; COUNT] {
            std::array::from_fn(|i| {
                let from = self.point(if i % 4 == 3 { 1e4 } else { 1.0 });
                let to = if i % 8 == 6 { from + self.point(1e-3) } else { self.point(1.0) };
                Segment { from, to, skip: [NO_FACET; 2] }
            })
        }
    }

    /// How many segments meet triangles of a size, how many were passed over though they do, and how many were let
    /// through though they do not.
    fn meetings(size: f32, widen: f32) -> [usize; 3] {
        let mut numbers = Numbers { sequence: PairSequence::new(1), next: 0 };
        let mut counts = [0; 3];
        for round in 0..3000 {
            let segments = numbers.segments();
            let mut lanes = Lanes::<COUNT>::new(&segments, 1.0);
            lanes.slack = lanes.slack.map(|slack| slack * widen);
            let mut corners = [(); 3].map(|()| numbers.point(1.0));
            corners = corners.map(|corner| corners[0] + (corner - corners[0]) * size);
            // Every other triangle has a corner on a segment, and so its line goes through an edge or a corner.
            if round % 2 == 0 {
                let Segment { from, to, .. } = segments[round % COUNT];
                corners[1] = from + (to - from) * 0.5;
            }
            let met = lanes.meet(corners);
            for (lane, segment) in segments.iter().enumerate() {
                let is_let_through = met >> lane & 1 == 1;
                let meets = Probe::new(segment.from, segment.to - segment.from).meet(&corners).is_some();
                counts[0] += usize::from(meets);
                counts[1] += usize::from(meets && !is_let_through);
                counts[2] += usize::from(!meets && is_let_through);
            }
        }
        counts
    }

    #[test]
    fn no_triangle_that_is_met_is_passed_over() {
        for size in [1.0, 0.1, 1e-2, 1e-3] {
            let [met, missed, needless] = meetings(size, 1.0);
            assert!(met > 500 && missed == 0, "{size}: {missed} of {met} passed over");
            assert!(needless < 3000 * COUNT / 50, "{size}: {needless} let through");
        }
    }

    /// Without the bound of what is rounded away some would be.
    #[test]
    fn without_slack_triangles_are_passed_over() {
        assert!(meetings(0.1, -1.0)[1] > 0);
    }

    #[test]
    fn no_box_that_is_entered_is_passed_over() {
        let mut numbers = Numbers { sequence: PairSequence::new(2), next: 0 };
        let (mut entered, mut passed) = (0, 0);
        for _ in 0..20_000 {
            let segment = numbers.segments()[0];
            let lanes = Lanes::<4>::new(&[segment], 1.0);
            let (a, b) = (numbers.point(1.0), numbers.point(1.0));
            let (min, max) = (a.min(b) - 1e-6, a.max(b) + 1e-6);
            // A point of the segment inside the box, but for what the box is grown by.
            let is_entered = (0..=64).any(|i| {
                let at = segment.from.lerp(segment.to, i as f32 / 64.0);
                at.cmpge(min + 5e-7).all() && at.cmple(max - 5e-7).all()
            });
            entered += usize::from(is_entered);
            passed += usize::from(!lanes.enter(min, max));
            assert!(!is_entered || lanes.enter(min, max), "{segment:?} {min} {max}");
        }
        assert!(entered > 2000 && passed > 2000, "{entered} entered, {passed} passed over");
    }

    #[test]
    fn closed_and_idle_lanes_meet_nothing() {
        let segment = Segment { from: Vec3::ZERO, to: Vec3::Z, skip: [NO_FACET; 2] };
        let triangle = [Vec3::new(-1.0, -1.0, 0.5), Vec3::new(1.0, -1.0, 0.5), Vec3::new(0.0, 1.0, 0.5)];
        let mut lanes = Lanes::<4>::new(&[segment; 2], 1.0);
        assert_eq!(lanes.meet(triangle), 0b11);
        lanes.close(0);
        assert_eq!(lanes.meet(triangle), 0b10);
        lanes.close(1);
        assert_eq!(lanes.meet(triangle), 0);
        assert!(!lanes.enter(Vec3::NEG_ONE, Vec3::ONE));
    }
}
