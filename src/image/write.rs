//! Pictures as files: PNG for the screen, EXR and HDR for further work, written whole or not at all.

use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use image::codecs::{hdr::HdrEncoder, openexr::OpenExrEncoder, png::PngEncoder};
use image::{ExtendedColorType, ImageEncoder, Rgb};

use super::layers::Layers;
use super::picture::Picture;
use super::tone;
use crate::unfinished::{Unfinished, folder_of};

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The extension names no format we write.
    #[error("{}: unknown picture format; the name must end in .png, .exr or .hdr", path.display())]
    UnknownFormat {
        /// The output as given.
        path: PathBuf,
    },
    /// The folder the file should go to does not exist.
    #[error("{}: the folder {} does not exist", path.display(), folder.display())]
    NoFolder {
        /// The output as given.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// A folder, a device or the like stands where the file should be.
    #[error("{}: exists and is not a regular file", path.display())]
    NotAFile {
        /// The output as given.
        path: PathBuf,
    },
    /// A symbolic link stands there, and what it leads to does not.
    #[error("{}: a symbolic link to a file that does not exist; remove it or make that file", path.display())]
    DanglingLink {
        /// The output as given.
        path: PathBuf,
    },
    /// The file exists and is read-only.
    #[error("{}: exists and is read-only", path.display())]
    ReadOnly {
        /// The output as given.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{}: cannot write: {source}", path.display())]
    Io {
        /// The output as given.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The encoder refused.
    #[error("{}: cannot encode the picture: {message}", path.display())]
    Encode {
        /// The output as given.
        path: PathBuf,
        /// What the encoder said.
        message: String,
    },
    /// The program that makes videos is missing, or refused.
    #[error("{}: cannot make the video: {message}", path.display())]
    Video {
        /// The output as given.
        path: PathBuf,
        /// What was wrong.
        message: String,
    },
}

/// A file format for pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8 bits a channel, sRGB, tone-mapped.
    Png,
    /// 32-bit float a channel, linear radiance in W/(m²·sr), not exposed and not tone-mapped.
    Exr,
    /// The same in 8 bits a channel with an exponent for all three (Radiance RGBE): a hundredth of the largest channel gets lost.
    Hdr,
}

impl PictureFormat {
    /// The format that the extension of `path` names, in upper or lower case.
    ///
    /// # Errors
    /// [`OutputError::UnknownFormat`] for any other extension or none.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            Some("hdr") => Ok(Self::Hdr),
            _ => Err(OutputError::UnknownFormat { path: path.to_owned() }),
        }
    }
}

/// Checks, before a long run, that a picture can be written to `path`; leaves nothing behind.
///
/// # Errors
/// When the extension is unknown or [`check_destination`] fails.
pub fn check_output(path: &Path) -> Result<PictureFormat, OutputError> {
    let format = PictureFormat::of(path)?;
    check_destination(path)?;
    Ok(format)
}

/// Checks that a file can be created or replaced at `path`; leaves nothing behind.
///
/// # Errors
/// When the folder is missing or not writable, or something other than a writable regular file
/// stands there.
pub fn check_destination(path: &Path) -> Result<(), OutputError> {
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(OutputError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    let io = |source| OutputError::Io { path: path.to_owned(), source };
    match path.metadata() {
        Ok(found) if found.is_file() && found.permissions().readonly() => {
            return Err(OutputError::ReadOnly { path: path.to_owned() });
        }
        Ok(found) if found.is_file() => {}
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            if path.is_symlink() {
                return Err(OutputError::DanglingLink { path: path.to_owned() });
            }
        }
        Err(error) => return Err(io(error)),
        _ => return Err(OutputError::NotAFile { path: path.to_owned() }),
    }
    if path.file_name().is_none() {
        return Err(OutputError::NotAFile { path: path.to_owned() });
    }
    Unfinished::at(path).map(drop).map_err(io)
}

/// Writes `picture` to `path` in the format its extension names, replacing what is there.
///
/// `exposure` multiplies linear radiance before the tone curve of a PNG; without one, colours from 0 to 1 are written
/// as they are. An EXR or HDR ignores it.
///
/// # Errors
/// As [`check_output`], and when the disk is full or the encoder refuses; then `path` is as before.
pub fn write_picture(path: &Path, picture: &Picture, exposure: Option<f32>) -> Result<(), OutputError> {
    debug_assert!(picture.is_consistent());
    let format = PictureFormat::of(path)?;
    let (width, height) = (picture.width, picture.height);
    write_atomically(path, |file| match format {
        PictureFormat::Png => write_png(file, picture, exposure),
        PictureFormat::Exr => {
            let bytes: Vec<u8> = picture.pixels.iter().flatten().flat_map(|c| c.to_ne_bytes()).collect();
            // In memory first: the encoder tells nobody that a full disk was the reason.
            let mut encoded = Cursor::new(Vec::new());
            OpenExrEncoder::new(&mut encoded).write_image(
                &bytes,
                width,
                height,
                ExtendedColorType::Rgb32F,
            )?;
            Ok(file.write_all(encoded.get_ref())?)
        }
        PictureFormat::Hdr => {
            let pixels: Vec<Rgb<f32>> = picture.pixels.iter().map(|&rgb| Rgb(rgb)).collect();
            HdrEncoder::new(file).encode(&pixels, width as usize, height as usize)
        }
    })
}

/// Writes an EXR with the radiance as its red, green and blue, and named layers besides.
///
/// # Errors
/// As [`write_picture`].
pub fn write_layers(path: &Path, picture: &Picture, layers: &Layers) -> Result<(), OutputError> {
    debug_assert!(picture.is_consistent() && layers.depth.len() == picture.pixels.len());
    let three = |names: [&str; 3], values: &[[f32; 3]]| {
        let channel = |index: usize| FlatSamples::F32(values.iter().map(|value| value[index]).collect());
        [0, 1, 2].map(|index| AnyChannel::new(names[index], channel(index)))
    };
    let mut channels = Vec::new();
    channels.extend(three(["R", "G", "B"], &picture.pixels));
    channels.extend(three(["irradiance.R", "irradiance.G", "irradiance.B"], &layers.irradiance));
    channels.extend(three(["albedo.R", "albedo.G", "albedo.B"], &layers.albedo));
    channels.extend(three(["normal.X", "normal.Y", "normal.Z"], &layers.normal));
    channels.push(AnyChannel::new("depth.Z", FlatSamples::F32(layers.depth.clone())));
    channels.push(AnyChannel::new("element.id", FlatSamples::U32(layers.element.clone())));
    channels.push(AnyChannel::new("class.id", FlatSamples::U32(layers.class.clone())));
    let size = (picture.width as usize, picture.height as usize);
    let channels = AnyChannels::sort(channels.into());
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    write_atomically(path, |file| {
        // In memory first, as other pictures.
        let mut encoded = Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .to_buffered(&mut encoded)
            .map_err(|error| FillError::Encode(error.to_string()))?;
        file.write_all(encoded.get_ref()).map_err(FillError::Io)
    })
}

/// The same PNG as [`write_picture`] writes, in memory.
///
/// # Errors
/// What the encoder says when it refuses.
pub fn png_bytes(picture: &Picture, exposure: Option<f32>) -> Result<Vec<u8>, String> {
    debug_assert!(picture.is_consistent());
    let mut bytes = Vec::new();
    write_png(&mut bytes, picture, exposure).map_err(|error| error.to_string())?;
    Ok(bytes)
}

fn write_png(to: impl Write, picture: &Picture, exposure: Option<f32>) -> image::ImageResult<()> {
    let bytes = tone::srgb_bytes(picture, exposure);
    PngEncoder::new(to).write_image(&bytes, picture.width, picture.height, ExtendedColorType::Rgb8)
}

/// What [`write_atomically`] writes to: buffered, and with a position.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Lets `fill` write an [`Unfinished`] file, then moves it to `path` in one step.
///
/// # Errors
/// When the folder is missing or not writable, the disk is full or `fill` fails; then `path` is as before.
pub fn write_atomically<E: Into<FillError>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Sink) -> Result<(), E>,
) -> Result<(), OutputError> {
    let io = |source| OutputError::Io { path: path.to_owned(), source };
    let mut file = Unfinished::at(path).map_err(io)?;
    let mut writer = BufWriter::new(&mut file);
    fill(&mut writer).map_err(|error| match error.into() {
        FillError::Io(source) => io(source),
        FillError::Encode(message) => OutputError::Encode { path: path.to_owned(), message },
    })?;
    writer.flush().map_err(io)?;
    drop(writer);
    file.finish().map_err(io)
}

/// Why filling a file failed.
#[derive(Debug)]
pub enum FillError {
    /// The system refused.
    Io(io::Error),
    /// The content cannot be encoded.
    Encode(String),
}

impl From<io::Error> for FillError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<image::ImageError> for FillError {
    fn from(error: image::ImageError) -> Self {
        match error {
            image::ImageError::IoError(source) => Self::Io(source),
            other => Self::Encode(other.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Picture {
        let pixels = (0..12).map(|i| [i as f32 * 0.5, 0.25, 3.0]).collect();
        Picture { width: 4, height: 3, pixels }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .expect("test folder")
            .map(|entry| entry.expect("entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn exr_keeps_every_bit_and_the_top_row_first() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("out.exr");
        let picture = gradient();
        write_picture(&path, &picture, Some(100.0)).expect("written");
        let read = image::open(&path).expect("readable").into_rgb32f();
        assert_eq!((read.width(), read.height()), (4, 3));
        for (index, pixel) in picture.pixels.iter().enumerate() {
            assert_eq!(read.get_pixel(index as u32 % 4, index as u32 / 4).0, *pixel);
        }
    }

    #[test]
    fn png_holds_the_tone_mapped_bytes() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("OUT.PNG");
        write_picture(&path, &gradient(), Some(0.3)).expect("written");
        let read = image::open(&path).expect("readable").into_rgb8();
        assert_eq!(read.into_raw(), tone::srgb_bytes(&gradient(), Some(0.3)));
        assert_eq!(names(folder.path()), ["OUT.PNG"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_temporary() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("out.png");
        std::fs::write(&path, "old").expect("written");
        let result = write_atomically(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(matches!(result, Err(OutputError::Io { .. })), "{result:?}");
        assert_eq!(std::fs::read(&path).expect("readable"), b"old");
        assert_eq!(names(folder.path()), ["out.png"]);
    }

    #[test]
    fn checks_name_what_is_wrong_and_leave_nothing() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = |name: &str| folder.path().join(name);
        let long = at(&format!("{}.png", "a".repeat(300)));
        assert!(matches!(check_output(&long), Err(OutputError::Io { .. })));
        assert!(matches!(check_output(&at("a.jpg")), Err(OutputError::UnknownFormat { .. })));
        assert!(matches!(check_output(&at("png")), Err(OutputError::UnknownFormat { .. })));
        assert!(matches!(check_output(&at("no/a.png")), Err(OutputError::NoFolder { .. })));
        std::fs::create_dir(at("b.png")).expect("folder");
        assert!(matches!(check_output(&at("b.png")), Err(OutputError::NotAFile { .. })));
        std::fs::write(at("c.png"), "").expect("written");
        let mut rights = at("c.png").metadata().expect("metadata").permissions();
        rights.set_readonly(true);
        std::fs::set_permissions(at("c.png"), rights).expect("rights");
        assert!(matches!(check_output(&at("c.png")), Err(OutputError::ReadOnly { .. })));
        assert!(matches!(check_output(&at("c.png/d.png")), Err(OutputError::NoFolder { .. })));
        assert_eq!(check_output(&at("d.exr")).expect("free"), PictureFormat::Exr);
        assert_eq!(names(folder.path()), ["b.png", "c.png"]);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_replaced_keeps_its_link_and_its_mode() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.png"), "old").expect("written");
        for mode in [0o600, 0o666] {
            std::fs::set_permissions(at("a.png"), PermissionsExt::from_mode(mode)).expect("rights");
            write_picture(&at("a.png"), &gradient(), Some(1.0)).expect("written");
            assert_eq!(at("a.png").metadata().expect("metadata").permissions().mode() & 0o777, mode);
        }
        std::fs::create_dir(at("deep")).expect("folder");
        std::os::unix::fs::symlink("../a.png", at("deep/link.png")).expect("link");
        write_picture(&at("deep/link.png"), &gradient(), Some(2.0)).expect("written");
        assert!(at("deep/link.png").is_symlink());
        assert_eq!(
            image::open(at("a.png")).expect("a picture").into_rgb8().into_raw(),
            tone::srgb_bytes(&gradient(), Some(2.0))
        );
        std::os::unix::fs::symlink("nothing", at("dangling.png")).expect("link");
        assert!(matches!(check_output(&at("dangling.png")), Err(OutputError::DanglingLink { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_the_picture_as_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("temporary folder");
        write_picture(&folder.path().join("a.png"), &gradient(), Some(1.0)).expect("written");
        std::fs::write(folder.path().join("b"), "").expect("written");
        let mode = |name: &str| folder.path().join(name).metadata().expect("metadata").permissions().mode();
        assert_eq!(mode("a.png"), mode("b"));
    }
}
