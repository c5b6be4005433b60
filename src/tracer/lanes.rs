//! A few segments side by side: each step tests all of them against one box or one triangle. What a
//! test passes over is missed for certain, by the bounds of what single precision rounds away, and some of what it lets
//! through is hit for certain; the rest is looked at again, in double precision.
//!
//! Certain is what is so exactly. The test in double precision says the same, unless a segment begins some thousand times
//! the size of the scene away and the triangle is tiny: then it is that test which rounds too much.

use super::{END_MARGIN, Segment};
use glam::Vec3;

/// What is less in a direction is as good as 0: its inverse is that of this.
pub(super) const LEAST_DIRECTION: f32 = 1e-18;

/// Ranges of a box grow by this share: two subtractions, two inverses and two products, each rounded.
const BOX_SLACK: f32 = 1.0 + 1e-6;

/// Rounding of the side on which a segment passes an edge, relative to the product of the longest coordinates of direction,
/// scene and edge, 38 roundings, and of moment and edge, 15 of them.
const SIDE_SLACK: f32 = 40.0 * f32::EPSILON / 2.0;

/// Where a segment passes the plane of a triangle, see [`Lanes::pass`], relative to the square of its longest coordinate:
/// what is rounded away for each unit of length that it may be from the origin, fewer than 100 roundings, and the part of
/// the segment at both ends that does not count.
const PLANE_SLACK: [f32; 2] = [256.0 * f32::EPSILON / 2.0, 4.0 * END_MARGIN];

/// Segments as lanes: by axis, then by segment.
pub(super) struct Lanes<const N: usize> {
    origin: [[f32; N]; 3],
    direction: [[f32; N]; 3],
    inverse: [[f32; N]; 3],
    /// `origin × direction`: with the direction, the Plücker coordinates of the line.
    moment: [[f32; N]; 3],
    /// Bound of [`SIDE_SLACK`] for an edge whose longest coordinate is 1.
    slack: [f32; N],
    /// Bound of [`PLANE_SLACK`] for a triangle whose longest coordinate is 1.
    depth: [f32; N],
    /// 1, or below 0 for a segment that is not looked at any more.
    end: [f32; N],
}

/// The edges of a triangle as lines: by axis, then by edge; the last one is the first once more.
struct Edges {
    /// Where they go.
    along: [[f32; 4]; 3],
    moment: [[f32; 4]; 3],
}

impl Edges {
    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3]) -> Edges {
        let from = [[a.x, b.x, c.x, a.x], [a.y, b.y, c.y, a.y], [a.z, b.z, c.z, a.z]];
        let to = [[b.x, c.x, a.x, b.x], [b.y, c.y, a.y, b.y], [b.z, c.z, a.z, b.z]];
        let (mut along, mut moment) = ([[0.0; 4]; 3], [[0.0; 4]; 3]);
        for axis in 0..3 {
            for edge in 0..4 {
                along[axis][edge] = to[axis][edge] - from[axis][edge];
            }
        }
        for (axis, moment) in moment.iter_mut().enumerate() {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            for edge in 0..4 {
                moment[edge] = from[i][edge] * along[j][edge] - from[j][edge] * along[i][edge];
            }
        }
        Edges { along, moment }
    }

    /// The longest coordinate of any of them.
    #[inline(always)]
    fn longest(&self) -> f32 {
        let mut longest = 0.0;
        for along in &self.along {
            for along in &along[..3] {
                longest = greater(longest, along.abs());
            }
        }
        longest
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

/// How far one of some vectors goes along a direction.
#[inline(always)]
fn along<const N: usize>(direction: Vec3, vectors: &[[f32; N]; 3], lane: usize) -> f32 {
    direction.x * vectors[0][lane] + direction.y * vectors[1][lane] + direction.z * vectors[2][lane]
}

#[inline(always)]
fn union<const N: usize>(bits: [u32; N]) -> u32 {
    let mut all = 0;
    for one in bits {
        all |= one;
    }
    all
}

impl<const N: usize> Lanes<N> {
    /// Lanes of segments in a scene that reaches out to `extent` along every axis.
    #[inline(always)]
    pub(super) fn new(segments: &[Segment], extent: f32) -> Lanes<N> {
        let (mut origin, mut direction, mut end) = ([[0.0; N]; 3], [[0.0; N]; 3], [-1.0; N]);
        for (lane, segment) in segments.iter().enumerate() {
            let along = segment.to - segment.from;
            for axis in 0..3 {
                origin[axis][lane] = segment.from[axis];
                direction[axis][lane] = along[axis];
            }
            end[lane] = 1.0;
        }
        let (mut inverse, mut moment) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        let (mut reach, mut longest, mut turned) = ([extent; N], [0.0; N], [0.0; N]);
        for axis in 0..3 {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            for lane in 0..N {
                let along = direction[axis][lane];
                let least = if along < 0.0 { -LEAST_DIRECTION } else { LEAST_DIRECTION };
                let safe = if along.abs() < LEAST_DIRECTION { least } else { along };
                inverse[axis][lane] = 1.0 / safe;
                let [oi, oj] = [origin[i][lane], origin[j][lane]].map(f64::from);
                let [di, dj] = [direction[i][lane], direction[j][lane]].map(f64::from);
                moment[axis][lane] = (oi * dj - oj * di) as f32;
                reach[lane] = greater(reach[lane], origin[axis][lane].abs() + along.abs());
                longest[lane] = greater(longest[lane], along.abs());
                turned[lane] = greater(turned[lane], moment[axis][lane].abs());
            }
        }
        let (mut slack, mut depth) = ([0.0; N], [0.0; N]);
        for lane in 0..N {
            slack[lane] = SIDE_SLACK * (longest[lane] * extent + turned[lane]);
            depth[lane] = PLANE_SLACK[0] * reach[lane] + PLANE_SLACK[1];
        }
        Lanes { origin, direction, inverse, moment, slack, depth, end }
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
        let mut any = 0u32;
        for lane in 0..N {
            any |= u32::from(leaves[lane] * BOX_SLACK >= enters[lane]);
        }
        any != 0
    }

    /// Which segments' lines may meet a triangle, and which of these pass it inside for certain: a bit for each, the
    /// latter `N` bits further up.
    #[inline(always)]
    fn sides(&self, edges: &Edges, longest: f32) -> u32 {
        let (mut low, mut high) = ([f32::MAX; N], [f32::MIN; N]);
        let ([dx, dy, dz], [mx, my, mz]) = (&self.direction, &self.moment);
        let ([ax, ay, az], [bx, by, bz]) = (&edges.along, &edges.moment);
        for edge in 0..3 {
            for lane in 0..N {
                let side = dx[lane] * bx[edge]
                    + dy[lane] * by[edge]
                    + dz[lane] * bz[edge]
                    + mx[lane] * ax[edge]
                    + my[lane] * ay[edge]
                    + mz[lane] * az[edge];
                low[lane] = lesser(low[lane], side);
                high[lane] = greater(high[lane], side);
            }
        }
        // Most triangles no segment meets, and that is found sooner than which.
        let mut any = 0;
        for lane in 0..N {
            let slack = self.slack[lane] * longest;
            let is_met = (low[lane] >= -slack || high[lane] <= slack) && self.end[lane] > 0.0;
            any |= u32::from(is_met);
        }
        if any == 0 {
            return 0;
        }
        let mut bits = [0u32; N];
        for lane in 0..N {
            let slack = self.slack[lane] * longest;
            let is_open = self.end[lane] > 0.0;
            let is_met = (low[lane] >= -slack || high[lane] <= slack) && is_open;
            let is_inside = (low[lane] > slack || high[lane] < -slack) && is_open;
            bits[lane] = u32::from(is_met) << lane | u32::from(is_inside) << (lane + N);
        }
        union(bits)
    }

    /// Which segments pass the plane of a triangle for certain between their ends.
    #[inline(always)]
    fn pass(&self, corner: Vec3, edges: &Edges, longest: f32) -> u32 {
        let [x, y, z] = &edges.along;
        let normal = Vec3::new(x[2], y[2], z[2]).cross(Vec3::new(x[0], y[0], z[0]));
        let offset = normal.dot(corner);
        let square = longest * longest;
        let mut bits = [0u32; N];
        for (lane, bit) in bits.iter_mut().enumerate() {
            let height = offset - along(normal, &self.origin, lane);
            let way = along(normal, &self.direction, lane);
            let height = if way < 0.0 { -height } else { height };
            let slack = self.depth[lane] * square;
            *bit = u32::from(height > slack && height < way.abs() - slack) << lane;
        }
        union(bits)
    }

    /// Which segments may meet a triangle, a bit for each: all of them that do so. And which of these meet it for certain,
    /// between their ends.
    #[inline(always)]
    pub(super) fn meet(&self, corners: [Vec3; 3]) -> [u32; 2] {
        const { assert!(2 * N <= u32::BITS as usize) };
        let edges = Edges::new(corners);
        let longest = edges.longest();
        let sides = self.sides(&edges, longest);
        if sides == 0 {
            return [0; 2];
        }
        let inside = sides >> N;
        let certain = if inside == 0 { 0 } else { inside & self.pass(corners[0], &edges, longest) };
        [sides & ((1 << N) - 1), certain]
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

    /// Of segments and triangles of a size.
    #[derive(Default)]
    struct Meetings {
        /// Segments whose lines meet a triangle.
        met: usize,
        /// Those that were passed over though they do.
        missed: usize,
        /// Let through though they do not.
        needless: usize,
        /// Said to meet it between their ends for certain.
        certain: usize,
        /// Those that do not.
        wrong: usize,
    }

    /// In a scene that reaches out to `extent`, with so many times the bounds of what is rounded away on the sides and
    /// along the segments.
    fn meetings(extent: f32, size: f32, [sides, depth]: [f32; 2]) -> Meetings {
        let mut numbers = Numbers { sequence: PairSequence::new(1), next: 0 };
        let mut counts = Meetings::default();
        for round in 0..3000 {
            let segments = numbers.segments().map(|segment| Segment {
                from: segment.from * extent,
                to: segment.to * extent,
                ..segment
            });
            let mut corners = [(); 3].map(|()| numbers.point(extent));
            corners = corners.map(|corner| corners[0] + (corner - corners[0]) * size);
            // Every other triangle has a corner on a segment, and so its line goes through an edge or a corner; the plane of
            // every fourth goes through the end of one, or a little away from it.
            if round % 2 == 0 {
                let Segment { from, to, .. } = segments[round % COUNT];
                corners[1] = from + (to - from) * 0.5;
            }
            if round % 4 == 1 {
                let Segment { from, to, .. } = segments[round / 4 % COUNT];
                let (end, into) = if round % 8 == 1 { (from, to - from) } else { (to, from - to) };
                let away = into.normalize_or_zero() * ((round / 8 % 32) as f32 * 1e-6);
                let center = corners.into_iter().sum::<Vec3>() / 3.0;
                corners = corners.map(|corner| corner + (end + away - center));
            }
            let reach = corners.iter().map(|corner| corner.abs().max_element()).fold(extent, f32::max);
            let mut lanes = Lanes::<COUNT>::new(&segments, reach);
            lanes.slack = lanes.slack.map(|slack| slack * sides);
            lanes.depth = lanes.depth.map(|slack| slack * depth);
            let [met, certain] = lanes.meet(corners);
            for (lane, segment) in segments.iter().enumerate() {
                let is_let_through = met >> lane & 1 == 1;
                let at = Probe::new(segment.from, segment.to - segment.from).meet(&corners);
                let [near, far] = segment.open_part().map(f64::from);
                counts.met += usize::from(at.is_some());
                counts.missed += usize::from(at.is_some() && !is_let_through);
                counts.needless += usize::from(at.is_none() && is_let_through);
                if certain >> lane & 1 == 1 {
                    counts.certain += 1;
                    counts.wrong += usize::from(!at.is_some_and(|t| t > near && t < far));
                }
            }
        }
        counts
    }

    #[test]
    fn no_triangle_that_is_met_is_passed_over() {
        for size in [1.0, 0.1, 1e-2, 1e-3] {
            let Meetings { met, missed, needless, .. } = meetings(1.0, size, [1.0; 2]);
            assert!(met > 500 && missed == 0, "{size}: {missed} of {met} passed over");
            assert!(needless < 3000 * COUNT / 50, "{size}: {needless} let through");
        }
    }

    #[test]
    fn what_is_certain_is_met_between_the_ends() {
        for (extent, size) in [(1.0, 1.0), (1.0, 0.1), (0.01, 1.0), (0.01, 0.1)] {
            let Meetings { certain, wrong, .. } = meetings(extent, size, [1.0; 2]);
            assert!(certain > 50 && wrong == 0, "{extent}, {size}: {wrong} of {certain} wrong");
        }
    }

    /// Triangles are passed over, and what is certain is not met.
    #[test]
    fn without_slack_some_are_wrong() {
        for (extent, slack) in [(1.0, [0.0, 1.0]), (1.0, [1.0, 0.0]), (0.01, [1.0, 0.1])] {
            let Meetings { missed, certain, wrong, .. } = meetings(extent, 0.1, slack);
            assert!(wrong > 0, "{extent}, {slack:?}: {wrong} of {certain} wrong");
            assert_eq!(missed > 0, slack[0] == 0.0, "{extent}, {slack:?}: {missed} passed over");
        }
    }

    #[test]
    fn any_number_of_lanes_says_the_same() {
        let mut numbers = Numbers { sequence: PairSequence::new(3), next: 0 };
        for _ in 0..1000 {
            let segments = numbers.segments();
            let corners = [(); 3].map(|()| numbers.point(1.0));
            let [met, certain] = Lanes::<COUNT>::new(&segments, 1.0).meet(corners);
            for (part, segments) in segments.chunks(4).enumerate() {
                let expected = [met, certain].map(|bits| bits >> (4 * part) & 0xf);
                assert_eq!(Lanes::<4>::new(segments, 1.0).meet(corners), expected);
            }
        }
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
        assert_eq!(lanes.meet(triangle), [0b11; 2]);
        lanes.close(0);
        assert_eq!(lanes.meet(triangle), [0b10; 2]);
        lanes.close(1);
        assert_eq!(lanes.meet(triangle), [0; 2]);
        assert!(!lanes.enter(Vec3::NEG_ONE, Vec3::ONE));
    }
}
