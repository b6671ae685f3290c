//! The numbers of the audit that no law and no statistics give.
//!
//! They were set by hand while recordings were audited; no test on record set them one by one. The tests of `gripd check`
//! and the concealed effects (tests/concealed) judge them together.

/// See [`TUNING`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Tuning {
    /// Cost of the first flipped sign …
    pub(super) first_flip: f64,
    /// … and of others with it: a whole sensor box or a whole convention is turned round.
    pub(super) further_flip: f64,
    /// Cost of swapped wheels of an axle: they are rarely mixed up …
    pub(super) swapped_axle: f64,
    /// … and of both axles.
    pub(super) both_axles: f64,
    /// Two explanations whose costs are nearer than this cannot be told apart.
    pub(super) clearly: f64,
    /// A scale that is off by less does no harm (logarithmic).
    pub(super) harmless_scale: f64,
    /// A delay as long as this, s, is mentioned from [`SUSPECTED`](super::attribution::SUSPECTED) on.
    pub(super) long_s: f64,
    /// A relation that explains less tells of no delay: whatever else is in it may look late.
    pub(super) told_late: f64,
    /// Where a delay leaves more than the rest of a relation unexplained, something else may have feigned it.
    pub(super) put_right: f64,
    /// A delay below this is ordinary, s …
    pub(super) ordinary_s: f64,
    /// … and above this it is none of it, s.
    pub(super) extraordinary_s: f64,
    /// Torques are known by maps: only a scale that is off by more is worth a word (logarithmic).
    pub(super) torque_map: f64,
    /// A relation must explain this share of the acceleration to be believed.
    pub(super) explained: f64,
    /// So many times the bound of an offset is beyond any road, too.
    pub(super) beyond_roads: f64,
}

/// All of them.
pub(super) const TUNING: Tuning = Tuning {
    first_flip: 1.0,
    further_flip: 0.5,
    swapped_axle: 2.0,
    both_axles: 2.5,
    clearly: 0.9,
    harmless_scale: 0.015,
    long_s: 0.025,
    told_late: 0.5,
    put_right: 0.95,
    ordinary_s: 0.012,
    extraordinary_s: 0.02,
    torque_map: 0.35,
    explained: 0.2,
    beyond_roads: 6.0,
};
