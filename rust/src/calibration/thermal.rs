//! Temperature-dependent calibration of one sensor triad.
//!
//! The error model is that of Tedaldi, Pretto and Menegatti, "A robust and easy to implement method
//! for IMU calibration without external equipments", ICRA 2014, eqs. 5-8, with bias and scale
//! factor as polynomials of the die temperature.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::calibration::affine::{Correction, IDENTITY, check_bias, check_matrix};
use crate::error::{ConfigError, DataError, Error};
use crate::limits;

/// Correction M (raw - b) of a sensor triad, optionally with temperature compensation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TriadCalibration {
    /// Rows of the matrix M at the reference temperature.
    pub matrix: [[f64; 3]; 3],
    /// Bias b at the reference temperature, in the sensor's unit.
    pub bias: [f64; 3],
    /// Temperature dependence of both; none if it is unknown.
    pub thermal: Option<TemperatureModel>,
}

impl Default for TriadCalibration {
    fn default() -> Self {
        Self { matrix: IDENTITY, bias: [0.0; 3], thermal: None }
    }
}

/// Temperature dependence of a sensor: polynomials of T - `reference` without a constant term.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TemperatureModel {
    /// Temperature at which the polynomials are zero, degrees Celsius.
    pub reference: f64,
    /// Lowest calibration temperature, degrees Celsius.
    pub lowest: f64,
    /// Highest calibration temperature, degrees Celsius.
    pub highest: f64,
    /// Extrapolation limit beyond these temperatures, K.
    pub margin: f64,
    /// Coefficients of the bias change in ascending order from the linear one, per axis, unit/K^k.
    pub bias: Vec<[f64; 3]>,
    /// Coefficients of the relative change of the sensitivity in ascending order from the linear
    /// one, per axis, 1/K^k.
    pub scale: Vec<[f64; 3]>,
}

impl TriadCalibration {
    /// Checks that every number is finite, the matrix is invertible and the temperatures are in
    /// order.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`] with the first invalid number.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check_matrix("matrix", &self.matrix)?;
        check_bias("bias", &self.bias)?;
        self.thermal.as_ref().map_or(Ok(()), TemperatureModel::validate)
    }

    /// The calibration at a fixed temperature (degrees Celsius), without temperature dependence.
    ///
    /// # Errors
    /// [`ConfigError`] for an invalid calibration, [`DataError`] for a temperature that is missing
    /// or outside the calibrated range.
    pub fn at(&self, temperature: Option<f64>) -> Result<Self, Error> {
        self.validate()?;
        let Some(thermal) = &self.thermal else { return Ok(self.clone()) };
        let temperature = temperature.ok_or(DataError::NoTemperature)?;
        thermal.check(0, temperature)?;
        let correction = self.correction(thermal, temperature);
        let matrix = std::array::from_fn(|i| std::array::from_fn(|j| correction.matrix[(i, j)]));
        Ok(Self { matrix, bias: correction.bias.into(), thermal: None })
    }

    /// The corrected readings.  `temperatures` has one entry per reading or is empty.
    ///
    /// # Errors
    /// As [`Self::at`]; [`DataError::TemperatureOutsideSpan`] names the first reading outside
    /// the range.
    pub fn apply(&self, raw: &[[f64; 3]], temperatures: &[f64]) -> Result<Vec<[f64; 3]>, Error> {
        self.validate()?;
        let Some(thermal) = &self.thermal else {
            let correction = Correction::new(&self.matrix, &self.bias);
            return Ok(raw
                .iter()
                .map(|reading| correction.apply(&(*reading).into()).into())
                .collect());
        };
        if temperatures.len() != raw.len() {
            return Err(DataError::NoTemperature.into());
        }
        let correct = |(index, (reading, &temperature)): (usize, (&[f64; 3], &f64))| {
            thermal.check(index, temperature)?;
            Ok(self.correction(thermal, temperature).apply(&(*reading).into()).into())
        };
        raw.iter().zip(temperatures).enumerate().map(correct).collect()
    }

    fn correction(&self, thermal: &TemperatureModel, temperature: f64) -> Correction {
        let mut correction = Correction::new(&self.matrix, &self.bias);
        let excess = temperature - thermal.reference;
        correction.bias += polynomial(&thermal.bias, excess);
        let scale = polynomial(&thermal.scale, excess);
        for (mut column, change) in correction.matrix.column_iter_mut().zip(scale.iter()) {
            column /= 1.0 + change;
        }
        correction
    }
}

impl TemperatureModel {
    fn validate(&self) -> Result<(), ConfigError> {
        limits::finite("thermal.bias", self.bias.as_flattened())?;
        limits::finite("thermal.scale", self.scale.as_flattened())?;
        limits::finite("thermal.reference", &[self.reference])?;
        limits::at_least_zero("thermal.margin", self.margin)?;
        limits::within(
            "thermal.lowest",
            self.lowest,
            -273.15..=self.highest,
            "a temperature up to thermal.highest",
        )?;
        limits::within(
            "thermal.highest",
            self.highest,
            self.lowest..=1000.0,
            "degrees Celsius, up to 1000",
        )
    }

    fn check(&self, index: usize, temperature: f64) -> Result<(), DataError> {
        let (lowest, highest) = (self.lowest - self.margin, self.highest + self.margin);
        if (lowest..=highest).contains(&temperature) {
            return Ok(());
        }
        Err(DataError::TemperatureOutsideSpan {
            index,
            temperature,
            lowest,
            highest,
            margin: self.margin,
        })
    }
}

/// Polynomial without a constant term, by Horner's rule.
fn polynomial(coefficients: &[[f64; 3]], x: f64) -> Vector3<f64> {
    coefficients.iter().rev().fold(Vector3::zeros(), |sum, &term| (sum + Vector3::from(term)) * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warm_sensor() -> TriadCalibration {
        TriadCalibration {
            matrix: [[1.01, 0.0, 0.0], [0.02, 0.98, 0.0], [0.0, -0.01, 1.03]],
            bias: [0.1, -0.2, 0.3],
            thermal: Some(TemperatureModel {
                reference: 25.0,
                lowest: 10.0,
                highest: 40.0,
                margin: 2.0,
                bias: vec![[1e-3, -2e-3, 0.0], [1e-5, 0.0, 3e-5]],
                scale: vec![[2e-4, 0.0, -1e-4]],
            }),
        }
    }

    /// Reading of a sensor with these errors at a temperature.
    fn reading(truth: Vector3<f64>, excess: f64) -> [f64; 3] {
        let calibration = warm_sensor();
        let matrix = crate::calibration::affine::matrix(&calibration.matrix).try_inverse().unwrap();
        let scale = Vector3::new(1.0 + 2e-4 * excess, 1.0, 1.0 - 1e-4 * excess);
        let drift = Vector3::new(1e-3, -2e-3, 0.0) * excess
            + Vector3::new(1e-5, 0.0, 3e-5) * excess * excess;
        ((matrix * truth).component_mul(&scale) + Vector3::from(calibration.bias) + drift).into()
    }

    #[test]
    fn correction_recovers_the_truth_at_every_temperature() {
        let truth = Vector3::new(1.0, -2.0, 9.0);
        let temperatures = [8.0, 25.0, 42.0];
        let raw: Vec<_> = temperatures.iter().map(|t| reading(truth, t - 25.0)).collect();
        for corrected in warm_sensor().apply(&raw, &temperatures).unwrap() {
            assert!((Vector3::from(corrected) - truth).norm() < 1e-13);
        }
    }

    #[test]
    fn calibration_at_a_temperature_equals_the_compensated_one() {
        let raw = [[1.0, 2.0, 3.0]];
        let fixed = warm_sensor().at(Some(17.0)).unwrap();
        assert_eq!(fixed.thermal, None);
        assert_eq!(fixed.apply(&raw, &[]), warm_sensor().apply(&raw, &[17.0]));
    }

    #[test]
    fn temperature_beyond_the_margin_is_an_error_with_both_limits() {
        let message = warm_sensor().apply(&[[0.0; 3]; 2], &[42.0, 42.1]).unwrap_err().to_string();
        let expected = "sample 1: the temperature is 42.1 degC, but the calibration holds \
                        from 8.0 to 42.0 degC";
        assert!(message.starts_with(expected), "{message}");
    }

    #[test]
    fn missing_temperature_is_an_error() {
        assert_eq!(warm_sensor().at(None), Err(DataError::NoTemperature.into()));
        assert_eq!(warm_sensor().apply(&[[0.0; 3]], &[]), Err(DataError::NoTemperature.into()));
    }

    #[test]
    fn reversed_temperature_limits_are_an_error_that_names_the_setting() {
        let mut calibration = warm_sensor();
        calibration.thermal.as_mut().unwrap().lowest = 50.0;
        assert!(calibration.validate().unwrap_err().to_string().starts_with("thermal.lowest = 50"));
    }
}
