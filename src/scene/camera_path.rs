//! A camera that moves: keyframes in a TOML file, and the views at any times between them.

use std::path::Path;

use glam::DVec3;
use serde::Deserialize;
use toml::Spanned;

use super::Camera;
use super::error::SceneError;
use super::pose::{PoseFault, pose_fault};
use super::toml_file::TomlFile;
use crate::math::Curve;

/// Times that keyframes may have, seconds.
const LATEST: f64 = 1e9;

/// Which views of a path are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// So many, evenly spread from the first keyframe to the last, both included; at least 1.
    Frames(u32),
    /// So many a second from the first keyframe on; > 0.
    PerSecond(f64),
}

/// Keyframes, at least two, in the order of their times.
pub struct CameraPath {
    file: TomlFile,
    keyframes: Vec<Keyframe>,
    times: Vec<f64>,
}

struct Keyframe {
    line: u64,
    eye: DVec3,
    target: DVec3,
    /// That of the camera when absent, and so for the field of view.
    up: Option<DVec3>,
    vfov_deg: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    keyframe: Vec<Spanned<KeyframeTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyframeTable {
    time: Spanned<f64>,
    eye: Spanned<[f64; 3]>,
    target: Spanned<[f64; 3]>,
    up: Option<Spanned<[f64; 3]>>,
    vfov_deg: Option<Spanned<f64>>,
}

impl CameraPath {
    /// Reads and checks a file of keyframes; see `docs/views.md`.
    ///
    /// # Errors
    /// All kinds of [`SceneError`], with the line where there is one to name.
    pub fn read(path: &Path) -> Result<CameraPath, SceneError> {
        let file = TomlFile::read(path, "keep fewer keyframes; the path is smooth between them")?;
        let document: Document = file.parse()?;
        let (mut keyframes, mut times) = (Vec::new(), Vec::new());
        for table in document.keyframe {
            let line = file.line(table.span());
            let table = table.into_inner();
            let time = *table.time.get_ref();
            if !(-LATEST..=LATEST).contains(&time) {
                let message = format!("time is {time}; write seconds from {:e} to {LATEST:e}", -LATEST);
                return file.fault(table.time.span(), message);
            }
            if let Some(before) = times.last().filter(|&&before| time <= before) {
                let message = format!("time {time} is not after {before}, the keyframe before; sort them");
                return file.fault(table.time.span(), message);
            }
            let (eye, target) = (file.point(&table.eye, "eye")?, file.point(&table.target, "target")?);
            let up = table.up.as_ref().map(|up| file.point(up, "up")).transpose()?;
            // Some up that is not along the view stands for that of a camera which is not known yet.
            match pose_fault(eye, target, up.unwrap_or((target - eye).any_orthogonal_vector())) {
                None => {}
                Some(fault @ PoseFault::NoView) => return file.fault(table.target.span(), fault.message()),
                Some(fault) => {
                    let at = table.up.as_ref().map_or(table.target.span(), Spanned::span);
                    return file.fault(at, fault.message());
                }
            }
            let vfov_deg = table.vfov_deg.as_ref().map(|angle| file.vfov_deg(angle)).transpose()?;
            keyframes.push(Keyframe { line, eye, target, up, vfov_deg });
            times.push(time);
        }
        if keyframes.len() < 2 {
            let message = match keyframes.len() {
                0 => "no [[keyframe]]; give two or more",
                _ => "one [[keyframe]] alone makes no path; give two or more",
            };
            return Err(SceneError::invalid(&file.path, keyframes.first().map(|only| only.line), message));
        }
        Ok(CameraPath { file, keyframes, times })
    }

    /// Seconds from the first keyframe to the last.
    pub fn seconds(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }

    /// How many views a pace takes.
    pub fn frame_count(&self, pace: Pace) -> u64 {
        match pace {
            Pace::Frames(frames) => frames.into(),
            // What rounding takes from a whole number of steps is given back.
            Pace::PerSecond(rate) => (self.seconds() * rate * (1.0 + 1e-12)).floor() as u64 + 1,
        }
    }

    /// The views of `camera` when it moves: eye and target along smooth curves, in straight lines where there are two
    /// keyframes only; up and field of view between those of the keyframes, or as they are where no keyframe has one.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] for a view that sees nothing, with the line of the keyframe before it.
    pub fn views(&self, camera: &Camera, pace: Pace) -> Result<Vec<Camera>, SceneError> {
        let curve = |point: &dyn Fn(&Keyframe) -> DVec3| {
            Curve::through(&self.times, self.keyframes.iter().map(point).collect())
        };
        let eyes = curve(&|key| key.eye);
        let targets = curve(&|key| key.target);
        let ups = curve(&|key| key.up.unwrap_or(camera.up).normalize());
        let angle_of = |key: &Keyframe| key.vfov_deg.unwrap_or(camera.vfov_deg);
        let angles = curve(&|key| DVec3::splat(angle_of(key)));
        let frames = self.frame_count(pace);
        let (start, end) = (self.times[0], self.times[self.times.len() - 1]);
        let mut views = Vec::new();
        for frame in 0..frames {
            let time = match pace {
                Pace::Frames(1) => start,
                Pace::Frames(_) => start + self.seconds() * (frame as f64 / (frames - 1) as f64),
                Pace::PerSecond(rate) => start + frame as f64 / rate,
            };
            let time = time.min(end);
            let after = self.times.partition_point(|&other| other <= time).clamp(1, self.times.len() - 1);
            let [before, after] = [after - 1, after].map(|index| &self.keyframes[index]);
            let (eye, target, up) = (eyes.at(time), targets.at(time), ups.at(time));
            if let Some(fault) = pose_fault(eye, target, up) {
                let message = format!("at {time} s, after this keyframe, {}", fault.message());
                return Err(SceneError::invalid(&self.file.path, Some(before.line), message));
            }
            // An angle beyond those of the keyframes could be none.
            let (a, b) = (angle_of(before), angle_of(after));
            let vfov_deg = angles.at(time).x.clamp(a.min(b), a.max(b));
            views.push(Camera { eye, target, up, vfov_deg, ..camera.clone() });
        }
        Ok(views)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: "main".to_owned(),
            eye: DVec3::ZERO,
            target: DVec3::X,
            up: DVec3::Y,
            vfov_deg: 40.0,
            width: 4,
            height: 3,
        }
    }

    fn read(text: &str) -> Result<CameraPath, SceneError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("path.toml");
        std::fs::write(&path, text).expect("written");
        CameraPath::read(&path)
    }

    /// A keyframe on four lines.
    fn key(time: &str, eye: &str, target: &str) -> String {
        format!("[[keyframe]]\ntime = {time}\neye = {eye}\ntarget = {target}\n")
    }

    fn error(text: &str) -> String {
        let error = read(text).err().unwrap_or_else(|| panic!("accepted:\n{text}"));
        let (file, line) = error.location();
        let text = error.to_string().replace(&file.display().to_string(), "path.toml");
        assert!(line.is_some() || text.contains("no [[keyframe]]"), "{text}");
        text
    }

    #[test]
    fn faults_have_their_line() {
        let first = key("0", "[0, 0, 0]", "[1, 0, 0]");
        let then = |second: String| error(&format!("{first}{second}"));
        for (text, parts) in [
            (error(""), ["path.toml: ", "no [[keyframe]]"]),
            (error(&first), ["path.toml:1: ", "one [[keyframe]] alone"]),
            (then(key("0", "[0, 0, 0]", "[1, 0, 0]")), ["path.toml:6: ", "not after 0"]),
            (then(key("-1", "[0, 0, 0]", "[1, 0, 0]")), ["path.toml:6: ", "not after 0"]),
            (then(key("nan", "[0, 0, 0]", "[1, 0, 0]")), ["path.toml:6: ", "time is NaN"]),
            (then(key("inf", "[0, 0, 0]", "[1, 0, 0]")), ["path.toml:6: ", "time is inf"]),
            (then(key("1", "[0, nan, 0]", "[1, 0, 0]")), ["path.toml:7: ", "eye is not finite"]),
            (
                then(key("1", "[0, 0, 0]", "[1e300, 0, 0]")),
                ["path.toml:8: ", "target is not finite or beyond"],
            ),
            (then(key("1", "[1, 2, 3]", "[1, 2, 3]")), ["path.toml:8: ", "same point"]),
            (then(key("1", "[0, 0]", "[1, 0, 0]")), ["path.toml:7: ", "correct the value"]),
            (then(key("1", "[0, 0, 0]", "[1, 0, 0]") + "up = [2, 0, 0]"), ["path.toml:9: ", "parallel"]),
            (then(key("1", "[0, 0, 0]", "[1, 0, 0]") + "up = [0, 0, 0]"), ["path.toml:9: ", "up is zero"]),
            (
                then(key("1", "[0, 0, 0]", "[1, 0, 0]") + "vfov_deg = 180"),
                ["path.toml:9: ", "vfov_deg is 180"],
            ),
            (then(key("1", "[0, 0, 0]", "[1, 0, 0]") + "fov = 80"), ["path.toml:9: ", "unknown field"]),
            (then("[[keyframe]]\ntime = 1\n".to_owned()), ["path.toml:5: ", "missing field"]),
            (then("[keyframes]\n".to_owned()), ["path.toml:5: ", "unknown field"]),
            (then("= 3\n".to_owned()), ["path.toml:5: ", ""]),
        ] {
            assert!(text.starts_with(parts[0]) && text.contains(parts[1]), "{text} has not {parts:?}");
        }
    }

    #[test]
    fn views_meet_the_keyframes_and_take_the_rest_from_the_camera() {
        let path = read(
            &(key("1", "[0, 0, 0]", "[5, 0, 0]")
                + &key("2", "[1, 0, 0]", "[5, 1, 0]")
                + "vfov_deg = 60\nup = [0, 0, 3]\n"
                + &key("4", "[2, 1, 0]", "[5, 0, 1]")),
        )
        .expect("a path");
        let views = path.views(&camera(), Pace::PerSecond(2.0)).expect("views");
        assert_eq!((views.len() as u64, path.seconds()), (path.frame_count(Pace::PerSecond(2.0)), 3.0));
        assert_eq!(views.len(), 7);
        let seen = |view: &Camera| (view.eye, view.target, view.up, view.vfov_deg);
        assert_eq!(seen(&views[0]), (DVec3::ZERO, DVec3::X * 5.0, DVec3::Y, 40.0));
        assert_eq!(seen(&views[2]), (DVec3::X, DVec3::new(5.0, 1.0, 0.0), DVec3::Z, 60.0));
        assert_eq!(seen(&views[6]).0, DVec3::new(2.0, 1.0, 0.0));
        assert!(views[1].vfov_deg > 45.0 && views[1].vfov_deg < 60.0 && views[1].eye.x > 0.3);
        assert_eq!((views[3].width, views[3].name.as_str()), (4, "main"));
        let spread = path.views(&camera(), Pace::Frames(7)).expect("views");
        for (a, b) in views.iter().zip(&spread) {
            assert!(a.eye.distance(b.eye) < 1e-12);
        }
        assert_eq!(path.views(&camera(), Pace::Frames(1)).expect("a view")[0], views[0]);
    }

    #[test]
    fn the_last_keyframe_is_not_lost_to_rounding() {
        let path = read(&(key("0.1", "[0, 0, 0]", "[1, 0, 0]") + &key("0.7", "[1, 0, 0]", "[2, 0, 0]")))
            .expect("a path");
        assert_eq!(path.frame_count(Pace::PerSecond(30.0)), 19);
        assert_eq!(path.frame_count(Pace::PerSecond(29.9)), 18);
        let views = path.views(&camera(), Pace::PerSecond(30.0)).expect("views");
        assert!(views[18].eye.distance(DVec3::X) < 1e-9);
    }

    #[test]
    fn angles_stay_between_those_of_the_keyframes() {
        let angled =
            |time: &str, angle: &str| key(time, "[0, 0, 0]", "[1, 0, 0]") + &format!("vfov_deg = {angle}\n");
        let text = angled("0", "178") + &angled("1", "1") + &angled("2", "3") + &angled("3", "179");
        let views =
            read(&text).expect("a path").views(&camera(), Pace::Frames(400)).expect("every angle is one");
        assert!(views.iter().all(|view| (1.0..=179.0).contains(&view.vfov_deg)));
    }

    #[test]
    fn a_view_that_sees_nothing_is_an_error_at_the_keyframe_before() {
        let path = read(&(key("0", "[-1, 0, 0]", "[1, 0, 0]") + &key("2", "[1, 0, 0]", "[-1, 0, 0]")))
            .expect("each keyframe by itself is sound");
        let error = path.views(&camera(), Pace::Frames(3)).expect_err("eye and target meet");
        assert!(
            error.to_string().contains("path.toml:1: at 1 s") && error.to_string().contains("same point")
        );
        let along = Camera { up: DVec3::X, ..camera() };
        let error = path.views(&along, Pace::Frames(2)).expect_err("up of the camera is along the view");
        assert!(error.to_string().contains("parallel"), "{error}");
    }
}
