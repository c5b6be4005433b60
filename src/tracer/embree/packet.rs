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
}

impl Lane {
    /// Whether it can be traced at all; anything else is left out of the query and hits nothing.
    #[inline]
    pub(super) fn is_valid(&self) -> bool {
        self.origin.is_finite() & self.direction.is_finite() & (self.direction != Vec3::ZERO)
    }

    /// A lone ray with id 0, of which the part between these shares of the direction counts.
    pub(super) fn ray(&self, [near, far]: [f32; 2]) -> raw::RTCRay {
        raw::RTCRay {
            org_x: self.origin.x,
            org_y: self.origin.y,
            org_z: self.origin.z,
            tnear: near,
            dir_x: self.direction.x,
            dir_y: self.direction.y,
            dir_z: self.direction.z,
            time: 0.0,
            tfar: far,
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }
}

/// Sixteen lanes; ray `i` has id `i`, and lanes without a valid ray are inactive. `part` tells from a ray's squared length
/// between which shares of it hits count.
#[inline]
pub(super) fn packet(
    lanes: impl Iterator<Item = Lane>,
    part: impl Fn(f32) -> [f32; 2],
) -> (ActiveLanes, raw::RTCRay16) {
    let (mut active, mut rays) = (ActiveLanes([0; PACKET]), NO_RAYS);
    for (i, lane) in lanes.take(PACKET).enumerate() {
        let is_valid = lane.is_valid();
        let Lane { origin, direction } = if is_valid { lane } else { NO_LANE };
        active.0[i] = -i32::from(is_valid);
        [rays.org_x[i], rays.org_y[i], rays.org_z[i]] = origin.to_array();
        [rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]] = direction.to_array();
    }
    // A loop of its own, which compilers make one of vectors.
    for i in 0..PACKET {
        let direction = Vec3::new(rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]);
        [rays.tnear[i], rays.tfar[i]] = part(direction.length_squared());
    }
    (active, rays)
}

const NO_LANE: Lane = Lane { origin: Vec3::ZERO, direction: Vec3::Z };

const NO_RAYS: raw::RTCRay16 = raw::RTCRay16 {
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
    id: [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15],
    flags: [0; PACKET],
};

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
