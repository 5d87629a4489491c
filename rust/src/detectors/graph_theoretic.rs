//! A change in the middle of the window: the memory-based graph-theoretic detector (MBGTD).
//!
//! The samples of a window are the nodes of a graph whose edges are as long as the specific forces
//! are apart.  Wherever the window is cut in two, the edges between the parts are compared with
//! those within them; while the foot rests no cut tells the parts apart.  The statistic is
//!
//! ```text
//! T = max over cuts of ( mean |f_i - f_l| between the parts - mean |f_i - f_l| within them )
//! ```
//!
//! # References
//! - Olivares, Ramírez, Górriz, Olivares, Damas, "Detection of (In)activity Periods in Human Body
//!   Motion Using Inertial Sensors: A Comparative Study", Sensors 12(5):5791, 2012: memory-based
//!   detectors.
//! - Wagstaff, Peretroukhin, Kelly, "Robust Data-Driven Zero-Velocity Detection for Foot-Mounted
//!   Inertial Navigation", IEEE Sensors J. 20(2), 2020: MBGTD among the detectors for a foot.
//!
//! Neither prints how the edges are normalized; here each mean is over the number of its edges.

use nalgebra::Vector3;

use crate::detectors::detector::{Decision, Detector, DetectorSettings, max_nan};
use crate::detectors::latency_counter::LatencyCounter;
use crate::detectors::sliding_window::{WINDOW_LIMITS, Window};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::rate::number;
use crate::types::sample::ImuSample;

settings! {
    /// Contrast of the specific force between the parts of a window (MBGTD).
    ///
    /// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's
    /// IMU.
    pub struct GraphTheoreticConfig: "detector" {
        /// Length of the window.
        window: f64 = 0.15, "s", WINDOW_LIMITS;
        /// Mean distance between the parts less that within them, largest over the cuts, up to
        /// which a sample is stationary.
        threshold: f64 = 0.3, "m/s²", Limits::Positive;
    }
}

impl DetectorSettings for GraphTheoreticConfig {
    fn build(&self, rate_hz: f64, _: f64) -> Box<dyn Detector> {
        Box::new(GraphTheoretic::new(self, rate_hz))
    }
}

/// Stationary where no cut of the window tells its parts apart.
#[derive(Clone, Debug)]
pub(crate) struct GraphTheoretic {
    window: Window<3>,
    latency_counter: LatencyCounter,
    threshold: f64,
    /// Of each sample of the window: length of its edges to the samples before and after it.
    edges: Vec<(f64, f64)>,
}

impl GraphTheoretic {
    pub(crate) fn new(config: &GraphTheoreticConfig, rate_hz: f64) -> Self {
        let window = Window::new(config.window, rate_hz);
        Self {
            latency_counter: LatencyCounter::new(window.half()),
            window,
            threshold: config.threshold,
            edges: Vec::new(),
        }
    }

    /// NaN while the window is not full.
    fn statistic(&mut self) -> f64 {
        let Self { window, edges, .. } = self;
        edges.clear();
        edges.resize(window.rows().count(), (0.0, 0.0));
        let mut total = 0.0;
        for (i, first) in window.rows().enumerate() {
            for (l, second) in window.rows().enumerate().skip(i + 1) {
                let edge = (Vector3::from(*first) - Vector3::from(*second)).norm();
                edges[l].0 += edge;
                edges[i].1 += edge;
                total += edge;
            }
        }
        greatest_contrast(edges, total)
    }
}

/// Over all cuts, the most by which the mean edge between the parts exceeds that within them.
fn greatest_contrast(edges: &[(f64, f64)], total: f64) -> f64 {
    let (mut before, mut after, mut left, mut right) = (0.0, total, 0.0, number(edges.len()));
    let mut greatest = f64::NEG_INFINITY;
    for (to_earlier, to_later) in &edges[..edges.len() - 1] {
        before += to_earlier;
        after -= to_later;
        left += 1.0;
        right -= 1.0;
        let pairs_within = 0.5 * (left * (left - 1.0) + right * (right - 1.0));
        let contrast = (total - before - after) / (left * right) - (before + after) / pairs_within;
        greatest = max_nan(greatest, contrast);
    }
    greatest
}

impl Detector for GraphTheoretic {
    fn latency(&self) -> usize {
        self.latency_counter.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        self.window.push(sample.specific_force.into());
        self.latency_counter
            .push()
            .then(|| Decision::threshold_at(self.threshold, self.statistic()))
    }

    fn drain(&mut self) -> Option<Decision> {
        self.latency_counter.drain().map(|_| Decision::UNKNOWN)
    }

    fn reset(&mut self) {
        self.window.reset();
        self.latency_counter.reset();
    }
}
