//! Regular grids of probe points: over a named rectangle, or over a plane at a height, such as the work
//! plane of lighting design.

use super::points::ProbePoint;
use crate::scene::Scene;
use glam::DVec3;

/// Most points of a grid.
pub const MOST_POINTS: u64 = 1_000_000;

/// Cells along the longer side when no spacing is given.
const CELLS: f64 = 20.0;

/// What a grid covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grid {
    /// The front of a rectangle with these corners.
    Rectangle([DVec3; 4]),
    /// A plane that faces up, at this coordinate along the up axis, over the whole scene. Up is the axis
    /// nearest to the up direction of the first camera.
    Height(f64),
}

/// Why there is no grid.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum GridError {
    /// No rectangle has the name.
    #[error("no rectangle is named '{name}'; the scene has: {known}")]
    Unknown {
        /// As asked for.
        name: String,
        /// Those there are.
        known: String,
    },
    /// Several rectangles have the name.
    #[error("{count} rectangles are named '{name}'; give each its own name, or --points")]
    Ambiguous {
        /// As asked for.
        name: String,
        /// How many.
        count: usize,
    },
    /// The height is infinite or not a number.
    #[error("the height of a grid must be a finite number, and no rectangle is named '{name}'")]
    NotFinite {
        /// As asked for.
        name: String,
    },
    /// The spacing is too fine.
    #[error(
        "a grid of {count:.0} points is more than the {MOST_POINTS} that are possible; give a larger --spacing"
    )]
    TooFine {
        /// Points it would have.
        count: f64,
    },
    /// The plane has no area.
    #[error("the scene has no extent along the plane, so there is no grid over it; give --points")]
    Flat,
    /// The plane misses the scene.
    #[error("the height {height} is outside the scene, which reaches from {low} to {high} along its up axis")]
    Outside {
        /// As asked for.
        height: f64,
        /// Of the scene.
        low: f64,
        /// Of the scene.
        high: f64,
    },
}

impl Grid {
    /// What is asked for by `text`: the rectangle with this name or else, if it is a number, a plane at this height.
    ///
    /// # Errors
    /// [`GridError::Unknown`], [`GridError::Ambiguous`] or [`GridError::NotFinite`].
    pub fn named(scene: &Scene, text: &str) -> Result<Grid, GridError> {
        let name = || text.to_owned();
        let found: Vec<_> = scene.rectangles.iter().filter(|rectangle| rectangle.name == text).collect();
        match (found.as_slice(), text.trim().parse::<f64>()) {
            ([one], _) => Ok(Grid::Rectangle(one.corners)),
            ([], Ok(height)) if height.is_finite() => Ok(Grid::Height(height)),
            ([], Ok(_)) => Err(GridError::NotFinite { name: name() }),
            ([], Err(_)) => Err(GridError::Unknown { name: name(), known: names(scene) }),
            (several, _) => Err(GridError::Ambiguous { name: name(), count: several.len() }),
        }
    }
}

/// The middles of the cells of a grid, row by row. Cells are as near to `spacing` (scene units) as whole
/// numbers of them allow.
///
/// # Errors
/// See [`GridError`].
pub fn grid_points(scene: &Scene, grid: &Grid, spacing: Option<f64>) -> Result<Vec<ProbePoint>, GridError> {
    let corners = match grid {
        Grid::Rectangle(corners) => *corners,
        Grid::Height(height) => plane_at(scene, *height)?,
    };
    let [a, b, c, d] = corners;
    let Some(normal) = (b - a).cross(d - a).try_normalize() else { return Err(GridError::Flat) };
    let (width, depth) = (a.distance(b).max(d.distance(c)), a.distance(d).max(b.distance(c)));
    let spacing = spacing.unwrap_or(width.max(depth) / CELLS);
    let (columns, rows) = ((width / spacing).round().max(1.0), (depth / spacing).round().max(1.0));
    if columns * rows > MOST_POINTS as f64 {
        return Err(GridError::TooFine { count: columns * rows });
    }
    let (columns, rows) = (columns as u32, rows as u32);
    let cell = |row: u32, column: u32| {
        let u = (f64::from(column) + 0.5) / f64::from(columns);
        let v = (f64::from(row) + 0.5) / f64::from(rows);
        // So written, a coordinate that all corners share stays exactly what it is.
        let (start, end) = (a + (b - a) * u, d + (c - d) * u);
        ProbePoint { position: start + (end - start) * v, normal }
    };
    Ok((0..rows).flat_map(|row| (0..columns).map(move |column| cell(row, column))).collect())
}

/// Names for a message.
fn names(scene: &Scene) -> String {
    let names: Vec<&str> = scene.rectangles.iter().take(8).map(|rectangle| rectangle.name.as_str()).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// The corners of the plane at a height, counter-clockwise from above.
fn plane_at(scene: &Scene, height: f64) -> Result<[DVec3; 4], GridError> {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = scene.positions.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let up = scene.cameras.first().map_or(DVec3::Y, |camera| camera.up);
    let axis = (0..3).max_by(|&i, &j| up[i].abs().total_cmp(&up[j].abs())).unwrap_or(1);
    if !(min[axis]..=max[axis]).contains(&height) {
        return Err(GridError::Outside { height, low: min[axis], high: max[axis] });
    }
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |x: f64, y: f64| {
        let mut point = DVec3::ZERO;
        (point[axis], point[i], point[j]) = (height, x, y);
        point
    };
    let corners =
        [corner(min[i], min[j]), corner(max[i], min[j]), corner(max[i], max[j]), corner(min[i], max[j])];
    // Right-handed axes make these face along the axis.
    Ok(if up[axis] < 0.0 { [corners[0], corners[3], corners[2], corners[1]] } else { corners })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, ImportCounts, Rectangle};

    fn scene(up: DVec3) -> Scene {
        let camera = Camera {
            name: "main".into(),
            eye: DVec3::ZERO,
            target: DVec3::ONE,
            up,
            vfov_deg: 40.0,
            width: 1,
            height: 1,
        };
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, z)| DVec3::new(x, 0.7, -z));
        Scene {
            name: "test".into(),
            positions: vec![DVec3::new(-1.0, 0.0, -2.0), DVec3::new(3.0, 2.5, 4.0)],
            triangles: Vec::new(),
            materials: Vec::new(),
            rectangles: vec![Rectangle { name: "desk".into(), corners }],
            cameras: vec![camera],
            meters_per_unit: 1.0,
            patch_count: 0,
            counts: ImportCounts::default(),
            files: Vec::new(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn a_rectangle_gets_the_middles_of_its_cells_and_its_front() {
        let scene = scene(DVec3::Y);
        let desk = Grid::named(&scene, "desk").expect("a rectangle");
        let points = grid_points(&scene, &desk, Some(0.5)).expect("a grid");
        assert_eq!(points.len(), 8);
        assert!(points[0].position.distance(DVec3::new(0.25, 0.7, -0.25)) < 1e-12, "{:?}", points[0]);
        assert!(points.iter().all(|p| p.normal.distance(DVec3::Y) < 1e-12), "{:?}", points[0].normal);
    }

    #[test]
    fn a_work_plane_covers_the_scene_and_faces_up_whatever_up_is() {
        for (up, axis, height) in [(DVec3::Y, 1, 0.8), (DVec3::Z, 2, 1.0), (-DVec3::X, 0, 0.0)] {
            let points = grid_points(&scene(up), &Grid::Height(height), Some(0.5)).expect("a grid");
            assert!(points.iter().all(|p| p.normal.distance(up) < 1e-12 && p.position[axis] == height));
        }
        let points = grid_points(&scene(DVec3::Y), &Grid::Height(0.8), None).expect("a grid");
        assert_eq!(points.len(), 20 * 13);
    }

    #[test]
    fn grids_that_cannot_be_are_refused() {
        let scene = scene(DVec3::Y);
        let unknown = Grid::named(&scene, "table").expect_err("unknown");
        assert!(unknown.to_string().contains("desk"), "{unknown}");
        assert!(matches!(grid_points(&scene, &Grid::Height(3.0), None), Err(GridError::Outside { .. })));
        assert!(matches!(
            grid_points(&scene, &Grid::Height(1.0), Some(1e-6)),
            Err(GridError::TooFine { .. })
        ));
    }

    #[test]
    fn names_come_before_numbers() {
        let mut scene = scene(DVec3::Y);
        assert_eq!(Grid::named(&scene, " 0.5 "), Ok(Grid::Height(0.5)));
        for name in ["nan", "inf", "1e999"] {
            assert!(matches!(Grid::named(&scene, name), Err(GridError::NotFinite { .. })), "{name}");
        }
        let corners = scene.rectangles[0].corners;
        for name in ["0.5", "nan", " 2 "] {
            scene.rectangles.push(Rectangle { name: name.into(), corners });
            assert_eq!(Grid::named(&scene, name), Ok(Grid::Rectangle(corners)));
        }
        assert_eq!(Grid::named(&scene, "0.50"), Ok(Grid::Height(0.5)));
    }

    #[test]
    fn a_name_of_two_rectangles_is_refused() {
        let mut scene = scene(DVec3::Y);
        scene.rectangles.push(scene.rectangles[0].clone());
        let error = Grid::named(&scene, "desk").expect_err("two of them");
        assert_eq!(error, GridError::Ambiguous { name: "desk".into(), count: 2 });
    }
}
