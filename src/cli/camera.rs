//! Which camera of the scene is used, and how large its picture is.

use super::args::MAX_PIXELS;
use super::config::ViewConfig;
use super::errors::CliError;
use crate::scene::{Camera, Scene};

/// The camera of this name, the first one without a name, with the size that the view asks for.
///
/// # Errors
/// [`CliError::Usage`] for a name the scene does not have, with the names it has;
/// [`CliError::InvalidScene`] when the scene has no camera or its picture is too large.
pub(super) fn choose_camera(
    scene: &Scene,
    name: Option<&str>,
    view: &ViewConfig,
) -> Result<Camera, CliError> {
    let found = match name {
        Some(name) => scene.cameras.iter().find(|camera| camera.name == name).ok_or_else(|| {
            let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
            CliError::Usage(format!("no camera is named '{name}'; the scene has: {}", names.join(", ")))
        })?,
        None => scene
            .cameras
            .first()
            .ok_or_else(|| CliError::InvalidScene("the scene has no camera".to_owned()))?,
    };
    let mut camera = found.clone();
    (camera.width, camera.height) = size(found, view.width, view.height);
    if camera.width > MAX_PIXELS || camera.height > MAX_PIXELS {
        return Err(CliError::InvalidScene(format!(
            "camera '{}': {} × {} pixels are more than the {MAX_PIXELS} a side that are possible",
            camera.name, camera.width, camera.height
        )));
    }
    Ok(camera)
}

/// Width and height; one given alone keeps the camera's proportions.
fn size(camera: &Camera, width: Option<u32>, height: Option<u32>) -> (u32, u32) {
    let scaled = |given: u32, from: u32, to: u32| {
        let exact = f64::from(given) * f64::from(to) / f64::from(from.max(1));
        exact.round().clamp(1.0, f64::from(u32::MAX)) as u32
    };
    match (width, height) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, scaled(width, camera.width, camera.height)),
        (None, Some(height)) => (scaled(height, camera.height, camera.width), height),
        (None, None) => (camera.width, camera.height),
    }
}

#[cfg(test)]
mod tests {
    use super::super::args::ViewArg;
    use super::*;
    use crate::image::tone::Exposure;
    use crate::scene::ImportCounts;
    use glam::DVec3;

    fn scene() -> Scene {
        let camera = |name: &str, width, height| Camera {
            name: name.to_owned(),
            eye: DVec3::ZERO,
            target: DVec3::X,
            up: DVec3::Y,
            vfov_deg: 40.0,
            width,
            height,
        };
        Scene {
            name: "test".to_owned(),
            positions: Vec::new(),
            triangles: Vec::new(),
            materials: Vec::new(),
            rectangles: Vec::new(),
            cameras: vec![camera("main", 640, 480), camera("top", 20_000, 10)],
            meters_per_unit: 1.0,
            patch_count: 0,
            counts: ImportCounts::default(),
            files: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn view(width: Option<u32>, height: Option<u32>) -> ViewConfig {
        ViewConfig { width, height, samples: None, exposure: Exposure::Automatic, kind: ViewArg::Shaded }
    }

    #[test]
    fn one_side_alone_keeps_the_proportions() {
        let sized = |width, height| {
            let camera = choose_camera(&scene(), None, &view(width, height)).expect("a camera");
            (camera.width, camera.height)
        };
        assert_eq!(sized(None, None), (640, 480));
        assert_eq!(sized(Some(320), None), (320, 240));
        assert_eq!(sized(None, Some(96)), (128, 96));
        assert_eq!(sized(Some(7), Some(900)), (7, 900));
        assert_eq!(sized(None, Some(1)), (1, 1));
    }

    #[test]
    fn an_unknown_camera_is_told_the_names_there_are() {
        let error = choose_camera(&scene(), Some("side"), &view(None, None)).expect_err("unknown");
        assert!(matches!(error, CliError::Usage(_)));
        let text = error.to_string();
        assert!(text.contains("'side'") && text.contains("main, top"), "{text}");
    }

    #[test]
    fn a_picture_larger_than_possible_is_refused() {
        let error = choose_camera(&scene(), Some("top"), &view(None, None)).expect_err("too large");
        assert!(matches!(error, CliError::InvalidScene(_)));
        assert!(choose_camera(&scene(), Some("top"), &view(Some(200), None)).is_ok());
    }
}
