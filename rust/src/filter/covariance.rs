//! The covariance of the 15 error states as 3x3 blocks.
//!
//! Only the upper triangle of blocks is kept and each operation treats both sides of the diagonal
//! alike, so the matrix is symmetric by construction, to the bit. The transition matrix of the
//! error model is a product of a few shears, each of which touches one row and column of blocks: a
//! fraction of the work of a dense product.
//!
//! # References
//! G. J. Bierman, "Factorization Methods for Discrete Sequential Estimation", 1977: sec. II.6 on
//! what makes an update safe.  The update subtracts `W Wᵀ` with `W = P Hᵀ L⁻ᵀ`, `L Lᵀ = H P Hᵀ +
//! R`; it keeps P positive as long as the ratio of P to R stays far below 1e16, and the check after
//! each sample detects where it does not.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::filter::error_state::{BLOCKS, Block, ErrorStates, LinearMap, STATES};
use crate::filter::kernels::backward;
use crate::filter::kernels::forward::{self, Prediction, WhitenedGain};
use crate::filter::observation::{Observation, Update};
use crate::filter::process_noise::Noise;
use crate::filter::transition::Transition;
use crate::math::block_matrix::{Block3, Upper, at};
use crate::math::simd::{Simd, WithSimd};

/// Symmetric 15x15 covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance {
    upper: Upper,
}

impl Covariance {
    /// No uncertainty at all.
    #[must_use]
    pub(crate) fn zero() -> Self {
        Self { upper: Upper::default() }
    }

    /// The covariance between two blocks of states.
    #[must_use]
    #[inline]
    pub fn block(&self, row: Block, column: Block) -> Matrix3<f64> {
        self.get(row.index(), column.index())
    }

    /// The variances of a block's states.
    #[must_use]
    #[inline]
    pub fn diagonal(&self, block: Block) -> Vector3<f64> {
        self.diagonal_between(block, block)
    }

    /// The covariances of a block's states with those of a later block on the same axes.
    #[inline]
    pub(crate) fn diagonal_between(&self, row: Block, column: Block) -> Vector3<f64> {
        Vector3::from(self.upper[at(row.index(), column.index())].diagonal())
    }

    /// The whole matrix.
    #[must_use]
    pub fn dense(&self) -> SMatrix<f64, STATES, STATES> {
        let mut dense = SMatrix::<f64, STATES, STATES>::zeros();
        for i in 0..BLOCKS {
            for j in 0..BLOCKS {
                dense.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&self.get(i, j));
            }
        }
        dense
    }

    /// P becomes F P Fᵀ + Q, with the `noise` in Q.
    #[inline(always)]
    pub(crate) fn predict<S: Simd>(&mut self, simd: S, transition: &Transition, noise: &Noise) {
        if transition.has_earth_rate() {
            simd.vectorize(PredictWithEarthRate {
                p: self,
                transition: *transition,
                noise: *noise,
            });
        } else {
            self.apply_factors(simd, transition, noise);
        }
    }

    /// Applies the factors of a transition, then adds the noise.
    #[inline(always)]
    fn apply_factors(&mut self, simd: impl Simd, transition: &Transition, noise: &Noise) {
        let (half, tilt, bias) = transition.factors();
        forward::predict(simd, &mut self.upper, &Prediction { half, tilt, bias: &bias, noise });
    }

    /// Adds Q.
    fn add_noise(&mut self, noise: &Noise) {
        let &Noise { position, velocity, attitude, gyro_bias, accel_bias, position_velocity } =
            noise;
        let variances = [position, velocity, attitude, gyro_bias, accel_bias];
        for (block, variance) in Block::ALL.into_iter().zip(variances) {
            self.add_variance(block, variance);
        }
        self.upper[at(Block::Position.index(), Block::Velocity.index())]
            .add_diagonal([position_velocity; 3]);
    }

    /// Adds the same independent variance to each state of a block.
    #[inline]
    pub(crate) fn add_variance(&mut self, block: Block, variance: f64) {
        self.add_diagonal(block, &Vector3::repeat(variance));
    }

    /// Adds independent variances to the states of a block.
    #[inline]
    pub(crate) fn add_diagonal(&mut self, block: Block, variances: &Vector3<f64>) {
        self.upper[at(block.index(), block.index())].add_diagonal((*variances).into());
    }

    /// Observes the three states of `block` with the noise covariance `r`.
    ///
    /// When the innovation passes the `gate`, the observation is left where it is `used`, since it
    /// is large.  An innovation covariance that is not positive is rejected at an infinite distance.
    #[inline(always)]
    pub(crate) fn observe(
        &mut self,
        simd: impl Simd,
        block: Block,
        innovation: &Vector3<f64>,
        r: &Matrix3<f64>,
        gate: f64,
        used: &mut Option<Observation>,
    ) -> Update {
        let whitener = inverse_cholesky_factor(&(self.block(block, block) + r));
        self.observe_whitened(simd, block, whitener, innovation, gate, used)
    }

    /// Observes one state of `block`, that of an `axis`, with a `variance`.  As
    /// [`Covariance::observe`].
    #[inline(always)]
    pub(crate) fn observe_axis(
        &mut self,
        simd: impl Simd,
        (block, axis): (Block, usize),
        innovation: f64,
        variance: f64,
        gate: f64,
        used: &mut Option<Observation>,
    ) -> Update {
        let innovation_variance = self.diagonal(block)[axis] + variance;
        let whitener = (innovation_variance > 0.0).then(|| {
            let mut whitener = Matrix3::zeros();
            whitener[(axis, axis)] = 1.0 / innovation_variance.sqrt();
            whitener
        });
        let mut along_axis = Vector3::zeros();
        along_axis[axis] = innovation;
        self.observe_whitened(simd, block, whitener, &along_axis, gate, used)
    }

    /// Observes a block with the inverse factor of its innovation covariance.
    #[inline(always)]
    fn observe_whitened(
        &mut self,
        simd: impl Simd,
        block: Block,
        whitener: Option<Matrix3<f64>>,
        innovation: &Vector3<f64>,
        gate: f64,
        used: &mut Option<Observation>,
    ) -> Update {
        let Some(whitener) = whitener else {
            return Update { distance: f64::INFINITY, accepted: false };
        };
        let white_innovation = lower_mul(simd, &whitener, innovation);
        let distance = white_innovation.norm_squared();
        if distance.is_nan() || distance > gate {
            return Update { distance, accepted: false };
        }
        self.replay(simd, used.insert(Observation::new(block, whitener, white_innovation)));
        Update { distance, accepted: true }
    }

    /// Takes an observation, and finds its gain and the errors that it estimates.
    #[inline(always)]
    pub(crate) fn replay(&mut self, simd: impl Simd, observation: &mut Observation) {
        let Observation { block, whitener, white_innovation, whitened_gain, errors } = observation;
        forward::reduce(
            simd,
            &mut self.upper,
            block.index(),
            whitener,
            white_innovation,
            whitened_gain,
            errors,
        );
    }

    /// The states of `block` become independent of all others, with these `variances`.
    pub(crate) fn reset_block(&mut self, block: Block, variances: &Vector3<f64>) {
        let b = block.index();
        for k in 0..BLOCKS {
            self.upper[at(k.min(b), k.max(b))] = Block3::default();
        }
        self.add_diagonal(block, variances);
    }

    /// Propagates an information matrix Λ back over an observation.
    #[inline]
    pub(crate) fn information_before(
        &mut self,
        simd: impl Simd,
        block: Block,
        whitener: &Matrix3<f64>,
        gain: &WhitenedGain,
    ) {
        backward::observe(simd, &mut self.upper, block.index(), whitener, &gain.0);
    }

    /// P λ, and the diagonal of the position's block of P Λ P: the reduction of its variances by the
    /// `information` Λ of later samples.
    #[must_use]
    #[inline]
    pub(crate) fn smoothing(
        &self,
        simd: impl Simd,
        costate: &ErrorStates,
        information: &Self,
    ) -> (ErrorStates, Vector3<f64>) {
        let (errors, reduction) =
            backward::smooth(simd, &self.upper, &costate.0, &information.upper);
        (ErrorStates(errors), reduction)
    }

    /// The first state whose variance is not positive and finite, with that variance.
    #[inline]
    pub(crate) fn first_not_positive(&self) -> Option<(&'static str, f64)> {
        let (mut least, mut sum) = (f64::INFINITY, 0.0);
        for block in Block::ALL {
            for &variance in &self.diagonal(block) {
                least = if variance < least { variance } else { least };
                sum += variance;
            }
        }
        if least > 0.0 && sum < f64::INFINITY { None } else { self.find_not_positive() }
    }

    #[cold]
    fn find_not_positive(&self) -> Option<(&'static str, f64)> {
        Block::ALL.into_iter().find_map(|block| {
            let diagonal = self.diagonal(block);
            let bad = |variance: &&f64| !(**variance > 0.0 && variance.is_finite());
            diagonal.iter().find(bad).map(|&variance| (block.name(), variance))
        })
    }

    #[inline]
    fn get(&self, i: usize, j: usize) -> Matrix3<f64> {
        if i <= j {
            Matrix3::from(&self.upper[at(i, j)])
        } else {
            Matrix3::from(&self.upper[at(j, i)].transpose())
        }
    }

    /// Adds to the block (i, j), i ≠ j, and so to (j, i).
    #[inline]
    fn add(&mut self, i: usize, j: usize, gain: &Matrix3<f64>) {
        let upper = if i < j { *gain } else { gain.transpose() };
        let block = &mut self.upper[at(i.min(j), i.max(j))];
        *block = Block3::from(&(Matrix3::from(&*block) + upper));
    }
}

/// P becomes (I + E) P (I + E)ᵀ, where E has one block.
impl LinearMap for Covariance {
    #[inline(always)]
    fn add_transformed(&mut self, simd: impl Simd, target: Block, source: Block, m: &Matrix3<f64>) {
        forward::shear(simd, &mut self.upper, target.index(), source.index(), m);
    }

    #[inline(always)]
    fn add_scaled(&mut self, simd: impl Simd, target: Block, source: Block, scale: f64) {
        self.add_transformed(simd, target, source, &Matrix3::from_diagonal_element(scale));
    }

    #[inline]
    fn transform(&mut self, block: Block, m: &Matrix3<f64>) {
        let b = block.index();
        let own = m * self.get(b, b) * m.transpose();
        self.upper[at(b, b)] = Block3::from(&(0.5 * (own + own.transpose())));
        for k in (0..BLOCKS).filter(|&k| k != b) {
            let gain = m * self.get(b, k) - self.get(b, k);
            self.add(b, k, &gain);
        }
    }

    #[inline]
    fn apply_transposed_factors(
        &mut self,
        simd: impl Simd,
        half: f64,
        tilt: &Matrix3<f64>,
        bias: &Matrix3<f64>,
    ) {
        backward::predict(simd, &mut self.upper, half, &tilt.into(), &bias.into());
    }
}

/// See [`Covariance::predict`]: the noise is added after the rotation of the Earth.
///
/// It owns what it needs, so that the arguments of the frequent case may stay in registers.
struct PredictWithEarthRate<'a> {
    p: &'a mut Covariance,
    transition: Transition,
    noise: Noise,
}

impl WithSimd for PredictWithEarthRate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { p, transition, noise } = self;
        p.apply_factors(simd, &transition, &Noise::default());
        transition.apply_earth_rate(p);
        p.add_noise(&noise);
    }
}

/// L⁻¹ of a positive matrix L Lᵀ, by way of a unit triangle and the inverse pivots, so that no
/// square root depends on another; none if it is not positive.
#[inline(always)]
fn inverse_cholesky_factor(s: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let inverse = |x: f64| (x > 0.0 && x.is_finite()).then(|| 1.0 / x);
    let d0 = inverse(s.m11)?;
    let (l10, l20) = (s.m21 * d0, s.m31 * d0);
    let d1 = inverse(s.m22 - l10 * s.m21)?;
    let rest = s.m32 - l20 * s.m21;
    let l21 = rest * d1;
    let d2 = inverse(s.m33 - l20 * s.m31 - l21 * rest)?;
    let (w0, w1, w2) = (d0.sqrt(), d1.sqrt(), d2.sqrt());
    Some(Matrix3::new(w0, 0.0, 0.0, -l10 * w1, w1, 0.0, (l21 * l10 - l20) * w2, -l21 * w2, w2))
}

/// The product of a lower triangle and a vector.
#[inline(always)]
fn lower_mul(simd: impl Simd, m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        m.m11 * v.x,
        simd.mul_add(m.m21, v.x, m.m22 * v.y),
        simd.mul_add(m.m31, v.x, simd.mul_add(m.m32, v.y, m.m33 * v.z)),
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::simd::Baseline;

    type Dense = SMatrix<f64, STATES, STATES>;

    fn matrices() -> impl Strategy<Value = Matrix3<f64>> {
        prop::collection::vec(-2.0..2.0, 9).prop_map(|values| Matrix3::from_column_slice(&values))
    }

    fn blocks() -> impl Strategy<Value = Block> {
        prop::sample::select(&Block::ALL[..])
    }

    /// A positive covariance A Aᵀ + I.
    fn covariances() -> impl Strategy<Value = (Covariance, Dense)> {
        prop::collection::vec(-1.0..1.0, STATES * STATES).prop_map(|values| {
            let a = Dense::from_column_slice(&values);
            let dense = a * a.transpose() + Dense::identity();
            let dense = 0.5 * (dense + dense.transpose());
            let mut covariance = Covariance::zero();
            for i in 0..BLOCKS {
                for j in i..BLOCKS {
                    covariance.upper[at(i, j)] =
                        Block3::from(&dense.fixed_view::<3, 3>(3 * i, 3 * j).into_owned());
                }
            }
            (covariance, dense)
        })
    }

    fn selector(target: Block, source: Block, m: &Matrix3<f64>) -> Dense {
        let mut f = Dense::identity();
        let mut view = f.fixed_view_mut::<3, 3>(3 * target.index(), 3 * source.index());
        view += m;
        f
    }

    proptest! {
        #[test]
        fn a_shear_is_the_dense_congruence(
            (mut p, dense) in covariances(),
            m in matrices(),
            s in blocks(),
            t in blocks(),
        ) {
            prop_assume!(s != t);
            p.add_transformed(Baseline, t, s, &m);
            let f = selector(t, s, &m);
            prop_assert!((p.dense() - f * dense * f.transpose()).norm() < 1e-11);
            prop_assert_eq!(p.dense(), p.dense().transpose());
        }

        #[test]
        fn a_scaled_shear_is_a_shear_with_a_multiple_of_the_identity(
            (p, _) in covariances(),
            x in -2.0..2.0,
            s in blocks(),
            t in blocks(),
        ) {
            prop_assume!(s != t);
            let (mut scaled, mut transformed) = (p.clone(), p);
            scaled.add_scaled(Baseline, t, s, x);
            transformed.add_transformed(Baseline, t, s, &Matrix3::from_diagonal_element(x));
            prop_assert!((scaled.dense() - transformed.dense()).norm() < 1e-11);
            prop_assert_eq!(scaled.dense(), scaled.dense().transpose());
        }

        #[test]
        fn a_transformation_is_the_dense_congruence(
            (mut p, dense) in covariances(),
            m in matrices(),
            b in blocks(),
        ) {
            p.transform(b, &m);
            let f = selector(b, b, &(m - Matrix3::identity()));
            prop_assert!((p.dense() - f * dense * f.transpose()).norm() < 1e-11);
            prop_assert_eq!(p.dense(), p.dense().transpose());
        }

        #[test]
        fn an_observation_is_the_dense_joseph_update(
            (mut p, dense) in covariances(),
            b in blocks(),
            r in 0.01..2.0,
            y in [-1.0..1.0, -1.0..1.0, -1.0..1.0],
        ) {
            let innovation = Vector3::from(y);
            let (noise, mut used) = (Matrix3::from_diagonal_element(r), None);
            let update = p.observe(Baseline, b, &innovation, &noise, f64::INFINITY, &mut used);
            let mut h = SMatrix::<f64, 3, STATES>::zeros();
            h.fixed_columns_mut::<3>(3 * b.index()).fill_with_identity();
            let s = h * dense * h.transpose() + Matrix3::from_diagonal_element(r);
            let inverse = s.try_inverse().unwrap();
            let k = dense * h.transpose() * inverse;
            let rest = Dense::identity() - k * h;
            let joseph = rest * dense * rest.transpose() + r * k * k.transpose();
            prop_assert!((p.dense() - joseph).norm() < 1e-10);
            prop_assert!((update.distance - innovation.dot(&(inverse * innovation))).abs() < 1e-11);
            let correction = k * innovation;
            for (block, part) in used.unwrap().errors().0.iter().enumerate() {
                prop_assert!((part - correction.fixed_rows::<3>(3 * block)).norm() < 1e-11);
            }
            prop_assert_eq!(p.first_not_positive(), None);
            prop_assert!(p.dense().symmetric_eigenvalues().min() > 0.0);
        }
    }

    #[test]
    fn an_innovation_beyond_the_gate_changes_nothing() {
        let mut p = Covariance::zero();
        p.add_variance(Block::Velocity, 1.0);
        let before = p.clone();
        let (innovation, mut used) = (Vector3::new(10.0, 0.0, 0.0), None);
        let r = Matrix3::identity();
        let update = p.observe(Baseline, Block::Velocity, &innovation, &r, 49.0, &mut used);
        assert_eq!((update.accepted, used, p), (false, None, before));
        assert!((update.distance - 50.0).abs() < 1e-12);
    }
}
