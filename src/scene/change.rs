//! Changes of materials by name: what a scene is lit with when only its light is to be another.

use serde::{Deserialize, Serialize};

use super::Material;
use super::draft::nearest_names;
use super::error::{name_list, quoted};
use super::statements::LARGEST_COLOUR;
use std::collections::BTreeSet;

/// What becomes of the materials and rectangles of one name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialChange {
    /// As in the MTL or the scene description.
    pub name: String,
    /// Instead of what the files say, linear RGB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflectance: Option<[f64; 3]>,
    /// Likewise, W/(m²·sr).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radiance: Option<[f64; 3]>,
}

impl MaterialChange {
    /// Reads a change of one property, such as `lamp.radiance=[20, 20, 20]`.
    ///
    /// # Errors
    /// What is wrong with it, and what to write.
    pub fn parse(text: &str) -> Result<MaterialChange, String> {
        let form = "write NAME.reflectance=[R,G,B] or NAME.radiance=[R,G,B]";
        let (place, value) = text.rsplit_once('=').ok_or(form)?;
        let (name, key) = place.rsplit_once('.').ok_or(form)?;
        if name.is_empty() {
            return Err(format!("the name is missing; {form}"));
        }
        let colour = Some(colour(key.trim_end(), value)?);
        let name = name.to_owned();
        match key.trim_end() {
            "reflectance" => Ok(MaterialChange { name, reflectance: colour, radiance: None }),
            "radiance" => Ok(MaterialChange { name, reflectance: None, radiance: colour }),
            other => Err(format!("a material has no {}; {form}", quoted(other))),
        }
    }

    /// Adds a later change to some: of what both change, the later one counts.
    pub fn add_to(&self, changes: &mut Vec<MaterialChange>) {
        match changes.iter_mut().find(|change| change.name == self.name) {
            Some(change) => {
                change.reflectance = self.reflectance.or(change.reflectance);
                change.radiance = self.radiance.or(change.radiance);
            }
            None => changes.push(self.clone()),
        }
    }

    /// Whether both change the same property of one material.
    pub fn contradicts(&self, other: &MaterialChange) -> bool {
        self.name == other.name
            && (self.reflectance.is_some() && other.reflectance.is_some()
                || self.radiance.is_some() && other.radiance.is_some())
    }

    /// Whether every number in it is one that a scene may have.
    pub fn is_sound(&self) -> bool {
        [self.reflectance, self.radiance].into_iter().flatten().all(is_colour)
    }
}

/// Checks that every change is one of a material that there is.
///
/// # Errors
/// Which is not, and what the scene has.
pub fn check_names(changes: &[MaterialChange], materials: &[Material]) -> Result<(), String> {
    let known: BTreeSet<String> = materials.iter().map(|material| material.name.clone()).collect();
    let Some(change) = changes.iter().find(|change| !known.contains(&change.name)) else { return Ok(()) };
    let near = nearest_names(&change.name, &known);
    let advice = match near.is_empty() {
        true => String::new(),
        false => format!("did you mean {}? ", name_list(near)),
    };
    let all = name_list(known.iter().map(String::as_str));
    Err(format!("no material or quad is named {}; {advice}the scene has {all}", quoted(&change.name)))
}

/// Whether a scene may have such a colour, in the precision that materials have.
fn is_colour(rgb: [f64; 3]) -> bool {
    rgb.iter().all(|&channel| (0.0..=LARGEST_COLOUR as f32).contains(&(channel as f32)))
}

/// Three channels, in the precision that materials have.
fn colour(key: &str, text: &str) -> Result<[f64; 3], String> {
    let bare = text.trim();
    let bare = bare.strip_prefix('[').and_then(|bare| bare.strip_suffix(']'));
    let channels: Option<Vec<f64>> =
        bare.and_then(|bare| bare.split(',').map(|number| number.trim().parse().ok()).collect());
    let Some(&[r, g, b]) = channels.as_deref() else {
        return Err(format!("{} is no colour; write three numbers such as [0.7, 0.1, 0.1]", quoted(text)));
    };
    let rgb = [r, g, b];
    if !is_colour(rgb) {
        return Err(format!(
            "{key} {rgb:?} is negative, not finite or too large; write 0 to {LARGEST_COLOUR:e}"
        ));
    }
    Ok(rgb.map(|channel| f64::from(channel as f32)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_read_as_it_is_typed() {
        let change = |text: &str| MaterialChange::parse(text).unwrap_or_else(|why| panic!("{text}: {why}"));
        let lamp = change("lamp.radiance=[20,20.5, 1e2]");
        assert_eq!(
            (lamp.name.as_str(), lamp.reflectance, lamp.radiance),
            ("lamp", None, Some([20.0, 20.5, 100.0]))
        );
        let wall = change(" a.b = c.reflectance = [.5, 0, 5]");
        assert_eq!((wall.name.as_str(), wall.reflectance), (" a.b = c", Some([0.5, 0.0, 5.0])));
        assert!(change("a.radiance=[1e30,0,0]").is_sound(), "the brightest that can be typed can be read");
        // As materials have it: what is written to a file and read again is the same.
        assert_eq!(change("a.radiance=[0.1,0,0]").radiance, Some([f64::from(0.1f32), 0.0, 0.0]));
    }

    #[test]
    fn what_is_no_change_is_refused_with_what_to_write() {
        for (text, part) in [
            ("", "NAME.radiance="),
            ("lamp", "NAME.radiance="),
            ("lamp=[1,1,1]", "NAME.radiance="),
            (".radiance=[1,1,1]", "name is missing"),
            ("lamp.colour=[1,1,1]", "no 'colour'"),
            ("lamp.radiance=", "no colour"),
            ("lamp.radiance=1", "no colour"),
            ("lamp.radiance=[1,1]", "no colour"),
            ("lamp.radiance=[1,1,1,1]", "no colour"),
            ("lamp.radiance=[1,1,x]", "no colour"),
            ("lamp.radiance=[1,1,-1]", "negative"),
            ("lamp.radiance=[1,1,nan]", "not finite"),
            ("lamp.radiance=[1,1,inf]", "not finite"),
            ("wall.reflectance=[1,1,1e31]", "too large"),
        ] {
            match MaterialChange::parse(text) {
                Err(why) => assert!(why.contains(part), "{text}: {why}"),
                Ok(change) => panic!("{text} became {change:?}"),
            }
        }
    }

    #[test]
    fn of_what_two_change_the_later_one_counts() {
        let mut changes = Vec::new();
        for text in
            ["a.radiance=[1,1,1]", "b.radiance=[2,2,2]", "a.reflectance=[0,0,0]", "a.radiance=[3,3,3]"]
        {
            MaterialChange::parse(text).expect("a change").add_to(&mut changes);
        }
        let of = |index: usize| {
            (changes[index].name.as_str(), changes[index].reflectance, changes[index].radiance)
        };
        assert_eq!(of(0), ("a", Some([0.0; 3]), Some([3.0; 3])));
        assert_eq!((of(1), changes.len()), (("b", None, Some([2.0; 3])), 2));
    }
}
