//! Reference irradiance with its standard errors, and the error of a probe run against it.

use super::points::{ProbeError, ProbePoint, quoted, read_text};
use super::table::coordinate;
use crate::gather::Irradiance;
use glam::DVec3;
use serde::Serialize;
use std::path::Path;

/// Differences within this many standard errors of the reference are its noise.
const NOISE: f64 = 3.0;

/// Largest value of a reference, W/m²: the squares of all differences stay in the range of numbers.
const MOST: f64 = 1e30;

/// Errors relative to a mean below this say nothing, W/m².
const LEAST_MEAN: f64 = 1e-30;

/// Reference values at one point, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// Irradiance.
    pub irradiance: Irradiance,
    /// Standard errors of it.
    pub error: Irradiance,
    /// The point it is for, scene coordinates, when the table has columns `x`, `y` and `z`.
    pub position: Option<DVec3>,
    /// Its normal, when the table has columns `nx`, `ny` and `nz`.
    pub normal: Option<DVec3>,
    /// Line of the table, from 1.
    pub line: usize,
}

/// How far one quantity is from its reference, relative to the mean of the reference. All figures are NaN, which
/// JSON has as `null`, where that mean is below 10⁻³⁰ W/m².
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
    /// Whether there is light to which errors can be relative.
    pub fn is_defined(&self) -> bool {
        !self.rms.is_nan()
    }

    /// Of what `part` picks from each value.
    pub fn of(
        found: &[Irradiance],
        reference: &[Reference],
        part: impl Fn(&Irradiance) -> DVec3,
    ) -> Deviation {
        let count = (3 * reference.len()).max(1) as f64;
        let mean = mean_of(reference, &part);
        if mean < LEAST_MEAN {
            return Deviation { rms: f64::NAN, bias: f64::NAN, worst: f64::NAN, worst_at: 0 };
        }
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

/// Mean over points and channels.
fn mean_of(reference: &[Reference], part: impl Fn(&Irradiance) -> DVec3) -> f64 {
    let count = (3 * reference.len()).max(1) as f64;
    reference.iter().map(|r| part(&r.irradiance).element_sum()).sum::<f64>() / count
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

/// Columns of positions and of normals, which need not be there.
const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// By how much a coordinate may differ, relative to it: tables are rounded.
const ROUNDING: f64 = 1e-5;

/// … and relative to the space that all points take up.
const ROUNDING_OF_EXTENT: f64 = 1e-6;

/// Reads reference values: a CSV with a header that names at least `total_*`, `direct_*`, `se_total_*`
/// and `se_direct_*` for `r`, `g` and `b`, each once, in any order, one row a point.
///
/// # Errors
/// When the file cannot be read, a column is missing or there twice, a row is longer than the header, a value is
/// no number from 0 to 10³⁰, a coordinate is no finite number or one of three is missing, or the mean of all light is below 10⁻³⁰.
pub fn read_reference(path: &Path) -> Result<Vec<Reference>, ProbeError> {
    let text = read_text(path)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let malformed = |line: usize, message: String| ProbeError::Malformed {
        path: path.to_owned(),
        line: line + 1,
        message,
    };
    let (top, header) = lines.next().unwrap_or_default();
    let header: Vec<&str> = cells_of(header).collect();
    let places = places_in(&header).map_err(|message| malformed(top, message))?;
    let values: Vec<Reference> = lines
        .map(|(index, line)| {
            let value = value_from_row(line, header.len(), &places);
            let value = value.map_err(|message| malformed(index, message))?;
            Ok(Reference { line: index + 1, ..value })
        })
        .collect::<Result<_, _>>()?;
    if mean_of(&values, |light| light.total) < LEAST_MEAN {
        return Err(malformed(top, "no point gets any light; errors are relative to the mean".to_owned()));
    }
    Ok(values)
}

/// Checks that each value is for its point, one a point.
///
/// # Errors
/// When there are more or fewer values than points, or a value names coordinates that are not those of its point;
/// `path` is the file of the values.
pub fn check_points(path: &Path, reference: &[Reference], points: &[ProbePoint]) -> Result<(), ProbeError> {
    if reference.len() != points.len() {
        let message = format!(
            "{} rows for {} points; give the reference of these points",
            reference.len(),
            points.len()
        );
        return Err(ProbeError::Unfit { path: path.to_owned(), message });
    }
    let wrong = (1..).zip(reference.iter().zip(points)).find(|(_, (value, point))| {
        let is_elsewhere = |position: DVec3| !is_near(position, point.position, extent_of(points));
        let faces_elsewhere = |normal: DVec3| !is_near(normal.normalize_or_zero(), point.normal, 1.0);
        value.position.is_some_and(is_elsewhere) || value.normal.is_some_and(faces_elsewhere)
    });
    let Some((number, (value, point))) = wrong else { return Ok(()) };
    let listed = |vectors: [Option<DVec3>; 2]| {
        let numbers = vectors.into_iter().flatten().flat_map(|v| v.to_array());
        numbers.map(|x| format!(" {}", coordinate(x))).collect::<String>()
    };
    let message = format!(
        "is for{}, but point {number} is{}; give the reference of these points",
        listed([value.position, value.normal]),
        listed([value.position.map(|_| point.position), value.normal.map(|_| point.normal)])
    );
    Err(ProbeError::Malformed { path: path.to_owned(), line: value.line, message })
}

/// The largest side of the box around all points.
fn extent_of(points: &[ProbePoint]) -> f64 {
    let positions = || points.iter().map(|point| point.position);
    let (low, high) = (positions().reduce(DVec3::min), positions().reduce(DVec3::max));
    (high.unwrap_or_default() - low.unwrap_or_default()).max_element()
}

/// Whether each coordinate is the same but for rounding.
fn is_near(a: DVec3, b: DVec3, extent: f64) -> bool {
    let slack = ROUNDING * a.abs().max(b.abs()) + ROUNDING_OF_EXTENT * extent;
    (a - b).abs().cmple(slack).all()
}

fn cells_of(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(str::trim)
}

/// Where the columns stand that are read.
struct Columns {
    light: [usize; COLUMNS.len()],
    position: Option<[usize; 3]>,
    normal: Option<[usize; 3]>,
}

fn places_in(header: &[&str]) -> Result<Columns, String> {
    let is_again = |&index: &usize| !header[index].is_empty() && header[..index].contains(&header[index]);
    if let Some(index) = (0..header.len()).find(is_again) {
        return Err(format!("the header has the column {} twice; keep one of them", quoted(header[index])));
    }
    let place_of = |name: &str| header.iter().position(|column| *column == name);
    let mut light = [0; COLUMNS.len()];
    for (place, name) in light.iter_mut().zip(COLUMNS) {
        *place = place_of(name)
            .ok_or_else(|| format!("the header has no column '{name}'; it needs {}", COLUMNS.join(",")))?;
    }
    let triple = |names: [&str; 3]| match names.map(place_of) {
        [Some(x), Some(y), Some(z)] => Ok(Some([x, y, z])),
        [None, None, None] => Ok(None),
        _ => Err(format!("the header has only some of the columns {}; give all or none", names.join(","))),
    };
    Ok(Columns { light, position: triple(POSITION)?, normal: triple(NORMAL)? })
}

/// The value of one row under a header of `width` columns.
fn value_from_row(line: &str, width: usize, places: &Columns) -> Result<Reference, String> {
    let cells: Vec<&str> = cells_of(line).collect();
    if cells.len() > width {
        return Err(format!(
            "{} cells under a header of {width}; give each row one for a column",
            cells.len()
        ));
    }
    let mut row = [0.0; COLUMNS.len()];
    for ((value, &place), name) in row.iter_mut().zip(&places.light).zip(COLUMNS) {
        let cell = cells.get(place).copied().unwrap_or_default();
        let is_right = |v: &f64| (0.0..=MOST).contains(v);
        *value =
            cell.parse().ok().filter(is_right).ok_or_else(|| {
                format!("{} in column '{name}' is no number from 0 to {MOST:e}", quoted(cell))
            })?;
    }
    let [total, direct, se_total, se_direct] =
        std::array::from_fn(|i| DVec3::new(row[3 * i], row[3 * i + 1], row[3 * i + 2]));
    let vector = |places: Option<[usize; 3]>, names| {
        places.map(|places| vector_from(&cells, places, names)).transpose()
    };
    Ok(Reference {
        irradiance: Irradiance { total, direct },
        error: Irradiance { total: se_total, direct: se_direct },
        position: vector(places.position, POSITION)?,
        normal: vector(places.normal, NORMAL)?,
        line: 0,
    })
}

fn vector_from(cells: &[&str], places: [usize; 3], names: [&str; 3]) -> Result<DVec3, String> {
    let mut vector = [0.0; 3];
    for ((value, place), name) in vector.iter_mut().zip(places).zip(names) {
        let cell = cells.get(place).copied().unwrap_or_default();
        *value = cell
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| format!("{} in column '{name}' is no finite number", quoted(cell)))?;
    }
    Ok(DVec3::from(vector))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(total: f64, direct: f64) -> Irradiance {
        Irradiance { total: DVec3::splat(total), direct: DVec3::splat(direct) }
    }

    #[test]
    fn differences_within_the_noise_do_not_count() {
        let reference = [1.0, 3.0].map(|e| Reference {
            irradiance: gray(e, 0.0),
            error: gray(0.1, 0.0),
            ..Reference::default()
        });
        let near = Deviation::of(&[gray(1.29, 0.0), gray(2.71, 0.0)], &reference, |i| i.total);
        assert!(near.rms == 0.0 && near.bias.abs() < 1e-12, "{near:?}");
        // Half a unit beyond three standard errors at one of two points, whose mean is 2.
        let far = Deviation::of(&[gray(1.0, 0.0), gray(3.8, 0.0)], &reference, |i| i.total);
        assert!((far.rms - 0.5 / 2f64.sqrt() / 2.0).abs() < 1e-12 && far.worst_at == 1, "{far:?}");
        assert!((far.bias - 0.2).abs() < 1e-12, "{far:?}");
    }

    #[test]
    fn errors_relative_to_no_light_are_undefined() {
        let (irradiance, error) = (gray(1.0, 0.0), gray(0.1, 0.0));
        let reference = [Reference { irradiance, error, ..Reference::default() }];
        let found = [gray(1.0, 0.5)];
        let [total, direct] =
            [Deviation::of(&found, &reference, |i| i.total), Deviation::of(&found, &reference, |i| i.direct)];
        assert!(total.is_defined() && !direct.is_defined(), "{total:?} {direct:?}");
        let json = serde_json::to_value(direct).expect("JSON");
        assert!(["rms", "bias", "worst"].iter().all(|figure| json[figure].is_null()), "{json}");
    }

    /// What the reader makes of a file with this content.
    fn read(content: &str) -> Result<Vec<Reference>, String> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("reference.csv");
        std::fs::write(&path, content).expect("written");
        read_reference(&path).map_err(|error| error.to_string())
    }

    const ROW: &str = "4,5,6,1,2,3,0.4,0.5,0.6,0.1,0.2,0.3";

    #[test]
    fn columns_are_found_by_name_after_a_byte_order_mark_and_empty_lines() {
        let value = Reference {
            irradiance: Irradiance { total: DVec3::new(4.0, 5.0, 6.0), direct: DVec3::new(1.0, 2.0, 3.0) },
            error: Irradiance { total: DVec3::new(0.4, 0.5, 0.6), direct: DVec3::new(0.1, 0.2, 0.3) },
            ..Reference::default()
        };
        let at = |line: usize| Reference { line, ..value };
        let header = COLUMNS.join(",");
        assert_eq!(read(&format!("\u{feff}{header}\r\n\r\n{ROW}\r\n")), Ok(vec![at(3)]));
        assert_eq!(read(&format!("{header}\r{ROW}\r{ROW}")), Ok(vec![at(2), at(3)]));
        assert_eq!(read(&format!("\n\nq,{header},,\n7,{ROW},\n7,{ROW}\n")), Ok(vec![at(4), at(5)]));
        let some = read(&format!("x,y,{header}\n7,7,{ROW}\n")).expect_err("no z");
        assert!(some.contains("reference.csv:1: the header has only some of the columns x,y,z"), "{some}");
        let placed = Reference { position: Some(DVec3::new(7.0, -8.0, 9.0)), ..at(2) };
        assert_eq!(read(&format!("z,y,x,{header}\n9,-8,7,{ROW}\n")), Ok(vec![placed]));
        let error = read(&format!("z,y,x,{header}\n9,inf,7,{ROW}\n")).expect_err("no place");
        assert!(error.contains("reference.csv:2: 'inf' in column 'y' is no finite number"), "{error}");
    }

    #[test]
    fn values_of_other_points_are_refused_with_their_line() {
        let points = [[1.0, 2.0, 3.0], [4.0, 5.0, 600.0], [0.0, 1e6, 0.0]]
            .map(|p| ProbePoint { position: DVec3::from(p), normal: DVec3::Y });
        let right = points.map(|p| Reference {
            position: Some(p.position * (1.0 + 5e-6) + 1e-17),
            normal: Some(p.normal * 3.0),
            line: 2,
            ..Reference::default()
        });
        let check = |values: &[Reference], points: &[ProbePoint]| {
            let path = Path::new("reference.csv");
            check_points(path, values, points).map_err(|error| error.to_string())
        };
        assert_eq!(check(&right, &points), Ok(()));
        assert_eq!(check(&[Reference::default()], &points[..1]), Ok(()));
        let moved = |position: DVec3| Reference { position: Some(position), line: 4, ..right[1] };
        let near = [right[0], moved(DVec3::new(4.0, 5.01, 600.0))];
        assert_eq!(
            check(&near, &points[..2]),
            Err("reference.csv:4: is for 4 5.01 600 0 3 0, but point 2 is 4 5 600 0 1 0; \
                 give the reference of these points"
                .to_owned())
        );
        let turned = Reference { normal: Some(DVec3::new(0.0, 1.0, 0.01)), ..right[0] };
        assert!(check(&[turned], &points[..1]).expect_err("turned").contains("0 1 0.01, but point 1"));
        let fewer = check(&right[..1], &points[..2]).expect_err("one of two");
        assert_eq!(fewer, "reference.csv: 1 rows for 2 points; give the reference of these points");
        let huge = check(&[moved(DVec3::splat(1e308))], &points[..1]).expect_err("far away");
        assert!(huge.len() < 200, "{huge}");
    }

    #[test]
    fn what_is_no_irradiance_is_refused_with_its_line() {
        let header = COLUMNS.join(",");
        for cell in ["1e308", "1.1e30", "1e999", "inf", "-inf", "nan", "-1", "-1e-9", "", "x"] {
            for column in ["4", "1", "0.4", "0.3"] {
                let row: Vec<&str> = ROW.split(',').map(|c| if c == column { cell } else { c }).collect();
                let error = read(&format!("{header}\n{ROW}\n\n{}\n", row.join(","))).expect_err(cell);
                let is_named = error.contains("reference.csv:4: ") && error.contains(&format!("'{cell}'"));
                assert!(is_named && error.contains("no number from 0 to 1e30"), "{error}");
            }
        }
        let largest = ROW.replace(['4', '5', '6'], "1e30");
        assert!(read(&format!("{header}\n{}\n", largest.replace("0.1e30", "1e30"))).is_ok());
    }

    #[test]
    fn a_reference_of_next_to_no_light_is_refused() {
        let header = COLUMNS.join(",");
        for light in ["0", "-0", "1e-320", "1e-31"] {
            let row = [light; 12].join(",");
            let error = read(&format!("{header}\n{row}\n{row}\n")).expect_err(light);
            assert!(error.contains("no point gets any light"), "{error}");
        }
        assert!(read(&format!("{header}\n{}\n", ["1e-29"; 12].join(","))).is_ok());
        assert!(read(&header).expect_err("no rows").contains("no point gets any light"));
    }

    #[test]
    fn a_table_that_is_not_one_is_refused() {
        let header = COLUMNS.join(",");
        for (content, part) in [
            (String::new(), "reference.csv:1: the header has no column 'total_r'"),
            (format!("{}\n{ROW}", header.replace("se_total_g", "x")), "no column 'se_total_g'"),
            (
                format!("{header},total_g\n{ROW},1"),
                "reference.csv:1: the header has the column 'total_g' twice",
            ),
            (format!("x,x,{header}\n1,1,{ROW}"), "'x' twice"),
            (format!("{header}\n{ROW}\n{ROW},1"), "reference.csv:3: 13 cells under a header of 12"),
            (format!("{header}\n4,5,6"), "reference.csv:2: '' in column 'direct_r'"),
        ] {
            let error = read(&content).expect_err(part);
            assert!(error.contains(part), "{error}");
        }
    }
}
