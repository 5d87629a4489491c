//! The affine correction of one sensor: M (raw - b).

use nalgebra::{Matrix3, Vector3};

use crate::error::ConfigError;

pub(super) const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Checks that a matrix is right-handed and not singular.
pub(super) fn check_matrix(key: &'static str, rows: &[[f64; 3]; 3]) -> Result<(), ConfigError> {
    let determinant = matrix(rows).determinant();
    if determinant.is_finite() && determinant > 1.0e-3 {
        return Ok(());
    }
    let value = format!("{rows:?}");
    Err(ConfigError::OutOfRange {
        key,
        value,
        expected: "three rows of a right-handed matrix near the identity".into(),
    })
}

/// Checks that a bias is finite.
pub(super) fn check_bias(key: &'static str, bias: &[f64; 3]) -> Result<(), ConfigError> {
    if bias.iter().all(|b| b.is_finite()) {
        return Ok(());
    }
    Err(ConfigError::OutOfRange {
        key,
        value: format!("{bias:?}"),
        expected: "three finite numbers".into(),
    })
}

/// The matrix with these rows.
pub(super) fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// M and b of one sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correction {
    pub(super) matrix: Matrix3<f64>,
    pub(super) bias: Vector3<f64>,
}

impl Correction {
    pub(super) fn new(rows: &[[f64; 3]; 3], bias: &[f64; 3]) -> Self {
        Self { matrix: matrix(rows), bias: (*bias).into() }
    }

    #[inline]
    pub(super) fn apply(&self, raw: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * (raw - self.bias)
    }
}
