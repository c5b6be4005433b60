//! The data of a file: the binary chunk, files beside it, and data in the text itself.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf_json::Root;
use percent_encoding::percent_decode_str;

use super::super::error::{SceneError, quoted};
use super::super::lines::read_whole;
use super::container::MOST_BYTES;

/// Padding is often left out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// What is read, each file once.
pub(super) struct Buffers {
    blocks: Vec<Vec<u8>>,
    /// For each buffer its block and how much of it counts.
    of_buffer: Vec<(usize, usize)>,
    /// Files beside the scene.
    pub(super) files: Vec<PathBuf>,
}

impl Buffers {
    /// Reads all buffers.
    ///
    /// # Errors
    /// [`SceneError::Io`] for files that cannot be read, [`SceneError::Parse`] for data that is cut off.
    pub(super) fn read(path: &Path, root: &Root, binary: Option<Vec<u8>>) -> Result<Buffers, SceneError> {
        let mut buffers = Buffers { blocks: Vec::new(), of_buffer: Vec::new(), files: Vec::new() };
        let mut blocks_of_files: HashMap<PathBuf, usize> = HashMap::new();
        let mut binary = binary;
        let mut left = MOST_BYTES;
        for (number, buffer) in root.buffers.iter().enumerate() {
            let place = format!("buffer {number}");
            let fault = |what: String| SceneError::parse(path, None, format!("{place}: {what}"));
            let block = match &buffer.uri {
                Some(uri) if is_data(uri) => {
                    buffers.blocks.push(decoded(uri).map_err(fault)?);
                    buffers.blocks.len() - 1
                }
                Some(uri) => {
                    let file = file_of(path, uri).map_err(fault)?;
                    let same = file.canonicalize().unwrap_or_else(|_| file.clone());
                    match blocks_of_files.get(&same) {
                        Some(&block) => block,
                        None => {
                            let bytes = read_whole(&file, left)
                                .map_err(|error| beside(error, path, &format!("{place}: {}", quoted(uri))))?;
                            left -= bytes.len() as u64;
                            buffers.files.push(file);
                            buffers.blocks.push(bytes);
                            blocks_of_files.insert(same, buffers.blocks.len() - 1);
                            buffers.blocks.len() - 1
                        }
                    }
                }
                None => {
                    let first = (number == 0).then(|| binary.take()).flatten();
                    let missing = || fault("has no data in the file; export it again".to_owned());
                    buffers.blocks.push(first.ok_or_else(missing)?);
                    buffers.blocks.len() - 1
                }
            };
            let (claimed, there) = (buffer.byte_length.0, buffers.blocks[block].len());
            if claimed > there as u64 {
                return Err(fault(format!("has {there} of {claimed} bytes; export it again")));
            }
            buffers.of_buffer.push((block, claimed as usize));
        }
        Ok(buffers)
    }

    /// The bytes of a buffer of the file.
    pub(super) fn bytes(&self, buffer: usize) -> &[u8] {
        let (block, length) = self.of_buffer[buffer];
        &self.blocks[block][..length]
    }

    /// The bytes of a view.
    ///
    /// # Errors
    /// When it reaches beyond its buffer.
    pub(super) fn view(&self, root: &Root, number: usize) -> Result<&[u8], String> {
        let view = &root.buffer_views[number];
        let buffer = self.bytes(view.buffer.value());
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let end = start.checked_add(view.byte_length.0).filter(|&end| end <= buffer.len() as u64);
        match end {
            Some(end) => Ok(&buffer[start as usize..end as usize]),
            None => Err(format!("bufferView {number} reaches beyond its buffer of {} bytes", buffer.len())),
        }
    }

    /// Of all that was read.
    pub(super) fn total(&self) -> u64 {
        self.blocks.iter().map(|block| block.len() as u64).sum()
    }
}

pub(super) fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|start| start.eq_ignore_ascii_case("data:"))
}

/// What stands in the text after `base64,`.
pub(super) fn decoded(uri: &str) -> Result<Vec<u8>, String> {
    let data = uri.split_once(',').filter(|(head, _)| head.ends_with(";base64")).map(|(_, data)| data);
    let Some(data) = data else {
        let start: String = uri.chars().take(24).collect();
        return Err(format!("{} is not data in base64; export it again", quoted(&start)));
    };
    BASE64.decode(data).map_err(|error| format!("its base64 is damaged ({error}); export it again"))
}

/// The file that a relative URI names, beside the scene; folders above are allowed, as in OBJ files.
pub(super) fn file_of(scene: &Path, uri: &str) -> Result<PathBuf, String> {
    let advice = "give the file beside the scene";
    let has_scheme = uri.split(['/', '\\']).next().is_some_and(|first| first.contains(':'));
    let name = percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| format!("{} is no UTF-8; {advice}", quoted(uri)))?;
    let name = Path::new(name.as_ref());
    let is_relative =
        name.components().all(|part| !matches!(part, Component::Prefix(_) | Component::RootDir));
    if has_scheme || !is_relative || name.as_os_str().is_empty() {
        return Err(format!("{} is not a relative path; {advice}", quoted(uri)));
    }
    Ok(scene.parent().unwrap_or(Path::new("")).join(name))
}

/// An error about a file that the scene names.
fn beside(error: SceneError, path: &Path, place: &str) -> SceneError {
    match error {
        SceneError::Io { message, .. } => SceneError::io(path, None, format!("{place}: {message}")),
        SceneError::Parse { message, .. } => SceneError::parse(path, None, format!("{place}: {message}")),
        SceneError::Invalid { message, .. } => SceneError::invalid(path, None, format!("{place}: {message}")),
    }
}
