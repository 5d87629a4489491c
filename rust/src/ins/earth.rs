//! Gravity and rotation of the Earth in the local level frame.
//!
//! # References
//! NIMA TR8350.2, "Department of Defense World Geodetic System 1984", 3rd ed., 2000: eq. 4-1
//! (Somigliana) and eq. 4-3 (height).

use nalgebra::Vector3;

/// Semi-major axis of the WGS-84 ellipsoid, m.
const SEMI_MAJOR_AXIS: f64 = 6_378_137.0;
/// Flattening of the WGS-84 ellipsoid.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Rotation rate of the Earth, rad/s.
const ROTATION_RATE: f64 = 7.292_115e-5;
/// Normal gravity at the equator, m/s².
const EQUATORIAL_GRAVITY: f64 = 9.780_325_335_9;
/// Somigliana's constant k.
const SOMIGLIANA: f64 = 0.001_931_852_652_41;
/// Ratio m of centrifugal to gravitational acceleration at the equator.
const CENTRIFUGAL_RATIO: f64 = 0.003_449_786_506_84;

/// WGS-84 normal gravity (m/s²) at a geodetic latitude (rad) and ellipsoidal height (m).
#[must_use]
pub fn normal_gravity(latitude: f64, height: f64) -> f64 {
    let sin2 = latitude.sin().powi(2);
    let eccentricity2 = FLATTENING * (2.0 - FLATTENING);
    let on_ellipsoid =
        EQUATORIAL_GRAVITY * (1.0 + SOMIGLIANA * sin2) / (1.0 - eccentricity2 * sin2).sqrt();
    let h = height / SEMI_MAJOR_AXIS;
    on_ellipsoid
        * (1.0 - 2.0 * (1.0 + FLATTENING + CENTRIFUGAL_RATIO - 2.0 * FLATTENING * sin2) * h
            + 3.0 * h * h)
}

/// Rotation rate of the Earth in east-north-up axes (rad/s) at a geodetic latitude (rad).
#[must_use]
pub fn rotation_rate(latitude: f64) -> Vector3<f64> {
    ROTATION_RATE * Vector3::new(0.0, latitude.cos(), latitude.sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_gravity_matches_the_defining_values_of_wgs84() {
        // TR8350.2, table 3.4: gravity at the equator and at the pole.
        assert!((normal_gravity(0.0, 0.0) - 9.780_325_335_9).abs() < 1e-12);
        assert!((normal_gravity(std::f64::consts::FRAC_PI_2, 0.0) - 9.832_184_937_8).abs() < 1e-9);
    }

    #[test]
    fn gravity_falls_by_three_micrometres_per_second_squared_and_metre() {
        let gradient = (normal_gravity(0.8, 1.0) - normal_gravity(0.8, -1.0)) / 2.0;
        assert!((gradient + 3.086e-6).abs() < 5e-9, "{gradient}");
    }

    #[test]
    fn the_earth_turns_once_in_a_sidereal_day() {
        let day = std::f64::consts::TAU / rotation_rate(0.7).norm();
        assert!((day - 86_164.1).abs() < 0.1);
        assert!(rotation_rate(-0.7).z < 0.0);
    }
}
