use super::*;
use crate::allan::Integral;

const DT: f64 = 0.01;

fn readings(errors: &SensorErrors, truth: &ImuSample, count: usize) -> Vec<ImuSample> {
    let mut sensor = Sensor::draw(errors, draw::stream(3, draw::Stream::Sensor));
    (0..count).map(|_| sensor.read(truth, DT)).collect()
}

fn gyro(gyro: TriadErrors) -> SensorErrors {
    SensorErrors { gyro, ..SensorErrors::ideal() }
}

fn moving() -> ImuSample {
    ImuSample::new(0.0, [1.0, -2.0, 9.0], [0.5, -3.0, 0.1])
}

#[test]
fn ideal_sensor_has_no_errors() {
    assert!(
        readings(&SensorErrors::ideal(), &moving(), 3).iter().all(|reading| *reading == moving())
    );
}

#[test]
fn white_noise_has_the_configured_density() {
    let errors = gyro(TriadErrors { noise_density: 0.002, ..TriadErrors::default() });
    let count = 4000;
    let power: f64 = readings(&errors, &moving(), count)
        .iter()
        .map(|reading| (reading.angular_rate - moving().angular_rate).norm_squared())
        .sum();
    let std = (power / 12_000.0).sqrt();
    assert!((std / (0.002 / DT.sqrt()) - 1.0).abs() < 0.03, "{std}");
}

#[test]
fn bias_random_walk_has_the_configured_density() {
    let errors = gyro(TriadErrors { bias_walk: 0.1, ..TriadErrors::default() });
    let readings = readings(&errors, &moving(), 4001);
    let steps = readings
        .windows(2)
        .map(|pair| (pair[1].angular_rate - pair[0].angular_rate).norm_squared());
    let std = (steps.sum::<f64>() / 12_000.0).sqrt();
    assert!((std / (0.1 * DT.sqrt()) - 1.0).abs() < 0.03, "{std}");
}

#[test]
fn bias_instability_sets_the_floor_of_the_allan_deviation() {
    let instability = 0.1;
    let errors = gyro(TriadErrors { bias_instability: instability, ..TriadErrors::default() });
    let readings = readings(&errors, &moving(), 100_000);
    for axis in 0..3 {
        let samples: Vec<f64> = readings.iter().map(|reading| reading.angular_rate[axis]).collect();
        let integral = Integral::new(&samples);
        let floor = (2.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt() * instability;
        for factor in [100, 300, 1000] {
            let deviation = integral.deviation(factor);
            assert!(
                (deviation / floor - 1.0).abs() < 0.15,
                "axis {axis}, {factor} samples: {deviation}"
            );
        }
    }
}

#[test]
fn bias_instability_leaves_the_other_draws_unchanged() {
    let noisy = TriadErrors { noise_density: 0.01, bias_walk: 0.1, ..TriadErrors::default() };
    let unstable = gyro(TriadErrors { bias_instability: 0.2, ..noisy });
    let mut sensor = Sensor::draw(&unstable, draw::stream(3, Stream::Sensor));
    for steady in readings(&gyro(noisy), &moving(), 5) {
        let flicker = sensor.gyro.flicker.value();
        let reading = sensor.read(&moving(), DT).angular_rate;
        assert!(flicker.norm() > 0.0);
        assert!((reading - flicker - steady.angular_rate).norm() < 1e-12);
    }
}

#[test]
fn readings_are_clipped_and_quantized() {
    let errors = gyro(TriadErrors { range: Some(2.0), resolution: 0.25, ..TriadErrors::default() });
    assert_eq!(readings(&errors, &moving(), 1)[0].angular_rate, Vector3::new(0.5, -2.0, 0.0));
}

#[test]
fn matrix_is_row_major() {
    let matrix = [[1.0, 2.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.1]];
    let read = readings(&gyro(TriadErrors { matrix, ..TriadErrors::default() }), &moving(), 1)[0]
        .angular_rate;
    assert!((read - Vector3::new(-5.5, -3.0, 0.11)).norm() < 1e-15);
}

#[test]
fn g_sensitivity_is_linear_in_specific_force() {
    let errors = SensorErrors { gyro_g_sensitivity_std: 0.01, ..SensorErrors::ideal() };
    let rate_error = |force: [f64; 3]| {
        readings(&errors, &ImuSample::new(0.0, force, [0.0; 3]), 1)[0].angular_rate
    };
    assert!(rate_error([0.0, 0.0, 10.0]).norm() > 0.0);
    assert!((rate_error([0.0, 0.0, 20.0]) - 2.0 * rate_error([0.0, 0.0, 10.0])).norm() < 1e-15);
}

#[test]
fn noise_density_does_not_change_the_bias() {
    let bias = |noise_density| {
        let errors = gyro(TriadErrors { bias_std: 0.1, noise_density, ..TriadErrors::default() });
        Sensor::draw(&errors, draw::stream(3, draw::Stream::Sensor)).biases()
    };
    assert_eq!(bias(0.0), bias(0.3));
    assert!(bias(0.0).0.norm() > 0.0);
}
