//! Vectors of four numbers on the best instruction set of the processor.
//!
//! A wheel must run on every x86-64, whose baseline has neither vectors of four nor the fused
//! multiply-add.  So the pipeline is compiled once for each instruction set, and the instruction set
//! is chosen where the navigator is made ([`detect`]).  It travels as a token, a type without size
//! that implements [`Simd`]: [`Simd::vectorize`] enters a function that is compiled for it, and
//! everything that is inlined there is compiled for it too.  A fused multiply-add rounds once
//! instead of twice, so the results differ in the sixteenth digit between instruction sets; one
//! process uses one of them.  On other targets the instruction set is known at
//! compile time.
//!
//! The names are those of the crate `pulp`, whose `Simd` has vectors of a width that depends on the
//! instruction set; a row of a 3x3 block needs four numbers on each.
//!
//! `FOOTNAV_KERNEL=plain` in the environment selects the baseline.

/// An instruction set that the processor has.
pub(crate) trait Simd: Copy + Send + Sync + 'static {
    /// Four numbers that are processed together.
    type F64x4: F64x4;

    /// Runs an operation in a function that is compiled for this instruction set.
    fn vectorize<W: WithSimd>(self, operation: W) -> W::Output;

    /// `a * b + c`, rounded once where the instruction set has that.
    fn mul_add(self, a: f64, b: f64, c: f64) -> f64;
}

/// An operation that is compiled for each instruction set; `with_simd` and all that it calls must be
/// inlined.
///
/// A closure, or `map` over an array of vectors, is not always inlined, and then each of its
/// instructions becomes a call: loops and arrays that are written out are.
pub(crate) trait WithSimd {
    /// Result of the operation.
    type Output;

    /// Runs the operation.
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output;
}

/// Four numbers that are processed together.
pub(crate) trait F64x4: Copy {
    fn load(numbers: &[f64; 4]) -> Self;

    /// Three numbers and a zero.
    fn from_array(numbers: [f64; 3]) -> Self;

    /// The same number in all places.
    fn splat(number: f64) -> Self;

    fn store(self, numbers: &mut [f64; 4]);

    /// `self * other`, number by number.
    #[must_use]
    fn mul(self, other: Self) -> Self;

    /// `factor * self`.
    #[must_use]
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self.mul(Self::splat(factor))
    }

    /// `self + factor * other`.
    #[must_use]
    #[inline(always)]
    fn add_scaled(self, factor: f64, other: Self) -> Self {
        self.add_product_of(Self::splat(factor), other)
    }

    /// `self + a * b`, number by number.
    #[must_use]
    fn add_product_of(self, a: Self, b: Self) -> Self;

    /// `self - a * b`, number by number.
    #[must_use]
    fn sub_product_of(self, a: Self, b: Self) -> Self;

    /// The first number of x, the second of y, the third of z and a zero.
    #[must_use]
    fn diagonal(x: Self, y: Self, z: Self) -> Self;

    /// The transpose of three rows; the fourth number of each is zero before and after.
    #[must_use]
    fn transpose(rows: [Self; 3]) -> [Self; 3];
}

/// The instruction set to use.
pub(crate) enum InstructionSet {
    /// That of every processor of the target.
    Baseline(Baseline),
    /// AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

/// The best instruction set that the processor has, unless the environment selects the baseline.
pub(crate) fn detect() -> InstructionSet {
    let baseline = std::env::var_os("FOOTNAV_KERNEL").is_some_and(|kernel| kernel == "plain");
    #[cfg(target_arch = "x86_64")]
    if !baseline && let Some(avx2) = Avx2::detect() {
        return InstructionSet::Avx2(avx2);
    }
    let _ = baseline;
    InstructionSet::Baseline(Baseline)
}

/// The value of an expression in which a name stands for the best instruction set.
#[cfg(test)]
macro_rules! on_best_instruction_set {
    ($simd:ident => $value:expr) => {
        match $crate::math::simd::detect() {
            $crate::math::simd::InstructionSet::Baseline($simd) => $value,
            #[cfg(target_arch = "x86_64")]
            $crate::math::simd::InstructionSet::Avx2($simd) => $value,
        }
    };
}
#[cfg(test)]
pub(crate) use on_best_instruction_set;

/// What every processor of the target has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Baseline;

impl Simd for Baseline {
    type F64x4 = BaselineVector;

    #[inline(never)]
    fn vectorize<W: WithSimd>(self, operation: W) -> W::Output {
        operation.with_simd(self)
    }

    #[inline(always)]
    fn mul_add(self, a: f64, b: f64, c: f64) -> f64 {
        a * b + c
    }
}

/// Four numbers on the instructions of every processor of the target.
#[derive(Clone, Copy)]
pub(crate) struct BaselineVector(wide::f64x4);

impl F64x4 for BaselineVector {
    #[inline(always)]
    fn load(numbers: &[f64; 4]) -> Self {
        Self(wide::f64x4::new(*numbers))
    }

    #[inline(always)]
    fn from_array([x, y, z]: [f64; 3]) -> Self {
        Self(wide::f64x4::new([x, y, z, 0.0]))
    }

    #[inline(always)]
    fn splat(number: f64) -> Self {
        Self(wide::f64x4::splat(number))
    }

    #[inline(always)]
    fn store(self, numbers: &mut [f64; 4]) {
        *numbers = self.0.to_array();
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }

    #[inline(always)]
    fn add_product_of(self, a: Self, b: Self) -> Self {
        Self(a.0.mul_add(b.0, self.0))
    }

    #[inline(always)]
    fn sub_product_of(self, a: Self, b: Self) -> Self {
        Self(a.0.mul_neg_add(b.0, self.0))
    }

    #[inline(always)]
    fn diagonal(x: Self, y: Self, z: Self) -> Self {
        let ([x, ..], [_, y, ..], [_, _, z, _]) = (x.0.to_array(), y.0.to_array(), z.0.to_array());
        Self(wide::f64x4::new([x, y, z, 0.0]))
    }

    #[inline(always)]
    fn transpose([a, b, c]: [Self; 3]) -> [Self; 3] {
        let (a, b, c) = (a.0.to_array(), b.0.to_array(), c.0.to_array());
        [0, 1, 2].map(|k| Self::from_array([a[k], b[k], c[k]]))
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;

/// AVX2 and FMA, detected at run time.
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions beyond the target's baseline are reached in no other way"
)]
mod avx2 {
    use std::arch::x86_64::{
        __m256d, _mm256_blend_pd, _mm256_castpd256_pd128, _mm256_fmadd_pd, _mm256_fnmadd_pd,
        _mm256_insertf128_pd, _mm256_loadu_pd, _mm256_mul_pd, _mm256_permute2f128_pd,
        _mm256_set1_pd, _mm256_setr_pd, _mm256_setzero_pd, _mm256_storeu_pd, _mm256_unpackhi_pd,
        _mm256_unpacklo_pd,
    };

    use super::{F64x4, Simd, WithSimd};

    /// Proof that the processor has AVX2 and FMA: made by [`Avx2::detect`] alone.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct Avx2(());

    impl Avx2 {
        /// The instruction set, if the processor has it.
        pub(super) fn detect() -> Option<Self> {
            let detected = std::arch::is_x86_feature_detected!("avx2")
                && std::arch::is_x86_feature_detected!("fma");
            detected.then_some(Self(()))
        }
    }

    #[target_feature(enable = "avx2,fma")]
    fn compiled<W: WithSimd>(operation: W, simd: Avx2) -> W::Output {
        operation.with_simd(simd)
    }

    impl Simd for Avx2 {
        type F64x4 = Avx2Vector;

        #[inline]
        fn vectorize<W: WithSimd>(self, operation: W) -> W::Output {
            // SAFETY: `self` exists, so the processor has both features.
            unsafe { compiled(operation, self) }
        }

        #[inline(always)]
        fn mul_add(self, a: f64, b: f64, c: f64) -> f64 {
            a.mul_add(b, c)
        }
    }

    /// Made by code that holds an [`Avx2`], which makes each instruction sound.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2Vector(__m256d);

    impl F64x4 for Avx2Vector {
        #[inline(always)]
        fn load(numbers: &[f64; 4]) -> Self {
            // SAFETY: four numbers are read where there are four; the processor has AVX.
            Self(unsafe { _mm256_loadu_pd(numbers.as_ptr()) })
        }

        #[inline(always)]
        fn from_array([x, y, z]: [f64; 3]) -> Self {
            // SAFETY: the processor has AVX.
            Self(unsafe { _mm256_setr_pd(x, y, z, 0.0) })
        }

        #[inline(always)]
        fn splat(number: f64) -> Self {
            // SAFETY: the processor has AVX.
            Self(unsafe { _mm256_set1_pd(number) })
        }

        #[inline(always)]
        fn store(self, numbers: &mut [f64; 4]) {
            // SAFETY: four numbers are written where there are four; the processor has AVX.
            unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: the processor has AVX.
            Self(unsafe { _mm256_mul_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn add_product_of(self, a: Self, b: Self) -> Self {
            // SAFETY: the processor has AVX and FMA.
            Self(unsafe { _mm256_fmadd_pd(a.0, b.0, self.0) })
        }

        #[inline(always)]
        fn sub_product_of(self, a: Self, b: Self) -> Self {
            // SAFETY: the processor has AVX and FMA.
            Self(unsafe { _mm256_fnmadd_pd(a.0, b.0, self.0) })
        }

        #[inline(always)]
        fn diagonal(x: Self, y: Self, z: Self) -> Self {
            // SAFETY: the processor has AVX.
            unsafe {
                let xy = _mm256_blend_pd::<0b0010>(x.0, y.0);
                let z = _mm256_blend_pd::<0b1000>(z.0, _mm256_setzero_pd());
                Self(_mm256_blend_pd::<0b1100>(xy, z))
            }
        }

        #[inline(always)]
        fn transpose([a, b, c]: [Self; 3]) -> [Self; 3] {
            // SAFETY: the processor has AVX.
            unsafe {
                let ab = _mm256_unpacklo_pd(a.0, b.0);
                let c_first = _mm256_castpd256_pd128(c.0);
                let first = _mm256_insertf128_pd::<1>(ab, c_first);
                [
                    Self(_mm256_blend_pd::<0b1000>(first, c.0)),
                    Self(_mm256_unpackhi_pd(_mm256_insertf128_pd::<1>(a.0, c_first), b.0)),
                    Self(_mm256_permute2f128_pd::<0x31>(ab, c.0)),
                ]
            }
        }
    }
}
