//! Small scenes made of rectangles and triangles, for which the answer is known.

use glam::DVec3;
use lightshaft::scene::{Camera, ImportCounts, Material, Scene, Triangle};

/// A scene that grows by rectangles.
pub(crate) struct Rectangles {
    scene: Scene,
}

impl Rectangles {
    pub(crate) fn new(name: &str) -> Rectangles {
        let camera = Camera {
            name: "main".to_owned(),
            eye: DVec3::new(0.4, 0.3, 0.2),
            target: DVec3::new(1.0, 1.0, 1.0),
            up: DVec3::Z,
            vfov_deg: 60.0,
            width: 32,
            height: 32,
        };
        Rectangles {
            scene: Scene {
                rectangles: Vec::new(),
                name: name.to_owned(),
                positions: Vec::new(),
                triangles: Vec::new(),
                materials: Vec::new(),
                cameras: vec![camera],
                meters_per_unit: 1.0,
                patch_count: 0,
                counts: ImportCounts::default(),
                files: Vec::new(),
                warnings: Vec::new(),
            },
        }
    }

    /// A grey material; returns its number.
    pub(crate) fn material(&mut self, reflectance: f32, radiance: f32) -> u32 {
        self.scene.materials.push(Material {
            name: format!("grey {}", self.scene.materials.len()),
            reflectance: [reflectance; 3],
            radiance: [radiance; 3],
            painting: None,
        });
        self.scene.materials.len() as u32 - 1
    }

    /// A rectangle, corners counter-clockwise from its front; returns its patch.
    pub(crate) fn quad(&mut self, corners: [[f64; 3]; 4], material: u32) -> u32 {
        let base = self.scene.positions.len() as u32;
        let patch = self.scene.patch_count;
        self.scene.positions.extend(corners.map(DVec3::from_array));
        for vertices in [[base, base + 1, base + 2], [base, base + 2, base + 3]] {
            self.scene.triangles.push(Triangle { vertices, material, patch });
        }
        self.scene.patch_count += 1;
        patch
    }

    /// Triangles around `center`, one for each two neighbours of the closed `rim`, which runs
    /// counter-clockwise from its front; returns their patch.
    pub(crate) fn fan(&mut self, center: DVec3, rim: &[DVec3], material: u32) -> u32 {
        let triangles = (0..rim.len()).map(|i| [center, rim[i], rim[(i + 1) % rim.len()]]);
        self.triangles(triangles, material)
    }

    /// Triangles, corners counter-clockwise from their front; returns their patch.
    pub(crate) fn triangles(
        &mut self,
        triangles: impl IntoIterator<Item = [DVec3; 3]>,
        material: u32,
    ) -> u32 {
        let patch = self.scene.patch_count;
        for corners in triangles {
            let base = self.scene.positions.len() as u32;
            self.scene.positions.extend(corners);
            let vertices = [base, base + 1, base + 2];
            self.scene.triangles.push(Triangle { vertices, material, patch });
        }
        self.scene.patch_count += 1;
        patch
    }

    /// The six walls of a box, fronts inside when `inward`, as −x, +x, −y, +y, −z, +z.
    pub(crate) fn closed_box(&mut self, min: [f64; 3], max: [f64; 3], inward: bool, material: u32) {
        for wall in 0..6 {
            self.wall(min, max, inward, material, wall);
        }
    }

    /// One of the walls of [`Rectangles::closed_box`], 0 to 5; returns its patch.
    pub(crate) fn wall(
        &mut self,
        min: [f64; 3],
        max: [f64; 3],
        inward: bool,
        material: u32,
        wall: usize,
    ) -> u32 {
        let (axis, high) = (wall / 2, wall % 2 == 1);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |at_u: bool, at_v: bool| {
            let mut p = [0.0; 3];
            p[axis] = if high { max[axis] } else { min[axis] };
            p[u] = if at_u { max[u] } else { min[u] };
            p[v] = if at_v { max[v] } else { min[v] };
            p
        };
        // Counter-clockwise seen from +axis.
        let mut corners =
            [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
        if high == inward {
            corners.reverse();
        }
        self.quad(corners, material)
    }

    /// Turns one triangle in two over.
    pub(crate) fn turn_every_other_triangle(&mut self, except_material: u32) {
        for triangle in self.scene.triangles.iter_mut().step_by(2) {
            if triangle.material != except_material {
                triangle.vertices.swap(1, 2);
            }
        }
    }

    pub(crate) fn finish(self) -> Scene {
        self.scene
    }
}
