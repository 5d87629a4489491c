//! The crate from outside, as a Rust program uses it.

mod allocations;
mod dense_filter;
mod detectors;
mod lever_arm;
mod linear_cost;
mod navigator;
mod progress;
mod simulation;
mod strides;
