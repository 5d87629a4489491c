//! Footholds along a route.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

use crate::simulation::draw;
use crate::simulation::gait::Gait;
use crate::simulation::route::{Route, Waypoint};

/// Length of the first and the last stride, from and to standing, as a fraction of a stride.
const END_STRIDE: f64 = 0.5;
/// Maximum yaw change of one stride in place, rad.
const MAX_PIVOT: f64 = 100.0 * PI / 180.0;
/// Lateral scatter of a foothold per unit of the gait's variation, m.
const LATERAL_SCATTER: f64 = 0.3;
/// Scatter of a foothold's yaw per unit of the gait's variation, rad.
const YAW_SCATTER: f64 = 1.0;

/// Position and yaw of the foot in flat stance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foothold {
    /// The sole's reference point in n, m.
    pub(super) position: Vector3<f64>,
    /// Direction of the toes, rad, anticlockwise from n x.
    pub(super) yaw: f64,
    /// Whether a lift carried the foot here.
    pub(super) by_lift: bool,
}

/// The footholds of a walk along a valid route.
pub(super) fn plan(route: &Route, gait: &Gait, random: &mut ChaCha8Rng) -> Vec<Foothold> {
    let mut footholds = Vec::new();
    for run in runs(route, gait.sharpest_curve) {
        if run.lift {
            add_lift_ride(&mut footholds, &run);
            continue;
        }
        let distances = run.distances(gait, random);
        let first = run.foothold(distances[0], gait);
        turn_in_place(&mut footholds, &first, gait.sharpest_curve);
        footholds.extend(distances[1..].iter().map(|&distance| run.foothold(distance, gait)));
    }
    scatter(&mut footholds, gait.variation, random);
    footholds
}

/// A part of the route that is walked without a stop, with the distance of each waypoint from its
/// start.
struct Run {
    points: Vec<Vector3<f64>>,
    travelled: Vec<f64>,
    treads: bool,
    lift: bool,
}

impl Run {
    fn new(from: Vector3<f64>, to: &Waypoint) -> Self {
        let mut run =
            Self { points: vec![from], travelled: vec![0.0], treads: to.tread, lift: to.lift };
        run.push(to.position);
        run
    }

    fn push(&mut self, point: Vector3<f64>) {
        let displacement = point - self.points[self.points.len() - 1];
        self.travelled.push(self.length() + displacement.norm());
        self.points.push(point);
    }

    /// Whether the leg `displacement` to a waypoint continues this run without a stop.
    fn continues(&self, to: &Waypoint, displacement: &Vector3<f64>, sharpest_curve: f64) -> bool {
        !self.lift
            && !to.lift
            && self.treads == to.tread
            && bend(&self.last_leg(), displacement) <= sharpest_curve
    }

    fn length(&self) -> f64 {
        self.travelled[self.travelled.len() - 1]
    }

    fn last_leg(&self) -> Vector3<f64> {
        let n = self.points.len();
        self.points[n - 1] - self.points[n - 2]
    }

    /// The point at `distance` from the start, clamped to the run.
    fn at(&self, distance: f64) -> Vector3<f64> {
        let leg = self
            .travelled
            .partition_point(|&travelled| travelled < distance)
            .clamp(1, self.points.len() - 1);
        let (start, end) = (self.travelled[leg - 1], self.travelled[leg]);
        let share = ((distance - start) / (end - start)).clamp(0.0, 1.0);
        self.points[leg - 1].lerp(&self.points[leg], share)
    }

    /// Distances of the footholds from the start of the run, including the start.
    fn distances(&self, gait: &Gait, random: &mut ChaCha8Rng) -> Vec<f64> {
        if self.treads {
            return self.travelled.clone();
        }
        let shares = stride_shares(self.length() / gait.stride_length, gait.variation, random);
        let total: f64 = shares.iter().sum();
        let mut distances = vec![0.0];
        let mut walked = 0.0;
        for share in shares {
            walked += share;
            distances.push(self.length() * walked / total);
        }
        distances
    }

    /// The yaw is that of the chord from one stride before the foothold to one stride after it,
    /// which smooths curves.
    fn foothold(&self, distance: f64, gait: &Gait) -> Foothold {
        let chord = self.at(distance + gait.stride_length) - self.at(distance - gait.stride_length);
        Foothold { position: self.at(distance), yaw: yaw(&chord), by_lift: false }
    }
}

/// Divides the route at sharp corners, at both ends of stairs and at lift rides.
fn runs(route: &Route, sharpest_curve: f64) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for leg in route.waypoints.windows(2) {
        let displacement = leg[1].position - leg[0].position;
        match runs.last_mut() {
            Some(run) if run.continues(&leg[1], &displacement, sharpest_curve) => {
                run.push(leg[1].position);
            }
            _ => runs.push(Run::new(leg[0].position, &leg[1])),
        }
    }
    runs
}

/// Relative lengths of the strides that fill a run of `strides` nominal strides.
fn stride_shares(strides: f64, variation: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
    let inner = strides.round() - 1.0;
    if inner < 0.0 {
        return vec![1.0];
    }
    let mut shares = vec![END_STRIDE];
    shares.extend(
        (0_u32..).take_while(|&k| f64::from(k) < inner).map(|_| draw::factor(random, variation)),
    );
    shares.push(END_STRIDE);
    shares
}

/// Adds the foothold at the end of a lift ride; a route that starts with a lift has zero yaw.
fn add_lift_ride(footholds: &mut Vec<Foothold>, run: &Run) {
    let entered = Foothold { position: run.points[0], yaw: 0.0, by_lift: false };
    if footholds.is_empty() {
        footholds.push(entered);
    }
    let last = footholds[footholds.len() - 1];
    footholds.push(Foothold { position: run.points[1], by_lift: true, ..last });
}

/// Adds the footholds that turn the last foothold in place to the yaw of `next`, which has the same
/// position.
fn turn_in_place(footholds: &mut Vec<Foothold>, next: &Foothold, sharpest_curve: f64) {
    let Some(&last) = footholds.last() else {
        footholds.push(*next);
        return;
    };
    let turn = wrap(next.yaw - last.yaw);
    if turn.abs() <= sharpest_curve {
        return;
    }
    let pivots = (turn.abs() / MAX_PIVOT).ceil();
    let pivot =
        |k: u32| Foothold { yaw: last.yaw + turn * f64::from(k) / pivots, by_lift: false, ..last };
    footholds.extend((1_u32..).take_while(|&k| f64::from(k) <= pivots).map(pivot));
}

/// Adds random lateral and yaw deviations to every foothold except the first and the last; a
/// foothold in a lift keeps those of the one before.
fn scatter(footholds: &mut [Foothold], variation: f64, random: &mut ChaCha8Rng) {
    let inner = footholds.len().saturating_sub(1);
    for k in 1..footholds.len() {
        let before = footholds[k - 1];
        let foothold = &mut footholds[k];
        if foothold.by_lift {
            let height = foothold.position.z;
            *foothold = Foothold { by_lift: true, ..before };
            foothold.position.z = height;
        } else if k < inner {
            let (sin, cos) = foothold.yaw.sin_cos();
            foothold.position += variation
                * LATERAL_SCATTER
                * draw::clamped_normal(random)
                * Vector3::new(-sin, cos, 0.0);
            foothold.yaw += variation * YAW_SCATTER * draw::clamped_normal(random);
        }
    }
}

/// Horizontal direction, rad, anticlockwise from n x.
fn yaw(displacement: &Vector3<f64>) -> f64 {
    displacement.y.atan2(displacement.x)
}

/// Magnitude of the change of horizontal direction between two legs, rad.
fn bend(leg: &Vector3<f64>, next: &Vector3<f64>) -> f64 {
    wrap(yaw(next) - yaw(leg)).abs()
}

/// The angle wrapped to -π..π.
pub(super) fn wrap(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned(route: &Route, gait: &Gait) -> Vec<Foothold> {
        plan(route, gait, &mut draw::stream(1, draw::Stream::Gait))
    }

    fn steady() -> Gait {
        Gait { variation: 0.0, stride_length: 1.0, ..Gait::walk() }
    }

    #[test]
    fn straight_route_has_full_strides_between_two_half_strides() {
        let x: Vec<f64> = planned(&Route::straight(4.0), &steady())
            .iter()
            .map(|foothold| foothold.position.x)
            .collect();
        assert_eq!(x, [0.0, 0.5, 1.5, 2.5, 3.5, 4.0]);
    }

    #[test]
    fn variation_keeps_the_first_and_last_footholds() {
        let gait = Gait { variation: 0.1, ..steady() };
        let footholds = planned(&Route::straight(9.0), &gait);
        let last = footholds[footholds.len() - 1];
        assert!((last.position - Vector3::new(9.0, 0.0, 0.0)).norm() < 1e-12);
        assert!(last.yaw.abs() < 1e-12);
        assert!(
            footholds[1..footholds.len() - 1]
                .iter()
                .any(|foothold| foothold.position.y.abs() > 0.01)
        );
    }

    #[test]
    fn short_route_is_one_stride() {
        assert_eq!(planned(&Route::straight(0.2), &steady()).len(), 2);
    }

    #[test]
    fn half_turn_takes_two_strides_in_place() {
        let footholds = planned(&Route::out_and_back(3.0), &steady());
        let there: Vec<_> =
            footholds.iter().filter(|foothold| (foothold.position.x - 3.0).abs() < 1e-12).collect();
        assert_eq!(there.len(), 3);
        assert!((there[1].yaw.abs() - PI / 2.0).abs() < 1e-12);
        assert!((wrap(there[2].yaw - PI)).abs() < 1e-12);
    }

    #[test]
    fn gentle_corner_is_walked_without_a_stop() {
        let gait = Gait { sharpest_curve: 2.0, ..steady() };
        let footholds = planned(&Route::rectangle(4.0, 4.0), &gait);
        assert!(
            footholds.windows(2).all(|pair| (pair[1].position - pair[0].position).norm() > 0.2)
        );
        assert!(footholds.windows(2).any(|pair| (0.1..1.5).contains(&(pair[1].yaw - pair[0].yaw))));
    }

    #[test]
    fn footholds_on_stairs_lie_on_treads() {
        let footholds = planned(&Route::stairs(2, 8, 0.17, 0.28), &steady());
        for foothold in &footholds {
            let risers = foothold.position.z / 0.17;
            assert!((risers - risers.round()).abs() < 1e-9, "{risers}");
        }
        assert!((footholds[footholds.len() - 1].position.z - 16.0 * 0.17).abs() < 1e-9);
    }

    #[test]
    fn lift_ride_keeps_horizontal_position_and_yaw() {
        let waypoint = |x: f64, z: f64, lift| Waypoint {
            position: Vector3::new(x, 0.0, z),
            lift,
            tread: false,
        };
        let waypoints = vec![
            waypoint(0.0, 0.0, false),
            waypoint(4.0, 0.0, false),
            waypoint(4.0, 6.0, true),
            waypoint(0.0, 6.0, false),
        ];
        let footholds = planned(&Route { waypoints }, &Gait { variation: 0.1, ..steady() });
        let k = footholds.iter().position(|foothold| foothold.by_lift).unwrap();
        let (entered, left) = (footholds[k - 1], footholds[k]);
        assert_eq!((left.position - entered.position, left.yaw), (6.0 * Vector3::z(), entered.yaw));
        assert!(
            footholds[k + 1..]
                .iter()
                .all(|foothold| !foothold.by_lift && foothold.position.z > 5.9)
        );
    }

    #[test]
    fn figure_of_eight_turns_by_two_full_circles() {
        let footholds = planned(&Route::figure_of_eight(40.0), &steady());
        let turned: f64 =
            footholds.windows(2).map(|pair| wrap(pair[1].yaw - pair[0].yaw).abs()).sum();
        // At both ends the chords are half as long, which shortens the total turn.
        assert!((turned - 2.0 * TAU).abs() < 0.8, "{turned}");
    }
}
