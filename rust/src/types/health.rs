//! Quality flags of a solution, and the status that they amount to.

use bitflags::bitflags;

bitflags! {
    /// Quality flags of a solution: each is a reason to trust it less.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Flags: u16 {
        /// The start is still being aligned.
        const ALIGNING = 1;
        /// The recording started in motion and the tilt has not converged yet.
        const MOVING_START = 2;
        /// No zero-velocity update for too long.
        const NO_ZERO_VELOCITY = 4;
        /// The latest zero-velocity updates were rejected.
        const UPDATES_REJECTED = 8;
        /// Samples are missing.
        const GAP = 16;
        /// A channel was at its full scale.
        const CLIPPED = 32;
        /// A sample was refused because it was not finite or older than the one before.
        const REFUSED = 64;
        /// No zero-velocity update, or no sample, for so long that the position is lost until the
        /// next start; or the filter failed.
        const LOST = 128;
    }
}

/// Status of a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// No flag is set.
    Ok,
    /// A flag is set.
    Degraded,
    /// It is not aligned, or lost.
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
