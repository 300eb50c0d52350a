//! The ratio program of a motor at a joint, solved: whatever can or cannot be judged of the design.

use gearwise::actuator::Load;
use gearwise::catalog::Motor;
use gearwise::design::answer::Reason;
use gearwise::design::program::{Optimum, RatioProgram};
use gearwise::design::{Evaluation, Mount, Prepared};
use gearwise::requirement::{RatioChoice, Robot};

/// What the ratio program says of a motor at the first joint, whatever can or cannot be judged of it.
pub struct Solved {
    pub optimum: Optimum,
    #[allow(dead_code, reason = "each test file uses its part")]
    pub evaluation: Evaluation,
}

/// Solves the ratio program of a motor at the first joint of a robot.
pub fn solve(motor: &Motor, robot: &Robot) -> Result<Solved, Reason> {
    let joint = &robot.joints[0];
    let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!("gears have no program") };
    let load = Load::new(&joint.motion, joint.ripple());
    let prepared = Prepared::new(Mount::new(robot, joint, &load, motor).candidate().map_err(Reason::Unusable)?);
    let optimum = RatioProgram::new(&prepared, &joint.objective, min, max).solve()?;
    let evaluation = prepared.at_in_full(optimum.ratio);
    assert!(evaluation.feasible, "the best design keeps its limits: {:?} of {optimum:?}", evaluation.tightest());
    Ok(Solved { optimum, evaluation })
}
