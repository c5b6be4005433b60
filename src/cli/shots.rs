//! Which pictures a run takes: the files they go to, before anything is solved, and the cameras, once the scene is there.

use std::path::{Path, PathBuf, absolute};

use super::args::MAX_FRAMES;
use super::camera::choose_camera;
use super::config::{Motion, RenderConfig, ViewConfig, Views, check_apart};
use super::errors::CliError;
use super::folder::{check_folder, make_folder};
use super::solved::scene_failure;
use crate::image::write::{OutputError, check_output};
use crate::scene::{self, Camera, CameraPath, Pace, Scene};
use crate::unfinished::folder_of;
use glam::DVec3;

/// The pictures of a run.
pub(super) struct Shots<'a> {
    /// Where each goes.
    pub(super) files: Vec<PathBuf>,
    /// The folder of all of them, when they are several.
    folder: Option<&'a Path>,
    taken: Taken<'a>,
}

/// Which cameras take them; where there is no name, the first one of the scene.
enum Taken<'a> {
    Cameras(Vec<Option<&'a str>>),
    Turntable(Option<&'a str>, u32, Option<DVec3>),
    Path(Option<&'a str>, Box<CameraPath>, Pace),
}

impl<'a> Shots<'a> {
    /// Reads the keyframes when there are some, and names the files.
    ///
    /// # Errors
    /// What is wrong with the keyframes; [`CliError::Usage`] for too many pictures, or one that would go over a file that
    /// has another use.
    pub(super) fn plan(config: &'a RenderConfig) -> Result<Shots<'a>, CliError> {
        let shots = match &config.views {
            Views::One { camera, output } => {
                let taken = Taken::Cameras(vec![camera.as_deref()]);
                Shots { files: vec![output.clone()], folder: None, taken }
            }
            Views::Cameras { names, output } => {
                let files = (1..).zip(names).map(|(number, name)| output.filled(number, name)).collect();
                let taken = Taken::Cameras(names.iter().map(|name| Some(name.as_str())).collect());
                Shots { files, folder: Some(output.folder()), taken }
            }
            Views::Sequence { camera, motion, output } => {
                let camera = camera.as_deref();
                let (frames, taken) = match motion {
                    Motion::Turntable(frames, around) => {
                        (*frames, Taken::Turntable(camera, *frames, *around))
                    }
                    Motion::Path(file, pace) => {
                        let path = CameraPath::read(file).map_err(scene_failure)?;
                        (frames_of(&path, file, *pace)?, Taken::Path(camera, Box::new(path), *pace))
                    }
                };
                let files = (1..=frames as usize).map(|number| output.filled(number, "")).collect();
                Shots { files, folder: Some(output.folder()), taken }
            }
        };
        // One picture was compared with other files before.
        if let Some(folder) = shots.folder {
            let others = || config.inputs.iter().chain(&config.run.outputs);
            shots.files.iter().try_for_each(|file| check_apart(file, others()))?;
            // A folder that is made would stand where another file is to go.
            check_apart(folder, others())?;
        }
        Ok(shots)
    }

    /// Whether the pictures follow each other.
    pub(super) fn is_sequence(&self) -> bool {
        !matches!(self.taken, Taken::Cameras(_))
    }

    /// Checks, before a long run, that every picture can be written.
    ///
    /// # Errors
    /// [`CliError::Output`] and [`CliError::OutputFolder`] when it cannot.
    pub(super) fn check(&self) -> Result<(), CliError> {
        match self.folder {
            Some(folder) => check_folder(folder, &self.files),
            None => Ok(self.files.iter().try_for_each(|file| check_output(file).map(drop))?),
        }
    }

    /// Where it can be tried out whether a file can be written: itself, or the folder of the pictures, when it lies in that
    /// and that is still to be made.
    pub(super) fn trial_of<'p>(&'p self, file: &'p Path) -> &'p Path {
        let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let is_around = |folder: &&Path| match (absolute(folder_of(file)), absolute(folder)) {
            (Ok(own), Ok(folder)) => own == folder,
            _ => false,
        };
        self.folder.filter(is_missing).filter(is_around).unwrap_or(file)
    }

    /// Makes the folder of several pictures when it is missing.
    ///
    /// # Errors
    /// When the system refuses.
    pub(super) fn make_folder(&self) -> Result<(), OutputError> {
        self.folder.map_or(Ok(()), make_folder)
    }

    /// The camera of each picture.
    ///
    /// # Errors
    /// Those of [`choose_camera`]; [`CliError::Usage`] when there is no way around a point;
    /// [`CliError::InvalidScene`] for a view of a path that sees nothing.
    pub(super) fn cameras(&self, scene: &Scene, view: &ViewConfig) -> Result<Vec<Camera>, CliError> {
        match &self.taken {
            Taken::Cameras(names) => names.iter().map(|name| choose_camera(scene, *name, view)).collect(),
            Taken::Turntable(name, frames, around) => {
                let camera = choose_camera(scene, *name, view)?;
                scene::turntable(&camera, around.unwrap_or(camera.target), *frames)
                    .map_err(|error| CliError::Usage(format!("--turntable: {error}; give another --around")))
            }
            Taken::Path(name, path, pace) => {
                path.views(&choose_camera(scene, *name, view)?, *pace).map_err(scene_failure)
            }
        }
    }
}

/// How many pictures a path gives.
fn frames_of(path: &CameraPath, file: &Path, pace: Pace) -> Result<u32, CliError> {
    let frames = path.frame_count(pace);
    u32::try_from(frames).ok().filter(|&frames| frames <= MAX_FRAMES).ok_or_else(|| {
        CliError::Usage(format!(
            "{}: {} s at this --fps are {frames} pictures, more than the {MAX_FRAMES} that are possible; give a smaller \
             one, or --frames",
            file.display(),
            path.seconds()
        ))
    })
}
