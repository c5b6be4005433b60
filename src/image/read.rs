//! Pictures from files: linear radiance of an EXR.

use super::picture::Picture;
use image::codecs::openexr::OpenExrDecoder;
use image::{DynamicImage, ImageDecoder};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Largest side of a picture that is read, pixels.
const LARGEST: u32 = 16_384;

/// Largest file that is read, bytes: four floats for each pixel of the largest picture.
const MOST_BYTES: u64 = 16 * (LARGEST as u64) * (LARGEST as u64);

/// Why a picture cannot be had from a file.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file is missing, or the system refuses.
    #[error("{}: {message}", path.display())]
    Unreadable {
        /// The file as given.
        path: PathBuf,
        /// What is wrong and what to do.
        message: String,
    },
    /// It holds something else.
    #[error("{}: {message}", path.display())]
    Malformed {
        /// The file as given.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
}

/// Reads an EXR: red, green and blue of its first picture, up to 16 384 pixels a side; values that are no number or
/// infinite are refused.
///
/// # Errors
/// When the file is missing or no regular file, or holds no such picture.
pub fn read_exr(path: &Path) -> Result<Picture, PictureError> {
    let unreadable = |message: String| PictureError::Unreadable { path: path.to_owned(), message };
    let malformed = |message: String| PictureError::Malformed { path: path.to_owned(), message };
    let refused = |error| unreadable(format!("cannot be read ({error}); check the file and its rights"));
    let about = std::fs::metadata(path).map_err(refused)?;
    if !about.is_file() {
        return Err(unreadable("is not a regular file; give an .exr picture".to_owned()));
    }
    if about.len() > MOST_BYTES {
        return Err(malformed("is too large for a picture".to_owned()));
    }
    let bytes = std::fs::read(path).map_err(refused)?;
    let no_exr = |error| malformed(format!("is no EXR picture with red, green and blue ({error})"));
    let decoder = OpenExrDecoder::with_alpha_preference(Cursor::new(bytes), Some(false)).map_err(no_exr)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > LARGEST || height > LARGEST {
        return Err(malformed(format!("{width} × {height} pixels; at most {LARGEST} a side can be read")));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(no_exr)?.into_rgb32f();
    let pixels: Vec<[f32; 3]> = image.pixels().map(|pixel| pixel.0).collect();
    if !pixels.iter().flatten().all(|value| value.is_finite()) {
        return Err(malformed("holds values that are no number or infinite".to_owned()));
    }
    Ok(Picture { width, height, pixels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::write::write_picture;

    #[test]
    fn what_was_written_is_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let pixels = (0..6).map(|i| [i as f32, 0.25 * i as f32, 1e3 * i as f32]).collect();
        let picture = Picture { width: 3, height: 2, pixels };
        write_picture(&path, &picture, None).expect("written");
        assert_eq!(read_exr(&path).expect("a picture"), picture);
        let whole = std::fs::read(&path).expect("a file");
        for (name, bytes) in [("cut.exr", &whole[..whole.len() - 9]), ("text.exr", b"no picture")] {
            let other = folder.path().join(name);
            std::fs::write(&other, bytes).expect("written");
            assert!(matches!(read_exr(&other), Err(PictureError::Malformed { .. })), "{name}");
        }
        let missing = read_exr(&folder.path().join("b.exr"));
        assert!(matches!(missing, Err(PictureError::Unreadable { .. })));
        assert!(matches!(read_exr(folder.path()), Err(PictureError::Unreadable { .. })));
    }
}
