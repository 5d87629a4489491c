//! Settings of the strapdown mechanization.

use crate::ins::strapdown::MechanizationKind;
use crate::limits::Limits;
use crate::settings::settings;

settings! {
    /// The strapdown integration, and the gravity and Earth rate that it uses.
    pub struct MechanizationConfig: "mechanization" {
        /// Form of the update.
        kind: MechanizationKind = MechanizationKind::TwoSample;
        /// Whether the rotation of the Earth is taken into account; needs a heading.
        earth_rate: bool = false;
        /// Gravity; from latitude and height when absent.
        gravity: Option<f64> = None, "m/s²", Limits::Between(9.0, 10.5);
        /// Geodetic latitude; from `output.origin`, or else 45 degrees, when absent.
        latitude_deg: Option<f64> = None, "degrees", Limits::Between(-90.0, 90.0);
        /// Height above the ellipsoid; from `output.origin`, or else 0 m, when absent.
        height: Option<f64> = None, "m", Limits::Between(-12_000.0, 100_000.0);
    }
}
