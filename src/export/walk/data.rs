//! The triangles of a part as text within the page: what changes from one value to the next, byte plane by byte plane,
//! deflated (RFC 1951 in RFC 1950), in base64. `page.js` reads it.

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;

use super::super::lit::Part;

/// Largest value of light: the largest that 16 bits hold, some 18 stops above middle grey.
const MOST_LIGHT: f32 = 65_504.0;

/// Any bytes, deflated, in base64.
pub(super) fn packed(bytes: &[u8]) -> io::Result<String> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    Ok(STANDARD.encode(encoder.finish()?))
}

/// Of each vertex x, y and z in metres as floats of 32 bits; red, green and blue of its exposed radiance as floats of 16
/// bits, and its mark as another one; then the numbers of the corners of triangles, 16 bits. A value after the other of the
/// same kind, each as its difference from the one before (of its bits, modulo), the lowest bytes of all first.
pub(super) fn packed_part(part: &Part, exposure: f32) -> io::Result<String> {
    let mut bytes = Vec::with_capacity(20 * part.vertices.len() + 6 * part.triangles.len());
    for axis in 0..3 {
        planes::<4>(&mut bytes, part.vertices.iter().map(|vertex| vertex.position[axis].to_bits()));
    }
    for channel in 0..3 {
        let light = |exitance: f32| (exitance / std::f32::consts::PI * exposure).clamp(0.0, MOST_LIGHT);
        let of_vertices = part.vertices.iter().map(|vertex| light(vertex.exitance[channel]));
        planes::<2>(&mut bytes, of_vertices.map(|light| f16::from_f32(light).to_bits().into()));
    }
    planes::<2>(&mut bytes, part.vertices.iter().map(|vertex| f16::from(vertex.mark).to_bits().into()));
    planes::<2>(&mut bytes, part.triangles.iter().flatten().map(|&number| number.into()));
    packed(&bytes)
}

/// The `N` lower bytes of the differences of values.
fn planes<const N: usize>(to: &mut Vec<u8>, values: impl Iterator<Item = u32>) {
    let mut last = 0;
    let differences: Vec<[u8; 4]> =
        values.map(|value| value.wrapping_sub(std::mem::replace(&mut last, value)).to_le_bytes()).collect();
    for plane in 0..N {
        to.extend(differences.iter().map(|bytes| bytes[plane]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_hold_differences() {
        let mut bytes = Vec::new();
        planes::<2>(&mut bytes, [0x0102, 0x0305, 0x0304].into_iter());
        assert_eq!(bytes, [0x02, 0x03, 0xff, 0x01, 0x02, 0xff]);
    }
}
