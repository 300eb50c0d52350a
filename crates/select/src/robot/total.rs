//! What is minimised over a whole robot.
//!
//! Joints that minimise the same quantity are added up, each as often as the robot has it. Where they
//! minimise different things there is no common unit: each is then divided by the best that its joint
//! could have alone, and that is said.

use gearwise_model::requirement::Joint;

/// How the joints' objectives make one number.
#[derive(Debug, Clone, PartialEq)]
pub struct Total {
    /// What a joint's objective is multiplied with: its count, and one over its reference.
    pub scale: Vec<f64>,
    /// In words, e.g. `loss`.
    pub name: String,
    /// Unit of the total.
    pub unit: &'static str,
    /// Whether each joint is measured by the best that it could have alone.
    pub relative: bool,
}

impl Total {
    /// Of joints and the best objective that each could have alone.
    ///
    /// # Errors
    /// Where joints minimise different things and a joint has no best, or one of zero or less: nothing can be measured by it.
    pub fn new(joints: &[Joint], best: &[f64]) -> Result<Total, String> {
        let counts = joints.iter().map(|j| f64::from(j.count));
        let Some(Joint { objective: first, .. }) = joints.first() else {
            return Err("the robot has no joints".into());
        };
        if joints.iter().all(|j| j.objective == *first) {
            return Ok(Total { scale: counts.collect(), name: first.name(), unit: first.unit(), relative: false });
        }
        if joints.iter().all(|j| j.objective.sole().is_none()) {
            let name = "the joints' weighted sums".into();
            return Ok(Total { scale: counts.collect(), name, unit: "1", relative: false });
        }
        if let Some((joint, _)) = joints.iter().zip(best).find(|(_, best)| !best.is_finite()) {
            return Err(format!(
                "the joints minimise different things, and `{}` has no design without what it carries: there is nothing to \
                 measure it by. Give every joint the same objective",
                joint.name
            ));
        }
        if let Some((joint, best)) = joints.iter().zip(best).find(|(_, best)| **best <= 0.0) {
            return Err(format!(
                "the joints minimise different things, and the best {} of `{}` is {best}: it cannot be the measure. Give \
                 every joint the same objective",
                joint.goal(),
                joint.name
            ));
        }
        let scale = counts.zip(best).map(|(count, best)| count / best).collect();
        Ok(Total { scale, name: "objectives over each joint's own best".into(), unit: "1", relative: true })
    }
}
