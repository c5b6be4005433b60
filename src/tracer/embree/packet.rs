//! Rays as Embree wants them: packets of 16, or one.

use embree4_sys as raw;
use glam::Vec3;

use crate::tracer::PACKET;

/// Which lanes of a packet hold a ray: −1 or 0, aligned as a packet of 16 must be.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(super) struct ActiveLanes(pub(super) [i32; PACKET]);

/// One ray or segment before it goes into a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lane {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) near: f32,
    pub(super) far: f32,
}

impl Lane {
    /// Holds no ray.
    pub(super) const IDLE: Lane = Lane { origin: Vec3::ZERO, direction: Vec3::ZERO, near: 0.0, far: 0.0 };

    /// Whether it can be traced at all; anything else is left out of the query and hits nothing.
    pub(super) fn is_valid(&self) -> bool {
        self.origin.is_finite() && self.direction.is_finite() && self.direction != Vec3::ZERO
    }

    /// A lone ray with that id.
    pub(super) fn ray(&self, id: u32) -> raw::RTCRay {
        raw::RTCRay {
            org_x: self.origin.x,
            org_y: self.origin.y,
            org_z: self.origin.z,
            tnear: self.near,
            dir_x: self.direction.x,
            dir_y: self.direction.y,
            dir_z: self.direction.z,
            time: 0.0,
            tfar: self.far,
            mask: u32::MAX,
            id,
            flags: 0,
        }
    }
}

/// Sixteen lanes; ray `i` has id `i`, and lanes without a valid ray are inactive.
pub(super) fn packet(lanes: impl Iterator<Item = Lane>) -> (ActiveLanes, raw::RTCRay16) {
    let mut active = ActiveLanes([0; PACKET]);
    let mut rays = raw::RTCRay16 {
        org_x: [0.0; PACKET],
        org_y: [0.0; PACKET],
        org_z: [0.0; PACKET],
        tnear: [0.0; PACKET],
        dir_x: [0.0; PACKET],
        dir_y: [0.0; PACKET],
        dir_z: [1.0; PACKET],
        time: [0.0; PACKET],
        tfar: [0.0; PACKET],
        mask: [u32::MAX; PACKET],
        id: std::array::from_fn(|lane| lane as u32),
        flags: [0; PACKET],
    };
    for (i, lane) in lanes.take(PACKET).enumerate().filter(|(_, lane)| lane.is_valid()) {
        active.0[i] = -1;
        [rays.org_x[i], rays.org_y[i], rays.org_z[i]] = lane.origin.to_array();
        [rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]] = lane.direction.to_array();
        rays.tnear[i] = lane.near;
        rays.tfar[i] = lane.far;
    }
    (active, rays)
}

/// A hit that is none yet, in every lane.
pub(super) fn no_hit16() -> raw::RTCHit16 {
    raw::RTCHit16 {
        Ng_x: [0.0; PACKET],
        Ng_y: [0.0; PACKET],
        Ng_z: [0.0; PACKET],
        u: [0.0; PACKET],
        v: [0.0; PACKET],
        primID: [u32::MAX; PACKET],
        geomID: [u32::MAX; PACKET],
        instID: [[u32::MAX; PACKET]],
        instPrimID: [[u32::MAX; PACKET]],
    }
}
