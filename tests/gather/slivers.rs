//! Interpolation where elements of very different shape and size meet in one plane. A failure means seams in pictures:
//! streaks along slivers, creases along borders of facets.

use std::borrow::Cow;

use glam::{DVec3, Vec3};
use lightshaft::gather::Reconstruction;
use lightshaft::hierarchy::{Hierarchy, Side};
use lightshaft::progress::Silent;
use lightshaft::radiosity::Forest;
use lightshaft::scene::{ImportCounts, Material, Scene, Triangle};

/// A rectangle in the plane z = 0, two opposite corners, with the irradiance of its one element.
type Tile = ([f64; 2], [f64; 2], f32);

/// Tiles of different materials, or they would be merged to one facet.
fn floor(tiles: &[Tile]) -> Scene {
    let (mut positions, mut triangles, mut materials) = (Vec::new(), Vec::new(), Vec::new());
    for (index, &([left, low], [right, high], _)) in (0..).zip(tiles) {
        let first = positions.len() as u32;
        let corners = [(left, low), (right, low), (right, high), (left, high)];
        positions.extend(corners.map(|(x, y)| DVec3::new(x, y, 0.0)));
        triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| Triangle {
            vertices: corners.map(|corner| first + corner),
            material: index,
            patch: index,
        }));
        materials.push(Material {
            name: index.to_string(),
            reflectance: [0.5; 3],
            radiance: [0.0; 3],
            painting: None,
        });
    }
    Scene {
        name: "floor".to_owned(),
        positions,
        triangles,
        materials,
        rectangles: Vec::new(),
        cameras: Vec::new(),
        meters_per_unit: 1.0,
        patch_count: tiles.len() as u32,
        counts: ImportCounts::default(),
        files: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Interpolated irradiance at points of a floor.
fn interpolated(tiles: &[Tile], points: &[[f64; 2]]) -> Vec<f32> {
    let hierarchy = Hierarchy::build(&floor(tiles), false, &Silent);
    let forest = Forest::new(&hierarchy);
    let side_of =
        |facet: u32| Side { facet, back: hierarchy.side_normal(Side { facet, back: false }).z < 0.0 };
    let tile_of = |facet: u32| hierarchy.facets[facet as usize].material as usize;
    let irradiance: Vec<Vec3> = (0..forest.len() as u32)
        .map(|element| Vec3::splat(tiles[tile_of(forest.side(forest.side_of(element)).facet)].2))
        .collect();
    let reconstruction = Reconstruction::of(&hierarchy, &forest, Cow::Owned(irradiance));
    let at = |&[x, y]: &[f64; 2]| {
        let holds =
            |&([left, low], [right, high], _): &Tile| left <= x && x <= right && low <= y && y <= high;
        let tile = tiles.iter().position(holds).expect("a point on the floor");
        let facet =
            (0..hierarchy.facets.len() as u32).find(|&facet| tile_of(facet) == tile).expect("its facet");
        let point = hierarchy.frame.local_from_scene(DVec3::new(x, y, 0.0)).as_dvec3();
        reconstruction.look_up(side_of(facet), point).expect("a side that takes part").irradiance.x
    };
    points.iter().map(at).collect()
}

/// The wrong mean of a sliver does not show: not beside it, where it shares corners with large elements, nor on it.
#[test]
fn a_sliver_between_two_walls_leaves_no_streak() {
    let tiles =
        [([-1.0, 0.0], [0.0, 1.0], 1.0), ([0.0, 0.0], [0.005, 1.0], 10.0), ([0.005, 0.0], [1.0, 1.0], 1.0)];
    let points = [-0.5, -0.1, -0.001, 0.0025, 0.006, 0.1, 0.5].map(|x| [x, 0.3]);
    for (value, [x, _]) in interpolated(&tiles, &points).into_iter().zip(points) {
        assert!((0.999..1.12).contains(&value), "{value} at {x}");
    }
}

/// Light that falls evenly across a border is the same on it wherever one element meets two that are half as large.
#[test]
fn a_slope_goes_on_where_elements_become_smaller() {
    let tiles =
        [([-2.0, -1.0], [0.0, 1.0], 9.0), ([0.0, -1.0], [1.0, 0.0], 10.5), ([0.0, 0.0], [1.0, 1.0], 10.5)];
    for value in interpolated(&tiles, &[[-1e-4, 0.0], [1e-4, 1e-4]]) {
        assert!((value - 10.0).abs() < 0.01, "{value}");
    }
}
