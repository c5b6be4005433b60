//! STAND-INS for rooms that are not joined yet: delete this file and its `mod` line, and in
//! `render.rs`, `doctor.rs` and `generate.rs` replace `super::pending::` by `crate::`.
#![allow(missing_docs, unused_variables)]

pub(super) mod scene {
    use crate::scene::{Camera, ImportCounts, Scene, Triangle};
    use glam::DVec3;
    use std::path::Path;

    #[derive(Default)]
    pub(in super::super) struct LoadOptions {}

    pub(in super::super) enum SceneErrorKind {
        Io,
        Parse,
        Invalid,
    }

    #[derive(Debug, thiserror::Error)]
    pub(in super::super) enum SceneError {
        #[error("{0}")]
        Unreadable(String),
        #[error("{0}")]
        Malformed(String),
        #[error("{0}")]
        Invalid(String),
    }

    impl SceneError {
        pub(in super::super) fn kind(&self) -> SceneErrorKind {
            match self {
                SceneError::Unreadable(_) => SceneErrorKind::Io,
                SceneError::Malformed(_) => SceneErrorKind::Parse,
                SceneError::Invalid(_) => SceneErrorKind::Invalid,
            }
        }
    }

    pub(in super::super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
        let at = |what: String| format!("{}: {what}", path.display());
        let bytes = std::fs::read(path).map_err(|e| SceneError::Unreadable(at(e.to_string())))?;
        let text = String::from_utf8(bytes).map_err(|e| SceneError::Malformed(at(e.to_string())))?;
        if path.extension().is_some_and(|e| e == "obj") {
            if let Some(line) = text.lines().position(|l| l.starts_with("v ") && l.contains('x')) {
                return Err(SceneError::Malformed(at(format!("line {}: not a number", line + 1))));
            }
            if !text.lines().any(|l| l.starts_with("f ")) {
                return Err(SceneError::Invalid(at("no triangles".to_owned())));
            }
            return Err(SceneError::Invalid(at("no emitter".to_owned())));
        }
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| {
            let line = e.span().map_or(1, |span| text[..span.start].lines().count().max(1));
            SceneError::Malformed(at(format!("line {line}: {}", e.message())))
        })?;
        if let Some(mesh) = table.get("mesh").and_then(|m| m.as_str()) {
            let mesh = path.with_file_name(mesh);
            std::fs::metadata(&mesh)
                .map_err(|e| SceneError::Unreadable(format!("{}: {e}", mesh.display())))?;
        }
        let number = |v: &toml::Value| v.as_float().or(v.as_integer().map(|i| i as f64)).unwrap_or(0.0);
        let mut cameras = Vec::new();
        for camera in table.get("camera").and_then(|c| c.as_array()).into_iter().flatten() {
            let point = |key: &str| {
                let v = camera.get(key).and_then(|v| v.as_array());
                v.map_or(DVec3::ZERO, |v| DVec3::new(number(&v[0]), number(&v[1]), number(&v[2])))
            };
            if point("eye") == point("target") {
                return Err(SceneError::Invalid(at("camera: eye = target".to_owned())));
            }
            if camera.get("width").is_some_and(|w| number(w) < 1.0) {
                return Err(SceneError::Invalid(at("camera: width is 0".to_owned())));
            }
            cameras.push(Camera {
                name: camera.get("name").and_then(|n| n.as_str()).unwrap_or("camera").to_owned(),
                eye: point("eye"),
                target: point("target"),
                up: DVec3::Y,
                vfov_deg: 40.0,
                width: camera.get("width").map_or(64.0, number) as u32,
                height: camera.get("height").map_or(64.0, number) as u32,
            });
        }
        if !text.contains("radiance") {
            return Err(SceneError::Invalid(at("no emitter".to_owned())));
        }
        Ok(Scene {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            positions: vec![DVec3::ZERO, DVec3::ONE, DVec3::X],
            triangles: vec![Triangle { vertices: [0, 1, 2], material: 0, patch: 0 }],
            materials: Vec::new(),
            cameras,
            meters_per_unit: 1.0,
            patch_count: 1,
            counts: ImportCounts { triangles_initial: 1, ..ImportCounts::default() },
            warnings: Vec::new(),
        })
    }

    pub(in super::super) struct OfficeOptions {
        pub(in super::super) floors: u32,
        pub(in super::super) rooms: u32,
    }
    pub(in super::super) struct OfficeSummary {
        pub(in super::super) triangles: u64,
    }
    pub(in super::super) fn generate_office(
        options: &OfficeOptions,
        dir: &Path,
    ) -> std::io::Result<OfficeSummary> {
        std::fs::write(dir.join("scene.toml"), "mesh = \"office.obj\"\n")?;
        std::fs::write(dir.join("office.obj"), "")?;
        Ok(OfficeSummary { triangles: u64::from(options.floors * options.rooms) })
    }
}

pub(super) mod hierarchy {
    pub(in super::super) struct Hierarchy {
        pub(in super::super) facets: Vec<()>,
    }
    impl Hierarchy {
        pub(in super::super) fn build(scene: &crate::scene::Scene, one_sided: bool) -> Self {
            Self { facets: vec![()] }
        }
        pub(in super::super) fn cluster_count(&self) -> usize {
            1
        }
    }
}

pub(super) mod tracer {
    use super::hierarchy::Hierarchy;
    use crate::tracer::{Candidates, FilterAudit, Hit, Ray, Segment, Tracer};
    use std::path::{Path, PathBuf};

    struct Nothing;
    impl Tracer for Nothing {
        fn name(&self) -> &'static str {
            "fallback"
        }
        fn blockers(&self, _: &[Segment], _: Candidates<'_>, _: &mut [u32], _: &mut FilterAudit) {}
        fn first_hits(&self, _: &[Ray], _: &mut [Option<Hit>]) {}
    }
    pub(in super::super) fn fallback(hierarchy: &Hierarchy) -> Box<dyn Tracer> {
        Box::new(Nothing)
    }
    pub(in super::super) fn embree(
        hierarchy: &Hierarchy,
        library: Option<&Path>,
    ) -> Result<(Box<dyn Tracer>, String), String> {
        Err(format!("not joined yet; {}", library.unwrap_or(Path::new("nothing")).display()))
    }
    pub(in super::super) struct Diagnosis {
        pub(in super::super) library: Option<PathBuf>,
        pub(in super::super) found_by: Option<String>,
        pub(in super::super) version: Option<String>,
        pub(in super::super) instruction_set: Option<String>,
        pub(in super::super) self_tests: Vec<(&'static str, Result<(), String>)>,
        /// Why Embree is not usable; nothing when it is.
        pub(in super::super) problem: Option<String>,
    }
    pub(in super::super) fn diagnose(library: Option<&Path>) -> Diagnosis {
        Diagnosis {
            library: library.map(Path::to_owned),
            found_by: None,
            version: None,
            instruction_set: None,
            self_tests: Vec::new(),
            problem: Some("not joined yet".to_owned()),
        }
    }
}

pub(super) mod visibility {
    #[derive(Clone, Copy)]
    pub(in super::super) enum Strategy {
        All,
        Root,
        Shaft,
        Adaptive,
        Sampled,
    }

    impl Strategy {
        pub(in super::super) fn name(self) -> &'static str {
            match self {
                Strategy::All => "all",
                Strategy::Root => "root",
                Strategy::Shaft => "shaft",
                Strategy::Adaptive => "adaptive",
                Strategy::Sampled => "sampled",
            }
        }
    }
}

pub(super) mod radiosity {
    use super::hierarchy::Hierarchy;
    use super::visibility::Strategy;
    use crate::progress::Progress;
    use crate::report::stats::{EnergyStats, LinkStats, VisibilityStats};
    use crate::tracer::Tracer;

    #[allow(dead_code)]
    pub(in super::super) struct SolveOptions {
        pub(in super::super) epsilon: f64,
        pub(in super::super) min_size: f64,
        pub(in super::super) rays: u32,
        pub(in super::super) iterations: u32,
        pub(in super::super) strategy: Strategy,
        pub(in super::super) certify: bool,
    }
    #[derive(Default)]
    pub(in super::super) struct Solution {
        pub(in super::super) patches: u64,
        pub(in super::super) elements: u64,
        pub(in super::super) triangles_final: u64,
        pub(in super::super) links: LinkStats,
        pub(in super::super) visibility: VisibilityStats,
        pub(in super::super) energy: EnergyStats,
        pub(in super::super) iterations: u32,
        pub(in super::super) energy_error_w: f64,
        pub(in super::super) links_bytes: u64,
        pub(in super::super) elements_bytes: u64,
        pub(in super::super) refine_seconds: f64,
        pub(in super::super) solve_seconds: f64,
    }
    pub(in super::super) fn solve(
        scene: &crate::scene::Scene,
        hierarchy: &Hierarchy,
        tracer: &dyn Tracer,
        options: &SolveOptions,
        progress: &dyn Progress,
    ) -> Solution {
        progress.start("refine", 10);
        (0..10).for_each(|_| progress.advance(1));
        progress.finish();
        Solution::default()
    }
}

pub(super) mod image {
    use super::{hierarchy::Hierarchy, radiosity::Solution};
    use crate::image::picture::Picture;
    use crate::progress::Progress;
    use crate::scene::{Camera, Scene};
    use crate::tracer::Tracer;

    pub(in super::super) enum View {
        Shaded,
        Mesh,
    }
    #[allow(dead_code)]
    pub(in super::super) struct RenderOptions {
        pub(in super::super) samples: u32,
        pub(in super::super) view: View,
    }
    pub(in super::super) fn render(
        scene: &Scene,
        hierarchy: &Hierarchy,
        tracer: &dyn Tracer,
        solution: &Solution,
        camera: &Camera,
        options: RenderOptions,
        progress: &dyn Progress,
    ) -> Picture {
        let mut picture = Picture::black(camera.width, camera.height);
        for (index, pixel) in picture.pixels.iter_mut().enumerate() {
            *pixel = [0.1 + (index % camera.width as usize) as f32 * 0.01; 3];
        }
        picture
    }
}
