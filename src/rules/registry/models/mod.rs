//! What is asked of robot models against the hardware that is bought for their joints.

pub(super) mod between;
pub(super) mod inertia;
pub(super) mod limits;
mod said;
