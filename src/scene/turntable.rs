//! A camera that goes around a point.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::Camera;
use super::pose::pose_fault;
use super::toml_file::is_position;

/// Why a camera cannot go around a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TurntableError {
    /// The point is not finite, or beyond all scenes.
    #[error("the point is not finite or too far away")]
    Far,
    /// The way around would be a point.
    #[error("the camera stands on the axis, which goes along its up through the point, and would not move")]
    OnAxis,
}

/// `frames` views of a camera that goes once around `center` and looks at it, in even steps about its up, counter-clockwise
/// seen from where up points to. The first stands where the camera does, the last one step before it.
///
/// # Errors
/// When the point is no place to go around.
pub fn turntable(camera: &Camera, center: DVec3, frames: u32) -> Result<Vec<Camera>, TurntableError> {
    if !is_position(center) {
        return Err(TurntableError::Far);
    }
    if pose_fault(camera.eye, center, camera.up).is_some() {
        return Err(TurntableError::OnAxis);
    }
    let (axis, from_center) = (camera.up.normalize(), camera.eye - center);
    let at = |frame: u32| {
        let turn = DQuat::from_axis_angle(axis, TAU * f64::from(frame) / f64::from(frames));
        // Not even rounding moves the first.
        let eye = if frame == 0 { camera.eye } else { center + turn * from_center };
        Camera { eye, target: center, ..camera.clone() }
    };
    Ok((0..frames).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: "main".to_owned(),
            eye: DVec3::new(3.0, 2.0, 5.0),
            target: DVec3::new(1.0, 0.5, 1.0),
            up: DVec3::new(0.0, 2.0, 0.0),
            vfov_deg: 40.0,
            width: 4,
            height: 3,
        }
    }

    #[test]
    fn it_goes_around_in_even_steps_and_does_not_repeat_the_first() {
        let camera = camera();
        let views = turntable(&camera, camera.target, 7).expect("views");
        assert_eq!((views.len(), &views[0]), (7, &camera));
        let step = views[0].eye.distance(views[1].eye);
        for (i, view) in views.iter().enumerate() {
            assert!((view.eye.y - camera.eye.y).abs() < 1e-12 && view.target == camera.target);
            let radius = view.eye.distance(camera.target);
            assert!((radius - camera.eye.distance(camera.target)).abs() < 1e-12);
            assert!((view.eye.distance(views[(i + 1) % 7].eye) - step).abs() < 1e-12, "step {i}");
        }
        // Counter-clockwise from above: from +z, where the eye is, towards +x.
        let from = views[0].eye - camera.target;
        assert!(from.cross(views[1].eye - camera.target).y > 0.0);
    }

    #[test]
    fn it_looks_at_the_point_it_goes_around() {
        let center = DVec3::new(-4.0, 1.0, 0.0);
        let views = turntable(&camera(), center, 4).expect("views");
        assert_eq!(views[0].eye, camera().eye);
        assert!(views[2].eye.distance(DVec3::new(-11.0, 2.0, -5.0)) < 1e-12);
        assert!(views.iter().all(|view| view.target == center));
    }

    #[test]
    fn there_is_no_way_around_a_point_above_below_or_nowhere() {
        let camera = camera();
        for height in [-7.0, 0.0, 1e-9, 3.0] {
            let center = camera.eye + DVec3::Y * height;
            assert_eq!(turntable(&camera, center, 9), Err(TurntableError::OnAxis), "{height}");
        }
        for x in [f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(turntable(&camera, DVec3::X * x, 9), Err(TurntableError::Far), "{x}");
        }
    }
}
