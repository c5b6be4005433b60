//! Places for labels beside points of a plot, so that none meets another one or a point.

/// Left, top, right and bottom, pixels.
pub(super) type Frame = [i32; 4];

/// Height of a label, pixels, and about the width of one of its letters.
const HEIGHT: i32 = 15;
const LETTER: f64 = 7.0;

/// Half of what a point takes up, pixels, and how far from its middle a label begins.
const POINT: i32 = 5;
const BESIDE: i32 = 8;

/// A point with its label.
pub(super) struct Labelled<'a> {
    /// Its place, pixels.
    pub(super) at: (i32, i32),
    pub(super) label: &'a str,
}

/// The left top corner of each label, where there is room for it within the frame. Where there is a choice, labels stay
/// away from lines, too.
pub(super) fn places(
    points: &[Labelled<'_>],
    lines: &[[(i32, i32); 2]],
    frame: Frame,
) -> Vec<Option<(i32, i32)>> {
    let mut taken: Vec<Frame> = points.iter().map(|point| around(point.at)).collect();
    let on_lines: Vec<(i32, i32)> = lines.iter().flat_map(along).collect();
    let place = |point: &Labelled<'_>| {
        let width = (LETTER * point.label.chars().count() as f64).ceil() as i32;
        let free = corners(point.at, width).into_iter().filter(|&(x, y)| {
            let own = [x, y, x + width, y + HEIGHT];
            let is_inside =
                own[0] >= frame[0] && own[1] >= frame[1] && own[2] <= frame[2] && own[3] <= frame[3];
            is_inside && !taken.iter().any(|other| meet(own, *other))
        });
        let covered = |&(x, y): &(i32, i32)| {
            let is_within =
                |&&(a, b): &&(i32, i32)| (x..x + width).contains(&a) && (y..y + HEIGHT).contains(&b);
            on_lines.iter().filter(is_within).count()
        };
        let (x, y) = free.min_by_key(covered)?;
        taken.push([x, y, x + width, y + HEIGHT]);
        Some((x, y))
    };
    points.iter().map(place).collect()
}

/// Corners to try, the best first.
fn corners((x, y): (i32, i32), width: i32) -> [(i32, i32); 8] {
    let (right, left) = (x + BESIDE, x - BESIDE - width);
    let (above, below) = (y - HEIGHT - 2, y + 2);
    let (middle, level) = (x - width / 2, y - HEIGHT / 2);
    [
        (right, below),
        (right, above),
        (left, below),
        (left, above),
        (right, level),
        (left, level),
        (middle, above - BESIDE / 2),
        (middle, below + BESIDE / 2),
    ]
}

/// Points along a line, a few pixels apart.
fn along(&[from, to]: &[(i32, i32); 2]) -> impl Iterator<Item = (i32, i32)> {
    let steps = (to.0 - from.0).abs().max((to.1 - from.1).abs()) / 3 + 1;
    (0..=steps).map(move |step| {
        let part = |a: i32, b: i32| a + (b - a) * step / steps;
        (part(from.0, to.0), part(from.1, to.1))
    })
}

fn around((x, y): (i32, i32)) -> Frame {
    [x - POINT, y - POINT, x + POINT, y + POINT]
}

fn meet(a: Frame, b: Frame) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = [0, 0, 400, 300];

    fn placed(points: &[(i32, i32)]) -> Vec<Frame> {
        let labelled: Vec<_> = points.iter().map(|&at| Labelled { at, label: "16 rays" }).collect();
        let places = places(&labelled, &[], FRAME);
        places.into_iter().flatten().map(|(x, y)| [x, y, x + 49, y + HEIGHT]).collect()
    }

    #[test]
    fn no_label_meets_another_one_or_a_point() {
        // Ten curves of two points each, all but on top of each other, as those of two tracers are.
        let points: Vec<(i32, i32)> =
            (0..20).map(|i| (150 + 3 * (i % 10), 120 + 40 * (i / 10) + i % 4)).collect();
        let labels = placed(&points);
        assert!(labels.len() >= 4, "{labels:?}");
        for (index, label) in labels.iter().enumerate() {
            assert!(labels[..index].iter().all(|other| !meet(*label, *other)), "{labels:?}");
            assert!(points.iter().all(|&point| !meet(*label, around(point))), "{label:?}");
            assert!(label[0] >= 0 && label[1] >= 0 && label[2] <= 400 && label[3] <= 300, "{label:?}");
        }
    }

    #[test]
    fn points_apart_all_have_labels_even_in_corners() {
        assert_eq!(placed(&[(5, 5), (395, 295), (200, 150), (5, 295), (395, 5)]).len(), 5);
    }

    #[test]
    fn labels_stay_away_from_lines() {
        let points = [Labelled { at: (100, 100), label: "4 rays" }];
        let line = [[(100, 100), (180, 110)]];
        assert_eq!(places(&points, &line, FRAME), [Some((108, 83))]);
        // Where there is no choice they do not.
        assert_eq!(places(&points, &line, [99, 99, 200, 200]), [Some((108, 102))]);
    }
}
