//! Writes OBJ as a stream: vertices, then the faces over them by relative index.

use std::io::{self, Write};

use glam::DVec3;

/// Counts triangles and remembers the first error, so that the code that models things stays free of
/// both.
pub(super) struct ObjWriter<W: Write> {
    out: W,
    triangles: u64,
    material: &'static str,
    error: Option<io::Error>,
    text: Vec<u8>,
}

impl<W: Write> ObjWriter<W> {
    pub(super) fn new(out: W) -> Self {
        Self { out, triangles: 0, material: "", error: None, text: Vec::new() }
    }

    /// Triangles after triangulation.
    pub(super) fn triangles(&self) -> u64 {
        self.triangles
    }

    /// The writer, unless something could not be written.
    pub(super) fn finish(self) -> io::Result<W> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(self.out),
        }
    }

    /// A line of text as it is.
    pub(super) fn line(&mut self, line: &str) {
        self.text.clear();
        self.text.extend_from_slice(line.as_bytes());
        self.text.push(b'\n');
        self.flush_text();
    }

    /// The material of all faces that follow.
    pub(super) fn material(&mut self, name: &'static str) {
        if self.material != name {
            self.material = name;
            self.line(&format!("usemtl {name}"));
        }
    }

    /// Adds vertices and faces over them; face corners are indices into `vertices`, counter-clockwise
    /// from the front.
    pub(super) fn faces<'a>(&mut self, vertices: &[DVec3], faces: impl IntoIterator<Item = &'a [u8]>) {
        self.text.clear();
        for vertex in vertices {
            self.text.push(b'v');
            for coordinate in vertex.to_array() {
                self.text.push(b' ');
                push_coordinate(&mut self.text, coordinate);
            }
            self.text.push(b'\n');
        }
        for face in faces {
            self.triangles += face.len() as u64 - 2;
            self.text.push(b'f');
            for &corner in face {
                // Writing to a vector does not fail.
                let _ = write!(self.text, " -{}", vertices.len() - usize::from(corner));
            }
            self.text.push(b'\n');
        }
        self.flush_text();
    }

    fn flush_text(&mut self) {
        if self.error.is_none()
            && let Err(error) = self.out.write_all(&self.text)
        {
            self.error = Some(error);
        }
    }
}

/// Micrometres are fine enough for an office and keep the file short.
fn push_coordinate(text: &mut Vec<u8>, value: f64) {
    let micro = (value * 1e6).round() as i64;
    if micro < 0 {
        text.push(b'-');
    }
    let (whole, mut part) = (micro.unsigned_abs() / 1_000_000, micro.unsigned_abs() % 1_000_000);
    let _ = write!(text, "{whole}");
    if part > 0 {
        let mut digits = 6;
        while part % 10 == 0 {
            part /= 10;
            digits -= 1;
        }
        let _ = write!(text, ".{part:0digits$}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short_and_right() {
        let cases =
            [(0.0, "0"), (-0.0, "0"), (1.5, "1.5"), (-0.000_001, "-0.000001"), (12.34, "12.34"), (3.0, "3")];
        for (value, expected) in cases {
            let mut text = Vec::new();
            push_coordinate(&mut text, value);
            assert_eq!(String::from_utf8(text).unwrap(), expected);
        }
    }
}
