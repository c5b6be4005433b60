use glam::DVec3;

use super::*;
use crate::progress::Silent;
use crate::scene::{LoadOptions, Scene, load};

fn office(floors: u32, rooms: u32, seed: u64) -> (tempfile::TempDir, OfficeSummary, Scene) {
    let folder = tempfile::tempdir().unwrap();
    let summary = generate_office(&OfficeOptions { floors, rooms, seed }, folder.path()).unwrap();
    let scene = load(&summary.scene, &LoadOptions::default(), &Silent).unwrap();
    (folder, summary, scene)
}

#[test]
fn a_building_loads_whole_and_has_the_promised_triangles() {
    for (floors, rooms) in [(1, 1), (1, 2), (2, 5)] {
        let (_folder, summary, scene) = office(floors, rooms, 7);
        let options = OfficeOptions { floors, rooms, seed: 7 };
        assert_eq!(summary.triangles, options.triangle_count().unwrap());
        assert_eq!(summary.rooms, u64::from(floors * rooms));
        assert_eq!(scene.triangles.len() as u64, summary.triangles);
        assert_eq!(scene.counts.triangles_initial, summary.triangles);
        assert_eq!((scene.counts.dropped_degenerate, scene.counts.dropped_duplicate), (0, 0));
        assert_eq!(scene.warnings, Vec::<String>::new());
        let per_room = summary.triangles / summary.rooms;
        assert!((3_000..=7_000).contains(&per_room), "{per_room} triangles a room");
        let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
        assert_eq!(names, ["room", "corridor"]);
    }
}

#[test]
fn the_same_seed_gives_the_same_files_and_another_seed_others() {
    let mesh = |seed| std::fs::read(office(1, 2, seed).0.path().join("office.obj")).unwrap();
    assert_eq!(mesh(3), mesh(3));
    assert_ne!(mesh(3), mesh(4));
}

#[test]
fn every_lamp_shines_down() {
    let (_folder, _, scene) = office(1, 3, 1);
    let mut lamps = 0;
    for triangle in &scene.triangles {
        if scene.materials[triangle.material as usize].is_emitter() {
            let [a, b, c] = triangle.vertices.map(|vertex| scene.positions[vertex as usize]);
            assert!((b - a).cross(c - a).normalize().abs_diff_eq(DVec3::NEG_Y, 1e-9));
            lamps += 1;
        }
    }
    // Four in each room and one in each of the two bays of the corridor, two triangles each.
    assert_eq!(lamps, 2 * (3 * 4 + 2));
}

/// The first triangle along a ray: its distance and whether its front was hit.
fn first_hit(scene: &Scene, eye: DVec3, direction: DVec3) -> Option<(f64, bool)> {
    let mut nearest: Option<(f64, bool)> = None;
    for triangle in &scene.triangles {
        let [a, b, c] = triangle.vertices.map(|vertex| scene.positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(ac);
        let determinant = ab.dot(p);
        if determinant.abs() < 1e-14 {
            continue;
        }
        let s = eye - a;
        let u = s.dot(p) / determinant;
        let q = s.cross(ab);
        let v = direction.dot(q) / determinant;
        let t = ac.dot(q) / determinant;
        if u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9 && t > 1e-9 && nearest.is_none_or(|(n, _)| t < n) {
            nearest = Some((t, determinant > 0.0));
        }
    }
    nearest
}

#[test]
fn no_light_escapes_and_fronts_face_the_rooms() {
    let (_folder, _, scene) = office(2, 3, 5);
    let eyes = scene.cameras.iter().map(|camera| camera.eye).chain([
        DVec3::new(2.0, 1.2 + 3.1, 4.0),
        DVec3::new(2.0, 1.0, -3.2),
        DVec3::new(6.0, 4.3, 0.1),
    ]);
    let mut backs = 0;
    let mut rays = 0;
    for eye in eyes {
        for i in 0..400 {
            // Points spread evenly over the sphere.
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 400.0;
            let angle = 2.399_963 * f64::from(i);
            let ring = (1.0 - z * z).sqrt();
            let direction = DVec3::new(ring * angle.cos(), z, ring * angle.sin());
            let hit = first_hit(&scene, eye, direction);
            let (distance, is_front) =
                hit.unwrap_or_else(|| panic!("a ray from {eye} to {direction} escapes"));
            assert!(distance < 20.0, "a ray from {eye} to {direction} leaves the storey");
            rays += 1;
            backs += usize::from(!is_front);
        }
    }
    // Only leaves and lamp shades are single sheets, seen from behind now and then.
    assert!(backs * 50 < rays, "{backs} of {rays} rays hit the back of a surface");
}

#[test]
fn senseless_sizes_are_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    for (floors, rooms, word) in [
        (0, 4, "at least 1"),
        (4, 0, "at least 1"),
        (5_000, 5_000, "at most"),
        (u32::MAX, u32::MAX, "at most"),
    ] {
        let options = OfficeOptions { floors, rooms, seed: 1 };
        let error = generate_office(&options, &folder.path().join("new")).unwrap_err();
        assert!(matches!(error, GenerateError::Options(_)));
        assert!(error.to_string().contains(word), "{error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_file_of_the_users_own_is_never_replaced() {
    let options = OfficeOptions { floors: 1, rooms: 1, seed: 1 };
    for name in ["scene.toml", "office.obj", "office.mtl"] {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join(name);
        for content in ["mine\n", "", "# Office"] {
            std::fs::write(&own, content).unwrap();
            let error = generate_office(&options, folder.path()).unwrap_err();
            assert!(matches!(&error, GenerateError::Occupied(path) if path == &own), "{error}");
            assert_eq!(std::fs::read_to_string(&own).unwrap(), content);
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        }
        std::fs::remove_file(&own).unwrap();
        std::fs::create_dir(&own).unwrap();
        assert!(matches!(generate_office(&options, folder.path()), Err(GenerateError::Occupied(_))));
    }
}

#[test]
fn a_generated_building_is_replaced_and_its_neighbours_are_not() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    generate_office(&OfficeOptions { floors: 1, rooms: 1, seed: 1 }, folder.path()).unwrap();
    let before = std::fs::read(folder.path().join("office.obj")).unwrap();
    generate_office(&OfficeOptions { floors: 1, rooms: 2, seed: 1 }, folder.path()).unwrap();
    assert_ne!(std::fs::read(folder.path().join("office.obj")).unwrap(), before);
    assert_eq!(std::fs::read(folder.path().join("notes.txt")).unwrap(), b"mine");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
}

#[test]
fn a_folder_that_cannot_be_made_is_an_error_with_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let error = generate_office(&OfficeOptions::default(), &file.join("below")).unwrap_err();
    assert!(matches!(error, GenerateError::Io { .. }));
    assert!(error.to_string().contains("below"), "{error}");
}
