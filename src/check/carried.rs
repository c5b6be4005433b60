//! What the links of a solution carry, link by link, and light that is alike on all surfaces.

use super::subject::Subject;
use crate::radiosity::{Light, intensities};
use glam::Vec3;
use rayon::prelude::*;

/// Irradiance of every leaf element over all links that lead to it or to what it is a part of; of no meaning in others.
pub(super) fn irradiance(subject: &Subject<'_>) -> Vec<Vec3> {
    let (hierarchy, solution) = (subject.hierarchy, subject.solution);
    let (forest, links, light) = (&solution.forest, &solution.links, &solution.light);
    let openness = &solution.openness;
    let arriving = openness.arriving(hierarchy, forest, links, light);
    let gathered = |element| light.gathered(hierarchy, forest, links, element);
    let (even, mut irradiance): (Vec<Vec3>, Vec<Vec3>) =
        (0..forest.len() as u32).into_par_iter().map(|element| gathered(element).into()).unzip();
    for side in 0..forest.side_count() {
        let own = forest.elements_of(side);
        let light = (&even[own.clone()], &mut irradiance[own]);
        openness.push(hierarchy, forest, side, &arriving, light);
    }
    irradiance
}

/// What is darker than this share of the typical irradiance sends out next to no light: the solver does not
/// follow shadows there either.
const BLACK: f32 = 0.03;

/// Light of which every leaf element sends 1 in every channel, or nothing if it is black.
pub(super) fn even_light(subject: &Subject<'_>) -> Light {
    let (hierarchy, solution) = (subject.hierarchy, subject.solution);
    let forest = &solution.forest;
    let black = BLACK * typical_irradiance(subject);
    let mut exitance = vec![Vec3::ZERO; forest.len()];
    for element in (0..forest.len()).rev() {
        let second = forest.second[element] as usize;
        exitance[element] = if second == 0 {
            if solution.light.exitance[element].max_element() > black { Vec3::ONE } else { Vec3::ZERO }
        } else {
            let share = forest.area[element + 1] / (forest.area[element + 1] + forest.area[second]);
            exitance[second].lerp(exitance[element + 1], share)
        };
    }
    let intensity = intensities(hierarchy, forest, &exitance);
    let brightest = exitance.iter().map(|exitance| exitance.max_element()).collect();
    Light { exitance, intensity, variation: vec![0.0; forest.len()], brightest, ..Light::default() }
}

/// Geometric mean of the irradiance of leaf elements, weighted by the power it brings; 0 when all is dark.
fn typical_irradiance(subject: &Subject<'_>) -> f32 {
    let (mut power, mut logarithms) = (0.0, 0.0);
    for &leaf in &subject.leaves {
        let irradiance = subject.solution.light.irradiance[leaf as usize].max_element() as f64;
        if irradiance > 0.0 {
            let received = irradiance * subject.area(leaf);
            power += received;
            logarithms += received * irradiance.ln();
        }
    }
    if power > 0.0 { (logarithms / power).exp() as f32 } else { 0.0 }
}
