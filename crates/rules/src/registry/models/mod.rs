//! What is asked of robot models against the hardware that is bought for their joints.

pub(crate) mod between;
pub(crate) mod inertia;
pub(crate) mod limits;
mod said;
