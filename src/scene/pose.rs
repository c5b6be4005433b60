//! How a camera stands, and whether it can see like that.

use glam::DVec3;

/// Why a camera sees nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PoseFault {
    /// It looks at where it stands.
    NoView,
    /// Up has no direction.
    NoUp,
    /// Up is along the view.
    UpAlongView,
}

impl PoseFault {
    /// What is wrong and what to do.
    pub(super) fn message(self) -> &'static str {
        match self {
            PoseFault::NoView => "eye and target are the same point; move one of them",
            PoseFault::NoUp => "up is zero; write a direction such as [0, 1, 0]",
            PoseFault::UpAlongView => "up is parallel to the view direction; choose another up",
        }
    }
}

/// What is wrong with a camera at `eye` that looks at `target`, if anything is; all of it finite.
pub(super) fn pose_fault(eye: DVec3, target: DVec3, up: DVec3) -> Option<PoseFault> {
    let view = target - eye;
    if view.length() <= 1e-12 * eye.abs().max(target.abs()).max_element() {
        return Some(PoseFault::NoView);
    }
    if up.length() == 0.0 {
        return Some(PoseFault::NoUp);
    }
    (view.normalize().cross(up.normalize()).length() < 1e-6).then_some(PoseFault::UpAlongView)
}
