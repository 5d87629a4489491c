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
//! each sample tells if it ever does not.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::filter::error_state::{BLOCKS, Block, ErrorStates, LinearMap, STATES};
use crate::filter::kernels::backward;
use crate::filter::kernels::forward::{self, Prediction, WhitenedGain};
use crate::filter::observation::{Observation, Update};
use crate::filter::transition::{Noise, Transition};
use crate::math::block_matrix::{Block3, Upper, at};
use crate::math::simd::{Lanes, dispatch};

mod work;

use crate::filter::covariance::work::{Observe, ObserveAgain, Predict, PredictOnEarth};

/// Symmetric 15x15 covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance {
    upper: Upper,
}

impl Covariance {
    /// No uncertainty at all.
    #[must_use]
    pub fn zero() -> Self {
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
    pub fn predict(&mut self, transition: &Transition, noise: &Noise) {
        dispatch(Predict { p: self, transition, noise });
    }

    /// The same on the lanes that the caller is compiled for.
    #[inline(always)]
    pub(crate) fn predict_on<L: Lanes>(&mut self, transition: &Transition, noise: &Noise) {
        if transition.turns_with_earth() {
            L::call(PredictOnEarth { p: self, transition: *transition, noise: *noise });
        } else {
            self.shear_all::<L>(transition, noise);
        }
    }

    /// The shears of a transition, and the noise after them.
    #[inline(always)]
    fn shear_all<L: Lanes>(&mut self, transition: &Transition, noise: &Noise) {
        let (half, tilt, bias) = transition.shears();
        forward::predict::<L>(&mut self.upper, &Prediction { half, tilt, bias: &bias, noise });
    }

    /// Adds Q.
    fn add_noise(&mut self, noise: &Noise) {
        let &Noise { position, velocity, attitude, gyro_bias, accel_bias, position_velocity } =
            noise;
        for (block, variance) in
            Block::ALL.into_iter().zip([position, velocity, attitude, gyro_bias, accel_bias])
        {
            self.add_variance(block, variance);
        }
        self.upper[at(Block::Position.index(), Block::Velocity.index())]
            .add_diagonal([position_velocity; 3]);
    }

    /// Adds the same independent variance to each state of a block.
    #[inline]
    pub fn add_variance(&mut self, block: Block, variance: f64) {
        self.add_diagonal(block, &Vector3::repeat(variance));
    }

    /// Adds independent variances to the states of a block.
    #[inline]
    pub fn add_diagonal(&mut self, block: Block, variances: &Vector3<f64>) {
        self.upper[at(block.index(), block.index())].add_diagonal((*variances).into());
    }

    /// Observes the three states of `block` directly, with the same `variance` on each axis.
    ///
    /// Returns the outcome and, when the innovation passed the `gate`, the observation.  An
    /// innovation covariance that is not positive is answered by a rejection at an infinite
    /// distance.
    pub fn observe(
        &mut self,
        block: Block,
        innovation: &Vector3<f64>,
        variance: f64,
        gate: f64,
    ) -> (Update, Option<Observation>) {
        let whitener = self.whitener(block, variance);
        dispatch(Observe { p: self, block, whitener, innovation, gate })
    }

    /// As [`Covariance::observe`], on the lanes that the caller is compiled for; the observation,
    /// which is large, comes to be where it is `used`.
    #[inline(always)]
    pub(crate) fn observe_on<L: Lanes>(
        &mut self,
        block: Block,
        innovation: &Vector3<f64>,
        variance: f64,
        gate: f64,
        used: &mut Option<Observation>,
    ) -> Update {
        self.observe_white::<L>(block, self.whitener(block, variance), innovation, gate, used)
    }

    /// The inverse factor of the innovation covariance of a block; none if that is not positive.
    #[inline(always)]
    fn whitener(&self, block: Block, variance: f64) -> Option<Matrix3<f64>> {
        inverse_cholesky_factor(
            &(self.block(block, block) + Matrix3::from_diagonal_element(variance)),
        )
    }

    /// Observes one state of `block`, that of an axis.  As [`Covariance::observe`].
    pub fn observe_axis(
        &mut self,
        block: Block,
        axis: usize,
        innovation: f64,
        variance: f64,
        gate: f64,
    ) -> (Update, Option<Observation>) {
        let innovation_variance = self.diagonal(block)[axis] + variance;
        let whitener = (innovation_variance > 0.0).then(|| {
            let mut whitener = Matrix3::zeros();
            whitener[(axis, axis)] = 1.0 / innovation_variance.sqrt();
            whitener
        });
        let mut along_axis = Vector3::zeros();
        along_axis[axis] = innovation;
        dispatch(Observe { p: self, block, whitener, innovation: &along_axis, gate })
    }

    /// Observes a block with the inverse factor of its innovation covariance.
    #[inline(always)]
    fn observe_white<L: Lanes>(
        &mut self,
        block: Block,
        whitener: Option<Matrix3<f64>>,
        innovation: &Vector3<f64>,
        gate: f64,
        used: &mut Option<Observation>,
    ) -> Update {
        let Some(whitener) = whitener else {
            return Update { distance: f64::INFINITY, accepted: false };
        };
        let white_innovation = lower_times::<L>(&whitener, innovation);
        let distance = white_innovation.norm_squared();
        if distance.is_nan() || distance > gate {
            return Update { distance, accepted: false };
        }
        self.reduce::<L>(used.insert(Observation::new(block, whitener, white_innovation)));
        Update { distance, accepted: true }
    }

    /// Takes an observation and finds its gain, and the errors that it tells of.
    #[inline(always)]
    fn reduce<L: Lanes>(&mut self, observation: &mut Observation) {
        let Observation { block, whitener, white_innovation, whitened_gain, errors } = observation;
        forward::reduce::<L>(
            &mut self.upper,
            block.index(),
            whitener,
            white_innovation,
            whitened_gain,
            errors,
        );
    }

    /// The states of `block` are forgotten: independent of all others, with the same `variance` on
    /// each axis.
    pub fn replace(&mut self, block: Block, variance: f64) {
        self.reset_block(block, &Vector3::repeat(variance));
    }

    /// As [`Covariance::replace`], with a variance for each axis.
    pub(crate) fn reset_block(&mut self, block: Block, variances: &Vector3<f64>) {
        let b = block.index();
        for k in 0..BLOCKS {
            self.upper[at(k.min(b), k.max(b))] = Block3::default();
        }
        self.add_diagonal(block, variances);
    }

    /// Takes an observation once more, from the same covariance as the first time, and finds its
    /// gain.
    #[inline]
    pub(crate) fn replay(&mut self, observation: &mut Observation) {
        dispatch(ObserveAgain { p: self, observation });
    }

    /// An information matrix Λ goes back over an observation.
    #[inline]
    pub(crate) fn go_back_over(
        &mut self,
        block: Block,
        whitener: &Matrix3<f64>,
        gain: &WhitenedGain,
    ) {
        backward::observe(&mut self.upper, block.index(), whitener, &gain.0);
    }

    /// P λ, and what the `information` Λ that came later takes off the variances of the position:
    /// the diagonal of that block of P Λ P.
    #[must_use]
    #[inline]
    pub(crate) fn smoothing(
        &self,
        costate: &ErrorStates,
        information: &Self,
    ) -> (ErrorStates, Vector3<f64>) {
        let (errors, known) = backward::smooth(&self.upper, &costate.0, &information.upper);
        (ErrorStates(errors), known)
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
    fn add_transformed(&mut self, target: Block, source: Block, m: &Matrix3<f64>) {
        forward::shear(&mut self.upper, target.index(), source.index(), m);
    }

    fn add_scaled(&mut self, target: Block, source: Block, scale: f64) {
        self.add_transformed(target, source, &Matrix3::from_diagonal_element(scale));
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
    fn move_back(&mut self, half: f64, tilt: &Matrix3<f64>, bias: &Matrix3<f64>) {
        backward::predict(&mut self.upper, half, &tilt.into(), &bias.into());
    }
}

/// L⁻¹ of a positive matrix L Lᵀ, by way of a unit triangle and the inverse pivots, so that the
/// square roots wait for no one; none if it is not positive.
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
fn lower_times<L: Lanes>(m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        m.m11 * v.x,
        L::fused(m.m21, v.x, m.m22 * v.y),
        L::fused(m.m31, v.x, L::fused(m.m32, v.y, m.m33 * v.z)),
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

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
        fn a_shear_is_the_dense_congruence((mut p, dense) in covariances(), m in matrices(), s in blocks(), t in blocks()) {
            prop_assume!(s != t);
            p.add_transformed(t, s, &m);
            let f = selector(t, s, &m);
            prop_assert!((p.dense() - f * dense * f.transpose()).norm() < 1e-11);
            prop_assert_eq!(p.dense(), p.dense().transpose());
        }

        #[test]
        fn a_scaled_shear_is_a_shear_with_a_multiple_of_the_identity((p, _) in covariances(), x in -2.0..2.0, s in blocks(), t in blocks()) {
            prop_assume!(s != t);
            let (mut scaled, mut transformed) = (p.clone(), p);
            scaled.add_scaled(t, s, x);
            transformed.add_transformed(t, s, &Matrix3::from_diagonal_element(x));
            prop_assert!((scaled.dense() - transformed.dense()).norm() < 1e-11);
            prop_assert_eq!(scaled.dense(), scaled.dense().transpose());
        }

        #[test]
        fn a_transformation_is_the_dense_congruence((mut p, dense) in covariances(), m in matrices(), b in blocks()) {
            p.transform(b, &m);
            let f = selector(b, b, &(m - Matrix3::identity()));
            prop_assert!((p.dense() - f * dense * f.transpose()).norm() < 1e-11);
            prop_assert_eq!(p.dense(), p.dense().transpose());
        }

        #[test]
        fn an_observation_is_the_dense_joseph_update((mut p, dense) in covariances(), b in blocks(), r in 0.01..2.0, y in [-1.0..1.0, -1.0..1.0, -1.0..1.0]) {
            let innovation = Vector3::from(y);
            let (update, observation) = p.observe(b, &innovation, r, f64::INFINITY);
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
            for (block, part) in observation.unwrap().errors().0.iter().enumerate() {
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
        let (update, observation) =
            p.observe(Block::Velocity, &Vector3::new(10.0, 0.0, 0.0), 1.0, 49.0);
        assert_eq!((update.accepted, observation, p), (false, None, before));
        assert!((update.distance - 50.0).abs() < 1e-12);
    }
}
