//! Triangles handed over to Embree: buffers that it reads in place, and the committed scene.

use std::ffi::c_void;
use std::sync::Arc;

use embree4_sys as raw;
use glam::Vec3;

use super::{EmbreeError, EmbreeOptions, device::Device};

/// A committed `RTCScene` of one triangle geometry, with the buffers it shares.
#[derive(Debug)]
pub(super) struct TriangleScene {
    scene: raw::RTCScene,
    device: Device,
    /// Shared with Embree, three floats a vertex and at least 16 bytes behind the last one, because it
    /// reads four floats at a time. Never touched again.
    _vertices: Vec<[f32; 3]>,
    /// Shared with Embree, never touched again.
    _triangles: Vec<[u32; 3]>,
}

// SAFETY: after the commit in `new` nothing modifies the scene, its device or the buffers, and Embree
// allows concurrent queries of a committed scene from any thread. The pointers are not tied to the
// thread that made them, so they may also be released on another one. The error log is behind a mutex.
unsafe impl Send for TriangleScene {}
// SAFETY: as above: shared use is queries only.
unsafe impl Sync for TriangleScene {}

impl TriangleScene {
    /// Builds and commits; indices out of range are an error. Triangles keep their ids.
    pub(super) fn new(
        api: &Arc<raw::Api>,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        options: EmbreeOptions,
    ) -> Result<Self, EmbreeError> {
        check_indices(positions, triangles)?;
        let device = Device::new(api, options.threads)
            .map_err(|message| EmbreeError::Failed { during: "making a device", message })?;
        let mut vertices: Vec<[f32; 3]> = Vec::with_capacity(positions.len() + PADDING);
        vertices.extend(positions.iter().map(|p| p.to_array()));
        vertices.extend([[0.0; 3]; PADDING]);

        // SAFETY: the device is valid.
        let scene = unsafe { api.rtcNewScene(device.raw()) };
        // From here on dropping it releases everything, on every path.
        let built = TriangleScene { scene, device, _vertices: vertices, _triangles: triangles.to_vec() };
        if !built.scene.is_null() {
            built.commit(positions.len(), options);
        }
        match built.device.take_error() {
            None if built.scene.is_null() => Err(failed("it made no scene".to_owned())),
            None => Ok(built),
            Some(message) => Err(failed(message)),
        }
    }

    fn commit(&self, vertex_count: usize, options: EmbreeOptions) {
        let api = self.device.api();
        let mut flags = raw::RTCSceneFlags::RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
        if options.robust {
            flags |= raw::RTCSceneFlags::RTC_SCENE_FLAG_ROBUST;
        }
        if options.compact {
            flags |= raw::RTCSceneFlags::RTC_SCENE_FLAG_COMPACT;
        }
        // SAFETY: the scene is valid and not committed yet.
        unsafe { api.rtcSetSceneFlags(self.scene, flags) };
        if !self._triangles.is_empty() {
            self.attach(vertex_count);
        }
        // Joined, not in the task arena of the device: of two devices with one thread the arena of the second leaves a
        // worker of TBB spinning for as long as the device lives (seen with Embree 4.4.0).
        // SAFETY: the scene is valid; its buffers are complete and in range, checked in `new`.
        unsafe { api.rtcJoinCommitScene(self.scene) };
    }

    fn attach(&self, vertex_count: usize) {
        let api = self.device.api();
        let (vertices, triangles) = (&self._vertices, &self._triangles);
        // SAFETY: the device is valid.
        let geometry = unsafe {
            api.rtcNewGeometry(self.device.raw(), raw::RTCGeometryType::RTC_GEOMETRY_TYPE_TRIANGLE)
        };
        if geometry.is_null() {
            return; // the device's error log has it
        }
        // SAFETY: both buffers hold the stated number of 12-byte items, are padded as Embree asks, and
        // live in `self` unmoved and unchanged until the scene is released. The geometry is valid, and
        // after it is attached the scene holds the reference that is released here.
        unsafe {
            api.rtcSetSharedGeometryBuffer(
                geometry,
                raw::RTCBufferType::RTC_BUFFER_TYPE_VERTEX,
                0,
                raw::RTCFormat::RTC_FORMAT_FLOAT3,
                vertices.as_ptr().cast::<c_void>(),
                0,
                size_of::<[f32; 3]>(),
                vertex_count,
            );
            api.rtcSetSharedGeometryBuffer(
                geometry,
                raw::RTCBufferType::RTC_BUFFER_TYPE_INDEX,
                0,
                raw::RTCFormat::RTC_FORMAT_UINT3,
                triangles.as_ptr().cast::<c_void>(),
                0,
                size_of::<[u32; 3]>(),
                triangles.len(),
            );
            api.rtcCommitGeometry(geometry);
            api.rtcAttachGeometryByID(self.scene, geometry, 0);
            api.rtcReleaseGeometry(geometry);
        }
    }

    pub(super) fn raw(&self) -> raw::RTCScene {
        self.scene
    }

    pub(super) fn device(&self) -> &Device {
        &self.device
    }

    pub(super) fn api(&self) -> &raw::Api {
        self.device.api()
    }

    /// What the tree, its device and the shared buffers take.
    pub(super) fn bytes(&self) -> u64 {
        let shared = size_of_val(&self._vertices[..]) + size_of_val(&self._triangles[..]);
        self.device.bytes() + shared as u64
    }

    /// Lower and upper corner of everything in the scene.
    pub(super) fn bounds(&self) -> [Vec3; 2] {
        let mut bounds = raw::RTCBounds {
            lower_x: 0.0,
            lower_y: 0.0,
            lower_z: 0.0,
            align0: 0.0,
            upper_x: 0.0,
            upper_y: 0.0,
            upper_z: 0.0,
            align1: 0.0,
        };
        // SAFETY: the scene is committed; the struct is ours, of the right size and alignment.
        unsafe { self.api().rtcGetSceneBounds(self.scene, &raw mut bounds) };
        [
            Vec3::new(bounds.lower_x, bounds.lower_y, bounds.lower_z),
            Vec3::new(bounds.upper_x, bounds.upper_y, bounds.upper_z),
        ]
    }
}

impl Drop for TriangleScene {
    fn drop(&mut self) {
        if !self.scene.is_null() {
            // SAFETY: the scene is valid and this is the only reference; the device and the buffers are
            // fields, dropped after this.
            unsafe { self.api().rtcReleaseScene(self.scene) };
        }
    }
}

/// Vertices added behind the last one: 24 bytes, at least the 16 that Embree may read.
const PADDING: usize = 2;

fn failed(message: String) -> EmbreeError {
    EmbreeError::Failed { during: "building a scene", message }
}

fn check_indices(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), EmbreeError> {
    if u32::try_from(triangles.len()).is_err() || u32::try_from(positions.len()).is_err() {
        return Err(EmbreeError::Mesh("it has more than 4 294 967 295 triangles or vertices".to_owned()));
    }
    let is_outside = |vertices: &[u32; 3]| vertices.iter().any(|&v| v as usize >= positions.len());
    match triangles.iter().position(is_outside) {
        None => Ok(()),
        Some(id) => Err(EmbreeError::Mesh(format!(
            "triangle {id} uses vertices {:?} of {}",
            triangles[id],
            positions.len()
        ))),
    }
}
