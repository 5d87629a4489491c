//! Tests of the public interface of the crate.

mod allocations;
mod dense_filter;
mod detectors;
mod lever_arm;
mod linear_cost;
mod navigator;
mod position_fix;
mod progress;
mod simulation;
mod strides;
