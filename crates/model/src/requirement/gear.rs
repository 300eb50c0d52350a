//! Which ratios a joint may have, and the gear that goes with a free one: `ratio`, `gears`, `gear`.

use std::sync::Arc;

use super::prices::{self, Money};
use super::teeth::{self, MOST_LISTED, SAME, Teeth, Toothed};
use crate::catalog::drag::Friction;
use crate::catalog::{Catalog, ContinuousTorque, Gear, GearRatings, LifeQuantile, matches_pattern, no_load_friction};
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
    /// One of certain ratios, with the gear that the requirement describes.
    Listed {
        /// The ratios, ascending, at least one.
        values: Vec<f64>,
        /// Where they were given as a grid, its step.
        step: Option<f64>,
        /// Where they are those of planetary stages, the teeth.
        teeth: Option<Arc<Teeth>>,
    },
    /// Gears of the catalogue.
    Catalog {
        /// Patterns of their ids, or of the names of their families; `*` for any run of characters.
        patterns: Vec<String>,
        /// Which of the two.
        from: GearsFrom,
        /// What a gear's efficiency acts on.
        efficiency_covers: EfficiencyCovers,
    },
}

/// By how much of itself four digits may be off.
const PRINTED: f64 = 5e-4;

impl RatioChoice {
    /// The gears that can be bought whose id matches one of the patterns.
    pub fn gears(patterns: Vec<String>, efficiency_covers: EfficiencyCovers) -> RatioChoice {
        RatioChoice::Catalog { patterns, from: GearsFrom::Gears, efficiency_covers }
    }

    /// The smallest and the largest ratio; `None` where gears of the catalogue have them.
    pub fn range(&self) -> Option<(f64, f64)> {
        match self {
            RatioChoice::Continuous { min, max } => Some((*min, *max)),
            RatioChoice::Listed { values, .. } => Some((*values.first()?, *values.last()?)),
            RatioChoice::Catalog { .. } => None,
        }
    }

    /// The ratios, where there are only certain ones.
    pub fn listed(&self) -> Option<&[f64]> {
        match self {
            RatioChoice::Listed { values, .. } => Some(values),
            _ => None,
        }
    }

    /// Whether the ratios were listed one by one, not as a range, a grid or by teeth.
    pub fn is_list(&self) -> bool {
        matches!(self, RatioChoice::Listed { step: None, teeth: None, .. })
    }

    /// The teeth, where the ratios are those of planetary stages.
    pub fn teeth(&self) -> Option<&Teeth> {
        match self {
            RatioChoice::Listed { teeth, .. } => teeth.as_deref(),
            _ => None,
        }
    }

    /// The gear of a ratio by its teeth, where the ratios are those of planetary stages.
    pub fn toothed(&self, ratio: f64) -> Option<&Toothed> {
        self.teeth()?.of(ratio)
    }

    /// Whether the ratios are those of gears of the catalogue.
    pub fn is_catalog(&self) -> bool {
        matches!(self, RatioChoice::Catalog { .. })
    }

    /// Whether ratios between the points of a family may be chosen, which only the catalogue knows.
    pub fn is_between(&self) -> bool {
        matches!(self, RatioChoice::Catalog { from, .. } if from.is_between())
    }

    /// The ratio that one was printed from in four digits, where the ratios are those of teeth; else the ratio itself.
    pub fn as_printed(&self, ratio: f64) -> f64 {
        let away = |n: &f64| (n / ratio - 1.0).abs();
        let of_teeth = self.teeth().into_iter().flat_map(|teeth| teeth.gears.iter().map(|gear| gear.ratio));
        of_teeth.filter(|n| away(n) <= PRINTED).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(ratio)
    }

    /// Whether a ratio may be chosen, but for rounding; of gears of the catalogue it is not told by the ratio.
    pub fn allows(&self, ratio: f64) -> bool {
        let same = |n: &f64| (ratio - n).abs() <= SAME * n.abs();
        match self {
            RatioChoice::Continuous { min, max } => min * (1.0 - SAME) <= ratio && ratio <= max * (1.0 + SAME),
            RatioChoice::Listed { values, .. } => values.iter().any(same),
            RatioChoice::Catalog { .. } => true,
        }
    }
}

/// Where the gears of a joint are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GearsFrom {
    /// Among the gears that can be bought.
    Gears,
    /// Among the points of families.
    Families {
        /// Whether a ratio between two points may be chosen, too. The catalogue knows the points: with it such a joint becomes one
        /// of a free ratio (`design::families`).
        between: bool,
    },
}

impl GearsFrom {
    /// The key that names them.
    pub fn word(self) -> &'static str {
        match self {
            GearsFrom::Gears => "gears",
            GearsFrom::Families { .. } => "family",
        }
    }

    /// Whether ratios between the points of a family may be chosen.
    pub fn is_between(self) -> bool {
        self == GearsFrom::Families { between: true }
    }

    /// Whether a gear is one that patterns name.
    pub fn has(self, patterns: &[String], gear: &Gear) -> bool {
        let name = match (self, gear.family.is_empty()) {
            (GearsFrom::Gears, true) => &gear.id,
            (GearsFrom::Families { .. }, false) => &gear.family,
            _ => return false,
        };
        patterns.iter().any(|p| matches_pattern(p, name))
    }

    /// The gears that patterns name, in the order of the catalogue.
    pub fn of<'c>(self, patterns: &[String], catalog: &'c Catalog) -> Vec<&'c Gear> {
        catalog.all_gears().filter(|gear| self.has(patterns, gear)).collect()
    }
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
    /// What else it may bear.
    pub ratings: GearRatings,
    /// Backlash at the output \[rad\].
    pub backlash: Option<f64>,
    /// Torsional stiffness at the output \[N·m/rad\].
    pub stiffness: Option<f64>,
    /// What it takes without load, at its input.
    pub no_load: Friction,
    /// Coulomb friction at its input at rest \[N·m\], where anything says one.
    pub friction_at_rest: Option<f64>,
    /// Torque at the output that sets it going with nothing at its input \[N·m\], where that is printed.
    pub backdriving_torque: Option<f64>,
    /// Whether anything is said of what it loses.
    pub says_loss: bool,
    /// Outer diameter \[m\]; `None` where it is not known.
    pub outer_diameter: Option<f64>,
    /// Length along the axis \[m\]; `None` where it is not known.
    pub length: Option<f64>,
    /// Price in the currency of `[prices]`, where the requirement says it; `None` where it is not known, and of a gear of the catalogue,
    /// whose offer says it.
    pub price: Option<f64>,
    /// Time until it is delivered \[s\]; `None` where it is not known.
    pub lead_time: Option<f64>,
}

impl GearModel {
    /// A gear without loss, mass, inertia and size, that costs nothing: what a requirement has that describes none.
    pub const IDEAL: GearModel = GearModel {
        efficiency: 1.0,
        backdrive_efficiency: 1.0,
        mass: Some(0.0),
        mass_per_stage: None,
        inertia: 0.0,
        peak_torque: None,
        continuous_torque: None,
        max_input_speed: None,
        ratings: GearRatings {
            average_torque: None,
            momentary_peak_torque: None,
            ratcheting_torque: None,
            average_input_speed: None,
            rated_speed: None,
            rated_life: None,
            life_quantile: None,
            continuous_torque_is: None,
        },
        backlash: None,
        stiffness: None,
        no_load: Friction { coulomb: 0.0, viscous: 0.0 },
        friction_at_rest: None,
        backdriving_torque: None,
        says_loss: false,
        outer_diameter: Some(0.0),
        length: Some(0.0),
        price: Some(0.0),
        lead_time: Some(0.0),
    };

    /// Whether it takes nothing of what the model computes with: no loss, no mass, no inertia, and no limit of its own.
    pub fn takes_nothing(&self) -> bool {
        let GearModel { outer_diameter, length, price, lead_time, .. } = *self;
        *self == GearModel { outer_diameter, length, price, lead_time, ..GearModel::IDEAL }
    }

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

/// The keys of which a joint has one: where its ratio comes from.
pub(super) const RATIO_KEYS: [&str; 3] = ["ratio", "gears", "family"];

/// Reads `ratio`, `gears` or `family` of a joint.
pub(super) fn read_ratio(section: &Section) -> Option<RatioChoice> {
    let about = "whether a ratio between two points of the family may be chosen, where the gear is interpolated; one family then";
    let between = section.has("family").then(|| section.boolean(key("between", about).default("false"))).flatten();
    let given: Vec<&'static str> = RATIO_KEYS.into_iter().filter(|key| section.has(*key)).collect();
    let [only] = given[..] else {
        match given[..] {
            [first, second, ..] => {
                let message = format!("a joint has `{first}` or `{second}`, not both");
                section.note(Problem::at(section.span_of(second), message, "remove one of the two"));
            }
            _ => section.missing("ratio", "{ min = 3, max = 30 }"),
        }
        return None;
    };
    let patterns = |asked| {
        let texts = section.texts(key(only, asked).value("list of patterns").or("ratio"))?;
        Some(texts.into_iter().map(|p| p.into_inner()).collect())
    };
    let (patterns, from) = match only {
        "gears" => (patterns("gears of the catalogue by id, `*` for any run of characters")?, GearsFrom::Gears),
        "family" => {
            let about = "families of gears by name, `*` for any run of characters: each of their points is a gear";
            let patterns = patterns(about)?;
            (patterns, GearsFrom::Families { between: between.unwrap_or(false) })
        }
        _ => {
            let about = "the ratios that may be chosen: any between two, a grid, or a list";
            let table = section.section(key("ratio", about).or("gears` or `family"))?;
            let read = read_ratios(&table);
            table.finish();
            return read;
        }
    };
    let covers = key("efficiency_covers", "what the efficiency of these gears is counted for").default("`load`");
    let efficiency_covers = section.choice(covers, EfficiencyCovers::NAMES).unwrap_or(EfficiencyCovers::Load);
    if from.is_between() && efficiency_covers == EfficiencyCovers::LoadAndGear {
        let message = "`efficiency_covers = \"load_and_gear\"` is not for ratios between the points of a family";
        let problem = Problem::at(section.span_of("efficiency_covers"), message, "with `between`");
        section.note(
            problem.help("which way power flows through the gear then depends on the ratio; leave one of the two out"),
        );
    }
    Some(RatioChoice::Catalog { patterns, from, efficiency_covers })
}

/// Reads `{ min, max }`, `{ min, max, step }`, `{ values }` or `{ stages, teeth }`.
fn read_ratios(table: &Section) -> Option<RatioChoice> {
    let (min, max) = (
        table.number(key("min", "smallest ratio").or("values"), Range::Positive),
        table.number(key("max", "largest ratio").or("values"), Range::Positive),
    );
    let step =
        table.number(key("step", "of a grid that begins at `min`; without it any ratio between"), Range::Positive);
    let values = table.number_list(key("values", "the only ratios, ascending").or("min"), Range::Positive);
    let stages = teeth::read_stages(table);
    let about = "which teeth the stages may have: all that can be assembled are listed; with `stages`";
    let teeth = table.section(key("teeth", about));
    if table.has("stages") || table.has("teeth") {
        let teeth = teeth::read(table, stages, teeth)?;
        let values = teeth.gears.iter().map(|gear| gear.ratio).collect();
        return Some(RatioChoice::Listed { values, step: None, teeth: Some(teeth.into()) });
    }
    if table.has("values") {
        if let Some(other) = ["min", "max", "step"].into_iter().find(|other| table.has(*other)) {
            let message = format!("`values` lists the ratios: it has no `{other}`");
            let problem = Problem::at(table.span_of(other), message, "not with `values`");
            table.note(problem.help("remove `values`, or `min`, `max` and `step`"));
            return None;
        }
        return read_values(table, values?);
    }
    for (key, value, example) in [("min", min, "3"), ("max", max, "30")] {
        if value.is_none() && !table.has(key) {
            table.missing(key, example);
        }
    }
    let (min, max) = (min?, max?);
    if min > max {
        table.note(
            Problem::at(
                table.span_of("max"),
                format!("the ratio range is upside down: max = {max} is less than min = {min}"),
                "less than min",
            )
            .help("swap min and max"),
        );
        return None;
    }
    if max / min > 1e6 || max > 1e6 || min < 1e-6 {
        table.note(Problem::at(
            table.span(),
            "the ratio range is not one of a gear",
            "expected ratios between 1e-6 and 1e6, at most a factor of 1e6 apart",
        ));
        return None;
    }
    match (table.has("step"), step) {
        (false, _) => Some(RatioChoice::Continuous { min, max }),
        (true, step) => read_grid(table, (min, max), step?),
    }
}

/// The ratios of a grid.
fn read_grid(table: &Section, (min, max): (f64, f64), step: f64) -> Option<RatioChoice> {
    let wrong = |message: String, label: &str| {
        table.note(Problem::at(table.span_of("step"), message, label));
        None
    };
    if step > (max - min) * (1.0 + SAME) {
        return wrong(format!("a step of {step} leads past the range from {min} to {max}"), "larger than the range");
    }
    let steps = ((max - min) / step * (1.0 + SAME)).floor();
    if steps >= MOST_LISTED as f64 {
        let message = format!("a step of {step} makes {} ratios from {min} to {max}", steps + 1.0);
        return wrong(message, &format!("at most {MOST_LISTED}"));
    }
    // As it would be written by hand: 5.3, not 5.300000000000001.
    let at = |k: usize| format!("{:.12e}", min + k as f64 * step).parse().unwrap_or(min + k as f64 * step);
    let values = (0..=steps as usize).map(at).map(|ratio: f64| ratio.min(max)).collect();
    Some(RatioChoice::Listed { values, step: Some(step), teeth: None })
}

/// The ratios of a list.
fn read_values(table: &Section, values: Vec<f64>) -> Option<RatioChoice> {
    let wrong = |message: String, label: &str| {
        table.note(Problem::at(table.span_of("values"), message, label));
        None
    };
    if values.is_empty() {
        return wrong("`values` lists no ratio".into(), "expected at least one");
    }
    if values.len() > MOST_LISTED {
        return wrong(format!("`values` lists {} ratios", values.len()), &format!("at most {MOST_LISTED}"));
    }
    if let Some(outside) = values.iter().find(|n| !(1e-6..=1e6).contains(*n)) {
        return wrong(format!("{outside} is not a ratio of a gear"), "expected ratios between 1e-6 and 1e6");
    }
    for pair in values.windows(2) {
        if (pair[1] - pair[0]).abs() <= SAME * pair[0] {
            return wrong(format!("the ratio {} is listed twice", pair[1]), "expected each once");
        }
        if pair[1] < pair[0] {
            let message = format!("the ratios are not in ascending order: {} after {}", pair[1], pair[0]);
            return wrong(message, "expected the smallest first");
        }
    }
    Some(RatioChoice::Listed { values, step: None, teeth: None })
}

/// Reads `gear` of a joint, but for its `map`; with the number of its stages, where the ratio says it.
pub(super) fn read_gear(section: &Section, stages: Option<usize>, money: &Money) -> GearModel {
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
        key(
            "stage_ratio",
            "largest ratio of one stage, at least 1.1; with `mass_per_stage`, unless `ratio` lists stages",
        ),
        Range::AtLeastOne,
    );
    let mass = section.quantity(
        key("mass", "where it does not depend on the ratio").default("none"),
        &units::MASS,
        Range::NonNegative,
    );
    match (per_stage, stage_ratio) {
        (_, Some(_)) if stages.is_some() => {
            let message = "`stage_ratio` says how many stages a ratio takes, and `ratio` lists the stages itself";
            let problem = Problem::at(section.span_of("stage_ratio"), message, "a second number of one thing");
            section.note(problem.help("remove it: `mass_per_stage` counts the listed stages"));
        }
        (Some(_), Some(ratio)) if ratio < 1.1 => {
            section.note(Problem::at(
                section.span_of("stage_ratio"),
                "`stage_ratio` of [gear] is out of range",
                "expected at least 1.1",
            ));
        }
        (Some(_), None) if !section.has("stage_ratio") && stages.is_none() => {
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
    let (no_load, friction_at_rest) = read_no_load(section);
    let length = |name: &'static str, about: &'static str| {
        section.quantity(key(name, about), &units::LENGTH, Range::NonNegative)
    };
    let gear = GearModel {
        efficiency,
        backdrive_efficiency: backdrive.unwrap_or_else(|| backdrive_efficiency(efficiency)),
        // Listed stages are as many at every ratio.
        mass: mass.or(match (per_stage, stages) {
            (Some(mass), Some(stages)) => Some(mass * stages as f64),
            (Some(_), None) => None,
            (None, _) => Some(0.0),
        }),
        mass_per_stage: per_stage.zip(stage_ratio).filter(|_| stages.is_none()),
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
        ratings: read_ratings(section),
        backlash: section.quantity(key("backlash", "at the output"), &units::ANGLE, Range::NonNegative),
        stiffness: section.quantity(key("stiffness", "torsional, at the output"), &units::STIFFNESS, Range::Positive),
        no_load,
        friction_at_rest,
        backdriving_torque: None,
        says_loss: LOSSES.iter().any(|key| section.has(*key)),
        outer_diameter: length("outer_diameter", "of the gear; without it a limit on the diameter is not judged"),
        length: length("length", "of the gear along its axis; without it a limit on the length is not judged"),
        price: prices::read_amount(
            section,
            key("price", "of the gear; without it a limit on the price is not judged"),
            Range::NonNegative,
            money,
        ),
        lead_time: section.quantity(
            key("lead_time", "of the gear; without it a limit on it is not judged"),
            &units::TIME,
            Range::NonNegative,
        ),
    };
    check_ratings(section, &gear);
    let covers =
        key("efficiency_covers", "only `load` here: `load_and_gear` needs gears of the catalogue").default("`load`");
    if section.choice(covers, EfficiencyCovers::NAMES) == Some(EfficiencyCovers::LoadAndGear) {
        let span = section.span_of("efficiency_covers");
        section.note(
            Problem::at(span, "`efficiency_covers = \"load_and_gear\"` needs gears of the catalogue", "not with a continuous ratio")
                .help("which way power flows through the gear then depends on the ratio; use `gears`, or cover the load alone"),
        );
    }
    gear
}

/// Notes what a gear may bear for long that is more than what it may bear at all.
fn check_ratings(section: &Section, gear: &GearModel) {
    for ([(lower, least), (upper, most)], unit) in
        gear.ratings.contradictions(gear.continuous_torque, gear.peak_torque, gear.max_input_speed)
    {
        let show = |si: f64| crate::words::number(units::in_unit(si, unit));
        let message =
            format!("`{lower}` of [gear] is {} {unit}, more than its `{upper}` of {} {unit}", show(least), show(most));
        let problem = Problem::at(section.span_of(lower), message, "more than it may bear at all");
        section.note(problem.help(format!("correct one of the two: `{lower}` is at most `{upper}`")));
    }
}

/// Keys that say something of what a gear loses.
const LOSSES: &[&str] = &["efficiency", "no_load_torque", "starting_torque", "no_load_viscous"];

/// What a gear takes without load at its input, and what of it is Coulomb friction at rest, where anything says so.
fn read_no_load(section: &Section) -> (Friction, Option<f64>) {
    let torque = |name: &'static str, about: &'static str| {
        section.quantity(key(name, about).default("none"), &units::TORQUE, Range::NonNegative)
    };
    let running = torque(
        "no_load_torque",
        "that keeps it going without load, at its input: at any speed, or with `starting_torque` at \
         `no_load_torque_speed`; `efficiency` is then that of the load alone",
    );
    let starting = torque("starting_torque", "that sets it going without load, at its input");
    let about = "of the input, that `no_load_torque` holds at";
    let speed = section.quantity(key("no_load_torque_speed", about), &units::SPEED, Range::Positive);
    let viscous = section
        .quantity(
            key("no_load_viscous", "what it takes without load more per speed of the input").default("none"),
            &units::VISCOUS_FRICTION,
            Range::NonNegative,
        )
        .unwrap_or(0.0);
    let both = section.has("no_load_torque") && section.has("starting_torque");
    if both && !section.has("no_load_torque_speed") {
        section.missing("no_load_torque_speed", "\"2000 rpm\"");
    }
    if both && section.has("no_load_viscous") {
        let message = "`no_load_viscous` follows from `starting_torque` and `no_load_torque`";
        let problem = Problem::at(section.span_of("no_load_viscous"), message, "a second number of one thing");
        section.note(problem.help("leave one of the three out"));
    }
    let friction = no_load_friction(starting, running, speed);
    (Friction { viscous: friction.viscous + viscous, ..friction }, starting.or(running))
}

/// What a gear may bear beyond its continuous and its peak torque.
fn read_ratings(section: &Section) -> GearRatings {
    let torque =
        |name: &'static str, about: &'static str| section.quantity(key(name, about), &units::TORQUE, Range::Positive);
    let speed =
        |name: &'static str, about: &'static str| section.quantity(key(name, about), &units::SPEED, Range::Positive);
    GearRatings {
        average_torque: torque("average_torque", "largest average, at the output"),
        momentary_peak_torque: torque("momentary_peak_torque", "of a few shocks in a life, at the output"),
        ratcheting_torque: torque("ratcheting_torque", "at which teeth skip, at the output"),
        average_input_speed: speed("average_input_speed", "largest average, at the input"),
        rated_speed: speed("rated_speed", "of the input, that `rated_life` holds at"),
        rated_life: section.quantity(
            key("rated_life", "at `continuous_torque` and `rated_speed`"),
            &units::TIME,
            Range::Positive,
        ),
        life_quantile: section.choice(
            key("life_quantile", "what `rated_life` is: nine in ten gears last longer, or half of them"),
            LifeQuantile::NAMES,
        ),
        continuous_torque_is: section.choice(
            key("continuous_torque_is", "what `continuous_torque` is a limit of: that of the rated life, or of heat"),
            ContinuousTorque::NAMES,
        ),
    }
}
