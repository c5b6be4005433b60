//! Surfaces that lie in each other: what several cover belongs to one of them, so that light is not received and
//! sent twice.

use glam::{DVec3, Vec3};
use lightshaft::hierarchy::Hierarchy;
use lightshaft::math::PairSequence;
use lightshaft::progress::Silent;
use lightshaft::radiosity::SolveOptions;
use lightshaft::scene::Scene;
use lightshaft::tracer::{Ray, Tracer};
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, options};

/// Points nearer than this to an outline are not asked about, scene units.
const BORDER: f64 = 1e-4;

/// A rectangle in a tilted plane: middle, half sizes and turn, in the plane.
struct Sheet {
    middle: [f64; 2],
    half: [f64; 2],
    turn: f64,
    material: u32,
    is_flipped: bool,
}

impl Sheet {
    fn corners(&self) -> [[f64; 3]; 4] {
        let (sin, cos) = self.turn.sin_cos();
        let [w, h] = self.half;
        let mut corners = [(-w, -h), (w, -h), (w, h), (-w, h)].map(|(x, y)| {
            on_plane(self.middle[0] + x * cos - y * sin, self.middle[1] + x * sin + y * cos).to_array()
        });
        if self.is_flipped {
            corners.reverse();
        }
        corners
    }

    fn area(&self) -> f64 {
        4.0 * self.half[0] * self.half[1]
    }

    /// How deep inside a point of the plane is; negative outside.
    fn depth(&self, [x, y]: [f64; 2]) -> f64 {
        let (sin, cos) = self.turn.sin_cos();
        let (dx, dy) = (x - self.middle[0], y - self.middle[1]);
        let (along, across) = (dx * cos + dy * sin, dy * cos - dx * sin);
        (self.half[0] - along.abs()).min(self.half[1] - across.abs())
    }
}

fn normal() -> DVec3 {
    DVec3::new(0.3, -0.2, 1.0).normalize()
}

fn on_plane(x: f64, y: f64) -> DVec3 {
    let u = DVec3::Y.cross(normal()).normalize();
    u * x + normal().cross(u) * y
}

/// Twelve sheets in one plane, every one of a material of its own, the last of which is a lamp.
fn pile(seed: u64) -> (Scene, Vec<Sheet>) {
    let random = PairSequence::new(seed);
    let mut scene = Rectangles::new("pile");
    let sheets: Vec<Sheet> = (0..12)
        .map(|i| {
            let ([a, b, c, d], [e, f, ..]) = (random.point(2 * i), random.point(2 * i + 1));
            Sheet {
                middle: [2.0 * a - 1.0, 2.0 * b - 1.0],
                half: [0.1 + 0.9 * c, 0.1 + 0.9 * d],
                turn: if i % 3 == 0 { 0.0 } else { 3.0 * e },
                material: scene.material(0.5, if i == 11 { 1.0 } else { 0.0 }),
                is_flipped: f < 0.5,
            }
        })
        .collect();
    for sheet in &sheets {
        scene.quad(sheet.corners(), sheet.material);
    }
    (scene.finish(), sheets)
}

/// Facets of which more than the border holds a point.
fn holders(hierarchy: &Hierarchy, point: DVec3) -> Vec<u32> {
    let local = hierarchy.frame.local_from_scene(point).as_dvec3();
    let inside = |&facet: &u32| {
        hierarchy.polygon(facet).outside_distance(local, hierarchy.facets[facet as usize].plane.normal) < 0.0
    };
    (0..hierarchy.facets.len() as u32).filter(inside).collect()
}

/// Every point belongs to one facet: of the lamp, else of the largest sheet it lies on; and rays meet that one.
#[test]
fn every_point_of_a_pile_belongs_to_one_sheet() {
    let (mut asked, mut shared) = (0, 0);
    for seed in 0..20 {
        let (scene, sheets) = pile(seed);
        let hierarchy = Hierarchy::build(&scene, false, &Silent);
        hierarchy.validate().expect("the hierarchy keeps its rules");
        assert!(hierarchy.covered_facets > 3, "{}", hierarchy.covered_facets);
        let tracer = lightshaft::tracer::FallbackTracer::new(&hierarchy.mesh);
        let random = PairSequence::new(1000 + seed);
        let mut cuts = 0;
        for i in 0..2000 {
            let [a, b, ..] = random.point(i);
            let at = [4.0 * a - 2.0, 4.0 * b - 2.0];
            if sheets.iter().any(|sheet| sheet.depth(at).abs() < BORDER) {
                continue;
            }
            let on: Vec<&Sheet> = sheets.iter().filter(|sheet| sheet.depth(at) > 0.0).collect();
            let owner = on.iter().max_by(|a, b| {
                (a.material == 11).cmp(&(b.material == 11)).then(a.area().total_cmp(&b.area()))
            });
            let point = on_plane(at[0], at[1]);
            let found = holders(&hierarchy, point);
            asked += 1;
            shared += usize::from(on.len() > 1);
            // On a line along which a facet was cut a point may lie in both parts, or in none.
            if found.len() != usize::from(owner.is_some()) {
                cuts += 1;
                continue;
            }
            let facets = found.iter().map(|&facet| hierarchy.facets[facet as usize].material);
            assert!(facets.eq(owner.map(|sheet| sheet.material)), "seed {seed}: {found:?} at {at:?}");

            let above = hierarchy.frame.local_from_scene(point + normal());
            let ray = Ray { origin: above, direction: -normal().as_vec3() };
            let mut hits = [None];
            tracer.first_hits(&[ray], &mut hits);
            assert_eq!(hits[0].map(|hit| hit.facet), found.first().copied(), "seed {seed} at {at:?}");
        }
        assert!(cuts <= 1, "seed {seed}: {cuts} points belong to none or to several");
    }
    assert!(asked > 30_000 && shared > 5_000, "{asked} points, {shared} on several sheets");
}

/// No ray slips through where facets were cut.
#[test]
fn a_cut_sheet_has_no_cracks() {
    for seed in 0..20 {
        let (scene, sheets) = pile(seed);
        let hierarchy = Hierarchy::build(&scene, false, &Silent);
        let tracer = lightshaft::tracer::FallbackTracer::new(&hierarchy.mesh);
        // Along the outlines, just inside of a sheet: there the others were cut.
        for sheet in &sheets {
            let corners = sheet.corners().map(DVec3::from_array);
            let middle = on_plane(sheet.middle[0], sheet.middle[1]);
            for i in 0..4 {
                for step in 0..200 {
                    let edge = corners[i].lerp(corners[(i + 1) % 4], (step as f64 + 0.5) / 200.0);
                    let point = edge.lerp(middle, 1e-5);
                    let origin = hierarchy.frame.local_from_scene(point + normal());
                    let mut hits = [None];
                    tracer.first_hits(&[Ray { origin, direction: -normal().as_vec3() }], &mut hits);
                    assert!(hits[0].is_some(), "seed {seed}, edge {i} of {}", sheet.material);
                }
            }
        }
    }
}

fn square(low: f64, high: f64, is_flipped: bool) -> [[f64; 3]; 4] {
    let mut corners = [[low, low, 0.0], [high, low, 0.0], [high, high, 0.0], [low, high, 0.0]];
    if is_flipped {
        corners.reverse();
    }
    corners
}

fn covered(sheets: &[([[f64; 3]; 4], f32)], one_sided: bool) -> (usize, Vec<f32>) {
    let mut scene = Rectangles::new("sheets");
    for &(corners, radiance) in sheets {
        let material = scene.material(0.5, radiance);
        scene.quad(corners, material);
    }
    let hierarchy = Hierarchy::build(&scene.finish(), one_sided, &Silent);
    let mut radiances: Vec<f32> =
        (0..hierarchy.facets.len() as u32).map(|facet| hierarchy.material(facet).radiance[0]).collect();
    radiances.sort_by(f32::total_cmp);
    (hierarchy.covered_facets, radiances)
}

#[test]
fn backs_that_exchange_no_light_and_lamps_back_to_back_both_stay() {
    let (large, small) = (square(0.0, 4.0, false), square(1.0, 2.0, true));
    assert_eq!(covered(&[(large, 0.0), (small, 0.0)], false), (1, vec![0.0]));
    assert_eq!(covered(&[(large, 0.0), (small, 0.0)], true), (0, vec![0.0, 0.0]));
    assert_eq!(covered(&[(large, 2.0), (small, 3.0)], false), (0, vec![2.0, 3.0]));
    // A lamp in a wall leaves four parts of it, a smaller one that faces the same way is the larger one's.
    assert_eq!(covered(&[(large, 0.0), (small, 3.0)], false), (1, vec![0.0, 0.0, 0.0, 0.0, 3.0]));
    assert_eq!(covered(&[(large, 2.0), (square(1.0, 2.0, false), 3.0)], true), (1, vec![2.0]));
    // Sheets that only touch, or lie above each other, are apart.
    assert_eq!(covered(&[(large, 0.0), (square(4.0, 5.0, false), 0.0)], false).0, 0);
    assert_eq!(covered(&[(large, 0.0), (small.map(|[x, y, _]| [x, y, 1e-3]), 0.0)], false).0, 0);
}

/// Lamps of many corners flush with a ceiling, turned every way: cuts pass through corners of what is left, and no
/// part of the ceiling may get lost or stay under the lamp.
#[test]
fn a_flush_lamp_of_many_corners_leaves_the_rest_of_the_ceiling() {
    for seed in 0..24 {
        let [a, b, c, _] = PairSequence::new(seed).point(3);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 6.0 * a, 6.0 * b, 6.0 * c);
        let turned =
            |x: f64, y: f64| if seed == 0 { DVec3::new(x, y, 0.0) } else { turn * DVec3::new(x, y, 0.0) };
        for corners in [3, 6, 12, 16, 24, 32, 48] {
            let mut scene = Rectangles::new("flush lamp");
            let (grey, lamp) = (scene.material(0.5, 0.0), scene.material(0.0, 1.0));
            scene.quad(
                [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| turned(x, y).to_array()),
                grey,
            );
            let rim: Vec<DVec3> = (0..corners)
                .map(|i| (i as f64 / corners as f64 * std::f64::consts::TAU).sin_cos())
                .map(|(sin, cos)| turned(2.0 + cos, 2.0 + sin))
                .collect();
            scene.fan(turned(2.0, 2.0), &rim, lamp);
            let hierarchy = Hierarchy::build(&scene.finish(), false, &Silent);
            assert_eq!(hierarchy.covered_facets, 1, "{seed} {corners}");
            let unit = hierarchy.square_meters_per_unit(1.0);
            let mut areas = [0.0; 2];
            for facet in 0..hierarchy.facets.len() as u32 {
                let material = hierarchy.facets[facet as usize].material;
                areas[material as usize] += hierarchy.polygon(facet).area() * unit;
            }
            let disc = 0.5 * corners as f64 * (std::f64::consts::TAU / corners as f64).sin();
            assert!((areas[0] - (16.0 - disc)).abs() < 1e-3, "{seed} {corners}: {areas:?} for {disc}");
            assert!((areas[1] - disc).abs() < 1e-3, "{seed} {corners}: {areas:?} for {disc}");
        }
    }
}

/// Hundreds of lamps in one ceiling, and a rug of several pieces under a floor that stands later in the file.
#[test]
fn many_lamps_are_let_into_a_ceiling() {
    let mut scene = Rectangles::new("lamps");
    let (grey, lamp) = (scene.material(0.5, 0.0), scene.material(0.0, 1.0));
    scene.quad(square(1.0, 19.0, true), grey);
    for i in 0..15 {
        for j in 0..15 {
            let (x, y) = (3.0 + i as f64, 3.0 + j as f64);
            scene.quad([[x, y, 0.0], [x + 0.5, y, 0.0], [x + 0.5, y + 0.5, 0.0], [x, y + 0.5, 0.0]], lamp);
        }
    }
    scene.quad(square(0.0, 20.0, false), grey);
    let hierarchy = Hierarchy::build(&scene.finish(), false, &Silent);
    assert_eq!(hierarchy.covered_facets, 2);
    let facets =
        (0..hierarchy.facets.len() as u32).filter(|&f| hierarchy.facets[f as usize].material == grey);
    let area: f64 = facets.map(|facet| hierarchy.polygon(facet).area()).sum();
    let area = area * hierarchy.square_meters_per_unit(1.0);
    assert!((area - (400.0 - 225.0 * 0.25)).abs() < 0.01, "{area}");
}

/// A furnace whose floor is two sheets, one over the other by a fifth of it, with a panel that lies in a wall and
/// faces it: what each covers twice would receive and send light twice.
#[test]
fn a_furnace_with_surfaces_in_each_other_is_uniformly_bright() {
    let (reflectance, radiance) = (0.8, 2.0);
    let mut room = Rectangles::new("furnace with sheets in each other");
    let grey = room.material(reflectance, radiance);
    let panel = room.material(reflectance, 0.0);
    for wall in 0..5 {
        let (min, max) = ([0.0; 3], [4.0, 3.0, 2.5]);
        // −x, +x, −y, +y; the floor is −z.
        room.wall(min, max, true, grey, if wall == 4 { 5 } else { wall });
    }
    for (low, high) in [(0.0, 2.4), (1.6, 4.0)] {
        room.quad([[low, 0.0, 0.0], [high, 0.0, 0.0], [high, 3.0, 0.0], [low, 3.0, 0.0]], grey);
    }
    // In the wall at y = 0, front to the wall.
    room.quad([[1.0, 0.0, 0.5], [2.5, 0.0, 0.5], [2.5, 0.0, 2.0], [1.0, 0.0, 2.0]], panel);
    let case = Case::of(room.finish(), false);
    assert_eq!(case.hierarchy.covered_facets, 2);
    let solution = case.solve(
        &case.fallback(),
        &SolveOptions { epsilon: 2e-4, iterations: 500, ..options(Strategy::Adaptive) },
    );
    let exact = std::f64::consts::PI * radiance as f64 / (1.0 - reflectance as f64);
    let (mut power, mut area) = (0.0, 0.0);
    let forest = &solution.forest;
    for side in (0..forest.side_count()).filter(|&side| !forest.side(side).back) {
        let root = forest.first_element[side] as usize;
        let brightness = solution.light.exitance[root].x as f64 / exact - 1.0;
        assert!(brightness.abs() < 0.005, "{:?}: {brightness}", forest.side(side));
        power += brightness * forest.area[root] as f64;
        area += forest.area[root] as f64;
    }
    println!(
        "mean exitance {:+.4} % off, balance {:.4} %",
        100.0 * power / area,
        100.0 * solution.energy.balance_error()
    );
    assert!(solution.energy.balance_error() < 0.005, "{:?}", solution.energy);
    assert!((power / area).abs() < 0.002);
    let expected =
        case.hierarchy.frame.local_from_scene(DVec3::ZERO) - case.hierarchy.frame.local_from_scene(DVec3::X);
    let total = (2.0 * (4.0 * 3.0 + 4.0 * 2.5 + 3.0 * 2.5)) * Vec3::length_squared(expected) as f64;
    assert!((area / total - 1.0).abs() < 1e-5, "area {area} for {total}");
}
