//! The path of a simulated walk.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::error::ConfigError;
use crate::limits;

/// Maximum length of a route, m.
const MAX_LENGTH: f64 = 100_000.0;
/// Number of legs in each circle of a figure of eight.
const LEGS_PER_CIRCLE: u32 = 64;
/// Length of the level path to the foot of the stairs, m.
const APPROACH: f64 = 2.0;
/// Length and width of a landing between two flights, m.
const LANDING: f64 = 1.2;
/// Number of risers per stride.
const RISERS_PER_STRIDE: u32 = 2;

/// A waypoint of a route.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Waypoint {
    /// Position of the sole, n frame, m.
    pub position: Vector3<f64>,
    /// Whether the leg to this waypoint is a single stride onto a stair tread; otherwise it is
    /// divided into strides of the gait's length.
    pub tread: bool,
    /// Whether the leg to this waypoint is a vertical lift ride with the foot standing.
    pub lift: bool,
}

/// A polyline on the ground, in n (x, y horizontal, z up).
///
/// The initial heading is along the first leg.  The default is a square of 10 m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Route {
    /// The waypoints in order; the first is the start.
    pub waypoints: Vec<Waypoint>,
}

impl Default for Route {
    fn default() -> Self {
        Self::square(10.0)
    }
}

impl Route {
    /// Straight legs between points (x, y, z in n, m).
    #[must_use]
    pub fn from_waypoints(points: &[[f64; 3]]) -> Self {
        let waypoints =
            points.iter().map(|&point| Waypoint { position: point.into(), ..Waypoint::default() });
        Self { waypoints: waypoints.collect() }
    }

    /// A straight line along x of `length` (m).
    #[must_use]
    pub fn straight(length: f64) -> Self {
        Self::from_waypoints(&[[0.0; 3], [length, 0.0, 0.0]])
    }

    /// One anticlockwise lap of a square of side `side` (m).
    #[must_use]
    pub fn square(side: f64) -> Self {
        Self::rectangle(side, side)
    }

    /// One anticlockwise lap of a rectangle of `length` along x and `width` along y (m).
    #[must_use]
    pub fn rectangle(length: f64, width: f64) -> Self {
        Self::from_waypoints(&[
            [0.0; 3],
            [length, 0.0, 0.0],
            [length, width, 0.0],
            [0.0, width, 0.0],
            [0.0; 3],
        ])
    }

    /// A straight line along x of `length` (m), a turn in place by 180 degrees, and the same line
    /// back.
    #[must_use]
    pub fn out_and_back(length: f64) -> Self {
        Self::from_waypoints(&[[0.0; 3], [length, 0.0, 0.0], [0.0; 3]])
    }

    /// Two circles tangent at the start, the first to the left and the second to the right, of the
    /// total length `length` (m).
    #[must_use]
    pub fn figure_of_eight(length: f64) -> Self {
        let legs = f64::from(LEGS_PER_CIRCLE);
        let radius = length / (4.0 * legs * (PI / legs).sin());
        let circle = |side: f64| {
            (1..=LEGS_PER_CIRCLE).map(move |k| {
                let angle = TAU * f64::from(k) / legs;
                [radius * angle.sin(), side * radius * (1.0 - angle.cos()), 0.0]
            })
        };
        let points: Vec<_> =
            std::iter::once([0.0; 3]).chain(circle(1.0)).chain(circle(-1.0)).collect();
        Self::from_waypoints(&points)
    }

    /// A stairwell of `floors` flights of `risers` each, with a landing and a turn by 180 degrees
    /// between flights.
    ///
    /// `riser` is the height of a riser and `tread` the depth of a tread (m); a negative `riser`
    /// descends.  The foot steps on every second tread and on the last.
    #[must_use]
    pub fn stairs(floors: u32, risers: u32, riser: f64, tread: f64) -> Self {
        let mut stairwell = Stairwell::at_the_foot();
        for floor in 0..floors {
            if floor > 0 {
                stairwell.turn_on_landing();
            }
            stairwell.climb(risers, riser, tread);
        }
        stairwell.leave()
    }

    /// Length along the polyline, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.waypoints.windows(2).map(|leg| (leg[1].position - leg[0].position).norm()).sum()
    }

    /// Checks that the route is valid.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`] for fewer than two waypoints, a waypoint that is not finite, a
    /// walked leg without horizontal extent, a lift ride that is not vertical or onto a tread, or
    /// a route longer than 100 km.
    pub fn validate(&self) -> Result<(), ConfigError> {
        const KEY: &str = "route.waypoints";
        let invalid = |value: String, expected: &'static str| {
            Err(ConfigError::OutOfRange { key: KEY, value, expected: expected.into() })
        };
        if self.waypoints.len() < 2 {
            return invalid(format!("{} waypoints", self.waypoints.len()), "at least 2 waypoints");
        }
        for waypoint in &self.waypoints {
            limits::finite(KEY, waypoint.position.as_slice())?;
        }
        for (k, leg) in self.waypoints.windows(2).enumerate() {
            let displacement = leg[1].position - leg[0].position;
            if leg[1].lift && (leg[1].tread || !is_vertical(&displacement)) {
                return invalid(
                    format!("leg {k} by lift to {:?}", leg[1]),
                    "a lift straight up or down, not to a tread",
                );
            }
            if !leg[1].lift && displacement.xy().norm() == 0.0 {
                return invalid(
                    format!("leg {k} without horizontal extent"),
                    "each waypoint apart from the one before it",
                );
            }
        }
        limits::within(KEY, self.length(), 0.0..=MAX_LENGTH, "a length of at most 100000 m")
    }
}

/// Whether a displacement is vertical.
fn is_vertical(displacement: &Vector3<f64>) -> bool {
    displacement.xy().norm() == 0.0 && displacement.z != 0.0
}

/// Builds the waypoints of a stairwell.
struct Stairwell {
    waypoints: Vec<Waypoint>,
    position: Vector3<f64>,
    forward: Vector3<f64>,
}

impl Stairwell {
    fn at_the_foot() -> Self {
        let mut stairwell =
            Self { waypoints: Vec::new(), position: Vector3::zeros(), forward: Vector3::x() };
        stairwell.advance(Vector3::zeros(), false);
        stairwell.advance(APPROACH * Vector3::x(), false);
        stairwell
    }

    fn advance(&mut self, displacement: Vector3<f64>, tread: bool) {
        self.position += displacement;
        self.waypoints.push(Waypoint { position: self.position, tread, lift: false });
    }

    fn climb(&mut self, risers: u32, riser: f64, tread: f64) {
        let mut left = risers;
        while left > 0 {
            let taken = left.min(RISERS_PER_STRIDE);
            self.advance(f64::from(taken) * (tread * self.forward + riser * Vector3::z()), true);
            left -= taken;
        }
    }

    fn turn_on_landing(&mut self) {
        self.advance(LANDING * self.forward, false);
        self.advance(LANDING * Vector3::y(), false);
        self.forward = -self.forward;
        self.advance(LANDING * self.forward, false);
    }

    fn leave(mut self) -> Route {
        self.advance(APPROACH * self.forward, false);
        Route { waypoints: self.waypoints }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn route_constructors_give_the_requested_length() {
        for (route, length) in [
            (Route::straight(7.0), 7.0),
            (Route::square(5.0), 20.0),
            (Route::rectangle(4.0, 3.0), 14.0),
            (Route::out_and_back(6.0), 12.0),
            (Route::figure_of_eight(50.0), 50.0),
        ] {
            assert!((route.length() - length).abs() < 1e-12);
            assert_eq!(route.validate(), Ok(()));
        }
    }

    #[test]
    fn closed_routes_end_at_the_start() {
        for route in [
            Route::square(5.0),
            Route::rectangle(4.0, 3.0),
            Route::out_and_back(6.0),
            Route::figure_of_eight(50.0),
        ] {
            let end = route.waypoints[route.waypoints.len() - 1].position;
            assert!(end.norm() < 1e-12);
        }
    }

    #[test]
    fn stairs_rise_by_all_risers_and_reverse_on_each_landing() {
        let route = Route::stairs(3, 9, 0.17, 0.28);
        assert_eq!(route.validate(), Ok(()));
        let end = route.waypoints[route.waypoints.len() - 1].position;
        assert!((end.z - 3.0 * 9.0 * 0.17).abs() < 1e-12);
        assert!((end.y - 2.0 * LANDING).abs() < 1e-12);
        assert_eq!(route.waypoints.iter().filter(|waypoint| waypoint.tread).count(), 3 * 5);
    }

    #[test]
    fn lift_legs_must_be_vertical_and_not_onto_a_tread() {
        let by_lift = |position: [f64; 3], tread| {
            let cabin = Waypoint { position: position.into(), tread, lift: true };
            Route { waypoints: vec![Waypoint::default(), cabin] }.validate()
        };
        assert_eq!(by_lift([0.0, 0.0, -9.0], false), Ok(()));
        for (position, tread) in
            [([0.0; 3], false), ([1.0, 0.0, 3.0], false), ([0.0, 0.0, 3.0], true)]
        {
            assert!(
                by_lift(position, tread).unwrap_err().to_string().contains("straight up or down")
            );
        }
    }
}
