//! Vectors of four numbers, on the best instructions that the processor has.
//!
//! A wheel must run on every x86-64, where vectors of four and the fused multiply-add came later
//! than the architecture: what works on lanes is compiled twice, and the processor tells which one
//! is run.  The choice is made once for a sample or a block of them, so that all of a sample's
//! arithmetic is compiled for the same instructions.  Elsewhere the target says at compile time
//! what there is.  A fused multiply-add rounds once instead of twice, so the two differ in the
//! sixteenth digit; one process uses one of them.
//!
//! `FOOTNAV_KERNEL=plain` in the environment forces the baseline.

#[cfg(target_arch = "x86_64")]
use std::sync::OnceLock;

/// Four numbers that are worked on together.
pub(crate) trait Lanes: Copy {
    /// Does work in a function of its own that is compiled for these lanes.
    fn call<W: Work>(work: W) -> W::Output;

    fn load(numbers: &[f64; 4]) -> Self;

    /// Three numbers and a zero.
    fn of(numbers: [f64; 3]) -> Self;

    /// The same number in all places.
    fn splat(number: f64) -> Self;

    fn store(self, numbers: &mut [f64; 4]);

    /// `a * b + c` of single numbers.
    fn fused(a: f64, b: f64, c: f64) -> f64;

    /// `self * other`, number by number.
    #[must_use]
    fn times(self, other: Self) -> Self;

    /// `factor * self`.
    #[must_use]
    #[inline(always)]
    fn scaled(self, factor: f64) -> Self {
        self.times(Self::splat(factor))
    }

    /// `self + factor * other`.
    #[must_use]
    #[inline(always)]
    fn plus(self, factor: f64, other: Self) -> Self {
        self.plus_times(Self::splat(factor), other)
    }

    /// `self + a * b`, number by number.
    #[must_use]
    fn plus_times(self, a: Self, b: Self) -> Self;

    /// `self - a * b`, number by number.
    #[must_use]
    fn minus_times(self, a: Self, b: Self) -> Self;

    /// The first number of x, the second of y, the third of z and a zero.
    #[must_use]
    fn diagonal(x: Self, y: Self, z: Self) -> Self;

    /// The transpose of three rows; the fourth number of each is zero before and after.
    #[must_use]
    fn transpose(rows: [Self; 3]) -> [Self; 3];
}

/// Work that is compiled for each kind of lanes; `run` must be inlined, as must all that it calls
/// with these lanes.
///
/// A closure, or `map` over an array of lanes, is not always inlined, and then each of its
/// instructions becomes a call: loops and arrays that are written out are.
pub(crate) trait Work {
    type Output;

    fn run<L: Lanes>(self) -> Self::Output;
}

/// Does the work on the best lanes that the processor has.
#[inline]
pub(crate) fn dispatch<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if has_avx() {
        return avx::run(work);
    }
    Baseline::call(work)
}

/// Whether the processor has AVX2 and FMA, and nobody forced the baseline.
#[cfg(target_arch = "x86_64")]
#[inline]
fn has_avx() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let forced = std::env::var_os("FOOTNAV_KERNEL").is_some_and(|kernel| kernel == "plain");
        !forced
            && std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("fma")
    })
}

/// What every processor of the target has.
#[derive(Clone, Copy)]
pub(crate) struct Baseline(wide::f64x4);

impl Lanes for Baseline {
    #[inline(never)]
    fn call<W: Work>(work: W) -> W::Output {
        work.run::<Self>()
    }

    #[inline(always)]
    fn load(numbers: &[f64; 4]) -> Self {
        Self(wide::f64x4::new(*numbers))
    }

    #[inline(always)]
    fn of([x, y, z]: [f64; 3]) -> Self {
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
    fn fused(a: f64, b: f64, c: f64) -> f64 {
        a * b + c
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }

    #[inline(always)]
    fn plus_times(self, a: Self, b: Self) -> Self {
        Self(a.0.mul_add(b.0, self.0))
    }

    #[inline(always)]
    fn minus_times(self, a: Self, b: Self) -> Self {
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
        [Self::of([a[0], b[0], c[0]]), Self::of([a[1], b[1], c[1]]), Self::of([a[2], b[2], c[2]])]
    }
}

/// AVX2 and FMA, found at run time.
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions beyond the target's baseline can be reached in no other way"
)]
mod avx {
    use std::arch::x86_64::{
        __m256d, _mm256_blend_pd, _mm256_castpd256_pd128, _mm256_fmadd_pd, _mm256_fnmadd_pd,
        _mm256_insertf128_pd, _mm256_loadu_pd, _mm256_mul_pd, _mm256_permute2f128_pd,
        _mm256_set1_pd, _mm256_setr_pd, _mm256_setzero_pd, _mm256_storeu_pd, _mm256_unpackhi_pd,
        _mm256_unpacklo_pd,
    };

    use super::{Lanes, Work, has_avx};

    /// Does the work on AVX lanes.
    #[inline]
    pub(super) fn run<W: Work>(work: W) -> W::Output {
        assert!(has_avx(), "AVX lanes are for a processor that has them");
        Avx::call(work)
    }

    #[target_feature(enable = "avx2,fma")]
    fn compiled<W: Work>(work: W) -> W::Output {
        work.run::<Avx>()
    }

    /// Comes into being in [`run`] alone, which has made sure of the processor: that is what makes
    /// each instruction below sound.
    #[derive(Clone, Copy)]
    struct Avx(__m256d);

    impl Lanes for Avx {
        #[inline]
        fn call<W: Work>(work: W) -> W::Output {
            // SAFETY: the processor has both features.
            unsafe { compiled(work) }
        }

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
        fn fused(a: f64, b: f64, c: f64) -> f64 {
            a.mul_add(b, c)
        }

        #[inline(always)]
        fn times(self, other: Self) -> Self {
            // SAFETY: the processor has AVX.
            Self(unsafe { _mm256_mul_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn plus_times(self, a: Self, b: Self) -> Self {
            // SAFETY: the processor has AVX and FMA.
            Self(unsafe { _mm256_fmadd_pd(a.0, b.0, self.0) })
        }

        #[inline(always)]
        fn minus_times(self, a: Self, b: Self) -> Self {
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
                [
                    Self(_mm256_blend_pd::<0b1000>(_mm256_insertf128_pd::<1>(ab, c_first), c.0)),
                    Self(_mm256_unpackhi_pd(_mm256_insertf128_pd::<1>(a.0, c_first), b.0)),
                    Self(_mm256_permute2f128_pd::<0x31>(ab, c.0)),
                ]
            }
        }
    }
}
