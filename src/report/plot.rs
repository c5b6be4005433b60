//! Plots as SVG.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::convergence::Convergence;
use crate::image::write::{FillError, OutputError, write_atomically};

/// Size of a plot, pixels.
const SIZE: (u32, u32) = (720, 480);

/// How far the axes reach beyond the data.
const MARGIN: f64 = 1.5;

/// Values below this are drawn at it: the axes are logarithmic.
const LEAST: f64 = 1e-3;

/// Draws the error (per cent) over the time (seconds) of each solution, each named by its epsilon.
///
/// # Errors
/// When `path` cannot be written.
pub fn write_convergence(path: &Path, found: &Convergence) -> Result<(), OutputError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let drawn = draw(&area, found).and_then(|()| area.present().map_err(|error| error.to_string()));
        drawn.map_err(|message| OutputError::Encode { path: path.to_owned(), message })?;
    }
    write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(FillError::Io))
}

fn draw(area: &DrawingArea<SVGBackend<'_>, Shift>, found: &Convergence) -> Result<(), String> {
    let points: Vec<(f64, f64)> = found
        .rungs
        .iter()
        .map(|rung| (rung.seconds.max(LEAST), (100.0 * rung.total.rms).max(LEAST)))
        .collect();
    let range = |value: fn(&(f64, f64)) -> f64| {
        let low = points.iter().map(value).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
        (low / MARGIN..high * MARGIN).log_scale()
    };
    let failed = |error: DrawingAreaErrorKind<_>| error.to_string();
    area.fill(&WHITE).map_err(failed)?;
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{}: error against time", found.scene), ("sans-serif", 20))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(64)
        .build_cartesian_2d(range(|p| p.0), range(|p| p.1))
        .map_err(failed)?;
    chart
        .configure_mesh()
        .x_desc("time of the solution (s)")
        .y_desc("error, root mean square (% of mean irradiance)")
        .x_label_formatter(&|x| plain(*x))
        .y_label_formatter(&|y| plain(*y))
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", 14))
        .draw()
        .map_err(failed)?;
    chart.draw_series(LineSeries::new(points.iter().copied(), &BLUE)).map_err(failed)?;
    // Names stand above and below in turn, so that those of neighbours do not meet.
    let marks = points.iter().zip(&found.rungs).enumerate().map(|(index, (&point, rung))| {
        let label = format!("ε {:.1e}", rung.epsilon);
        let above = if index % 2 == 0 { 6 } else { -18 };
        EmptyElement::at(point)
            + Circle::new((0, 0), 4, BLUE.filled())
            + Text::new(label, (8, above), ("sans-serif", 13))
    });
    chart.draw_series(marks).map_err(failed)?;
    Ok(())
}

/// Without an exponent, and without zeros at its end.
fn plain(x: f64) -> String {
    let digits = (1.0 - x.abs().max(LEAST).log10().floor()).max(0.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
