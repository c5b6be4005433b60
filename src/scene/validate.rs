//! The clean-up at the end of the import: equal positions become one vertex, triangles without area and
//! duplicates go, reflectances are clamped, and a scene that cannot be lit is refused.

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use super::draft::{DEFAULT_GREY, Draft, DraftMaterial, Origin, shown_name};
use super::error::{SceneError, name_list};
use super::{LoadOptions, Material, Scene, Triangle};

/// Highest reflectance: a closed room with more would take hundreds of reflections to converge.
pub(super) const HIGHEST_REFLECTANCE: f64 = 0.98;

/// A triangle lower than this, in units of its longest edge or its largest coordinate, has no area
/// that double precision can tell from rounding.
const FLATNESS: f64 = 1e-12;

/// Cleans up and checks; the scene has no cameras yet.
pub(super) fn finish(
    mut draft: Draft,
    name: String,
    meters_per_unit: f64,
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    weld(&mut draft.positions, &mut draft.triangles);
    drop_degenerate(&mut draft);
    drop_duplicates(&mut draft);
    if draft.triangles.is_empty() {
        let counts = &draft.counts;
        let message = if counts.triangles_initial > 0 {
            "no triangles left: all have zero area; check the vertex positions".to_owned()
        } else if counts.skipped_faces > 0 {
            format!("no triangles, only {} point(s) and line(s); export polygons", counts.skipped_faces)
        } else {
            "no triangles; the scene needs faces with at least 3 corners".to_owned()
        };
        return Err(SceneError::invalid(&draft.file, None, message));
    }
    let materials = compact_materials(&mut draft);
    warn_of_defaults(&mut draft.warnings, &draft.file.display().to_string(), &materials);
    let materials = clamp(&mut draft.warnings, &draft.file.display().to_string(), materials);
    if options.require_emitter && !materials.iter().any(Material::is_emitter) {
        let missing = &draft.missing_libraries;
        let reason = if !missing.is_empty() {
            format!(" (material library not found: {})", name_list(missing.iter().map(String::as_str)))
        } else if draft.pointlike_lights > 0 {
            format!(" ({} point, spot or directional light(s) have no surface)", draft.pointlike_lights)
        } else {
            String::new()
        };
        let message = format!(
            "nothing emits light{reason}; give a material a Ke in the MTL or an emissiveFactor in the glTF, or radiance \
             in a .toml scene description ([[quad]] or [material.\"name\"])"
        );
        return Err(SceneError::invalid(&draft.file, None, message));
    }
    check_extent(&mut draft, &materials)?;
    let patch_count = renumber_patches(&mut draft.triangles);
    Ok(Scene {
        name,
        positions: draft.positions,
        triangles: draft.triangles,
        materials,
        rectangles: Vec::new(),
        cameras: Vec::new(),
        meters_per_unit,
        patch_count,
        counts: draft.counts,
        files: draft.files,
        warnings: draft.warnings,
    })
}

/// Refuses emitters that single precision cannot tell from a point in a scene of this size.
fn check_extent(draft: &mut Draft, materials: &[Material]) -> Result<(), SceneError> {
    let corners = |t: &Triangle| t.vertices.map(|v| draft.positions[v as usize]);
    let emitters = draft.triangles.iter().filter(|t| materials[t.material as usize].is_emitter());
    let edges = emitters.flat_map(|t| {
        let [a, b, c] = corners(t);
        [(a.distance(b), a), (b.distance(c), b), (c.distance(a), c)]
    });
    let Some((edge, emitter)) = edges.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    let distance = |p: &DVec3| p.distance(emitter);
    let points = draft.triangles.iter().flat_map(corners);
    let Some(far) = points.max_by(|a, b| distance(a).total_cmp(&distance(b))) else { return Ok(()) };
    let extent = distance(&far);
    if edge > LEAST_EMITTER * extent {
        return Ok(());
    }
    let message = format!(
        "the point ({:e} {:e} {:e}) lies {extent:.3e} units from the largest emitter, which is {edge:.3e} units long: \
         too far for single precision; remove it, or bring it nearer",
        far.x, far.y, far.z
    );
    if edge > SMALLEST_EMITTER * extent {
        draft.warnings.push(format!("{}: {message}", draft.file.display()));
        return Ok(());
    }
    Err(SceneError::invalid(&draft.file, None, message))
}

/// An emitter shorter than this part of the scene is a few roundings long.
const LEAST_EMITTER: f64 = 1e-5;

/// And one shorter than this is none.
const SMALLEST_EMITTER: f64 = 1e-7;

/// Makes equal positions one vertex and forgets those no triangle uses; the order stays.
fn weld(positions: &mut Vec<DVec3>, triangles: &mut [Triangle]) {
    const UNUSED: u32 = u32::MAX;
    let bits = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let mut is_used = vec![false; positions.len()];
    for vertex in triangles.iter().flat_map(|triangle| triangle.vertices) {
        is_used[vertex as usize] = true;
    }
    // Sorting by a hash costs one comparison of small keys instead of one of three coordinates.
    let mut order: Vec<(u64, u32)> = positions
        .iter()
        .enumerate()
        .filter(|&(i, _)| is_used[i])
        .map(|(i, &position)| (hash(bits(position)), i as u32))
        .collect();
    order.par_sort_unstable();
    let mut kept = vec![UNUSED; positions.len()];
    for run in order.chunk_by_mut(|a, b| a.0 == b.0) {
        // Equal hashes are nearly always equal positions; sort to be sure of it at any size.
        run.sort_unstable_by_key(|&(_, i)| (bits(positions[i as usize]), i));
        let mut first = run[0].1;
        for &(_, i) in run.iter() {
            if bits(positions[i as usize]) != bits(positions[first as usize]) {
                first = i;
            }
            kept[i as usize] = first;
        }
    }
    drop(order);
    let mut count = 0;
    for i in 0..positions.len() {
        kept[i] = match kept[i] {
            UNUSED => UNUSED,
            first if first as usize == i => {
                // Adding zero turns −0 into 0.
                positions[count] = positions[i] + DVec3::ZERO;
                count += 1;
                count as u32 - 1
            }
            first => kept[first as usize],
        };
    }
    positions.truncate(count);
    positions.shrink_to_fit();
    for triangle in triangles {
        triangle.vertices = triangle.vertices.map(|vertex| kept[vertex as usize]);
    }
}

fn hash(words: [u64; 3]) -> u64 {
    words.iter().fold(0x9E37_79B9_7F4A_7C15, |state, &word| {
        let mixed = (state ^ word).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed ^ (mixed >> 29)
    })
}

fn drop_degenerate(draft: &mut Draft) {
    let before = draft.triangles.len();
    let positions = &draft.positions;
    draft.triangles.retain(|triangle| {
        let [a, b, c] = triangle.vertices.map(|vertex| positions[vertex as usize]);
        !is_degenerate(a, b, c)
    });
    draft.counts.dropped_degenerate += (before - draft.triangles.len()) as u64;
}

/// Whether the height over the longest edge is within rounding of zero.
fn is_degenerate(a: DVec3, b: DVec3, c: DVec3) -> bool {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let longest = ab.length().max(ac.length()).max(bc.length());
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    ab.cross(ac).length() <= FLATNESS * longest * longest.max(largest)
}

/// Keeps one triangle of those with the same three corners: the first that emits, else the first.
fn drop_duplicates(draft: &mut Draft) {
    let mut order: Vec<([u32; 3], u32)> = draft
        .triangles
        .iter()
        .enumerate()
        .map(|(i, triangle)| {
            let mut corners = triangle.vertices;
            corners.sort_unstable();
            (corners, i as u32)
        })
        .collect();
    order.par_sort_unstable();
    let emits =
        |triangle: &Triangle| draft.materials[triangle.material as usize].radiance.iter().any(|&l| l > 0.0);
    let mut is_dropped = vec![false; draft.triangles.len()];
    let mut lost_emitters = 0;
    for run in order.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        let kept = run.iter().position(|&(_, i)| emits(&draft.triangles[i as usize])).unwrap_or(0);
        let kept_triangle = &draft.triangles[run[kept].1 as usize];
        for (_, &(_, i)) in run.iter().enumerate().filter(|&(place, _)| place != kept) {
            let triangle = &draft.triangles[i as usize];
            let is_turned = !is_rotation(triangle.vertices, kept_triangle.vertices);
            lost_emitters += usize::from(is_turned && emits(triangle));
            is_dropped[i as usize] = true;
        }
    }
    if lost_emitters > 0 {
        draft.warnings.push(format!(
            "{}: {lost_emitters} emitting triangle(s) dropped that lie on another facing the other way; \
             emission leaves the first only, so move them apart for a lamp that shines both ways",
            draft.file.display()
        ));
    }
    let before = draft.triangles.len();
    let mut i = 0;
    draft.triangles.retain(|_| {
        i += 1;
        !is_dropped[i - 1]
    });
    draft.counts.dropped_duplicate += (before - draft.triangles.len()) as u64;
}

/// Whether two triangles with the same corners are wound the same way.
fn is_rotation(a: [u32; 3], b: [u32; 3]) -> bool {
    a == b || a == [b[1], b[2], b[0]] || a == [b[2], b[0], b[1]]
}

/// The materials that triangles use, in order of first use; the triangles are renumbered.
fn compact_materials(draft: &mut Draft) -> Vec<DraftMaterial> {
    let mut new_id: Vec<Option<u32>> = vec![None; draft.materials.len()];
    let mut used = Vec::new();
    for triangle in &mut draft.triangles {
        let old = triangle.material as usize;
        triangle.material = *new_id[old].get_or_insert_with(|| {
            used.push(draft.materials[old].clone());
            used.len() as u32 - 1
        });
    }
    used
}

/// One line for each reason why materials are grey.
fn warn_of_defaults(warnings: &mut Vec<String>, file: &str, materials: &[DraftMaterial]) {
    let names = |origin: Origin| {
        let found = distinct_names(materials.iter().filter(|m| m.origin == origin));
        (!found.is_empty()).then(|| name_list(found))
    };
    if let Some(names) = names(Origin::Missing) {
        warnings
            .push(format!("{file}: material(s) in no MTL file get grey reflectance {DEFAULT_GREY}: {names}"));
    }
    if let Some(names) = names(Origin::WithoutKd) {
        warnings.push(format!("{file}: material(s) without Kd get grey reflectance {DEFAULT_GREY}: {names}"));
    }
    if names(Origin::Unnamed).is_some() {
        warnings.push(format!("{file}: faces without a material get grey reflectance {DEFAULT_GREY}"));
    }
}

/// Each name once: many materials have the same where vertices have colours.
fn distinct_names<'a>(materials: impl Iterator<Item = &'a DraftMaterial>) -> Vec<&'a str> {
    let mut seen = HashSet::new();
    materials.map(|material| material.name.as_str()).filter(|&name| seen.insert(name)).collect()
}

fn clamp(warnings: &mut Vec<String>, file: &str, materials: Vec<DraftMaterial>) -> Vec<Material> {
    let is_too_bright =
        |material: &&DraftMaterial| material.reflectance.iter().any(|&rho| rho > HIGHEST_REFLECTANCE);
    let clamped = distinct_names(materials.iter().filter(is_too_bright));
    if !clamped.is_empty() {
        warnings.push(format!(
            "{file}: reflectance above {HIGHEST_REFLECTANCE} is clamped to it in material(s) {}",
            name_list(clamped)
        ));
    }
    materials
        .into_iter()
        .map(|material| Material {
            name: shown_name(&material.name),
            reflectance: material.reflectance.map(|rho| rho.min(HIGHEST_REFLECTANCE) as f32),
            radiance: material.radiance.map(|radiance| radiance as f32),
            painting: material.painting,
        })
        .collect()
}

/// Numbers the polygons that still have triangles from 0, in order; returns how many.
fn renumber_patches(triangles: &mut [Triangle]) -> u32 {
    let mut count = 0;
    let mut last = None;
    for triangle in triangles {
        if last != Some(triangle.patch) {
            last = Some(triangle.patch);
            count += 1;
        }
        triangle.patch = count - 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_triangles_are_degenerate_at_any_scale_and_place() {
        for scale in [1e-9, 1.0, 1e9] {
            for offset in [0.0, 3.0] {
                let at = |x: f64, y: f64| DVec3::new(x + offset, y + offset, offset) * scale;
                assert!(is_degenerate(at(0.0, 0.0), at(0.1, 0.1), at(0.7, 0.7)));
                assert!(is_degenerate(at(0.0, 0.0), at(0.0, 0.0), at(1.0, 0.0)));
                assert!(!is_degenerate(at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1e-6)));
            }
        }
    }

    #[test]
    fn welding_joins_equal_positions_and_forgets_unused_ones() {
        let mut positions = vec![
            DVec3::new(9.0, 9.0, 9.0),
            DVec3::new(-0.0, 0.0, 0.0),
            DVec3::X,
            DVec3::Y,
            DVec3::ZERO,
            DVec3::X,
            DVec3::Z,
        ];
        let triangle = |vertices| Triangle { vertices, material: 0, patch: 0 };
        let mut triangles = [triangle([1, 2, 3]), triangle([4, 6, 5])];
        weld(&mut positions, &mut triangles);
        assert_eq!(positions, [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
        assert_eq!(triangles.map(|t| t.vertices), [[0, 1, 2], [0, 3, 1]]);
    }
}
