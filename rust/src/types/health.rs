//! Whether the solution can be trusted, and why not.

use bitflags::bitflags;

bitflags! {
    /// Flags not to trust a solution fully.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Flags: u16 {
        /// The start is still being aligned.
        const ALIGNING = 1;
        /// The recording started in motion and the tilt is not if_current yet.
        const MOVING_START = 2;
        /// No zero velocity for too long.
        const NO_ZERO_VELOCITY = 4;
        /// The latest zero velocities contradicted the prediction.
        const UPDATES_REJECTED = 8;
        /// Samples are missing.
        const GAP = 16;
        /// A channel was at its full scale.
        const CLIPPED = 32;
        /// A sample was refused because it was not finite or older than the one before.
        const REFUSED = 64;
        /// No zero velocity, or no sample, for so long that the position means nothing until the
        /// next start; or the filter cannot go on.
        const LOST = 128;
    }
}

/// Trust in a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// Nothing speaks against it.
    Ok,
    /// Something does; see the [`Flags`].
    Degraded,
    /// It is not aligned, or was without a zero velocity for so long that it means nothing.
    #[default]
    Invalid,
}

impl Flags {
    /// The status that these flags amount to.
    #[must_use]
    pub fn status(self) -> Status {
        if self.intersects(Self::ALIGNING | Self::LOST) {
            Status::Invalid
        } else if self.is_empty() {
            Status::Ok
        } else {
            Status::Degraded
        }
    }
}

/// What was counted since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples taken in.
    pub samples: u64,
    /// Samples with the stamp of the one before.
    pub repeated: u64,
    /// Intervals in which samples are missing.
    pub gaps: u64,
    /// Samples with a channel at its full scale.
    pub clipped: u64,
    /// Samples refused as not finite or out of order.
    pub refused: u64,
    /// What the filter was told.
    pub updates: UpdateCounters,
}

/// Observations since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UpdateCounters {
    /// Zero velocities used.
    pub zero_velocity: u64,
    /// Zero velocities rejected by the innovation test.
    pub zero_velocity_rejected: u64,
    /// Zero angular rates used.
    pub zero_angular_rate: u64,
    /// Stances whose magnetic field corrected the heading.
    pub magnetic: u64,
    /// Stances whose magnetic field disagreed with that at the start.
    pub magnetic_rejected: u64,
}

/// What speaks against the newest solution, and what was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// What speaks against it.
    pub flags: Flags,
    /// What was counted since the start.
    pub counters: Counters,
    /// One-sigma horizontal position uncertainty, m (root of the sum of both variances).
    pub horizontal_std: f64,
    /// One-sigma vertical position uncertainty, m.
    pub vertical_std: f64,
}
