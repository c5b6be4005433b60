//! Fingerprints of what a file was made for, so that it is not used with anything else.

use super::{Hierarchy, TraceMesh};
use crate::math::hash_pair;
use crate::scene::Material;
use std::collections::HashMap;
use std::sync::Arc;

/// What the light of a scene depends on, in parts, so that it can be said which of them differs. Names, cameras and
/// files do not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// Whether surfaces reflect on their front side only.
    pub one_sided: bool,
    /// Triangles, the facets they make, and the units of length.
    pub geometry: u64,
    /// Reflectance, with the pictures, and radiance of every facet.
    pub materials: u64,
    /// The tree above the facets and the contacts on them, which follow from the geometry by rules of this program.
    pub tree: u64,
}

impl Fingerprint {
    /// Of a hierarchy, in whose scene a unit of length is so many metres.
    pub fn of(hierarchy: &Hierarchy, meters_per_unit: f64) -> Fingerprint {
        let frame = hierarchy.frame.numbers().into_iter().chain([meters_per_unit]);
        let geometry = frame.map(f64::to_bits).fold(hierarchy.mesh.fingerprint(), hash_pair);
        let facets = 0..hierarchy.facets.len() as u32;
        let materials = facets.clone().map(|facet| hierarchy.material(facet));
        // Of what has a picture the mean alone would not tell.
        let mut of_painting = HashMap::new();
        let mut painted = |material: &Material| {
            let painting = material.painting.as_ref()?;
            Some(*of_painting.entry(Arc::as_ptr(painting)).or_insert_with(|| painting.fingerprint()))
        };
        let materials = materials.flat_map(|material| {
            let numbers = material.reflectance.into_iter().chain(material.radiance);
            numbers.map(|number| number.to_bits().into()).chain(painted(material))
        });
        let nodes = hierarchy.nodes.iter().map(|node| pair(node.first, node.end));
        let contacts = facets.flat_map(|facet| {
            let contacts = hierarchy.contacts.on(facet);
            let ends = contacts.iter().flatten().flat_map(|end| end.to_array()).map(f64::to_bits);
            [contacts.len() as u64].into_iter().chain(ends)
        });
        Fingerprint {
            one_sided: hierarchy.one_sided,
            geometry,
            materials: materials.fold(0, hash_pair),
            tree: nodes.chain(contacts).fold(0, hash_pair),
        }
    }
}

impl TraceMesh {
    /// A fingerprint of the triangles and of the facets they make.
    pub fn fingerprint(&self) -> u64 {
        let positions =
            self.positions.iter().flat_map(|p| [pair(p.x.to_bits(), p.y.to_bits()), p.z.to_bits().into()]);
        let triangles = self.triangles.iter().zip(&self.facet_of_triangle);
        let triangles = triangles.flat_map(|(&[a, b, c], &facet)| [pair(a, b), pair(c, facet)]);
        let counts = [self.positions.len() as u64, self.triangles.len() as u64];
        counts.into_iter().chain(positions).chain(triangles).fold(0, hash_pair)
    }
}

fn pair(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}
