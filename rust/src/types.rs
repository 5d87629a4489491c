//! What passes between the stages: samples, states, solutions, trajectories and health.

pub mod health;
pub(crate) mod health_settings;
pub mod nav_state;
pub mod rate;
pub mod sample;
pub mod sensor;
pub mod solution;
pub mod trajectory;
