//! Cameras of a file. A camera of glTF has a direction and no target, and a shape of the picture and no size; both are chosen.

use std::collections::HashSet;

use glam::{DMat4, DVec3};
use gltf_json::{Camera as Lens, Root};

use super::super::Camera;
use super::super::camera::{DEFAULT_HEIGHT, DEFAULT_WIDTH};
use super::super::draft::shown_name;
use super::super::error::quoted;
use super::super::pose::pose_fault;
use super::super::toml_file::is_position;
use super::nodes::Placed;

/// More cameras of one file than anybody chooses from.
pub(super) const MOST_CAMERAS: usize = 1000;
/// Most pixels along one side of a picture.
const MOST_PIXELS: f64 = 16_384.0;

/// The cameras of these nodes in a scene with these positions; what cannot see is left out, with a warning.
pub(super) fn cameras(
    file: &str,
    root: &Root,
    placed: &[Placed],
    positions: &[DVec3],
    warnings: &mut Vec<String>,
) -> Vec<Camera> {
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let mut cameras: Vec<Camera> = Vec::new();
    let mut taken = HashSet::new();
    let with_lens = placed.iter().filter_map(|placed| {
        let node = &root.nodes[placed.node];
        Some((node, node.camera?, placed.world))
    });
    for (count, (node, lens, world)) in with_lens.enumerate() {
        if count == MOST_CAMERAS {
            warnings.push(format!("{file}: more than {MOST_CAMERAS} cameras; the others are left out"));
            break;
        }
        let lens = &root.cameras[lens.value()];
        let named = [&node.name, &lens.name].into_iter().flatten().find(|name| !name.is_empty());
        let name = named.map_or_else(|| format!("camera{}", cameras.len() + 1), |name| shown_name(name));
        match seeing(lens, world, [low, high]) {
            Ok(camera) => {
                let name = free_name(name, &taken);
                taken.insert(name.clone());
                cameras.push(Camera { name, ..camera });
            }
            Err(why) => warnings.push(format!("{file}: camera {} is left out: {why}", quoted(&name))),
        }
    }
    cameras
}

/// The first of `name`, `name 2`, `name 3`, … that no camera has.
fn free_name(name: String, taken: &HashSet<String>) -> String {
    let numbered = (2..).map(|number| format!("{name} {number}"));
    std::iter::once(name.clone()).chain(numbered).find(|name| !taken.contains(name)).unwrap_or(name)
}

fn seeing(lens: &Lens, world: DMat4, [low, high]: [DVec3; 2]) -> Result<Camera, String> {
    let Some(lens) = &lens.perspective else { return Err("it is orthographic".to_owned()) };
    let vfov_deg = f64::from(lens.yfov).to_degrees();
    if !(vfov_deg > 0.0 && vfov_deg < 180.0) {
        return Err(format!("its field of view is {vfov_deg}°"));
    }
    let eye = world.transform_point3(DVec3::ZERO);
    let ahead = -world.transform_vector3(DVec3::Z).normalize_or_zero();
    let up = world.transform_vector3(DVec3::Y).normalize_or_zero();
    // It goes around what it looks at: as far away as the middle of the scene.
    let size = (high - low).length();
    let depth = (0.5 * (low + high) - eye).dot(ahead);
    let distance = if depth > 0.01 * size { depth } else { 0.5 * size };
    let target = eye + ahead * if distance.is_finite() && distance > 0.0 { distance } else { 1.0 };
    if !is_position(eye) || !is_position(target) {
        return Err("it stands too far away".to_owned());
    }
    if let Some(fault) = pose_fault(eye, target, up) {
        return Err(fault.message().to_owned());
    }
    let aspect = lens.aspect_ratio.map(f64::from).filter(|aspect| aspect.is_finite() && *aspect > 0.0);
    let width = aspect.map_or(DEFAULT_WIDTH, |aspect| {
        (aspect * f64::from(DEFAULT_HEIGHT)).round().clamp(1.0, MOST_PIXELS) as u32
    });
    Ok(Camera { name: String::new(), eye, target, up, vfov_deg, width, height: DEFAULT_HEIGHT })
}
