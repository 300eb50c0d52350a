//! A requirement that the reader accepts, solved with a few motors and gears: reader and solver together.

use std::sync::{Arc, OnceLock};

use gearwise::catalog::Catalog;
use gearwise::design::answer::{Design, JointResult};
use gearwise::design::optimize::optimize;
use gearwise::design::program::{Certificate, GAP_TOLERANCE};
use gearwise::design::{JointDemand, Mount, Prepared, grid};
use gearwise::input::Source;
use gearwise::requirement::{self, Joint, RatioChoice, Robot};

use super::parts::Parts;
use super::sane::{self, accepted};

const MOTORS: &str = "id,terminals,current,resistance [ohm],inductance [H],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],pole_pairs,peak_current [A],continuous_current [A],max_speed [rad/s],coulomb_friction [N*m],thermal_resistance_winding_housing [K/W],thermal_resistance_housing_ambient [K/W],thermal_time_constant_winding [s],thermal_time_constant_housing [s],source,source_kind
small,q_axis,q_axis,1,1e-3,0.05,1e-5,0.2,7,20,5,800,,1,4,10,600,-,derived
large,q_axis,q_axis,0.1,1e-4,0.1,1e-4,0.6,,60,20,,0.01,,,,,-,derived
";
const GEARS: &str = "id,kind,ratio,efficiency,mass [kg],inertia [kg*m^2],peak_torque [N*m],source,source_kind
planetary-4,planetary,4,0.95,0.1,1e-6,20,-,derived
planetary-9,planetary,9,0.9,0.15,2e-6,30,-,derived
belt-30,belt,30,0.7,0.4,,,-,derived
";
/// Ratios that are looked at between the ends.
const RATIOS: usize = 60;
/// What is too large to be looked at this way within the time of one input.
const MOST_SAMPLES: usize = 200;
const MOST_JOINTS: usize = 4;

fn catalog() -> &'static Catalog {
    static CATALOG: OnceLock<Catalog> = OnceLock::new();
    CATALOG.get_or_init(|| {
        let sources = [("motors.csv", MOTORS), ("gears.csv", GEARS)];
        let sources = sources.map(|(name, text)| Arc::new(Source::new(name, text))).to_vec();
        Catalog::from_sources(sources).expect("a catalogue")
    })
}

/// A requirement, and what is chosen for it.
pub fn solve(bytes: &[u8]) {
    let Some(mut parts) = Parts::new(bytes) else { return };
    let source = Arc::new(Source::new("requirement.toml", parts.main));
    let Some(robot) = accepted(requirement::read_changed(&source, &[], &mut parts)) else { return };
    sane::robot(&robot);
    let samples: usize = robot.joints.iter().map(|j| j.motion.len()).sum();
    // A spring takes seconds: the target `optimize` has them, with motions that are shorter still.
    let springs = robot.joints.iter().any(|j| j.limits.spring.is_some());
    if samples > MOST_SAMPLES || robot.joints.len() > MOST_JOINTS || springs {
        return;
    }
    let result = optimize(&robot, catalog());
    assert_eq!(result.joints.len(), robot.joints.len());
    for found in &result.joints {
        judge(&robot, found);
    }
}

fn judge(robot: &Robot, found: &JointResult) {
    let count = found.designs().count() + found.rejected.len();
    assert_eq!(count, catalog().motors.len(), "every motor is a candidate, cannot be judged or is rejected");
    let objectives: Vec<f64> = found.candidates.iter().map(|d| d.optimum.objective).collect();
    assert!(objectives.windows(2).all(|w| w[0] <= w[1]), "best first: {objectives:?}");
    for design in &found.candidates {
        numbers(design);
        if found.joint.limits.spring.is_none() {
            nothing_better(robot, found.joint, design);
        }
    }
}

/// No number of a design is NaN, what is called feasible is so, and its proof holds.
pub fn numbers(design: &Design) {
    let (optimum, at) = (&design.optimum, &design.evaluation);
    assert!(at.feasible, "the best design breaks a limit: {design:?}");
    sane::positive("ratio", [optimum.ratio]);
    sane::finite("objective", [optimum.objective, at.loss, at.peak_current, at.rms_current, at.mean_power]);
    sane::not_negative("evaluation", [at.loss, at.peak_current, at.rms_current, at.reflected_inertia]);
    sane::not_negative("mass", at.mass.into_iter().chain(at.peak_power));
    sane::finite("energy", at.energy);
    for margin in &at.margins {
        assert!(!margin.demand.is_nan() && !margin.bound.is_nan() && !margin.margin.is_nan(), "{margin:?}");
    }
    assert!(!design.reversal_time.is_some_and(f64::is_nan));
    assert!(!design.winding_temperature.kelvin().is_some_and(f64::is_nan));
    assert!(!optimum.windows.is_empty());
    for window in &optimum.windows {
        assert!(window.min <= window.max * (1.0 + 1e-9), "{window:?}");
    }
    let window = optimum.window();
    let inside = window.min <= optimum.ratio * (1.0 + 1e-6) && optimum.ratio <= window.max * (1.0 + 1e-6);
    assert!(inside, "{optimum:?}");
    for price in &optimum.shadow_prices {
        sane::finite(price.limit, [price.price, price.elasticity]);
    }
    if let Certificate::Certified { lower_bound, gap, .. } = optimum.certificate {
        sane::finite("bound", [lower_bound, gap]);
        assert!((0.0..=GAP_TOLERANCE).contains(&gap), "{optimum:?}");
        let size = optimum.objective.abs().max(f64::MIN_POSITIVE);
        assert!(lower_bound <= optimum.objective + 1e-9 * size, "{optimum:?}");
    }
}

/// Looks at other ratios, or at the other gears, by the same evaluation: none that keeps all limits is better.
fn nothing_better(robot: &Robot, joint: &Joint, design: &Design) {
    let demand = JointDemand::new(joint, catalog());
    let better = |prepared: &Prepared, ratio: f64, size: f64| {
        let at = prepared.at_in_full(ratio);
        let kept = at.margins.iter().all(|m| m.margin > 1e-9);
        let value = at.objective(&joint.objective);
        let better = value.is_some_and(|value| value < design.optimum.objective - 2.0 * GAP_TOLERANCE * size);
        assert!(!(kept && better), "{value:?} at {ratio} is better than {:?}", design.optimum);
    };
    match &joint.ratio {
        RatioChoice::Continuous { .. } | RatioChoice::Listed { .. } => {
            let (min, max) = joint.ratio.range().expect("ratios");
            let candidate = Mount::new(robot, joint, &demand.load, design.motor).candidate().expect("a candidate");
            let prepared = Prepared::new(candidate);
            let middle = prepared.at_in_full((min * max).sqrt()).objective(&joint.objective).unwrap_or(0.0);
            let size = design.optimum.objective.abs().max(1e-6 * middle.abs()).max(1e-300);
            let ratios = joint.ratio.listed().map_or_else(|| grid(min, max, RATIOS), <[f64]>::to_vec);
            for ratio in ratios {
                better(&prepared, ratio, size);
            }
        }
        RatioChoice::Catalog { .. } => {
            for (gear, load) in demand.gears_for(design.motor) {
                let Ok(candidate) = Mount::new(robot, joint, load, design.motor).with_gear(Some(gear)).candidate()
                else {
                    continue;
                };
                better(&Prepared::new(candidate), gear.ratio, design.optimum.objective.abs());
            }
        }
    }
}
