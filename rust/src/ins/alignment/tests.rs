use proptest::prelude::*;

use super::*;
use crate::ins::strapdown::MechanizationKind;

const G: f64 = 9.806;

fn config() -> AlignmentConfig {
    AlignmentConfig::default()
}

fn strapdown() -> Strapdown {
    let kind = MechanizationKind::default();
    Strapdown { kind, gravity: G, earth_rate: Vector3::zeros(), nominal_interval: 0.005 }
}

fn rest(attitude: &UnitQuaternion<f64>, k: u32) -> ImuSample {
    let force = attitude.inverse() * Vector3::new(0.0, 0.0, G);
    ImuSample::new(f64::from(k) * 0.005, force.into(), [0.01, -0.02, 0.03])
}

fn align(
    config: AlignmentConfig,
    mut sample: impl FnMut(u32) -> ImuSample,
) -> Result<Aligned, DataError> {
    let mut alignment = Alignment::new(config, &strapdown());
    for k in 0..1000 {
        if let Some(aligned) = alignment.push(&sample(k))? {
            return Ok(aligned);
        }
    }
    unreachable!("the alignment ends after its duration")
}

fn attitudes() -> impl Strategy<Value = UnitQuaternion<f64>> {
    [-3.1..3.1, -1.5..1.5, -3.1..3.1]
        .prop_map(|[x, y, z]: [f64; 3]| UnitQuaternion::from_euler_angles(x, y, z))
}

proptest! {
    #[test]
    fn any_mounting_is_levelled(attitude in attitudes()) {
        let aligned = align(config(), |k| rest(&attitude, k)).unwrap();
        let up = aligned.attitude.inverse() * Vector3::z();
        prop_assert!((up - attitude.inverse() * Vector3::z()).norm() < 1e-12);
        prop_assert!((aligned.gyro_bias - Vector3::new(0.01, -0.02, 0.03)).norm() < 1e-12);
        prop_assert!(aligned.at_rest);
    }

    #[test]
    fn a_given_heading_gives_the_whole_attitude(attitude in attitudes()) {
        let (yaw, elevation) = rotation::yaw_and_elevation(&attitude, &Vector3::x());
        prop_assume!(elevation.abs() < 1.1);
        let heading_deg = Some((FRAC_PI_2 - yaw).to_degrees());
        let aligned = align(AlignmentConfig { heading_deg, ..config() }, |k| rest(&attitude, k)).unwrap();
        prop_assert!(aligned.attitude.angle_to(&attitude) < 1e-7);
    }

    #[test]
    fn a_magnetic_field_gives_the_whole_attitude(
        attitude in attitudes(),
        declination_deg in -30.0..30.0,
    ) {
        let north =
            rotation::about_up(-f64::to_radians(declination_deg)) * Vector3::new(0.0, 18.0, -44.0);
        let magnetic_field = Some((attitude.inverse() * north).into());
        let settings = AlignmentConfig { magnetic_field, declination_deg, ..config() };
        let aligned = align(settings, |k| rest(&attitude, k)).unwrap();
        prop_assert!(aligned.attitude.angle_to(&attitude) < 1e-7);
    }

    #[test]
    fn arcsines_agree_with_arctangents_near_upright(x in -1.2..1.2, y in -1.2..1.2) {
        let force = UnitQuaternion::from_euler_angles(x, y, 0.0).inverse() * Vector3::new(0.0, 0.0, 10.1);
        prop_assert!(level_by_arcsine(&force).angle_to(&level_by_arctangent(&force)) < 1e-7);
    }
}

#[test]
fn a_rest_shorter_than_min_rest_is_a_start_in_motion() {
    let level = UnitQuaternion::identity();
    let moving = |k: u32| ImuSample::new(0.005 * f64::from(k), [3.0, 0.0, G], [0.0, 2.0, 0.0]);
    for (min_rest, at_rest) in [(0.2, true), (0.5, false)] {
        let settings = AlignmentConfig { min_rest, ..config() };
        let start = |k: u32| if k <= 60 { rest(&level, k) } else { moving(k) };
        assert_eq!(align(settings, start).unwrap().at_rest, at_rest, "{min_rest} s");
    }
}

#[test]
fn a_rest_as_short_as_duration_is_accepted() {
    for duration in [0.001, 0.05, 0.1, 0.15] {
        let still = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.0);
        let aligned = align(AlignmentConfig { duration, ..config() }, |k| rest(&still, k)).unwrap();
        assert!(
            aligned.at_rest && aligned.attitude.angle_to(&still) < 1e-7,
            "{duration}: {aligned:?}"
        );
    }
}

#[test]
fn stepping_off_early_shortens_the_rest() {
    let attitude = UnitQuaternion::identity();
    let moving = |k: u32| {
        if k < 110 {
            rest(&attitude, k)
        } else {
            ImuSample::new(f64::from(k) * 0.005, [3.0, 1.0, 12.0], [1.0, f64::from(k % 7), 0.5])
        }
    };
    let aligned = align(config(), moving).unwrap();
    assert!(aligned.at_rest && (aligned.rest - 0.5).abs() < 1e-9, "{aligned:?}");
    assert!((aligned.gyro_bias - Vector3::new(0.01, -0.02, 0.03)).norm() < 1e-12);
}

#[test]
fn walking_from_the_first_sample_is_no_rest() {
    let aligned = align(config(), |k| {
        ImuSample::new(
            f64::from(k) * 0.005,
            [2.0, f64::from(k % 5), 9.0],
            [0.0, f64::from(k % 3), 0.0],
        )
    })
    .unwrap();
    assert!(!aligned.at_rest);
    assert_eq!(aligned.gyro_bias, Vector3::zeros());
}

#[test]
fn repeated_stamps_are_no_rest() {
    let strapdown = strapdown();
    let mut alignment = Alignment::new(config(), &strapdown);
    let still = rest(&UnitQuaternion::identity(), 0);
    assert!((0..1000).all(|_| alignment.push(&still).unwrap().is_none()));
}

#[test]
fn what_moves_at_the_end_of_the_rest_is_handed_over() {
    let attitude = UnitQuaternion::identity();
    let strapdown = strapdown();
    let mut alignment = Alignment::new(config(), &strapdown);
    let pushed =
        |k: u32| ImuSample::new(f64::from(k) * 0.005, [f64::from(k % 9), 1.0, 12.0], [1.0; 3]);
    let sample = |k: u32| if k < 110 { rest(&attitude, k) } else { pushed(k) };
    let end = (0..1000).find(|&k| alignment.push(&sample(k)).unwrap().is_some()).unwrap();
    let (anchor, moving) = alignment.handover(&sample(end));
    assert!((anchor.time - 0.5).abs() < 1e-9, "{anchor:?}");
    assert_eq!(moving.len(), 20);
    assert_eq!(moving.last(), Some(&sample(end)));
}

#[test]
fn units_of_g_are_recognized() {
    let error =
        align(config(), |k| ImuSample::new(f64::from(k) * 0.005, [0.0, 0.0, 1.0], [0.0; 3]))
            .unwrap_err();
    assert!(error.to_string().contains("it looks like g"), "{error}");
}

#[test]
fn an_upright_forward_axis_has_no_heading() {
    let settings = AlignmentConfig { heading_deg: Some(10.0), forward_axis: Axis::Z, ..config() };
    let error = align(settings, |k| rest(&UnitQuaternion::identity(), k)).unwrap_err();
    assert!(error.to_string().contains("z axis"), "{error}");
}
