//! The answers of a probe run, for CSV and JSON.

use super::lux::illuminance;
use super::points::ProbePoint;
use super::reference::Deviation;
use crate::gather::Irradiance;
use serde::Serialize;
use std::io::{self, Write};

/// One run of probes, as the JSON has it.
#[derive(Debug, Serialize)]
pub struct ProbeRun {
    /// The scene's name.
    pub scene: String,
    /// What cast the rays.
    pub tracer: String,
    /// Rays for the light of the emitters at a point, and for what is reflected.
    pub samples: u32,
    /// Wall-clock seconds: up to the solution, and for the points.
    pub seconds_solution: f64,
    /// See `seconds_solution`.
    pub seconds_points: f64,
    /// Largest resident memory, bytes.
    pub peak_rss_bytes: u64,
    /// Elements of the solution.
    pub elements: u64,
    /// Links of the solution.
    pub links: u64,
    /// Energy balance of the solution.
    pub balance_error: f64,
    /// Against the reference, when there is one.
    pub reference: Option<Comparison>,
    /// In the order of the points.
    pub points: Vec<Answer>,
}

/// How far the answers are from a reference.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Comparison {
    /// All light.
    pub total: Deviation,
    /// Straight from emitters.
    pub direct: Deviation,
}

/// The answer at one point.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Answer {
    /// Scene units.
    pub position: [f64; 3],
    /// Unit normal.
    pub normal: [f64; 3],
    /// Irradiance, W/m², linear RGB.
    pub total: [f64; 3],
    /// Of that, straight from emitters.
    pub direct: [f64; 3],
    /// Illuminance, lux.
    pub total_lux: f64,
    /// Of that, straight from emitters.
    pub direct_lux: f64,
}

impl Answer {
    /// Joins a point and its irradiance.
    pub fn new(point: &ProbePoint, irradiance: &Irradiance) -> Answer {
        Answer {
            position: point.position.to_array(),
            normal: point.normal.to_array(),
            total: irradiance.total.to_array(),
            direct: irradiance.direct.to_array(),
            total_lux: illuminance(irradiance.total),
            direct_lux: illuminance(irradiance.direct),
        }
    }
}

/// Writes one row a point, in order: irradiance in W/m² by channel, or with `lux` illuminance.
///
/// # Errors
/// When `file` refuses.
pub fn write_csv(answers: &[Answer], lux: bool, file: &mut dyn Write) -> io::Result<()> {
    let values =
        if lux { "total_lux,direct_lux" } else { "total_r,total_g,total_b,direct_r,direct_g,direct_b" };
    writeln!(file, "x,y,z,nx,ny,nz,{values}")?;
    for answer in answers {
        let light: Vec<f64> = if lux {
            vec![answer.total_lux, answer.direct_lux]
        } else {
            answer.total.into_iter().chain(answer.direct).collect()
        };
        let place = answer.position.into_iter().chain(answer.normal).map(coordinate);
        let cells: Vec<String> = place.chain(light.into_iter().map(|x| format!("{x:.7e}"))).collect();
        writeln!(file, "{}", cells.join(","))?;
    }
    Ok(())
}

/// With an exponent where that is shorter.
pub(super) fn coordinate(x: f64) -> String {
    if x == 0.0 || (1e-6..=1e16).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn long_numbers_are_written_with_an_exponent() {
        for (x, text) in [
            (0.0, "0"),
            (-2.5, "-2.5"),
            (1e-6, "0.000001"),
            (9.9e-7, "9.9e-7"),
            (-5e-324, "-5e-324"),
            (1e16, "10000000000000000"),
            (-1.5e16, "-1.5e16"),
            (f64::MAX, "1.7976931348623157e308"),
        ] {
            assert_eq!(coordinate(x), text);
            assert_eq!(coordinate(x).parse(), Ok(x));
        }
        let point = ProbePoint { position: DVec3::new(1e300, -1e-300, 0.5), normal: DVec3::Y };
        let light = Irradiance { total: DVec3::splat(1e20), direct: DVec3::splat(1e-20) };
        let mut file = Vec::new();
        write_csv(&[Answer::new(&point, &light)], false, &mut file).expect("memory takes it");
        let text = String::from_utf8(file).expect("text");
        assert!(text.contains("\n1e300,-1e-300,0.5,0,1,0,1.0000000e20,"), "{text}");
        assert!(text.lines().all(|line| line.len() < 150), "{text}");
    }

    #[test]
    fn rows_follow_the_header() {
        let point = ProbePoint { position: DVec3::new(1.0, 2.5, -3.0), normal: DVec3::Y };
        let irradiance = Irradiance { total: DVec3::new(3.0, 2.0, 1.0), direct: DVec3::new(0.5, 0.25, 0.0) };
        for (lux, columns) in [(false, 12), (true, 8)] {
            let mut file = Vec::new();
            write_csv(&[Answer::new(&point, &irradiance)], lux, &mut file).expect("memory takes it");
            let text = String::from_utf8(file).expect("text");
            let lines: Vec<&str> = text.lines().collect();
            assert_eq!(lines.len(), 2);
            assert!(lines.iter().all(|line| line.split(',').count() == columns), "{text}");
            assert!(lines[1].starts_with("1,2.5,-3,0,1,0,"), "{text}");
        }
    }
}
