//! Which ratios a joint may have, and the gear that goes with a continuous one: `ratio`, `gears`, `gear`.

use crate::input::{Problem, Range, Section, key};
use crate::units;

/// Where the ratio of a joint comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum RatioChoice {
    /// Any ratio in an interval.
    Continuous {
        /// Smallest ratio.
        min: f64,
        /// Largest ratio.
        max: f64,
    },
    /// The gears of the catalogue whose id matches one of the patterns.
    Catalog {
        /// The patterns, `*` for any run of characters.
        patterns: Vec<String>,
        /// What a gear's efficiency acts on.
        efficiency_covers: EfficiencyCovers,
    },
}

/// What torque a gear's efficiency acts on, and whose direction of power it flips with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EfficiencyCovers {
    /// The load torque alone.
    Load,
    /// Load torque and the gear's own inertia (the convention of CORDS): the flip depends on the ratio.
    LoadAndGear,
}

impl EfficiencyCovers {
    /// Both with the word a requirement uses for them.
    pub const NAMES: &[(&str, EfficiencyCovers)] =
        &[("load", EfficiencyCovers::Load), ("load_and_gear", EfficiencyCovers::LoadAndGear)];
}

/// The gear assumed at a continuous ratio. SI; torques at the output, inertia and speed at the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearModel {
    /// Efficiency when the motor drives, η.
    pub efficiency: f64,
    /// Efficiency when the load drives, η_b; `2 − 1/η` unless given.
    pub backdrive_efficiency: f64,
    /// Mass, where it does not depend on the ratio \[kg\].
    pub mass: Option<f64>,
    /// Mass per stage \[kg\] and the largest ratio of a stage.
    pub mass_per_stage: Option<(f64, f64)>,
    /// Inertia at the input \[kg·m²\], J_g.
    pub inertia: f64,
    /// Largest output torque \[N·m\].
    pub peak_torque: Option<f64>,
    /// Output torque that can be carried for ever \[N·m\].
    pub continuous_torque: Option<f64>,
    /// Largest input speed \[rad/s\].
    pub max_input_speed: Option<f64>,
}

impl GearModel {
    /// A gear without loss, mass and inertia.
    pub const IDEAL: GearModel = GearModel {
        efficiency: 1.0,
        backdrive_efficiency: 1.0,
        mass: Some(0.0),
        mass_per_stage: None,
        inertia: 0.0,
        peak_torque: None,
        continuous_torque: None,
        max_input_speed: None,
    };

    /// Mass at a ratio \[kg\]: the fixed one, or as many stages as the ratio takes.
    pub fn mass_at(&self, ratio: f64) -> Option<f64> {
        match self.mass_per_stage {
            Some((mass, stage_ratio)) => Some(mass * f64::from(stages(ratio, stage_ratio))),
            None => self.mass,
        }
    }
}

/// Number of stages of at most `stage_ratio` that make `ratio`: none up to a ratio of one.
pub fn stages(ratio: f64, stage_ratio: f64) -> u32 {
    if ratio <= 1.0 {
        return 0;
    }
    let exact = ratio.ln() / stage_ratio.ln();
    // A ratio that is a power of the stage ratio needs no further stage for rounding's sake.
    (exact - 1e-9).ceil().max(1.0) as u32
}

/// Backdrive efficiency that belongs to a forward efficiency where friction is the same both ways:
/// `2 − 1/η`; below η = ½ the gear locks and it is negative.
pub fn backdrive_efficiency(efficiency: f64) -> f64 {
    2.0 - 1.0 / efficiency
}

/// Reads `ratio` or `gears` of a joint.
pub(super) fn read_ratio(section: &Section) -> Option<RatioChoice> {
    match (section.has("ratio"), section.has("gears")) {
        (true, true) => {
            section.note(Problem::at(
                section.span_of("gears"),
                "a joint has `ratio` or `gears`, not both",
                "remove one of the two",
            ));
            None
        }
        (false, false) => {
            section.missing("ratio", "{ min = 3, max = 30 }");
            None
        }
        (false, true) => {
            let patterns = section.texts(
                key("gears", "gears of the catalogue by id, `*` for any run of characters")
                    .value("list of patterns")
                    .or("ratio"),
            )?;
            Some(RatioChoice::Catalog {
                patterns: patterns.into_iter().map(|p| p.into_inner()).collect(),
                efficiency_covers: section
                    .choice(
                        key("efficiency_covers", "what the efficiency of these gears is counted for").default("`load`"),
                        EfficiencyCovers::NAMES,
                    )
                    .unwrap_or(EfficiencyCovers::Load),
            })
        }
        (true, false) => {
            let ratio = section.section(key("ratio", "a continuous ratio").or("gears"))?;
            let (min, max) = (
                ratio.number(key("min", "smallest ratio").required(), Range::Positive),
                ratio.number(key("max", "largest ratio").required(), Range::Positive),
            );
            for (key, value) in [("min", min), ("max", max)] {
                if value.is_none() && !ratio.has(if key == "min" { "min" } else { "max" }) {
                    ratio.missing(if key == "min" { "min" } else { "max" }, if key == "min" { "3" } else { "30" });
                }
            }
            let (span, max_span) = (ratio.span(), ratio.span_of("max"));
            ratio.finish();
            let (min, max) = (min?, max?);
            if min > max {
                section.note(
                    Problem::at(
                        max_span,
                        format!("the ratio range is upside down: max = {max} is less than min = {min}"),
                        "less than min",
                    )
                    .help("swap min and max"),
                );
                return None;
            }
            if max / min > 1e6 || max > 1e6 || min < 1e-6 {
                section.note(Problem::at(
                    span,
                    "the ratio range is not one of a gear",
                    "expected ratios between 1e-6 and 1e6, at most a factor of 1e6 apart",
                ));
                return None;
            }
            Some(RatioChoice::Continuous { min, max })
        }
    }
}

/// Reads `gear` of a joint.
pub(super) fn read_gear(section: Section) -> GearModel {
    let efficiency =
        section.number(key("efficiency", "when the motor drives, η").default("1"), Range::Fraction).unwrap_or(1.0);
    let backdrive = section
        .number(key("backdrive_efficiency", "when the load drives, η_b; at most 1").default("2 − 1/η"), Range::Any);
    if backdrive.is_some_and(|b| b > 1.0) {
        section.note(Problem::at(
            section.span_of("backdrive_efficiency"),
            "`backdrive_efficiency` of [gear] is out of range",
            "expected at most 1",
        ));
    }
    let per_stage =
        section.quantity(key("mass_per_stage", "of each stage, in place of `mass`"), &units::MASS, Range::NonNegative);
    let stage_ratio = section.number(
        key("stage_ratio", "largest ratio of one stage, at least 1.1; with `mass_per_stage`"),
        Range::AtLeastOne,
    );
    let mass = section.quantity(
        key("mass", "where it does not depend on the ratio").default("none"),
        &units::MASS,
        Range::NonNegative,
    );
    match (per_stage, stage_ratio) {
        (Some(_), Some(ratio)) if ratio < 1.1 => {
            section.note(Problem::at(
                section.span_of("stage_ratio"),
                "`stage_ratio` of [gear] is out of range",
                "expected at least 1.1",
            ));
        }
        (Some(_), None) if !section.has("stage_ratio") => {
            section.missing("stage_ratio", "5  # largest ratio of one stage")
        }
        (None, Some(_)) if !section.has("mass_per_stage") => section.missing("mass_per_stage", "\"120 g\""),
        _ => {}
    }
    if per_stage.is_some() && mass.is_some() {
        section.note(Problem::at(
            section.span_of("mass_per_stage"),
            "a gear has `mass` or `mass_per_stage`, not both",
            "remove one of the two",
        ));
    }
    let gear = GearModel {
        efficiency,
        backdrive_efficiency: backdrive.unwrap_or_else(|| backdrive_efficiency(efficiency)),
        mass: mass.or(if per_stage.is_some() { None } else { Some(0.0) }),
        mass_per_stage: per_stage.zip(stage_ratio),
        inertia: section
            .quantity(key("inertia", "at the input, J_g").default("none"), &units::INERTIA, Range::NonNegative)
            .unwrap_or(0.0),
        peak_torque: section.quantity(key("peak_torque", "largest, at the output"), &units::TORQUE, Range::Positive),
        continuous_torque: section.quantity(
            key("continuous_torque", "continuous, at the output"),
            &units::TORQUE,
            Range::Positive,
        ),
        max_input_speed: section.quantity(
            key("max_input_speed", "largest, at the input"),
            &units::SPEED,
            Range::Positive,
        ),
    };
    let covers =
        key("efficiency_covers", "only `load` here: `load_and_gear` needs gears of the catalogue").default("`load`");
    if section.choice(covers, EfficiencyCovers::NAMES) == Some(EfficiencyCovers::LoadAndGear) {
        let span = section.span_of("efficiency_covers");
        section.note(
            Problem::at(span, "`efficiency_covers = \"load_and_gear\"` needs gears of the catalogue", "not with a continuous ratio")
                .help("which way power flows through the gear then depends on the ratio; use `gears`, or cover the load alone"),
        );
    }
    section.finish();
    gear
}
