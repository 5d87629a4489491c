//! Vectors of four numbers, on the best instructions that the processor has.
//!
//! A wheel must run on every x86-64, where vectors of four and the fused multiply-add came later than the architecture: what works on lanes is compiled twice, and the processor tells which
//! one is run.  Elsewhere the target says at compile time what there is.  A fused multiply-add rounds once instead of twice, so the two differ in the sixteenth digit; one process uses one of them.
//!
//! `FOOTNAV_KERNEL=plain` in the environment forces the baseline.

#[cfg(target_arch = "x86_64")]
use std::sync::OnceLock;

/// Four numbers that are worked on together.
pub(super) trait Lanes: Copy {
    fn load(numbers: &[f64; 4]) -> Self;

    /// Three numbers and a zero.
    fn of(numbers: [f64; 3]) -> Self;

    fn store(self, numbers: &mut [f64; 4]);

    /// `self + factor * other`.
    #[must_use]
    fn plus(self, factor: f64, other: Self) -> Self;

    /// `self + a * b`, number by number.
    #[must_use]
    fn plus_times(self, a: Self, b: Self) -> Self;

    /// The transpose of three rows; the fourth number of each is zero before and after.
    #[must_use]
    fn transpose(rows: [Self; 3]) -> [Self; 3];
}

/// Work that is compiled for each kind of lanes; `run` must be inlined, as must all that it calls.
pub(super) trait Work {
    fn run<L: Lanes>(self);
}

/// Does the work on the best lanes that the processor has.
#[inline]
pub(super) fn dispatch<W: Work>(work: W) {
    #[cfg(target_arch = "x86_64")]
    if has_avx() {
        return avx::run(work);
    }
    work.run::<Baseline>();
}

/// Whether the processor has AVX2 and FMA, and nobody forced the baseline.
#[cfg(target_arch = "x86_64")]
#[inline]
fn has_avx() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let forced = std::env::var_os("FOOTNAV_KERNEL").is_some_and(|kernel| kernel == "plain");
        !forced && std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
    })
}

/// What every processor of the target has.
#[derive(Clone, Copy)]
pub(super) struct Baseline(wide::f64x4);

impl Lanes for Baseline {
    #[inline(always)]
    fn load(numbers: &[f64; 4]) -> Self {
        Self(wide::f64x4::new(*numbers))
    }

    #[inline(always)]
    fn of([x, y, z]: [f64; 3]) -> Self {
        Self(wide::f64x4::new([x, y, z, 0.0]))
    }

    #[inline(always)]
    fn store(self, numbers: &mut [f64; 4]) {
        *numbers = self.0.to_array();
    }

    #[inline(always)]
    fn plus(self, factor: f64, other: Self) -> Self {
        Self(other.0.mul_add(wide::f64x4::splat(factor), self.0))
    }

    #[inline(always)]
    fn plus_times(self, a: Self, b: Self) -> Self {
        Self(a.0.mul_add(b.0, self.0))
    }

    #[inline(always)]
    fn transpose(rows: [Self; 3]) -> [Self; 3] {
        let [a, b, c] = rows.map(|row| row.0.to_array());
        [0, 1, 2].map(|k| Self(wide::f64x4::new([a[k], b[k], c[k], 0.0])))
    }
}

/// AVX2 and FMA, found at run time.
#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "instructions beyond the target's baseline can be reached in no other way")]
mod avx {
    use std::arch::x86_64::{
        __m256d, _mm256_blend_pd, _mm256_fmadd_pd, _mm256_loadu_pd, _mm256_permute2f128_pd, _mm256_set1_pd,
        _mm256_setr_pd, _mm256_setzero_pd, _mm256_storeu_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
    };

    use super::{Lanes, Work, has_avx};

    /// Does the work on AVX lanes.
    #[inline]
    pub(super) fn run<W: Work>(work: W) {
        #[target_feature(enable = "avx2,fma")]
        fn compiled<W: Work>(work: W) {
            work.run::<Avx>();
        }
        assert!(has_avx(), "AVX lanes are for a processor that has them");
        // SAFETY: the processor has both features.
        unsafe { compiled(work) }
    }

    /// Comes into being in [`run`] alone, which has made sure of the processor: that is what makes each instruction below sound.
    #[derive(Clone, Copy)]
    struct Avx(__m256d);

    impl Lanes for Avx {
        #[inline(always)]
        fn load(numbers: &[f64; 4]) -> Self {
            // SAFETY: four numbers are read where there are four; the processor has AVX.
            Self(unsafe { _mm256_loadu_pd(numbers.as_ptr()) })
        }

        #[inline(always)]
        fn of([x, y, z]: [f64; 3]) -> Self {
            // SAFETY: the processor has AVX.
            Self(unsafe { _mm256_setr_pd(x, y, z, 0.0) })
        }

        #[inline(always)]
        fn store(self, numbers: &mut [f64; 4]) {
            // SAFETY: four numbers are written where there are four; the processor has AVX.
            unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn plus(self, factor: f64, other: Self) -> Self {
            // SAFETY: the processor has AVX and FMA.
            Self(unsafe { _mm256_fmadd_pd(_mm256_set1_pd(factor), other.0, self.0) })
        }

        #[inline(always)]
        fn plus_times(self, a: Self, b: Self) -> Self {
            // SAFETY: the processor has AVX and FMA.
            Self(unsafe { _mm256_fmadd_pd(a.0, b.0, self.0) })
        }

        #[inline(always)]
        fn transpose([a, b, c]: [Self; 3]) -> [Self; 3] {
            // SAFETY: the processor has AVX.
            unsafe {
                let zero = _mm256_setzero_pd();
                let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a.0, b.0), _mm256_unpackhi_pd(a.0, b.0));
                let (c_even, c_odd) = (_mm256_blend_pd::<0b0101>(zero, c.0), _mm256_unpackhi_pd(c.0, zero));
                [
                    Self(_mm256_permute2f128_pd::<0x20>(ab_even, c_even)),
                    Self(_mm256_permute2f128_pd::<0x20>(ab_odd, c_odd)),
                    Self(_mm256_permute2f128_pd::<0x31>(ab_even, c_even)),
                ]
            }
        }
    }
}
