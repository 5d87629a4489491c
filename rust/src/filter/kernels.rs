//! The hot kernels of the filter.

#[expect(clippy::many_single_char_names, reason = "as the blocks")]
pub(crate) mod backward;
#[cfg(test)]
mod dense;
pub(crate) mod forward;
