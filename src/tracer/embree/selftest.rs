//! Before the first real ray: does the library read and write structs of our size, does it hit what
//! is there, does it call the filter. Run on two triangles, takes less than a millisecond.

use std::{ffi::c_void, ptr, sync::Arc};

use embree4_sys as raw;
use glam::Vec3;

use super::{
    EmbreeOptions,
    error::Refusal,
    filter::FilterContext,
    packet::{ActiveLanes, Lane, packet},
    scene::TriangleScene,
};
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET};

/// A self-test that was passed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelfTest {
    /// What was tested.
    pub name: &'static str,
    /// What was seen.
    pub message: String,
}

type Test = fn(&TriangleScene) -> Result<String, String>;

const TESTS: [(&str, Test); 6] = [
    ("scene bounds", bounds_fit),
    ("struct of one ray", |scene| guard_holds(scene, GuardedQuery::One, size_of::<raw::RTCRayHit>())),
    ("struct of 16 rays", |scene| guard_holds(scene, GuardedQuery::Sixteen, size_of::<raw::RTCRayHit16>())),
    ("closest hit", closest_hit_is_right),
    ("filter of one ray", |scene| filter_fires(scene, GuardedQuery::One)),
    ("filter of 16 rays", |scene| filter_fires(scene, GuardedQuery::Sixteen)),
];

/// Runs all of them; the first failure is the reason to refuse the library.
pub(super) fn run(api: &Arc<raw::Api>) -> Result<Vec<SelfTest>, Refusal> {
    let scene = two_triangles(api)?;
    TESTS
        .iter()
        .map(|&(name, test)| {
            let outcome = test(&scene).and_then(|message| match scene.device().take_error() {
                None => Ok(message),
                Some(error) => Err(error),
            });
            match outcome {
                Ok(message) => Ok(SelfTest { name, message }),
                Err(message) => Err(Refusal::SelfTest { name, message }),
            }
        })
        .collect()
}

/// Two parallel triangles across the z axis, at z = 1 and z = 2.
pub(super) fn two_triangles(api: &Arc<raw::Api>) -> Result<TriangleScene, Refusal> {
    let corners = [(-1.0, -1.0), (3.0, -1.0), (-1.0, 3.0)];
    let positions: Vec<Vec3> =
        [1.0, 2.0].iter().flat_map(|&z| corners.map(|(x, y)| Vec3::new(x, y, z))).collect();
    let options = EmbreeOptions { threads: 1, robust: true, compact: false };
    TriangleScene::new(api, &positions, &[[0, 1, 2], [3, 4, 5]], options)
        .map_err(|error| Refusal::SelfTest { name: "building a scene", message: error.to_string() })
}

/// From the origin along the z axis, `t` from 0 to 1 up to z = 4: hits at 0.25 and 0.5.
fn probe() -> Lane {
    Lane { origin: Vec3::ZERO, direction: Vec3::new(0.0, 0.0, 4.0) }
}

/// The part of it that counts.
const PART: [f32; 2] = [1e-4, 1.0 - 1e-4];

fn bounds_fit(scene: &TriangleScene) -> Result<String, String> {
    let expected = [Vec3::new(-1.0, -1.0, 1.0), Vec3::new(3.0, 3.0, 2.0)];
    let bounds = scene.bounds();
    let is_close = |i: usize| bounds[i].abs_diff_eq(expected[i], 1e-5);
    if is_close(0) && is_close(1) {
        Ok("as built".to_owned())
    } else {
        Err(format!("{:?} instead of {expected:?}", bounds))
    }
}

fn closest_hit_is_right(scene: &TriangleScene) -> Result<String, String> {
    let mut query = raw::RTCRayHit { ray: probe().ray(PART), hit: no_hit() };
    // SAFETY: the scene is committed, the struct is ours; null arguments are the defaults.
    unsafe { scene.api().rtcIntersect1(scene.raw(), &raw mut query, ptr::null_mut()) };
    let (t, hit) = (query.ray.tfar, &query.hit);
    if hit.geomID == 0 && hit.primID == 0 && (t - 0.25).abs() < 1e-6 {
        Ok("the right triangle at the right distance".to_owned())
    } else {
        Err(format!("triangle {} of geometry {} at {t} instead of 0 of 0 at 0.25", hit.primID, hit.geomID))
    }
}

fn no_hit() -> raw::RTCHit {
    raw::RTCHit {
        Ng_x: 0.0,
        Ng_y: 0.0,
        Ng_z: 0.0,
        u: 0.0,
        v: 0.0,
        primID: u32::MAX,
        geomID: u32::MAX,
        instID: [u32::MAX],
        instPrimID: [u32::MAX],
    }
}

/// Which function is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GuardedQuery {
    /// `rtcIntersect1` or `rtcOccluded1`.
    One,
    /// `rtcIntersect16` or `rtcOccluded16`.
    Sixteen,
}

/// Room for the struct and what is written behind it by a library with larger structs: 16 lanes of
/// up to eight instance levels more.
#[repr(C, align(64))]
struct Guarded([u8; GUARDED_BYTES]);

const GUARDED_BYTES: usize = 4096;
const GUARD: u8 = 0xA5;

/// Whether a closest-hit query stays inside a struct of `struct_size` bytes. The struct lies in a
/// larger buffer whose other bytes hold a pattern, so that a query that writes past its end changes
/// the pattern and nothing else.
pub(super) fn guard_holds(
    scene: &TriangleScene,
    query: GuardedQuery,
    struct_size: usize,
) -> Result<String, String> {
    let mut guarded = Guarded([GUARD; GUARDED_BYTES]);
    let start = guarded.0.as_mut_ptr();
    match query {
        GuardedQuery::One => {
            debug_assert!(struct_size >= size_of::<raw::RTCRay>());
            guarded.0[..struct_size].fill(0);
            // SAFETY: the buffer is larger and more aligned than RTCRayHit; the query reads and writes
            // only in it, even if the library's struct were as large as the buffer.
            unsafe {
                start.cast::<raw::RTCRay>().write(probe().ray(PART));
                set_no_geometry(start, size_of::<raw::RTCRay>(), 1);
                scene.api().rtcIntersect1(scene.raw(), start.cast(), ptr::null_mut());
            }
        }
        GuardedQuery::Sixteen => {
            debug_assert!(struct_size >= size_of::<raw::RTCRay16>());
            guarded.0[..struct_size].fill(0);
            let (active, rays) = packet(std::iter::repeat_n(probe(), PACKET), |_| PART);
            // SAFETY: as above, for RTCRayHit16.
            unsafe {
                start.cast::<raw::RTCRay16>().write(rays);
                set_no_geometry(start, size_of::<raw::RTCRay16>(), PACKET);
                intersect16(scene, &active, start.cast());
            }
        }
    }
    match guarded.0[struct_size..].iter().position(|&byte| byte != GUARD) {
        None => Ok(format!("nothing written beyond its {struct_size} bytes")),
        Some(offset) => Err(format!(
            "the library wrote past the end of the struct of {struct_size} bytes, at byte {}",
            struct_size + offset
        )),
    }
}

/// Marks the hits behind `ray_size` bytes of rays as "none yet": row 6 of N words is `geomID`.
///
/// # Safety
/// `start` points to at least `ray_size + 28 * lanes` writable bytes, aligned for `u32`.
unsafe fn set_no_geometry(start: *mut u8, ray_size: usize, lanes: usize) {
    for lane in 0..lanes {
        // SAFETY: within the bytes the caller vouches for.
        unsafe { start.add(ray_size).cast::<u32>().add(6 * lanes + lane).write(u32::MAX) };
    }
}

/// # Safety
/// `query` points to a packet aligned to 64 bytes, with room for all that the library writes.
unsafe fn intersect16(scene: &TriangleScene, active: &ActiveLanes, query: *mut c_void) {
    // SAFETY: the scene is committed; the packet is as the caller says.
    unsafe {
        scene.api().rtcIntersect16(active.0.as_ptr(), scene.raw(), query.cast(), ptr::null_mut());
    }
}

/// Both triangles are offered when all are rejected, and an accepted one is recorded.
fn filter_fires(scene: &TriangleScene, query: GuardedQuery) -> Result<String, String> {
    let lanes = if query == GuardedQuery::One { 1 } else { PACKET };
    let blocked = |candidates| {
        let mut audit = FilterAudit::default();
        let mut context = FilterContext::new(&[0, 1], candidates, &mut audit);
        let this = &raw mut context;
        let mut arguments = FilterContext::arguments(this);
        // SAFETY: the scene is committed, rays and arguments are ours and aligned by their types, and
        // `this` is the only way to the context until the calls return.
        unsafe {
            if query == GuardedQuery::One {
                let mut ray = probe().ray(PART);
                scene.api().rtcOccluded1(scene.raw(), &raw mut ray, &raw mut arguments);
            } else {
                let (active, mut rays) = packet(std::iter::repeat_n(probe(), PACKET), |_| PART);
                let active = active.0.as_ptr();
                scene.api().rtcOccluded16(active, scene.raw(), &raw mut rays, &raw mut arguments);
            }
            let context = &*this;
            let blocked = context.blockers[..lanes].iter().filter(|&&facet| facet != NO_FACET).count();
            (blocked, context.audit.calls)
        }
    };
    let (accepted, calls) = blocked(Candidates::All);
    if accepted != lanes || calls == 0 {
        return Err(format!("{accepted} of {lanes} rays were blocked, after {calls} calls"));
    }
    let (accepted, calls) = blocked(Candidates::Only(&[]));
    if accepted != 0 || calls < 2 * lanes as u64 {
        return Err(format!("with every hit rejected {accepted} rays were blocked, after {calls} calls"));
    }
    Ok("called for each hit, and its answer is followed".to_owned())
}
