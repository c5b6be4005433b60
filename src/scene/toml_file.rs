//! A TOML file written by hand: read with bounds, and with the line of every fault.

use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::de::DeserializeOwned;
use toml::Spanned;

use super::error::SceneError;
use super::lines::{open_regular, unreadable};
use super::statements::LARGEST_COORDINATE;

/// Largest file in bytes; a longer one is not written by hand.
const LARGEST_FILE: u64 = 16 << 20;

/// The text of a file, and where it is from.
pub(super) struct TomlFile {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

impl TomlFile {
    /// Reads a file; `advice` is what to do when it is too large.
    ///
    /// # Errors
    /// [`SceneError::Io`], and [`SceneError::Parse`] for what is no text or too large.
    pub(super) fn read(path: &Path, advice: &str) -> Result<Self, SceneError> {
        let mut bytes = Vec::new();
        open_regular(path)?
            .take(LARGEST_FILE + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| unreadable(path, &error))?;
        if bytes.len() as u64 > LARGEST_FILE {
            let message = format!("larger than {} MiB; {advice}", LARGEST_FILE >> 20);
            return Err(SceneError::parse(path, None, message));
        }
        if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
            return Err(SceneError::parse(path, Some(1), "the file is UTF-16; save it as UTF-8"));
        }
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            let line = line_at(&bytes, error.valid_up_to());
            SceneError::parse(path, Some(line), "the text is not UTF-8; save the file as UTF-8")
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).to_owned();
        Ok(Self { path: path.to_owned(), text })
    }

    /// What the text says.
    ///
    /// # Errors
    /// [`SceneError::Parse`], with the line.
    pub(super) fn parse<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        toml::from_str(&self.text).map_err(|error| {
            let line = error.span().map(|span| line_at(self.text.as_bytes(), span.start));
            SceneError::parse(&self.path, line, explain(error.message()))
        })
    }

    /// Line, from 1, of what is written there.
    pub(super) fn line(&self, span: Range<usize>) -> u64 {
        line_at(self.text.as_bytes(), span.start)
    }

    /// An error about what is written there.
    pub(super) fn fault<T>(&self, span: Range<usize>, message: impl Into<String>) -> Result<T, SceneError> {
        Err(SceneError::invalid(&self.path, Some(self.line(span)), message))
    }

    /// A point or direction of usual size.
    ///
    /// # Errors
    /// [`SceneError::Invalid`], with the line.
    pub(super) fn point(&self, value: &Spanned<[f64; 3]>, key: &str) -> Result<DVec3, SceneError> {
        let point = DVec3::from_array(*value.get_ref());
        if is_position(point) {
            return Ok(point);
        }
        let message = format!("{key} is not finite or beyond {LARGEST_COORDINATE:e}; correct it");
        self.fault(value.span(), message)
    }

    /// A vertical field of view, degrees.
    ///
    /// # Errors
    /// [`SceneError::Invalid`], with the line.
    pub(super) fn vfov_deg(&self, angle: &Spanned<f64>) -> Result<f64, SceneError> {
        let degrees = *angle.get_ref();
        if degrees > 0.0 && degrees < 180.0 {
            return Ok(degrees);
        }
        let message = format!("vfov_deg is {degrees}; write an angle between 0 and 180, such as 45");
        self.fault(angle.span(), message)
    }
}

/// The parser's message on one line, with advice for the common slips.
fn explain(message: &str) -> String {
    let message = message.trim().replace('\n', "; ");
    let advice = if message.contains("expected a sequence") && message.contains("invalid type: map") {
        "; write [[camera]], [[quad]] and [[keyframe]] with two brackets"
    } else if message.starts_with("missing field") {
        "; add it"
    } else if message.starts_with("unknown field") {
        "; correct the key or remove it"
    } else {
        "; correct the value"
    };
    format!("{message}{advice}")
}

/// Line, from 1, of a byte offset.
fn line_at(text: &[u8], offset: usize) -> u64 {
    1 + text[..offset.min(text.len())].iter().filter(|&&byte| byte == b'\n').count() as u64
}

/// Whether a point is finite and of a size that can be computed with.
pub(super) fn is_position(point: DVec3) -> bool {
    point.is_finite() && point.abs().max_element() <= LARGEST_COORDINATE
}
