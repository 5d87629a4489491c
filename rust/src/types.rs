//! What passes between the stages: samples, states, solutions, trajectories and health.

pub mod health;
pub mod nav_state;
pub mod rate;
pub(crate) mod row_buffer;
pub mod sample;
pub mod sensor;
pub mod solution;
pub mod trajectory;
