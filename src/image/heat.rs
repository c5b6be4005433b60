//! Heat maps: leaf elements coloured by what their visibility cost, or by the links that light them.

use super::descent::handed_down;
use crate::hierarchy::Hierarchy;
use crate::math::srgb_from_linear;
use crate::radiosity::{LinkClass, Solution};
use glam::Vec3;
use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use std::fmt;

/// Part of what is seen that lies beyond the colours, at either end: a sliver must not spoil the scale.
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
    /// Class of the links that cost the most.
    Class,
    /// Share of the light that comes over partial links.
    Partial,
}

/// A class of links, as the heat map of classes tells them apart, with the name and the linear value of its colour.
const CLASSES: [(&str, &str, Vec3); 4] = [
    ("visible, by rays", "blue", Vec3::new(0.03, 0.15, 0.75)),
    ("visible, proved", "green", Vec3::new(0.05, 0.45, 0.10)),
    ("partly visible", "orange", Vec3::new(0.85, 0.25, 0.03)),
    ("no test: inherited, or dark", "grey", NOTHING),
];

/// The figure of every element, and the scale of its colours.
pub struct HeatMap {
    kind: Heat,
    /// By element; for classes an index of [`CLASSES`]. Negative where there is nothing to say.
    figures: Vec<f32>,
    /// Where the colours begin and end.
    ends: [f64; 2],
    /// Least and most of all that light reaches.
    range: [f64; 2],
    /// Area by class, of what light reaches.
    shares: [f64; 4],
}

impl HeatMap {
    /// From a solution; for [`Heat::Cost`] one that was found with
    /// [`Record::Work`](crate::radiosity::Record::Work). `square_meters` is the area of one local unit of area. The colours
    /// are for what is [seen](super::seen), leaf elements as often as they are met; where nothing is, for all that light
    /// reaches.
    pub fn new(
        hierarchy: &Hierarchy,
        solution: &Solution,
        square_meters: f64,
        kind: Heat,
        seen: &[u32],
    ) -> HeatMap {
        let figures = match kind {
            Heat::Cost => cost(hierarchy, solution, square_meters),
            Heat::Links => links(hierarchy, solution),
            Heat::Class => class(hierarchy, solution),
            Heat::Partial => partial(hierarchy, solution),
        };
        let forest = &solution.forest;
        // The outside of a house must not spoil the scale, either: often it is dark, or not seen.
        let is_lit = |&element: &usize| solution.light.irradiance[element].max_element() > 0.0;
        let figure = |element: usize| figures[element] as f64;
        let lit = forest.leaves().filter(is_lit);
        let mut by_figure: Vec<(f64, f64)> =
            lit.map(|element| (figure(element), forest.area[element] as f64)).collect();
        let seen = seen.iter().map(|&element| element as usize).filter(is_lit);
        let mut by_sight: Vec<(f64, f64)> = seen.map(|element| (figure(element), 1.0)).collect();
        let mut shares = [0.0; 4];
        if kind == Heat::Class {
            by_figure.iter().for_each(|&(class, area)| shares[class as usize] += area);
            let whole: f64 = shares.iter().sum();
            shares.iter_mut().for_each(|share| *share /= whole.max(f64::MIN_POSITIVE));
        }
        for figures in [&mut by_figure, &mut by_sight] {
            figures.retain(|&(figure, _)| if kind == Heat::Partial { figure >= 0.0 } else { figure > 0.0 });
            figures.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let scaled = if by_sight.is_empty() { &by_figure } else { &by_sight };
        let ends = match kind {
            Heat::Partial => [0.0, 1.0],
            _ => [quantile(scaled, BEYOND), quantile(scaled, 1.0 - BEYOND)],
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

    /// Of a map of [`Heat::Class`]: which entry of the legend an element has.
    pub fn class(&self, element: u32) -> u8 {
        self.figures[element as usize] as u8
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

    /// What the colours stand for.
    pub fn legend(&self) -> Legend {
        let what = match self.kind {
            Heat::Cost => "visibility tests, rays/m² of receiver",
            Heat::Links => "links over which an element is lit",
            Heat::Class => {
                "class of the links that cost the most on each element, and its share of the area that light reaches"
            }
            Heat::Partial => "share of the light that comes over partial links",
        };
        if self.kind == Heat::Class {
            let rows = CLASSES.iter().zip(self.shares);
            let entries = rows.map(|((class, name, colour), share)| {
                (srgb_bytes_of(*colour), format!("{name:<8}{:5.1} %  {class}", 100.0 * share))
            });
            return Legend { title: what.to_owned(), entries: entries.collect() };
        }
        let scale = if self.is_logarithmic() { "logarithmic" } else { "linear" };
        let title =
            format!("{what}: {} to {}; {scale} scale", rounded(self.range[0]), rounded(self.range[1]));
        let entry = |(step, name): (usize, &&str)| {
            let place = step as f64 / (STEPS.len() - 1) as f64;
            let beyond = match step {
                _ if self.kind == Heat::Partial => "",
                0 => " or less",
                _ if step + 1 == STEPS.len() => " or more",
                _ => "",
            };
            let figure = rounded(self.figure_at(place));
            (srgb_bytes_of(viridis(place)), format!("{name:<12}{figure}{beyond}"))
        };
        Legend { title, entries: STEPS.iter().enumerate().map(entry).collect() }
    }
}

/// What the colours of a heat map stand for; as text, some lines for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// What is shown.
    pub title: String,
    /// Colours, sRGB, each with its name and what it stands for.
    pub entries: Vec<([u8; 3], String)>,
}

impl fmt::Display for Legend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        self.entries.iter().try_for_each(|(_, words)| writeln!(f, "  {words}"))
    }
}

fn srgb_bytes_of(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|value| (255.0 * srgb_from_linear(value)).round() as u8)
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

/// The figure that `part` of the weight lies below, of figures in ascending order with their weights.
fn quantile(by_figure: &[(f64, f64)], part: f64) -> f64 {
    let wanted = part * by_figure.iter().map(|&(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    let reaches = |&&(_, weight): &&(f64, f64)| {
        below += weight;
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

/// Area on which a node is lit, local units: a cluster on all sides of its facets.
fn area_of_receiver(hierarchy: &Hierarchy, solution: &Solution, node: usize) -> f64 {
    let area = match node.checked_sub(hierarchy.nodes.len()) {
        Some(element) => solution.forest.area[element] as f64,
        None => hierarchy.nodes[node].area as f64 * f64::from(hierarchy.sides()),
    };
    area.max(f64::MIN_POSITIVE)
}

/// Work by area of the receivers: that of an element, and of all it is part of.
fn cost(hierarchy: &Hierarchy, solution: &Solution, square_meters: f64) -> Vec<f32> {
    let (clusters, forest) = (hierarchy.nodes.len(), &solution.forest);
    let own = solution.work.iter().enumerate().map(|(node, &work)| {
        if work == 0 {
            0.0
        } else {
            work as f64 / (area_of_receiver(hierarchy, solution, node) * square_meters)
        }
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

/// The class whose links cost the most on an element: its own, and those of all it is part of, by area.
fn class(hierarchy: &Hierarchy, solution: &Solution) -> Vec<f32> {
    let clusters = hierarchy.nodes.len();
    let nodes = clusters + solution.forest.len();
    let by_class = |node: usize| {
        let mut sums = [0.0f64; 3];
        for link in solution.links.of(node as u32) {
            let class = match link.class {
                LinkClass::Untested => continue,
                LinkClass::Visible => 0,
                LinkClass::CertifiedVisible => 1,
                LinkClass::Partial => 2,
            };
            sums[class] += f64::from(link.work());
        }
        let area = area_of_receiver(hierarchy, solution, node);
        sums.map(|sum| if sum > 0.0 { sum / area } else { 0.0 })
    };
    let own = (0..nodes).map(by_class).collect();
    let all = handed_down(hierarchy, &solution.forest, own, |sums: &mut [f64; 3], above| {
        sums.iter_mut().zip(above).for_each(|(sum, above)| *sum += above);
    });
    let costliest = |sums: &[f64; 3]| {
        let most = sums.iter().copied().fold(0.0, f64::max);
        sums.iter().position(|&sum| sum > 0.0 && sum == most).unwrap_or(sums.len()) as f32
    };
    all[clusters..].iter().map(costliest).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::radiosity::{Record, SolveOptions, solve};
    use crate::scene;
    use crate::tracer::FallbackTracer;
    use crate::visibility::{Strategy, VisibilityOptions};
    use std::path::Path;

    fn solved() -> (Hierarchy, Solution) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.toml");
        let scene = scene::load(&path, &Default::default(), &Silent).expect("a scene of the project");
        let hierarchy = Hierarchy::build(&scene, false, &Silent);
        let options = SolveOptions {
            epsilon: 5e-3,
            contrast: 0.4,
            min_size: None,
            resolution: 32.0,
            iterations: 100,
            visibility: VisibilityOptions { strategy: Strategy::Adaptive, rays: 4, certify: false },
            record: Record::Work,
        };
        let solution = solve(&hierarchy, &FallbackTracer::new(&hierarchy.mesh), &options, 1.0, &Silent);
        (hierarchy, solution)
    }

    fn map(ends: [f64; 2]) -> HeatMap {
        HeatMap { kind: Heat::Cost, figures: vec![0.0], ends, range: ends, shares: [0.0; 4] }
    }

    #[test]
    fn no_cost_is_lost_on_the_way_down() {
        let (hierarchy, solution) = solved();
        let (cost, square_meters) = (cost(&hierarchy, &solution, 2.5), 2.5);
        let forest = &solution.forest;
        let handed: f64 = forest.leaves().map(|e| (cost[e] * forest.area[e]) as f64 * square_meters).sum();
        let done = solution.work.iter().sum::<u64>() as f64;
        assert!(done > 1000.0 && (handed / done - 1.0).abs() < 1e-3, "{handed} of {done}");
    }

    #[test]
    fn links_are_those_of_an_element_and_of_all_it_is_part_of() {
        let (hierarchy, solution) = solved();
        let (links, clusters) = (links(&hierarchy, &solution), hierarchy.nodes.len() as u32);
        let forest = &solution.forest;
        for element in forest.leaves().step_by(37).map(|element| element as u32) {
            let side = forest.side_of(element);
            let mut way = vec![forest.first_element[side]];
            while let Some(&last) = way.last().filter(|&&last| last != element) {
                let second = forest.second[last as usize];
                way.push(if element < second { last + 1 } else { second });
            }
            let leaf = hierarchy.leaf(forest.side(side).facet);
            let nodes = way.iter().map(|e| clusters + e).chain(hierarchy.lineage(leaf));
            let wanted: usize = nodes.map(|node| solution.links.of(node).len()).sum();
            assert_eq!(links[element as usize], wanted as f32, "element {element}");
        }
    }

    #[test]
    fn shares_and_classes_are_what_they_can_be() {
        let (hierarchy, solution) = solved();
        let shares = partial(&hierarchy, &solution);
        assert!(shares.iter().all(|&share| share == -1.0 || (0.0..=1.0).contains(&share)));
        let lit = || solution.forest.leaves().map(|e| shares[e]).filter(|&share| share >= 0.0);
        assert!(lit().any(|share| share < 0.2) && lit().any(|share| share > 0.5), "light and half-shadow");
        let classes = class(&hierarchy, &solution);
        assert_eq!(classes.len(), solution.forest.len());
        let has = |class: f32| solution.forest.leaves().any(|e| classes[e] == class);
        assert!(has(0.0) && has(2.0), "rays, clear and mixed, cost something somewhere");
        assert!(classes.iter().all(|&class| class < CLASSES.len() as f32));
    }

    #[test]
    fn wide_scales_are_logarithmic_and_narrow_ones_are_not() {
        let (wide, narrow) = (map([1.0, 1e4]), map([100.0, 200.0]));
        assert!((wide.place(100.0) - 0.5).abs() < 1e-9 && (narrow.place(150.0) - 0.5).abs() < 1e-9);
        for map in [&wide, &narrow] {
            assert_eq!((map.place(0.0), map.place(1e9)), (0.0, 1.0));
            for place in [0.0, 0.25, 1.0] {
                assert!((map.place(map.figure_at(place)) - place).abs() < 1e-9);
            }
        }
        assert!(wide.legend().title.contains("logarithmic") && narrow.legend().title.contains("linear"));
        let (legend, text) = (wide.legend(), wide.legend().to_string());
        assert_eq!(
            (legend.entries[0].0, legend.entries[4].0),
            ([68, 1, 84], [254, 232, 37]),
            "the ends of viridis"
        );
        assert_eq!(text.lines().count(), 6, "{text}");
        assert_eq!(map([7.0, 7.0]).place(7.0), 0.5);
        assert!(map([0.0, 0.0]).place(0.0).is_finite());
    }

    #[test]
    fn colours_run_from_dark_violet_to_yellow() {
        let [low, high] = [viridis(0.0), viridis(1.0)];
        assert!(low.max_element() == low.z && high.min_element() == high.z, "{low} {high}");
        let luminance = |place: f64| viridis(place).dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let rising: Vec<f32> = (0..=20).map(|step| luminance(step as f64 / 20.0)).collect();
        assert!(rising.windows(2).all(|pair| pair[0] < pair[1]), "{rising:?}");
    }

    #[test]
    fn colours_are_for_what_is_seen() {
        let (hierarchy, solution) = solved();
        let links = links(&hierarchy, &solution);
        let leaves =
            || solution.forest.leaves().filter(|&e| solution.light.irradiance[e].max_element() > 0.0);
        let map = |seen: &[u32]| HeatMap::new(&hierarchy, &solution, 1.0, Heat::Links, seen);
        let most = leaves().max_by(|&a, &b| links[a].total_cmp(&links[b])).expect("an element");
        let near = map(&[most as u32]);
        assert_eq!(near.ends, [f64::from(links[most]); 2]);
        let all: Vec<u32> = leaves().map(|element| element as u32).collect();
        assert!(map(&all).ends[0] < near.ends[0] && map(&[]).ends[0] < near.ends[0]);
        assert_eq!(map(&[]).range, near.range, "of all that light reaches");
    }

    #[test]
    fn the_ends_leave_out_slivers() {
        let figures = [(0.001, 0.2), (1.0, 49.0), (2.0, 50.0), (900.0, 0.8)];
        assert_eq!((quantile(&figures, BEYOND), quantile(&figures, 1.0 - BEYOND)), (1.0, 2.0));
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
