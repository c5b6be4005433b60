//! Plots as SVG.

use std::cell::Cell;
use std::path::Path;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::convergence::Convergence;
use super::labels::{self, Labelled};
use super::look::Look;
use super::profile::{Profile, ProfiledRun};
use super::text::{counted, printable};
use crate::image::write::{FillError, OutputError, write_atomically};

/// Size of a plot, pixels.
const SIZE: (u32, u32) = (720, 480);

/// Width of the legend beside it, and height of one of its lines, pixels.
const LEGEND: u32 = 200;
const LINE: i32 = 24;

/// Dashes and the gaps between them, pixels.
const DASH: u32 = 5;

/// Size of letters of labels and of legends, as the library counts it.
const LABEL: u32 = 15;
const NAME: u32 = 16;

/// How far the axes reach beyond the data.
const MARGIN: f64 = 1.5;

/// Marks on an axis, at most; enough for those between the powers of ten where there are two of these.
const MOST_MARKS: usize = 20;

/// Values below this are drawn at it: the axes are logarithmic.
const LEAST: f64 = 1e-3;

/// Values above this are drawn at it.
const MOST: f64 = 1e9;

/// Some curves over two logarithmic axes.
pub(super) struct Plot<'a> {
    /// Above it; none where it is empty, and then no legend either: a page has its own.
    title: String,
    x: &'a str,
    y: &'a str,
    curves: Vec<Curve>,
}

/// Points in the order in which a line joins them, each with its label. Those that are not finite are left out.
struct Curve {
    /// In the legend, if there are several.
    name: String,
    look: Look,
    points: Vec<((f64, f64), String)>,
}

impl Curve {
    /// What is drawn, between [`LEAST`] and [`MOST`].
    fn drawn(&self) -> impl Iterator<Item = ((f64, f64), &str)> {
        let finite = self.points.iter().filter(|((x, y), _)| x.is_finite() && y.is_finite());
        finite.map(|((x, y), label)| ((x.clamp(LEAST, MOST), y.clamp(LEAST, MOST)), label.as_str()))
    }
}

/// Draws the error (per cent) over the time (seconds) of each solution, each named by its epsilon.
///
/// # Errors
/// When `path` cannot be written.
pub fn write_convergence(path: &Path, found: &Convergence) -> Result<(), OutputError> {
    let points = found
        .rungs
        .iter()
        .map(|rung| ((rung.seconds, 100.0 * rung.total.rms), format!("ε {:.1e}", rung.epsilon)));
    let plot = Plot {
        title: format!("{}: error against time", found.scene),
        x: "time of the solution (s)",
        y: "error, root mean square (% of mean irradiance)",
        curves: vec![Curve { name: String::new(), look: Look::filled(0), points: points.collect() }],
    };
    plot.write(path)
}

/// Draws the visibility error of links (per cent) over the seconds in visibility, a curve for each strategy and
/// tracer, each point named by its rays.
///
/// # Errors
/// When `path` cannot be written.
pub fn write_profile(path: &Path, found: &Profile) -> Result<(), OutputError> {
    profile(found, format!("{}: visibility", found.scene)).write(path)
}

/// The plot of [`write_profile`] under a title.
pub(super) fn profile(found: &Profile, title: String) -> Plot<'static> {
    let point = |run: &ProfiledRun| {
        let at = (run.visibility_seconds.median, 100.0 * run.visibility_error.mean);
        let rays = if title.is_empty() { run.rays.to_string() } else { counted(run.rays.into(), "ray") };
        (at, rays)
    };
    let curve = |(name, look): (String, Look)| {
        // One that lost all light has no error.
        let runs = found.runs.iter().filter(|run| run.kind() == name && run.has_light());
        let points = runs.map(point).collect();
        Curve { name, look, points }
    };
    let curves = found.kinds().into_iter().map(curve).collect();
    let y = "visibility error, mean over links (%)";
    Plot { title, x: "time in visibility, all threads (s)", y, curves }
}

impl Plot<'_> {
    fn write(&self, path: &Path) -> Result<(), OutputError> {
        let size = (SIZE.0 + if self.has_legend() { LEGEND } else { 0 }, SIZE.1);
        let text =
            self.svg(size).map_err(|message| OutputError::Encode { path: path.to_owned(), message })?;
        write_atomically(path, |file| file.write_all(printable(&text).as_bytes()).map_err(FillError::Io))
    }

    fn has_legend(&self) -> bool {
        !self.title.is_empty() && self.curves.len() > 1
    }

    /// As SVG of this size, pixels.
    ///
    /// # Errors
    /// What the library for drawing says.
    pub(super) fn svg(&self, size: (u32, u32)) -> Result<String, String> {
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        self.draw(&area)?;
        area.present().map_err(|error| error.to_string())?;
        drop(area);
        Ok(text)
    }

    fn range(&self, value: fn((f64, f64)) -> f64) -> std::ops::Range<f64> {
        let values = || self.curves.iter().flat_map(Curve::drawn).map(|point| value(point.0));
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(LEAST, f64::max));
        // Marks begin at a power of ten; what lies below the first would have none. A little less, or rounding
        // may leave it out.
        let low = 0.999 * 10f64.powf((low.min(high) / MARGIN).log10().floor());
        low..high * MARGIN
    }

    fn draw(&self, whole: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), String> {
        let failed = |error: DrawingAreaErrorKind<_>| error.to_string();
        whole.fill(&WHITE).map_err(failed)?;
        let mut area = whole.clone();
        if self.has_legend() {
            let legend;
            (area, legend) = whole.split_horizontally(whole.dim_in_pixel().0 - LEGEND);
            self.draw_legend(&legend).map_err(failed)?;
        }
        let mut builder = ChartBuilder::on(&area);
        if !self.title.is_empty() {
            builder.caption(&self.title, ("sans-serif", 20));
        }
        let mut chart = builder
            .margin(16)
            .x_label_area_size(48)
            .y_label_area_size(64)
            .build_cartesian_2d(self.range(|p| p.0).log_scale(), self.range(|p| p.1).log_scale())
            .map_err(failed)?;
        let lengths = chart.plotting_area().dim_in_pixel();
        let marks = [
            Marks::along(self.range(|p| p.0), lengths.0.into(), 8.0, 0.0),
            Marks::along(self.range(|p| p.1), lengths.1.into(), 0.0, 16.0),
        ];
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .x_labels(MOST_MARKS)
            .y_labels(MOST_MARKS)
            .x_label_formatter(&|x| marks[0].next(*x))
            .y_label_formatter(&|y| marks[1].next(*y))
            .light_line_style(TRANSPARENT)
            .label_style(("sans-serif", 16))
            .draw()
            .map_err(failed)?;
        // From here on in pixels, which start at the left top corner.
        let in_pixels = |curve: &Curve| -> Vec<(i32, i32)> {
            curve.drawn().map(|(point, _)| chart.backend_coord(&point)).collect()
        };
        let (across, down) = chart.plotting_area().get_pixel_range();
        let curves: Vec<Vec<(i32, i32)>> = self.curves.iter().map(in_pixels).collect();
        for (curve, points) in self.curves.iter().zip(&curves) {
            draw_line(&area, curve.look, points).map_err(failed)?;
        }
        for (curve, points) in self.curves.iter().zip(&curves) {
            for &point in points {
                draw_mark(&area, curve.look, point).map_err(failed)?;
            }
        }
        let labels = self.curves.iter().flat_map(Curve::drawn).map(|(_, label)| label);
        let labelled: Vec<Labelled<'_>> =
            curves.iter().flatten().zip(labels).map(|(&at, label)| Labelled { at, label }).collect();
        let lines: Vec<_> =
            curves.iter().flat_map(|points| points.windows(2).map(|ends| [ends[0], ends[1]])).collect();
        let frame = [across.start, down.start, across.end, down.end];
        for (place, point) in labels::places(&labelled, &lines, frame).into_iter().zip(&labelled) {
            if let Some(place) = place {
                area.draw(&Text::new(point.label, place, ("sans-serif", LABEL))).map_err(failed)?;
            }
        }
        Ok(())
    }

    /// A line for each curve, as it is drawn.
    fn draw_legend(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Failure> {
        for (curve, top) in self.curves.iter().zip((40..).step_by(LINE as usize)) {
            draw_line(area, curve.look, &[(0, top), (36, top)])?;
            draw_mark(area, curve.look, (18, top))?;
            area.draw(&Text::new(curve.name.as_str(), (44, top - 8), ("sans-serif", NAME)))?;
        }
        Ok(())
    }
}

type Failure = DrawingAreaErrorKind<std::io::Error>;

/// A line in pixels.
fn draw_line(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    look: Look,
    points: &[(i32, i32)],
) -> Result<(), Failure> {
    let style = look.colour().stroke_width(2);
    match look.is_hollow {
        true => area.draw(&DashedPathElement::new(points.iter().copied(), DASH, DASH, style)),
        false => area.draw(&PathElement::new(points.to_vec(), style)),
    }
}

/// A point of a line, in pixels.
fn draw_mark(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    look: Look,
    point: (i32, i32),
) -> Result<(), Failure> {
    const RADIUS: i32 = 4;
    if look.is_hollow {
        area.draw(&Circle::new(point, RADIUS, WHITE.filled()))?;
        return area.draw(&Circle::new(point, RADIUS, look.colour().stroke_width(2)));
    }
    area.draw(&Circle::new(point, RADIUS, look.colour().filled()))
}

/// Labels of the marks of an axis, in the order in which they stand there; the library asks for powers of ten twice.
struct Marks {
    range: std::ops::Range<f64>,
    /// Length of the axis, and what a letter and a whole label take up along it, pixels.
    length: f64,
    letter: f64,
    least: f64,
    /// The last mark, and where its label ends.
    last: Cell<(f64, f64)>,
}

impl Marks {
    fn along(range: std::ops::Range<f64>, length: f64, letter: f64, least: f64) -> Marks {
        Marks { range, length, letter, least, last: Cell::new((f64::INFINITY, 0.0)) }
    }

    /// Nothing where there is no room for it.
    fn next(&self, x: f64) -> String {
        let (before, end) = self.last.get();
        let end = if x < before { f64::NEG_INFINITY } else { end };
        let text = mark(x);
        let at = self.length * (x / self.range.start).ln() / (self.range.end / self.range.start).ln();
        let half = 0.5 * (self.letter * text.chars().count() as f64).max(self.least);
        let has_room = at - half >= end && (x / before - 1.0).abs() > 1e-6;
        let shown = if has_room { text } else { String::new() };
        self.last.set((x, if shown.is_empty() { end } else { at + half }));
        shown
    }
}

/// The label of a mark on an axis: of 1, 2 and 5 and their tenfolds; more would not fit.
fn mark(x: f64) -> String {
    let leading = x / 10f64.powf(x.abs().max(LEAST).log10().floor());
    let is_round = [1.0, 2.0, 5.0, 10.0].iter().any(|round| (leading / round - 1.0).abs() < 1e-6);
    if is_round { plain(x) } else { String::new() }
}

/// Without an exponent, and without zeros at its end.
fn plain(x: f64) -> String {
    let digits = (1.0 - x.abs().max(LEAST).log10().floor()).max(0.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn svg(points: &[(f64, f64)]) -> String {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.svg");
        let points = points.iter().enumerate().map(|(i, &point)| (point, format!("point {i}"))).collect();
        let curves = vec![Curve { name: "one".to_owned(), look: Look::filled(0), points }];
        Plot { title: "title".to_owned(), x: "x", y: "y", curves }.write(&path).expect("written");
        std::fs::read_to_string(&path).expect("readable")
    }

    /// Axes to infinity have marks without end.
    #[test]
    fn points_that_are_not_finite_are_left_out() {
        let text =
            svg(&[(1.0, 2.0), (f64::INFINITY, 1.0), (2.0, f64::INFINITY), (3.0, f64::NAN), (4.0, 1.0)]);
        let drawn: Vec<bool> = (0..5).map(|i| text.contains(&format!("point {i}"))).collect();
        assert_eq!(drawn, [true, false, false, false, true], "{text}");
    }

    #[test]
    fn axes_have_marks_on_both_sides_of_the_data() {
        let text = svg(&[(0.5, 1.7), (28.0, 11.0)]);
        let labels: Vec<f64> = text.lines().filter_map(|line| line.trim().parse().ok()).collect();
        for (below, above) in [(0.5, 28.0), (1.7, 11.0)] {
            assert!(labels.iter().any(|&x| x <= below), "nothing below {below}: {labels:?}");
            assert!(labels.iter().any(|&x| x > below && x < above), "nothing above {below}: {labels:?}");
        }
        for x in [2.0, 10.0] {
            let count = labels.iter().filter(|&&label| label == x).count();
            assert_eq!(count, 2, "each axis has one mark at {x}: {labels:?}");
        }
    }

    #[test]
    fn a_plot_of_nothing_and_of_extremes_ends() {
        for points in [
            &[][..],
            &[(f64::INFINITY, f64::INFINITY)],
            &[(f64::NAN, f64::NEG_INFINITY)],
            &[(0.0, 0.0)],
            &[(1.0, f64::MAX), (f64::MIN_POSITIVE, -1.0)],
        ] {
            let text = svg(points);
            assert!(text.trim_end().ends_with("</svg>"), "{points:?}: {text}");
        }
    }
}
