//! Primitives of a mesh as triangles of the scene, where a node puts them.

use std::path::Path;

use glam::{DMat4, DVec3};
use gltf_json::accessor::ComponentType;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index, Root};

use super::super::draft::Draft;
use super::super::error::{SceneError, quoted};
use super::super::painted::Painter;
use super::super::tint::Tints;
use super::super::toml_file::is_position;
use super::accessor::Values;
use super::buffers::Buffers;
use super::materials::{Materials, Surface};
use super::nodes;
use super::pictures::{Pictures, Places};

/// Most triangles whatever the file is: nodes that repeat a mesh make them of next to nothing.
const LEAST_ROOM: u64 = 1 << 24;
/// Most vertices of a primitive of which the file stores none but changes.
const MOST_ZEROS: usize = 1 << 20;

/// Everything of a file that its primitives need.
pub(super) struct Meshes<'a> {
    pub(super) path: &'a Path,
    pub(super) root: &'a Root,
    pub(super) buffers: &'a Buffers,
    pub(super) materials: Materials,
    pub(super) pictures: Pictures<'a>,
    tints: Tints,
    painter: Painter,
    /// Points and lines.
    pub(super) skipped: u64,
    /// Primitives without positions, which the format lets readers skip.
    pub(super) without_positions: u64,
}

/// Corners of the triangles of a primitive: numbers of its vertices, three by three.
type Corners = Vec<u32>;

impl<'a> Meshes<'a> {
    /// `room` is that of [`Pictures::new`].
    pub(super) fn new(path: &'a Path, root: &'a Root, buffers: &'a Buffers, room: u64) -> Self {
        let materials = Materials::new(root);
        Meshes {
            path,
            root,
            buffers,
            materials,
            pictures: Pictures::new(path, root, buffers, room),
            tints: Tints::default(),
            painter: Painter::default(),
            skipped: 0,
            without_positions: 0,
        }
    }

    /// Counts what all nodes make of the meshes before any of it is made.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] when it is too much; those of [`nodes::visit`].
    pub(super) fn check_room(&self) -> Result<(), SceneError> {
        let (path, root) = (self.path, self.root);
        let of_mesh: Vec<u64> = root
            .meshes
            .iter()
            .map(|mesh| mesh.primitives.iter().map(|primitive| self.triangles(primitive)).sum())
            .collect();
        let most = LEAST_ROOM.max(self.buffers.total());
        let mut all = 0u64;
        let mut add = |mesh: usize| {
            all = all.saturating_add(of_mesh[mesh]);
            if all <= most {
                return Ok(());
            }
            let name = quoted(root.meshes[mesh].name.as_deref().unwrap_or_default());
            let message = format!(
                "mesh {mesh} {name}: more than {most} triangles, with all that nodes repeat; split the scene"
            );
            Err(SceneError::invalid(path, None, message))
        };
        if nodes::is_without_scene(root) {
            return (0..root.meshes.len()).try_for_each(add);
        }
        nodes::visit(path, root, |placed| {
            root.nodes[placed.node].mesh.map_or(Ok(()), |mesh| add(mesh.value()))
        })
    }

    /// Of a primitive; of one that is refused later, none.
    fn triangles(&self, primitive: &Primitive) -> u64 {
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let (Some(&positions), Checked::Valid(mode)) = (positions, primitive.mode) else { return 0 };
        let count = |index| self.values(index).ok().map(|values| (values.count, values.is_stored()));
        let Some((vertices, is_stored)) = count(positions) else { return 0 };
        if !is_stored && vertices > MOST_ZEROS {
            return 0;
        }
        let corners = match primitive.indices {
            None => vertices,
            Some(indices) => match count(indices) {
                Some((corners, true)) => corners,
                _ => return 0,
            },
        };
        triangles_of(mode, corners) as u64
    }

    /// Adds all primitives of a mesh, transformed.
    ///
    /// # Errors
    /// [`SceneError::Parse`] for what is malformed, [`SceneError::Invalid`] for what is too large.
    pub(super) fn add(&mut self, draft: &mut Draft, mesh: usize, world: DMat4) -> Result<(), SceneError> {
        let root = self.root;
        let name = root.meshes[mesh].name.as_deref().unwrap_or_default();
        for (number, primitive) in root.meshes[mesh].primitives.iter().enumerate() {
            let place = format!("mesh {mesh} {}, primitive {number}", quoted(name));
            self.add_primitive(draft, primitive, world, &place)?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        draft: &mut Draft,
        primitive: &Primitive,
        world: DMat4,
        place: &str,
    ) -> Result<(), SceneError> {
        let path = self.path;
        let malformed = |what: String| SceneError::parse(path, None, format!("{place}: {what}"));
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(positions) = attribute(Semantic::Positions) else {
            self.without_positions += 1;
            return Ok(());
        };
        let positions = self.values(positions).map_err(malformed)?;
        if positions.width != 3 {
            return Err(malformed("positions are no vectors of 3; export it again".to_owned()));
        }
        let colours = attribute(Semantic::Colors(0)).map(|index| self.values(index)).transpose();
        let colours = colours.map_err(malformed)?;
        if colours.as_ref().is_some_and(|colours| colours.width < 3 || colours.count != positions.count) {
            return Err(malformed("colours do not fit the positions; export it again".to_owned()));
        }
        let Some(mut corners) = self.corners(primitive, &positions, place)? else { return Ok(()) };
        let index = primitive.material.map(|index| index.value());
        let Surface { mut material, layer, baked } =
            self.materials.get(draft, path, self.root, &mut self.pictures, index)?;
        if baked.is_some_and(|baked| baked.back) {
            return Ok(());
        }
        // Of what is baked they are light.
        let colours = colours.filter(|_| baked.is_none());
        let places = match layer {
            Some(layer) => {
                let mean = layer.picture.texture.mean();
                let places = Places::of(self.root, self.buffers, primitive, layer, positions.count);
                let places = places.map_err(malformed)?;
                if places.is_none() {
                    material = self.tints.material(draft, material, mean);
                }
                places
            }
            None => None,
        };

        let is_mirrored = world.determinant() < 0.0;
        if is_mirrored {
            corners.as_chunks_mut::<3>().0.iter_mut().for_each(|corner| corner.swap(1, 2));
        }
        let used = Used::of(&corners);
        let first = draft.room_for(path, used.vertices.len())?;
        for &vertex in &used.vertices {
            let [x, y, z, _] = positions.vector(vertex as usize);
            let position = world.transform_point3(DVec3::new(x, y, z));
            if !is_position(position) {
                let what = format!("vertex {vertex} is not finite or too far away; export it again");
                return Err(malformed(what));
            }
            draft.positions.push(position);
        }
        for &[a, b, c] in corners.as_chunks::<3>().0 {
            let material = match &colours {
                None => material,
                Some(colours) => {
                    let mean = mean_colour(colours, [a, b, c]);
                    let mean = mean.ok_or_else(|| {
                        malformed(format!(
                            "a colour of vertex {a}, {b} or {c} is not finite; export it again"
                        ))
                    })?;
                    self.tints.material(draft, material, mean)
                }
            };
            let vertices = [a, b, c].map(|vertex| first + used.number(vertex));
            let material = match &places {
                None => material,
                Some(places) => {
                    let points = vertices.map(|vertex| draft.positions[vertex as usize]);
                    let at = [a, b, c].map(|vertex| places.place(vertex));
                    if !at.iter().all(|place| place.is_finite()) {
                        let what = format!(
                            "a texture coordinate of vertex {a}, {b} or {c} is not finite; export it again"
                        );
                        return Err(malformed(what));
                    }
                    self.painter.material(draft, material, places.picture(), points, at)
                }
            };
            draft.add_triangle(path, vertices, material)?;
        }
        Ok(())
    }

    fn values(&self, index: Index<Accessor>) -> Result<Values<'a>, String> {
        Values::of(self.root, self.buffers, index)
    }

    /// The triangles of a primitive; none for points and lines.
    fn corners(
        &mut self,
        primitive: &Primitive,
        positions: &Values<'_>,
        place: &str,
    ) -> Result<Option<Corners>, SceneError> {
        let path = self.path;
        let malformed = |what: String| SceneError::parse(path, None, format!("{place}: {what}"));
        let indices = primitive.indices.map(|index| self.values(index)).transpose().map_err(malformed)?;
        if let Some(indices) = &indices {
            let is_whole =
                matches!(indices.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
            if indices.width != 1 || !is_whole || !indices.is_stored() {
                return Err(malformed("indices are no stored whole numbers; export it again".to_owned()));
            }
        }
        let count = indices.as_ref().map_or(positions.count, |indices| indices.count);
        let Checked::Valid(mode) = primitive.mode else {
            return Err(malformed("has a mode that glTF does not know; export it again".to_owned()));
        };
        let skipped = match mode {
            Mode::Points => Some(count),
            Mode::Lines => Some(count / 2),
            Mode::LineLoop => Some(count),
            Mode::LineStrip => Some(count.saturating_sub(1)),
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => None,
        };
        if let Some(skipped) = skipped {
            self.skipped = self.skipped.saturating_add(skipped as u64);
            return Ok(None);
        }
        if !positions.is_stored() && positions.count > MOST_ZEROS {
            let what = format!("claims {} vertices and stores none; export it again", positions.count);
            return Err(malformed(what));
        }
        let triangles = triangles_of(mode, count);
        if mode == Mode::Triangles && count % 3 != 0 {
            return Err(malformed(format!("{count} corners are no triangles; export it again")));
        }
        let corner = |i: usize| {
            let vertex = indices.as_ref().map_or(i as u32, |indices| indices.whole(i));
            match (vertex as usize) < positions.count {
                true => Ok(vertex),
                false => Err(malformed(format!(
                    "index {i} is {vertex}, and there are {} vertices; export it again",
                    positions.count
                ))),
            }
        };
        let order = |i: usize| match mode {
            // Every second triangle of a strip is wound the other way.
            Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Mode::TriangleFan => [i + 1, i + 2, 0],
            _ => [3 * i, 3 * i + 1, 3 * i + 2],
        };
        let corners: Result<Corners, SceneError> = (0..triangles).flat_map(order).map(corner).collect();
        corners.map(Some)
    }
}

/// How many triangles so many corners are.
fn triangles_of(mode: Mode, corners: usize) -> usize {
    match mode {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
        Mode::Triangles => corners / 3,
        Mode::TriangleStrip | Mode::TriangleFan => corners.saturating_sub(2),
    }
}

/// The vertices that a primitive uses, in the order in which it does: primitives often share those of a whole mesh.
struct Used {
    vertices: Vec<u32>,
    /// Each vertex with its place in `vertices`, sorted.
    places: Vec<(u32, u32)>,
}

impl Used {
    fn of(corners: &[u32]) -> Used {
        // By vertex, then by where it comes first.
        let mut places: Vec<(u32, u32)> = corners.iter().copied().zip(0..).collect();
        places.sort_unstable();
        places.dedup_by_key(|&mut (vertex, _)| vertex);
        let mut order: Vec<(u32, u32)> = places.iter().map(|&(vertex, corner)| (corner, vertex)).collect();
        order.sort_unstable();
        let vertices: Vec<u32> = order.into_iter().map(|(_, vertex)| vertex).collect();
        let mut places: Vec<(u32, u32)> = vertices.iter().copied().zip(0..).collect();
        places.sort_unstable();
        Used { vertices, places }
    }

    fn number(&self, vertex: u32) -> u32 {
        let at = self.places.partition_point(|&(other, _)| other < vertex);
        self.places[at].1
    }
}

/// Of the colours of three vertices, linear.
fn mean_colour(colours: &Values<'_>, vertices: [u32; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = vertices.map(|vertex| colours.share(vertex as usize));
    let mean = [0, 1, 2].map(|channel| (a[channel] + b[channel] + c[channel]) / 3.0);
    mean.iter().all(|channel| channel.is_finite()).then_some(mean)
}
