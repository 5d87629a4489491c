//! Settings of the magnetic heading.

use crate::limits::Limits;
use crate::settings::settings;

settings! {
    /// Heading updates from a magnetometer.
    ///
    /// The reference is the field of the rest at the start, or else of the first stance with a
    /// reading.  The heading is corrected once in each stance, unless strength, dip or heading of
    /// its field differ too much from the reference.
    pub struct MagnetometerConfig: "magnetometer" {
        /// Whether the magnetic field corrects the heading.  The readings have to be calibrated, see
        /// `docs/accuracy.md`.
        heading: bool = false;
        /// Standard deviation of the heading from the field of a stance: disturbances that strength
        /// and dip do not show.
        std_deg: f64 = 10.0, "degrees", Limits::Between(0.1, 90.0);
        /// Largest relative difference of the field's strength from the reference.
        strength_tolerance: f64 = 0.1, "", Limits::Positive;
        /// Largest difference of the field's dip from the reference.
        dip_tolerance_deg: f64 = 5.0, "degrees", Limits::Positive;
    }
}
