//! How elements are divided: along the lines where other surfaces stand on their facet or cover it first, then in
//! halves. \[LTG93\]

use crate::hierarchy::{Contact, Hierarchy, TOLERANCE, within};
use crate::math::{MAX_VERTICES, Plane, Polygon};
use glam::DVec3;

/// No further cut: divided in halves.
pub(super) const NO_CUT: u32 = u32::MAX;

/// A facet is cut into at most two to the power of this many cells.
const DEEPEST: u32 = 6;

/// No cuts further down than this.
const DEEPEST_HALVED: u32 = 20;

/// An element is cut along a contact that is at least this long, relative to its width and to the line across
/// it that the contact lies on.
const LEAST_CONTACT: f64 = 0.25;

/// A cut leaves at least this share of the area on each side.
const LEAST_SHARE: f64 = 1e-4;

/// How elements are divided where something stands on them or covers them: the long contacts cut a facet into cells, the
/// short ones the elements that have come down to their size.
#[derive(Clone, Debug, Default)]
pub(super) struct Cuts {
    cuts: Vec<Cut>,
    /// The first cut of each facet, or [`NO_CUT`].
    of_facet: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Cut {
    /// The first part lies in front.
    plane: Plane,
    /// Outlines of both parts, seen from the front of the facet.
    parts: [Polygon; 2],
    /// Whether it divides cells.
    between_cells: bool,
    /// The next cuts of both parts.
    below: [u32; 2],
}

impl Cuts {
    /// Cuts along the contacts of all facets, the longest first.
    pub(super) fn of(hierarchy: &Hierarchy) -> Cuts {
        let mut cuts = Cuts::default();
        for facet in 0..hierarchy.facets.len() as u32 {
            let plane = hierarchy.facets[facet as usize].plane;
            let contacts = hierarchy.contacts.on(facet);
            let first = cuts.add(&hierarchy.polygon(facet), &plane, contacts, DEEPEST, 0);
            cuts.of_facet.push(first);
        }
        cuts
    }

    /// The first cut of a facet.
    pub(super) fn first(&self, facet: u32) -> u32 {
        self.of_facet[facet as usize]
    }

    /// Whether both sides of a cut are cells of their own, or more than one.
    pub(super) fn is_between_cells(&self, cut: u32) -> bool {
        self.cuts.get(cut as usize).is_some_and(|cut| cut.between_cells)
    }

    /// The plane along which `cut` divides an outline with this `normal`, which need not have length 1; the first part lies in
    /// front.
    pub(super) fn across(&self, outline: &Polygon, cut: u32, normal: DVec3) -> Plane {
        self.cuts.get(cut as usize).map_or_else(|| outline.cut_plane(normal), |cut| cut.plane)
    }

    /// The outline of a part that `cut` makes.
    fn outline(&self, cut: u32, is_back: bool, part: usize) -> Polygon {
        let outline = self.cuts[cut as usize].parts[part];
        if is_back { outline.flipped() } else { outline }
    }

    /// An outline that is divided by `cut` becomes one of its parts, the first or the second; how that is divided.
    pub(super) fn keep_part(&self, outline: &mut Polygon, cut: u32, is_back: bool, part: usize) -> u32 {
        let Some(Cut { below, .. }) = self.cuts.get(cut as usize) else {
            outline.keep_half(part);
            return NO_CUT;
        };
        *outline = self.outline(cut, is_back, part);
        below[part]
    }

    /// Adds the cuts of a polygon, unless there are none; `cells` is how often it may be cut into cells.
    fn add(&mut self, polygon: &Polygon, plane: &Plane, contacts: &[Contact], cells: u32, depth: u32) -> u32 {
        let mut inside: Vec<(Contact, f64)> =
            contacts.iter().filter_map(|&line| within(line, polygon, plane)).collect();
        let width = polygon.width();
        let length = |line: &Contact| line[0].distance(line[1]);
        let across =
            |[from, to]: Contact| Plane::through(from, plane.normal.cross(to - from).normalize_or_zero());
        inside.sort_by(|(a, _), (b, _)| length(b).total_cmp(&length(a)));
        let mut longest = None;
        inside.retain(|&(line, chord)| {
            if longest.is_some() || length(&line) < LEAST_CONTACT * chord.max(width) {
                return true;
            }
            // One that runs along the border leaves nothing to divide, here or further down.
            longest = parted(polygon, &across(line)).map(|parts| (across(line), parts));
            longest.is_some()
        });
        if inside.is_empty() || depth == DEEPEST_HALVED {
            return NO_CUT;
        }
        let (across, parts) = longest.unwrap_or_else(|| {
            // None of them divides all of it, but one may divide a half.
            let (from, to) = polygon.cut();
            (across([from, to]), polygon.bisect())
        });
        let between_cells = longest.is_some() && cells > 0;
        let cells = if between_cells { cells - 1 } else { 0 };
        let lines: Vec<Contact> = inside.into_iter().map(|(line, _)| line).collect();
        let index = self.cuts.len();
        self.cuts.push(Cut { plane: across, parts, between_cells, below: [NO_CUT; 2] });
        let below = parts.map(|part| self.add(&part, plane, &lines, cells, depth + 1));
        if longest.is_none() && below == [NO_CUT; 2] {
            self.cuts.truncate(index);
            return NO_CUT;
        }
        self.cuts[index].below = below;
        index as u32
    }
}

/// The parts in front of a plane and behind it; `None` when there is nothing to gain.
fn parted(polygon: &Polygon, plane: &Plane) -> Option<[Polygon; 2]> {
    if polygon.vertices().len() == MAX_VERTICES {
        return None;
    }
    let parts = [tidied(&polygon.clipped(plane)?)?, tidied(&polygon.clipped(&plane.flipped())?)?];
    let least = LEAST_SHARE * polygon.area();
    parts.iter().all(|part| part.area() > least).then_some(parts)
}

/// A polygon without the corners that do not show: where a cut passes through a corner there are two that
/// differ by rounding, and their halves would have no area. `None` when nothing else is left.
fn tidied(polygon: &Polygon) -> Option<Polygon> {
    let mut room = [DVec3::ZERO; MAX_VERTICES];
    let mut count = polygon.vertices().len();
    room[..count].copy_from_slice(polygon.vertices());
    let hides = |corners: &[DVec3], i: usize| {
        let n = corners.len();
        let (before, here, after) = (corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]);
        let along = (after - before).normalize_or_zero();
        here.distance(before) < TOLERANCE || (here - before).reject_from(along).length() < 0.1 * TOLERANCE
    };
    while let Some(i) = (0..count).find(|&i| count > 2 && hides(&room[..count], i)) {
        room.copy_within(i + 1..count, i);
        count -= 1;
    }
    (count > 2).then(|| Polygon::new(&room[..count]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_along_the_border_keeps_no_other_from_cutting() {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let square = Polygon::new(&corners);
        let line = |x: f64, length: f64| [DVec3::new(x, 0.0, 0.0), DVec3::new(x, length, 0.0)];
        let plane = Plane::through(DVec3::ZERO, DVec3::Z);
        let mut cuts = Cuts::default();
        let along = line(5e-5, 1.0);
        let first = cuts.add(&square, &plane, &[along, line(0.5, 0.8)], DEEPEST, 0);
        assert!(cuts.is_between_cells(first));
        let halves = [0, 1].map(|part| cuts.outline(first, false, part).area());
        assert!(halves.iter().all(|half| (half - 0.5).abs() < 1e-9), "{halves:?}");
        // By itself it cuts nothing, however finely the square is divided.
        assert_eq!(Cuts::default().add(&square, &plane, &[along], DEEPEST, 0), NO_CUT);
    }

    #[test]
    fn a_cut_through_corners_leaves_parts_that_can_be_divided() {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let square = Polygon::new(&corners);
        for shift in [0.0, 1e-9, -1e-9, 1e-7] {
            let diagonal =
                Plane::through(DVec3::new(shift, 0.0, 0.0), DVec3::new(1.0, -1.0, 0.0).normalize());
            let parts = parted(&square, &diagonal).expect("two triangles");
            let mut pieces = parts.to_vec();
            for _ in 0..8 {
                pieces = pieces.iter().flat_map(|piece| piece.bisect()).collect();
            }
            let (least, sum) =
                pieces.iter().fold((f64::MAX, 0.0), |(l, s), p| (p.area().min(l), s + p.area()));
            assert!(least > 1e-4 && (sum - 1.0).abs() < 1e-6, "{shift}: {least}, {sum}");
        }
    }
}
