//! Camera rays in local coordinates.

use crate::hierarchy::Frame;
use crate::scene::Camera;
use crate::tracer::Ray;
use glam::Vec3;

/// A pinhole camera, ready to shoot rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    eye: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    width: f32,
    height: f32,
}

impl Lens {
    pub(super) fn new(camera: &Camera, frame: &Frame) -> Lens {
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let half_height = (camera.vfov_deg.to_radians() * 0.5).tan();
        let half_width = half_height * camera.width as f64 / camera.height as f64;
        Lens {
            eye: frame.local_from_scene(camera.eye),
            forward: forward.as_vec3(),
            right: (right * half_width).as_vec3(),
            up: (up * half_height).as_vec3(),
            width: camera.width as f32,
            height: camera.height as f32,
        }
    }

    /// The ray through a point of the picture, in pixels from its top left corner.
    pub(super) fn ray(&self, x: f32, y: f32) -> Ray {
        let (u, v) = (2.0 * x / self.width - 1.0, 1.0 - 2.0 * y / self.height);
        Ray { origin: self.eye, direction: (self.forward + self.right * u + self.up * v).normalize() }
    }

    /// Width of a pixel at distance 1.
    pub(super) fn pixel_angle(&self) -> f32 {
        2.0 * self.up.length() / self.height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_middle_looks_at_the_target_and_up_is_up() {
        let camera = Camera {
            name: "main".into(),
            eye: DVec3::new(1.0, 2.0, 3.0),
            target: DVec3::new(4.0, 2.0, 3.0),
            up: DVec3::Y,
            vfov_deg: 90.0,
            width: 200,
            height: 100,
        };
        let lens = Lens::new(&camera, &Frame::around(&[DVec3::ZERO, DVec3::splat(4.0)]));
        assert!(lens.ray(100.0, 50.0).direction.distance(Vec3::X) < 1e-6);
        let top = lens.ray(100.0, 0.0).direction;
        assert!((top.y / top.x - 1.0).abs() < 1e-6);
        let right_edge = lens.ray(200.0, 50.0).direction;
        assert!((right_edge.z / right_edge.x - 2.0).abs() < 1e-5);
    }
}
