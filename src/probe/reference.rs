//! Reference irradiance with its standard errors, and the error of a probe run against it.

use super::points::{ProbeError, quoted, read_text};
use crate::gather::Irradiance;
use glam::DVec3;
use serde::Serialize;
use std::path::Path;

/// Differences within this many standard errors of the reference are its noise.
const NOISE: f64 = 3.0;

/// Reference values at one point, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// Irradiance.
    pub irradiance: Irradiance,
    /// Standard errors of it.
    pub error: Irradiance,
}

/// How far one quantity is from its reference, relative to the mean of the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Deviation {
    /// Root mean square over points and channels of what exceeds the noise of the reference.
    pub rms: f64,
    /// Mean difference; negative when light is missing.
    pub bias: f64,
    /// Largest difference beyond the noise.
    pub worst: f64,
    /// The point it is at, from 0.
    pub worst_at: usize,
}

impl Deviation {
    /// Of what `part` picks from each value.
    pub fn of(
        found: &[Irradiance],
        reference: &[Reference],
        part: impl Fn(&Irradiance) -> DVec3,
    ) -> Deviation {
        let count = (3 * reference.len()).max(1) as f64;
        let mean = reference.iter().map(|r| part(&r.irradiance).element_sum()).sum::<f64>() / count;
        let mean = mean.max(f64::MIN_POSITIVE);
        let mut deviation = Deviation::default();
        let mut squares = 0.0;
        for (index, (f, r)) in found.iter().zip(reference).enumerate() {
            let difference = part(f) - part(&r.irradiance);
            let beyond = if difference.is_finite() {
                (difference.abs() - part(&r.error) * NOISE).max(DVec3::ZERO)
            } else {
                DVec3::MAX
            };
            deviation.bias += difference.element_sum() / (count * mean);
            squares += beyond.length_squared();
            if beyond.max_element() / mean > deviation.worst {
                deviation.worst = beyond.max_element() / mean;
                deviation.worst_at = index;
            }
        }
        deviation.rms = (squares / count).sqrt() / mean;
        deviation
    }
}

/// The columns that are read.
const COLUMNS: [&str; 12] = [
    "total_r",
    "total_g",
    "total_b",
    "direct_r",
    "direct_g",
    "direct_b",
    "se_total_r",
    "se_total_g",
    "se_total_b",
    "se_direct_r",
    "se_direct_g",
    "se_direct_b",
];

/// Reads reference values: a CSV with a header that names at least `total_*`, `direct_*`, `se_total_*`
/// and `se_direct_*` for `r`, `g` and `b`, in any order, one row a point.
///
/// # Errors
/// When the file cannot be read, a column is missing or a value is no finite number from 0.
pub fn read_reference(path: &Path) -> Result<Vec<Reference>, ProbeError> {
    let text = read_text(path)?;
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let malformed = |line: usize, message: String| ProbeError::Malformed {
        path: path.to_owned(),
        line: line + 1,
        message,
    };
    let header: Vec<&str> = lines.next().map_or("", |(_, line)| line).split(',').map(str::trim).collect();
    let mut places = [0; COLUMNS.len()];
    for (place, name) in places.iter_mut().zip(COLUMNS) {
        *place = header.iter().position(|column| *column == name).ok_or_else(|| {
            malformed(0, format!("the header has no column '{name}'; it needs {}", COLUMNS.join(",")))
        })?;
    }
    let mut values = Vec::new();
    for (index, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let mut row = [0.0; COLUMNS.len()];
        for ((value, place), name) in row.iter_mut().zip(places).zip(COLUMNS) {
            let cell = cells.get(place).copied().unwrap_or_default();
            let is_right = |v: &f64| v.is_finite() && *v >= 0.0;
            *value = cell.parse().ok().filter(is_right).ok_or_else(|| {
                malformed(index, format!("{} in column '{name}' is no finite number from 0", quoted(cell)))
            })?;
        }
        let [a, b, c, d] = std::array::from_fn(|i| DVec3::new(row[3 * i], row[3 * i + 1], row[3 * i + 2]));
        values.push(Reference {
            irradiance: Irradiance { total: a, direct: b },
            error: Irradiance { total: c, direct: d },
        });
    }
    let is_dark = |value: &Reference| value.irradiance.total == DVec3::ZERO;
    if values.iter().all(is_dark) {
        return Err(malformed(0, "no point gets any light; errors are relative to the mean".to_owned()));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(total: f64, direct: f64) -> Irradiance {
        Irradiance { total: DVec3::splat(total), direct: DVec3::splat(direct) }
    }

    #[test]
    fn differences_within_the_noise_do_not_count() {
        let reference = [1.0, 3.0].map(|e| Reference { irradiance: gray(e, 0.0), error: gray(0.1, 0.0) });
        let near = Deviation::of(&[gray(1.29, 0.0), gray(2.71, 0.0)], &reference, |i| i.total);
        assert!(near.rms == 0.0 && near.bias.abs() < 1e-12, "{near:?}");
        // Half a unit beyond three standard errors at one of two points, whose mean is 2.
        let far = Deviation::of(&[gray(1.0, 0.0), gray(3.8, 0.0)], &reference, |i| i.total);
        assert!((far.rms - 0.5 / 2f64.sqrt() / 2.0).abs() < 1e-12 && far.worst_at == 1, "{far:?}");
        assert!((far.bias - 0.2).abs() < 1e-12, "{far:?}");
    }
}
