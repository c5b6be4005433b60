//! Meshes of the formats that others write, glTF and PLY, as scenes: what is read, what is left out with a warning, what is
//! refused and with which words. All files are made here.

mod files;
mod gltf;
mod gltf_places;
mod gltf_refused;
mod painted_light;
mod ply;
mod round_trip;
mod textures;
