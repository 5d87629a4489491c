//! Settings of the smoothers.

use crate::limits::Limits;
use crate::settings::{choices, settings};

choices! {
    /// Later samples that a state is estimated from.
    pub enum SmootherKind {
        /// None.
        None = "none",
        /// Those of its step (Colomar et al. 2012): works in a stream, with a delay.
        Stepwise = "stepwise",
        /// All (Rauch, Tung, Striebel 1965): needs the whole recording.
        Rts = "rts",
    }
}

settings! {
    /// Smoothing: states estimated from later samples as well.
    pub struct SmootherConfig: "smoother" {
        /// Later samples that a state is estimated from.
        kind: SmootherKind = SmootherKind::None;
        /// Longest step that the step-wise smoother smooths as a whole: its delay in a stream.
        longest_step: f64 = 2.0, "s", Limits::Between(0.1, 60.0);
    }
}
