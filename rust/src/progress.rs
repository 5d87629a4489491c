//! Cancellation of long computations.
//!
//! A computation over many samples is divided into chunks.  Before each chunk it calls the
//! `progress` function of the caller; an error cancels the computation.  The error is returned
//! unchanged, for any error type, and the partial result is dropped.

/// Samples per chunk: 0.1 s of the slowest computation.
pub(crate) const CHUNK: usize = 10_000;

/// A progress function that never cancels.
#[expect(clippy::unnecessary_wraps, reason = "the signature of a progress function")]
pub(crate) fn no_progress<E>() -> Result<(), E> {
    Ok(())
}
