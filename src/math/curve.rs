//! A smooth curve through points at given times, for what moves.
//!
//! Catmull & Rom, *A class of local interpolating splines*, 1974: cubic pieces whose velocity at a point follows from its
//! two neighbours. For times with uneven steps it is that of the parabola through the three points (de Boor, *A Practical
//! Guide to Splines*, chapter IV).

use glam::DVec3;

/// How much faster than its slower neighbouring piece, on average, a point may be passed: more would let the curve swing
/// far beyond the points (Fritsch & Carlson, *Monotone piecewise cubic interpolation*, 1980).
const FASTEST: f64 = 3.0;

/// A curve with a steady velocity through points, at rest wherever one of two points that follow each other repeats the
/// other.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    times: &'a [f64],
    points: Vec<DVec3>,
    /// Velocity at each point.
    velocities: Vec<DVec3>,
}

impl<'a> Curve<'a> {
    /// Through `points` at `times`, which rise; as many of one as of the other, at least 2.
    pub fn through(times: &'a [f64], points: Vec<DVec3>) -> Curve<'a> {
        debug_assert!(times.len() == points.len() && times.len() >= 2);
        debug_assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
        let last = points.len() - 1;
        let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let slopes: Vec<DVec3> =
            points.windows(2).zip(&steps).map(|(pair, step)| (pair[1] - pair[0]) / step).collect();
        let mut velocities = vec![DVec3::ZERO; points.len()];
        for i in 1..last {
            let (before, after) = (slopes[i - 1], slopes[i]);
            let share = steps[i] / (steps[i - 1] + steps[i]);
            let most = FASTEST * before.length().min(after.length());
            velocities[i] = (before * share + after * (1.0 - share)).clamp_length_max(most);
        }
        // At the ends without acceleration; with two points only that is a straight line at an even speed.
        let end = |slope: DVec3, inner: DVec3| {
            ((slope * 3.0 - inner) * 0.5).clamp_length_max(FASTEST * slope.length())
        };
        let inner = |at: usize, slope: DVec3| if last == 1 { slope } else { velocities[at] };
        let (first, final_one) =
            (end(slopes[0], inner(1, slopes[0])), end(slopes[last - 1], inner(last - 1, slopes[last - 1])));
        (velocities[0], velocities[last]) = (first, final_one);
        Curve { times, points, velocities }
    }

    /// The point at a time; before the first and after the last time the points there.
    pub fn at(&self, time: f64) -> DVec3 {
        let last = self.times.len() - 1;
        let after = self.times.partition_point(|&other| other <= time).clamp(1, last);
        let (i, j) = (after - 1, after);
        let step = self.times[j] - self.times[i];
        let s = ((time - self.times[i]) / step).clamp(0.0, 1.0);
        // The cubic of Hermite.
        let r = 1.0 - s;
        self.points[i] * (r * r * (1.0 + 2.0 * s))
            + self.points[j] * (s * s * (1.0 + 2.0 * r))
            + (self.velocities[i] * r - self.velocities[j] * s) * (r * s * step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn velocity(curve: &Curve<'_>, time: f64) -> DVec3 {
        (curve.at(time + 1e-6) - curve.at(time - 1e-6)) / 2e-6
    }

    #[test]
    fn a_straight_move_stays_straight_and_even_whatever_the_steps() {
        let line = |t: f64| DVec3::new(1.0, 2.0, -3.0) * t + DVec3::splat(4.0);
        for times in [&[0.0, 1.0][..], &[0.0, 0.5, 7.0, 7.5]] {
            let curve = Curve::through(times, times.iter().map(|&t| line(t)).collect());
            for i in 0..=50 {
                let t = times[times.len() - 1] * f64::from(i) / 50.0;
                assert!(curve.at(t).distance(line(t)) < 1e-12, "{t}");
            }
            assert_eq!((curve.at(-9.0), curve.at(99.0)), (line(0.0), line(times[times.len() - 1])));
        }
    }

    #[test]
    fn eight_points_of_a_circle_make_nearly_one() {
        let times: Vec<f64> = (0..=16).map(f64::from).collect();
        let on = |t: f64| {
            let angle = t * std::f64::consts::TAU / 8.0;
            DVec3::new(angle.cos(), 0.0, angle.sin())
        };
        let curve = Curve::through(&times, times.iter().map(|&t| on(t)).collect());
        for i in 80..=320 {
            let t = f64::from(i) / 40.0 + 2.0;
            assert!(curve.at(t).distance(on(t)) < 0.02, "{t}: {} for {}", curve.at(t), on(t));
        }
    }

    #[test]
    fn where_points_repeat_it_stands_still() {
        let times = [0.0, 1.0, 2.0, 3.0];
        let (a, b) = (DVec3::X, DVec3::new(2.0, 5.0, 1.0));
        let curve = Curve::through(&times, vec![a, b, b, a]);
        for i in 0..=20 {
            assert_eq!(curve.at(1.0 + f64::from(i) / 20.0), b);
        }
    }

    proptest! {
        /// It meets its points, has no jump in its velocity, and does not swing far.
        #[test]
        fn smooth_through_all_points(
            knots in prop::collection::vec((0.5f64..10.0, prop::array::uniform3(-5.0f64..5.0)), 2..9)
        ) {
            let mut times = Vec::new();
            for (step, _) in &knots {
                times.push(times.last().unwrap_or(&0.0) + step);
            }
            let points: Vec<DVec3> = knots.iter().map(|(_, point)| DVec3::from_array(*point)).collect();
            let curve = Curve::through(&times, points.clone());
            for (&time, &point) in times.iter().zip(&points) {
                prop_assert!(curve.at(time).distance(point) < 1e-9);
            }
            for (i, pair) in points.windows(2).enumerate() {
                for part in 0..=10 {
                    let at = curve.at(times[i] + (times[i + 1] - times[i]) * f64::from(part) / 10.0);
                    let beyond = at.distance(pair[0]).min(at.distance(pair[1]));
                    prop_assert!(beyond <= 1.5 * pair[0].distance(pair[1]) + 1e-9);
                }
            }
            for &time in &times[1..times.len() - 1] {
                let (before, after) = (velocity(&curve, time - 2e-6), velocity(&curve, time + 2e-6));
                prop_assert!(before.distance(after) < 1e-2 * (1.0 + before.length()));
            }
        }
    }
}
