//! Heat maps: leaf elements coloured by what their visibility cost, or by the links that light them.

use super::descent::handed_down;
use crate::hierarchy::Hierarchy;
use crate::radiosity::{Link, LinkClass, Solution};
use glam::Vec3;
use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};

/// Part of the area that lies beyond the colours, at either end: a sliver must not spoil the scale.
const BEYOND: f64 = 0.01;

/// From this ratio of its ends on a scale is logarithmic.
const WIDE: f64 = 30.0;

/// Names of the colours in even steps of the scale.
const STEPS: [&str; 5] = ["dark violet", "blue", "teal", "green", "yellow"];

/// Linear colour of what the figure says nothing about.
const NOTHING: Vec3 = Vec3::splat(0.08);

/// What is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heat {
    /// Work of visibility tests by area.
    Cost,
    /// Links over which an element is lit.
    Links,
    /// Class of the link that cost the most.
    Class,
    /// Share of the light that comes over partial links.
    Partial,
}

/// A class of links, as the heat map of classes tells them apart, with the name and the linear value of its colour.
const CLASSES: [(&str, &str, Vec3); 4] = [
    ("visible, by rays", "blue", Vec3::new(0.03, 0.15, 0.75)),
    ("visible, proved", "green", Vec3::new(0.05, 0.45, 0.10)),
    ("partly visible", "orange", Vec3::new(0.85, 0.25, 0.03)),
    ("not tested, or no light", "grey", NOTHING),
];

/// The figure of every element, and the scale of its colours.
pub struct HeatMap {
    kind: Heat,
    /// By element; for classes an index of [`CLASSES`]. Negative where there is nothing to say.
    figures: Vec<f32>,
    /// Where the colours begin and end.
    ends: [f64; 2],
    /// Least and most of all.
    range: [f64; 2],
    /// Area by class, relative.
    shares: [f64; 4],
}

impl HeatMap {
    /// From a solution; for [`Heat::Cost`] one that was found with
    /// [`Record::Work`](crate::radiosity::Record::Work). `square_meters` is the area of one local unit of area.
    pub fn new(hierarchy: &Hierarchy, solution: &Solution, square_meters: f64, kind: Heat) -> HeatMap {
        let figures = match kind {
            Heat::Cost => cost(hierarchy, solution, square_meters),
            Heat::Links => links(hierarchy, solution),
            Heat::Class => class(hierarchy, solution),
            Heat::Partial => partial(hierarchy, solution),
        };
        let forest = &solution.forest;
        let mut by_figure: Vec<(f64, f64)> =
            forest.leaves().map(|element| (figures[element] as f64, forest.area[element] as f64)).collect();
        let mut shares = [0.0; 4];
        if kind == Heat::Class {
            by_figure.iter().for_each(|&(class, area)| shares[class as usize] += area);
            let whole: f64 = shares.iter().sum();
            shares.iter_mut().for_each(|share| *share /= whole.max(f64::MIN_POSITIVE));
        }
        by_figure.retain(|&(figure, _)| if kind == Heat::Partial { figure >= 0.0 } else { figure > 0.0 });
        by_figure.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = match kind {
            Heat::Partial => [0.0, 1.0],
            _ => [quantile(&by_figure, BEYOND), quantile(&by_figure, 1.0 - BEYOND)],
        };
        let at = |end: Option<&(f64, f64)>| end.map_or(0.0, |end| end.0);
        HeatMap { kind, figures, ends, range: [at(by_figure.first()), at(by_figure.last())], shares }
    }

    /// Linear colour of an element.
    pub(super) fn color(&self, element: u32) -> Vec3 {
        let figure = self.figures[element as usize] as f64;
        match self.kind {
            Heat::Class => CLASSES[figure as usize].2,
            _ if figure < 0.0 => NOTHING,
            _ => viridis(self.place(figure)),
        }
    }

    fn is_logarithmic(&self) -> bool {
        self.kind != Heat::Partial && self.ends[1] > WIDE * self.ends[0]
    }

    /// Where on the scale a figure lies, from 0 to 1.
    fn place(&self, figure: f64) -> f64 {
        let [low, high] = self.ends;
        if high <= low {
            return if figure < low { 0.0 } else { 0.5 };
        }
        let place = if self.is_logarithmic() {
            (figure.max(low) / low).ln() / (high / low).ln()
        } else {
            (figure - low) / (high - low)
        };
        place.clamp(0.0, 1.0)
    }

    /// The figure at a place of the scale.
    fn figure_at(&self, place: f64) -> f64 {
        let [low, high] = self.ends;
        if self.is_logarithmic() { low * (high / low).powf(place) } else { low + (high - low) * place }
    }

    /// What the colours mean: some lines for people.
    pub fn legend(&self) -> String {
        let what = match self.kind {
            Heat::Cost => "visibility tests, rays/m² of receiver",
            Heat::Links => "links over which an element is lit",
            Heat::Class => "class of the link of each element that cost the most, and its share of all area",
            Heat::Partial => "share of the light that comes over partial links",
        };
        if self.kind == Heat::Class {
            let rows = CLASSES.iter().zip(self.shares);
            let lines = rows
                .map(|((class, name, _), share)| format!("  {name:<8}{:5.1} %  {class}\n", 100.0 * share));
            return format!("{what}\n{}", lines.collect::<String>());
        }
        let scale = if self.is_logarithmic() { "logarithmic" } else { "linear" };
        let mut text =
            format!("{what}: {} to {}; {scale} scale\n", rounded(self.range[0]), rounded(self.range[1]));
        for (step, name) in STEPS.iter().enumerate() {
            let figure = rounded(self.figure_at(step as f64 / (STEPS.len() - 1) as f64));
            let beyond = match step {
                _ if self.kind == Heat::Partial => "",
                0 => " or less",
                _ if step + 1 == STEPS.len() => " or more",
                _ => "",
            };
            text += &format!("  {name:<12}{figure}{beyond}\n");
        }
        text
    }
}

/// Three digits.
fn rounded(figure: f64) -> String {
    match figure.abs() {
        size if size >= 1e6 || size > 0.0 && size < 1e-3 => format!("{figure:.2e}"),
        size if size >= 100.0 => format!("{figure:.0}"),
        size if size >= 10.0 => format!("{figure:.1}"),
        _ => format!("{figure:.2}"),
    }
}

/// The figure that `part` of the area lies below, of figures in ascending order with their areas.
fn quantile(by_figure: &[(f64, f64)], part: f64) -> f64 {
    let wanted = part * by_figure.iter().map(|&(_, area)| area).sum::<f64>();
    let mut below = 0.0;
    let reaches = |&&(_, area): &&(f64, f64)| {
        below += area;
        below >= wanted
    };
    by_figure.iter().find(reaches).map_or(0.0, |&(figure, _)| figure)
}

/// The colour map viridis (N. Smith, S. van der Walt), linear.
fn viridis(place: f64) -> Vec3 {
    let RGBColor(r, g, b) = ViridisRGB.get_color(place as f32);
    Vec3::from([r, g, b].map(|code| linear_from_srgb(f32::from(code) / 255.0)))
}

/// The inverse of [`srgb_from_linear`](super::tone::srgb_from_linear).
fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Work by area of the receivers: that of an element, and of all it is part of.
fn cost(hierarchy: &Hierarchy, solution: &Solution, square_meters: f64) -> Vec<f32> {
    let (clusters, forest) = (hierarchy.nodes.len(), &solution.forest);
    // A cluster is lit on all sides of its facets.
    let area = |node: usize| match node.checked_sub(clusters) {
        Some(element) => forest.area[element] as f64,
        None => hierarchy.nodes[node].area as f64 * f64::from(hierarchy.sides()),
    };
    let own = solution.work.iter().enumerate().map(|(node, &work)| {
        if work == 0 { 0.0 } else { work as f64 / (area(node) * square_meters).max(f64::MIN_POSITIVE) }
    });
    let by_area = handed_down(hierarchy, forest, own.collect(), |sum: &mut f64, above| *sum += above);
    by_area[clusters.min(by_area.len())..].iter().map(|&work| work as f32).collect()
}

/// Links of an element and of all it is part of.
fn links(hierarchy: &Hierarchy, solution: &Solution) -> Vec<f32> {
    let clusters = hierarchy.nodes.len();
    let nodes = clusters + solution.forest.len();
    let own = (0..nodes).map(|node| solution.links.of(node as u32).len() as u64).collect();
    let all = handed_down(hierarchy, &solution.forest, own, |sum, above| *sum += above);
    all[clusters..].iter().map(|&count| count as f32).collect()
}

/// The class of the link that cost the most, of an element and all it is part of; of two that cost the same, that of
/// the element.
fn class(hierarchy: &Hierarchy, solution: &Solution) -> Vec<f32> {
    let clusters = hierarchy.nodes.len();
    let nodes = clusters + solution.forest.len();
    let none = (0u16, CLASSES.len() as u8 - 1);
    let of = |link: &Link| match link.class {
        LinkClass::Visible => (link.work, 0),
        LinkClass::CertifiedVisible => (link.work, 1),
        LinkClass::Partial | LinkClass::Invisible => (link.work, 2),
        LinkClass::Untested => none,
    };
    let costliest = |node: usize| {
        let classes = solution.links.of(node as u32).iter().map(of);
        classes.reduce(|most, other| if other.0 > most.0 { other } else { most }).unwrap_or(none)
    };
    let own = (0..nodes).map(costliest).collect();
    let all = handed_down(hierarchy, &solution.forest, own, |most: &mut (u16, u8), above| {
        if above.0 > most.0 || most.1 == none.1 {
            *most = above;
        }
    });
    all[clusters..].iter().map(|&(_, class)| class as f32).collect()
}

/// Irradiance over partial links, of all of it.
fn partial(hierarchy: &Hierarchy, solution: &Solution) -> Vec<f32> {
    let classes = super::mesh_view::light_by_class(hierarchy, solution);
    let share = |by_class: &[f32; 4]| {
        let all: f32 = by_class.iter().sum();
        if all > 0.0 { by_class[LinkClass::Partial as usize] / all } else { -1.0 }
    };
    classes[hierarchy.nodes.len()..].iter().map(share).collect()
}
