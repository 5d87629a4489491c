//! Long work, and whoever may end it.
//!
//! Work over many samples is done in stretches; before each of them it asks a `progress` of the
//! caller's, whose error ends it.  The work hands that error out as it is, whatever its type is;
//! what was done so far is dropped.

/// Samples between two questions: 0.1 s of the slowest work on them.
pub(crate) const CHUNK: usize = 10_000;

/// The watch that never ends the work.
#[expect(clippy::unnecessary_wraps, reason = "a progress answers so")]
pub(crate) fn no_progress<E>() -> Result<(), E> {
    Ok(())
}
