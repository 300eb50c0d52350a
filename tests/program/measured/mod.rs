//! Whether a measurement becomes the right figures, effects and verdicts.

mod fitted_actuator;
mod honest_verdicts;
mod whole_robot;
