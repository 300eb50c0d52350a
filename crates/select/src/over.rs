//! The best design over one number of the requirement that the ratio program does not choose: a ratio of a belt, a crank, a lead.
//!
//! The one idea: the number is set, and the inner choice is made with its certificate; a grid first, then golden sections between the
//! neighbours of the best. What is proved is proved at each number that was looked at, and nothing between them.

use std::cell::RefCell;

use super::answer::JointResult;
use super::program::Certificate;
use super::remake::Chosen;
use gearwise_model::numerics::line_search::golden_section;
use gearwise_model::requirement::Quantity;

/// What was found at one value of the number.
#[derive(Debug, Clone)]
pub struct Looked {
    /// The value, in the unit of the range.
    pub value: f64,
    /// The choice of each joint; an error where the requirement cannot be at this value.
    pub found: Result<Vec<Found>, String>,
}

/// What was chosen for a joint.
#[derive(Debug, Clone)]
pub struct Found {
    /// The joint.
    pub joint: String,
    /// How many of it there are.
    pub count: u32,
    /// The first choice; `None` where there is none.
    pub choice: Option<Chosen>,
    /// What all transmissions of the joint lose themselves \[W\], where the objective is the loss and their efficiency is given.
    pub between: f64,
}

impl Found {
    /// Of a result.
    pub fn new(result: &JointResult) -> Found {
        let is_loss = result.joint.objective.sole() == Some(Quantity::Loss);
        Found {
            joint: result.joint.name.clone(),
            count: result.joint.count,
            choice: result.candidates.first().map(Chosen::new),
            between: result
                .joint
                .passed
                .as_deref()
                .filter(|passed| is_loss && passed.numbers.says_loss)
                .map_or(0.0, |passed| passed.loss * f64::from(result.joint.count) / passed.joints.len() as f64),
        }
    }
}

impl Looked {
    /// The sum of the joints' objectives, each as often as there are actuators, with what transmissions lose where that is the loss; `None`
    /// where a joint has no choice.
    pub fn total(&self) -> Option<f64> {
        let found = self.found.as_ref().ok()?;
        found.iter().map(|f| Some(f64::from(f.count) * f.choice.as_ref()?.objective + f.between)).sum()
    }

    /// Whether every choice at this value is certified.
    pub fn is_proved(&self) -> bool {
        let certified =
            |f: &Found| f.choice.as_ref().is_some_and(|c| matches!(c.certificate, Certificate::Certified { .. }));
        self.found.as_ref().is_ok_and(|found| found.iter().all(certified))
    }
}

/// Golden sections after the grid.
const SECTIONS: usize = 12;

/// Looks at `points` values between two, and then nearer and nearer at the best of them; in the order of the values.
///
/// # Errors
/// A look that was stopped, or failed in a way that is none of the value's.
pub fn search<E>(
    (low, high): (f64, f64),
    points: usize,
    look: impl FnMut(f64) -> Result<Looked, E>,
) -> Result<Vec<Looked>, E> {
    let points = points.max(2);
    let at = |k: usize| low + (high - low) * k as f64 / (points - 1) as f64;
    // What was looked at, and what stopped it.
    let seen = RefCell::new((Vec::new(), None, look));
    let value = |at: f64| {
        let (all, failed, look) = &mut *seen.borrow_mut();
        if failed.is_some() {
            return f64::INFINITY;
        }
        match look(at) {
            Ok(looked) => {
                let total = looked.total().unwrap_or(f64::INFINITY);
                all.push(looked);
                total
            }
            Err(error) => {
                *failed = Some(error);
                f64::INFINITY
            }
        }
    };
    let grid: Vec<f64> = (0..points).map(|k| value(at(k))).collect();
    let best = (0..points).min_by(|a, b| grid[*a].total_cmp(&grid[*b])).unwrap_or(0);
    if grid[best].is_finite() {
        golden_section(&value, at(best.saturating_sub(1)), at((best + 1).min(points - 1)), SECTIONS);
    }
    let (mut all, failed, _) = seen.into_inner();
    if let Some(error) = failed {
        return Err(error);
    }
    all.sort_by(|a, b| a.value.total_cmp(&b.value));
    all.dedup_by(|b, a| a.value == b.value);
    Ok(all)
}

/// The best of what was looked at.
pub fn best(all: &[Looked]) -> Option<&Looked> {
    let totals = all.iter().filter_map(|looked| Some((looked.total()?, looked)));
    totals.reduce(|a, b| if b.0 < a.0 { b } else { a }).map(|(_, looked)| looked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Bind;

    fn looked(value: f64, objective: Option<f64>) -> Looked {
        let choice = objective.map(|objective| Chosen {
            motor: "m".into(),
            gear: None,
            ratio: 1.0,
            window: (1.0, 1.0),
            binds: (Bind::of("ratio_min", None), Bind::of("ratio_max", None)),
            margins: Vec::new(),
            objective,
            loss: objective,
            certificate: Certificate::NotCertified("a test".into()),
        });
        Looked { value, found: Ok(vec![Found { joint: "j".into(), count: 2, choice, between: 0.0 }]) }
    }

    #[test]
    fn the_least_of_a_valley_is_found_and_nothing_is_called_proved() {
        let all =
            search((0.0, 4.0), 9, |x| Ok::<_, ()>(looked(x, (x < 3.5).then_some((x - 1.3).powi(2) + 5.0)))).unwrap();
        let found = best(&all).unwrap();
        assert!((found.value - 1.3).abs() < 0.01, "{}", found.value);
        assert!((found.total().unwrap() - 10.0).abs() < 1e-3);
        assert!(!found.is_proved());
        assert!(all.windows(2).all(|w| w[0].value < w[1].value));
        // Where there is no choice there is no best.
        let none = search((0.0, 1.0), 5, |x| Ok::<_, ()>(looked(x, None))).unwrap();
        assert!(best(&none).is_none() && none.len() == 5);
    }
}
