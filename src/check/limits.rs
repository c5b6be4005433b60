//! What a right solution may get wrong. What is exact has one limit; what is an approximation has one for
//! each quality, and a draft may exceed it: it is rough then, not wrong.

/// The largest values that pass; shares are relative to 1. `docs/check.md` gives the reasons at length.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Whether the approximations have to keep their limits.
    pub(super) is_binding: bool,
    /// Light between surfaces that see each other although no link joins them, of all light sent out: rays
    /// that were all blocked are believed where little light rests on them.
    pub(super) unlinked: f64,
    /// Light that links of one kind lose or make against rays, summed over the kinds, of all light sent
    /// out. Kinds can balance each other, so this is less strict than the balance.
    pub(super) by_kind: f64,
    /// Mean relative error of form factors between elements: the quadrature has one or four points.
    pub(super) factor: f64,
    /// Light that one form factor gets wrong, of all light sent out.
    pub(super) one_factor: f64,
    /// Difference of the mean row sum from the share of the hemisphere that rays find covered.
    pub(super) row_sum: f64,
    /// Difference of the row sum of one element from that share, relative to it: both as the root of the mean square. In
    /// open scenes of thin parts, where little is met, it is largest.
    pub(super) single_row: f64,
    /// Difference of the light on a group of surfaces that face alike from what rays bring there, relative to it and
    /// beyond the noise of the rays: root of the mean square.
    pub(super) group: f64,
    /// Light lost or made between leaving one surface and arriving at the next, of all light sent out. No
    /// single cause may bring more of it either: row sums that are too large, light held back because of them.
    pub(super) balance: f64,
}

impl Limits {
    /// For `--quality draft`.
    pub const DRAFT: Limits = Limits {
        is_binding: false,
        unlinked: 0.05,
        by_kind: 0.12,
        factor: 0.02,
        one_factor: 5e-3,
        row_sum: 0.05,
        single_row: 0.25,
        group: 0.2,
        balance: 0.05,
    };

    /// For `--quality normal`.
    pub const NORMAL: Limits = Limits {
        is_binding: true,
        unlinked: 5e-3,
        by_kind: 0.015,
        factor: 5e-3,
        one_factor: 5e-4,
        row_sum: 0.01,
        single_row: 0.15,
        group: 0.05,
        balance: 0.01,
    };

    /// For `--quality high`.
    pub const HIGH: Limits = Limits {
        is_binding: true,
        unlinked: 2.5e-3,
        by_kind: 0.01,
        factor: 5e-3,
        one_factor: 2.5e-4,
        row_sum: 0.01,
        single_row: 0.1,
        group: 0.03,
        balance: 5e-3,
    };
}

/// Blocked segments between nodes that are proved to see each other, of all segments. A proof has no
/// exceptions, but a ray along the edge of an occluder is decided by rounding.
pub(super) const PROOF: f64 = 1e-5;

/// A form factor between elements is a share of a hemisphere; beyond this it is no rounding.
pub(super) const MOST_FACTOR: f32 = 1.001;

/// Light that links carry beyond what would arrive if nothing stood in between, of all light sent out.
/// Rays weigh a source by how bright it is point by point, and the light changes a little afterwards.
pub(super) const UNOBSTRUCTED: f64 = 5e-4;

/// Mean difference between A_i F_ij and A_j F_ji, relative to the mean of both. Of touching elements, both
/// ways are computed over the larger one; of others, the smaller one is described by a few points.
pub(super) const RECIPROCITY: f64 = 5e-3;

/// Largest relative difference between an exitance and emission + reflectance × irradiance: single
/// precision.
pub(super) const REFLECTION: f64 = 1e-6;

/// Irradiance that is not what the links carry, of all light sent out: what still changes.
pub(super) const RESIDUAL: f64 = 1e-3;

/// Light that is lost or made on all its way, of the emitted, although what links lose or make is made up for.
pub(super) const LOST: f64 = 0.01;

/// What links lose or make of it before, of the emitted: from here on a solution warns.
pub const UNBALANCED: f64 = 0.05;

/// Power that still changed in the last iteration, of the emitted: from here on a solution warns.
pub const UNSETTLED: f64 = 0.01;
