//! The route on the ground that a walk follows.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::error::ConfigError;
use crate::limits;

/// Longest route that is accepted, m.
const LONGEST: f64 = 100_000.0;
/// Legs in each circle of a figure of eight.
const LEGS_OF_A_CIRCLE: u32 = 64;
/// Level way to the foot of the stairs, m.
const APPROACH: f64 = 2.0;
/// Length and width of a landing between two flights, m.
const LANDING: f64 = 1.2;
/// Risers that one foot takes in a stride.
const RISERS_PER_STRIDE: u32 = 2;

/// One corner of a route.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Waypoint {
    /// Where the sole goes, n frame, m.
    pub position: Vector3<f64>,
    /// Whether the way to here is a single stride onto a tread of stairs; if not, it is divided
    /// into strides of the gait's length.
    pub tread: bool,
    /// Whether a lift carries the walker here, straight up or down, while the foot stands.
    pub lift: bool,
}

/// A polyline on the ground, in n (x, y horizontal, z up).
///
/// The walker sets out along the first leg.  The default is a square of 10 m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Route {
    /// The corners in the order of the walk; the first one is the start.
    pub waypoints: Vec<Waypoint>,
}

impl Default for Route {
    fn default() -> Self {
        Self::square(10.0)
    }
}

impl Route {
    /// Along straight lines from one point (x, y, z in n, m) to the next.
    #[must_use]
    pub fn from_waypoints(points: &[[f64; 3]]) -> Self {
        let waypoints =
            points.iter().map(|&point| Waypoint { position: point.into(), ..Waypoint::default() });
        Self { waypoints: waypoints.collect() }
    }

    /// Straight ahead along x for `length` (m).
    #[must_use]
    pub fn straight(length: f64) -> Self {
        Self::from_waypoints(&[[0.0; 3], [length, 0.0, 0.0]])
    }

    /// Once around a square of side `side` (m), anticlockwise, back to the start.
    #[must_use]
    pub fn square(side: f64) -> Self {
        Self::rectangle(side, side)
    }

    /// Once around a rectangle of `length` along x and `width` along y (m), anticlockwise, back to
    /// the start.
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

    /// Along x for `length` (m), about turn, and back to the start.
    #[must_use]
    pub fn out_and_back(length: f64) -> Self {
        Self::from_waypoints(&[[0.0; 3], [length, 0.0, 0.0], [0.0; 3]])
    }

    /// Two circles that touch at the start, the first to the left and the second to the right,
    /// `length` (m) in all.
    #[must_use]
    pub fn figure_of_eight(length: f64) -> Self {
        let legs = f64::from(LEGS_OF_A_CIRCLE);
        let radius = length / (4.0 * legs * (PI / legs).sin());
        let circle = |side: f64| {
            (1..=LEGS_OF_A_CIRCLE).map(move |k| {
                let angle = TAU * f64::from(k) / legs;
                [radius * angle.sin(), side * radius * (1.0 - angle.cos()), 0.0]
            })
        };
        let points: Vec<_> =
            std::iter::once([0.0; 3]).chain(circle(1.0)).chain(circle(-1.0)).collect();
        Self::from_waypoints(&points)
    }

    /// Up a stairwell of `floors` flights of `risers` each, with a landing and an about turn
    /// between them.
    ///
    /// A riser is `riser` high and a tread `tread` deep (m); a negative `riser` leads down.  The
    /// foot takes every second tread, and the last one.
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

    /// Checks that the route can be walked.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`] when there are fewer than two waypoints, one is not finite, a
    /// leg that is walked has no horizontal extent, one that is ridden is not vertical, a lift
    /// leads to a tread, or the route is longer than 100 km.
    pub fn validate(&self) -> Result<(), ConfigError> {
        const KEY: &str = "route.waypoints";
        let refuse = |value: String, expected: &'static str| {
            Err(ConfigError::OutOfRange { key: KEY, value, expected: expected.into() })
        };
        if self.waypoints.len() < 2 {
            return refuse(format!("{} waypoints", self.waypoints.len()), "at least 2 waypoints");
        }
        for waypoint in &self.waypoints {
            limits::finite(KEY, waypoint.position.as_slice())?;
        }
        for (k, leg) in self.waypoints.windows(2).enumerate() {
            let way = leg[1].position - leg[0].position;
            if leg[1].lift && (leg[1].tread || !is_vertical(&way)) {
                return refuse(
                    format!("leg {k} by lift to {:?}", leg[1]),
                    "a lift straight up or down, not to a tread",
                );
            }
            if !leg[1].lift && way.xy().norm() == 0.0 {
                return refuse(
                    format!("leg {k} without horizontal extent"),
                    "each waypoint apart from the one before it",
                );
            }
        }
        limits::within(KEY, self.length(), 0.0..=LONGEST, "a length of at most 100000 m")
    }
}

/// Whether a way leads straight up or down.
fn is_vertical(way: &Vector3<f64>) -> bool {
    way.xy().norm() == 0.0 && way.z != 0.0
}

/// Draws the waypoints of a stairwell.
struct Stairwell {
    waypoints: Vec<Waypoint>,
    position: Vector3<f64>,
    forward: Vector3<f64>,
}

impl Stairwell {
    fn at_the_foot() -> Self {
        let mut stairwell =
            Self { waypoints: Vec::new(), position: Vector3::zeros(), forward: Vector3::x() };
        stairwell.go(Vector3::zeros(), false);
        stairwell.go(APPROACH * Vector3::x(), false);
        stairwell
    }

    fn go(&mut self, way: Vector3<f64>, tread: bool) {
        self.position += way;
        self.waypoints.push(Waypoint { position: self.position, tread, lift: false });
    }

    fn climb(&mut self, risers: u32, riser: f64, tread: f64) {
        let mut left = risers;
        while left > 0 {
            let taken = left.min(RISERS_PER_STRIDE);
            self.go(f64::from(taken) * (tread * self.forward + riser * Vector3::z()), true);
            left -= taken;
        }
    }

    fn turn_on_landing(&mut self) {
        self.go(LANDING * self.forward, false);
        self.go(LANDING * Vector3::y(), false);
        self.forward = -self.forward;
        self.go(LANDING * self.forward, false);
    }

    fn leave(mut self) -> Route {
        self.go(APPROACH * self.forward, false);
        Route { waypoints: self.waypoints }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lengths_are_as_named() {
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
    fn closed_routes_end_where_they_begin() {
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
    fn a_stairwell_climbs_all_its_risers_and_turns_between_flights() {
        let route = Route::stairs(3, 9, 0.17, 0.28);
        assert_eq!(route.validate(), Ok(()));
        let end = route.waypoints[route.waypoints.len() - 1].position;
        assert!((end.z - 3.0 * 9.0 * 0.17).abs() < 1e-12);
        assert!((end.y - 2.0 * LANDING).abs() < 1e-12);
        assert_eq!(route.waypoints.iter().filter(|waypoint| waypoint.tread).count(), 3 * 5);
    }

    #[test]
    fn a_lift_leads_straight_up_or_down() {
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
