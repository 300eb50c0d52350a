//! The model of one motor, one gear, one joint.
//!
//! The one idea of this room: torque and voltage at the motor are linear in a few features of a
//! sample, each with its own power of the ratio ([`shaft`]). Squares of these are Laurent
//! polynomials in N ([`Laurent`]); the [`waveform`] finds their largest value over all samples, and
//! each limit says once which of them it bounds ([`limits`]).

mod along_d;
mod at_ratio;
pub mod candidate;
pub mod envelope;
pub mod estimate;
pub mod fitted;
pub mod gear_figures;
pub mod gearing;
mod heat_course;
pub mod limits;
pub mod load;
pub mod losses;
pub mod metrics;
pub mod parts;
pub mod shaft;
mod standing;
pub mod step_response;
pub mod stretch;
pub mod supply;
pub mod thermal;
pub mod thermal_motion;
pub mod waveform;
pub mod weakening;

pub use crate::numerics::laurent::Laurent;
pub use load::Load;
pub use shaft::Actuator;
