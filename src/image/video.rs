//! Videos, made by the program `ffmpeg` from the bytes of the pictures; they appear whole or not at all, as pictures do.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::write::OutputError;
use crate::unfinished::Unfinished;

/// The program, looked for where the system looks for programs.
const PROGRAM: &str = "ffmpeg";

/// Sides become even, as the colours of a video at half their resolution need it; colours become those of high-definition
/// video, with the curve of sRGB.
const FILTER: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,\
                      setparams=color_primaries=bt709:color_trc=iec61966-2-1:colorspace=bt709:range=tv";

/// What is told of the encoding: H.264 that players know, of a quality at which little is seen of the loss.
const ENCODING: [&str; 8] = ["-c:v", "libx264", "-crf", "18", "-movflags", "+faststart", "-f", "mp4"];

/// Most of what the program says that is passed on.
const LONGEST_MESSAGE: usize = 300;

/// The size and speed of a video.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VideoShape {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Pictures a second, > 0.
    pub rate: f64,
}

/// A video on its way to its place.
pub struct Video {
    path: PathBuf,
    file: Unfinished,
    program: Program,
    frame_bytes: usize,
}

/// The program at work; it is ended when nobody wants its answer any more.
struct Program {
    child: Child,
    /// What it says. A file: a pipe that nobody reads would stop it.
    said: File,
}

/// Checks, before a long run, that there is an `ffmpeg`.
///
/// # Errors
/// [`OutputError::Video`] when it is missing or does not run.
pub fn check_program(path: &Path) -> Result<(), OutputError> {
    let refused = |message: String| OutputError::Video { path: path.to_owned(), message };
    let status = Command::new(PROGRAM)
        .arg("-version")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .map_err(|error| refused(not_started(&error)))?;
    if status.success() { Ok(()) } else { Err(refused(format!("`ffmpeg -version` failed ({status})"))) }
}

/// Checks, before a long run, that such a video can be made: makes one of a black picture in the place of `trial`, and
/// leaves nothing.
///
/// # Errors
/// [`OutputError::Video`] with what the program says when it refuses.
pub fn check_video(path: &Path, trial: &Path, shape: VideoShape) -> Result<(), OutputError> {
    let mut trial = Video { path: path.to_owned(), ..Video::begin(trial, shape)? };
    trial.add(&vec![0; trial.frame_bytes])?;
    trial.complete()
}

impl Video {
    /// Starts the program.
    ///
    /// # Errors
    /// When the file cannot be created or the program does not start.
    pub fn begin(path: &Path, shape: VideoShape) -> Result<Video, OutputError> {
        let io = |source| OutputError::Io { path: path.to_owned(), source };
        let file = Unfinished::at(path).map_err(io)?;
        let (stdout, name) = file.lend().map_err(io)?;
        let said = tempfile::tempfile().map_err(io)?;
        let child = Command::new(PROGRAM)
            .args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24"])
            .args(["-video_size", &format!("{}x{}", shape.width, shape.height)])
            .args(["-framerate", &shape.rate.to_string(), "-i", "pipe:0", "-vf", FILTER])
            .args(ENCODING)
            .args(["-threads", &rayon::current_num_threads().to_string()])
            .arg(name)
            .stdin(Stdio::piped())
            .stdout(stdout)
            .stderr(said.try_clone().map_err(io)?)
            .spawn()
            .map_err(|error| OutputError::Video { path: path.to_owned(), message: not_started(&error) })?;
        let frame_bytes = shape.width as usize * shape.height as usize * 3;
        Ok(Video { path: path.to_owned(), file, program: Program { child, said }, frame_bytes })
    }

    /// Appends a picture: 8-bit sRGB, three bytes a pixel, row by row from the top.
    ///
    /// # Errors
    /// [`OutputError::Video`] when the program has given up, with what it said.
    pub fn add(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        debug_assert_eq!(bytes.len(), self.frame_bytes);
        let Some(stdin) = &mut self.program.child.stdin else { return Ok(()) };
        stdin.write_all(bytes).map_err(|error| {
            let message = self.program.end().err().unwrap_or(error.to_string());
            OutputError::Video { path: self.path.clone(), message }
        })
    }

    /// Waits for the program and moves the video to its place.
    ///
    /// # Errors
    /// When the program or the system refuses; then what stands there is as before.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.complete()?;
        self.file.finish().map_err(|source| OutputError::Io { path: self.path, source })
    }

    /// Waits until all is written.
    fn complete(&mut self) -> Result<(), OutputError> {
        let is_empty = || self.file.size().is_ok_and(|size| size == 0);
        let written = self.program.end().and_then(|()| match is_empty() {
            true => Err("ffmpeg wrote nothing".to_owned()),
            false => Ok(()),
        });
        written.map_err(|message| OutputError::Video { path: self.path.clone(), message })
    }
}

impl Program {
    /// Tells the program that all is said, and waits for it; the error is what it says then.
    fn end(&mut self) -> Result<(), String> {
        drop(self.child.stdin.take());
        let status = self.child.wait().map_err(|error| format!("lost ffmpeg: {error}"))?;
        if status.success() {
            return Ok(());
        }
        let mut said = Vec::new();
        // Without its words the status has to do.
        let _ = self.said.seek(SeekFrom::Start(0)).and_then(|_| self.said.read_to_end(&mut said));
        let text: String = String::from_utf8_lossy(&said).trim().chars().take(LONGEST_MESSAGE).collect();
        Err(if text.is_empty() { format!("ffmpeg failed ({status})") } else { format!("ffmpeg: {text}") })
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Why the program cannot be started, and what to do.
fn not_started(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => {
            "no program ffmpeg is on the PATH; install it, or leave out --video and make the video elsewhere"
                .to_owned()
        }
        _ => format!("ffmpeg does not start: {error}"),
    }
}
