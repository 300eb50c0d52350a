//! What is asked of robot models against the hardware that is bought for their joints.

pub(in crate::rules) mod between;
pub(in crate::rules) mod inertia;
pub(in crate::rules) mod limits;
mod said;
