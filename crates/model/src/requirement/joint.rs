//! One `[[joint]]` of a requirement.

use std::sync::Arc;

use super::carried::{self, Asked};
use super::gear::{EfficiencyCovers, GearModel, GearsFrom, RatioChoice};
use super::limits::{self, Limits};
use super::mechanism::{self, Model, Use};
use super::motions::{self, MotionReader};
use super::prices::Money;
use super::robot::{Filter, Joint};
use super::turns::{self, Turns};
use super::{Drive, MotorDrag, Objective, Quantity, cases, drive, gear, map_file, objective, transmission};
use crate::input::{Problem, Range, Section, key};
use crate::motion::{self, Motion};
use crate::units;

/// Reads a joint: with what it takes from a description of the robot, and whom it says that it carries.
pub(super) fn read(
    section: Section,
    ambient: f64,
    no_springs: Option<&str>,
    joints: &[String],
    money: &Money,
    model: &Model,
    reader: &mut MotionReader,
) -> Option<(Joint, Option<Use>, Vec<Asked>)> {
    let name = section.required_text(key("name", "name of the joint"), "\"knee\"").map(|t| t.into_inner());
    let count = section.count(key("count", "how many joints like this").default("1")).unwrap_or(1);
    let ratio = match is_for_modules_alone(&section) {
        true => Some(RatioChoice::gears(Vec::new(), EfficiencyCovers::Load)),
        false => gear::read_ratio(&section),
    };
    let (gear, map) = match section
        .section(key("gear", "the gear that goes with a continuous ratio").default("an ideal one"))
    {
        Some(gear) => {
            if let Some(RatioChoice::Catalog { from, .. }) = ratio {
                let (message, label, help) = match (is_for_modules_alone(&section), from) {
                    (_, GearsFrom::Families { .. }) => (
                        "`gear` describes the gear of a continuous ratio, but `family` names gears that have their numbers",
                        "not used with `family`",
                        "remove one of the two",
                    ),
                    (true, _) => (
                        "`gear` describes the gear of a continuous ratio, and this joint has modules alone",
                        "a module has its own gear",
                        "remove it; or give a `ratio` too, for motors next to the modules",
                    ),
                    (false, _) => (
                        "`gear` describes the gear of a continuous ratio, but `gears` takes them from the catalogue",
                        "not used with `gears`",
                        "remove one of the two",
                    ),
                };
                section.note(Problem::at(gear.span(), message, label).help(help));
            }
            let stages = ratio.as_ref().and_then(RatioChoice::teeth).map(|teeth| teeth.stages.len());
            let model = gear::read_gear(&gear, stages, money);
            let map = map_file::read(&gear, reader);
            gear.finish();
            (model, map)
        }
        None => (GearModel::IDEAL, None),
    };
    let scale = motions::read_scale(&section);
    let (read, taken) = if section.has("case") {
        (cases::read(&section, joints, name.as_ref(), scale, reader), None)
    } else if section.has("mechanism_joint") {
        let (motion, taken) = mechanism::read_joint(&section, scale, model).unzip();
        (motion.map(|m| (Arc::new(m), Vec::new())), taken)
    } else {
        (motions::read_motion(&section, joints, name.as_ref(), scale, reader), None)
    };
    let (motion, columns) = read.unzip();
    let between = transmission::read_joint(&section, money, reader);
    let (objective, balancing) = objective::read(&section).unzip();
    let limits = read_limits(&section, ambient, money, no_springs, motion.as_deref());
    let limits = Limits { mount_resistance: read_mount(&section), ..limits };
    if let Some(map) = &map {
        map_file::check(&section, map, ratio.as_ref(), &limits);
    }
    if ratio.as_ref().is_some_and(RatioChoice::is_between) {
        map_file::check_between(&section, &limits);
    }
    let noted = section.noted();
    let (motion, columns, passed) = match (&between, motion) {
        (Some(between), Some(motion)) => {
            match transmission::pass(&section, between, &motion, &limits, columns.unwrap_or_default()) {
                Some((motion, passed, columns)) => (Some(motion), Some(columns), Some(passed)),
                None => (None, None, None),
            }
        }
        (_, motion) => (motion, columns, None),
    };
    let is_broken = section.has("transmission") && (between.is_none() || section.noted() > noted);
    let own_drive = section.section(key("drive", "the drive of this joint, in place of the bus's")).map(|table| {
        let current =
            table.quantity(key("current", "largest drive current, phase amplitude"), &units::CURRENT, Range::Positive);
        let drive = Drive {
            supply_lead_resistance: table.quantity(
                key("supply_lead_resistance", "of the leads between the supply and this drive, both ways")
                    .default("none"),
                &units::RESISTANCE,
                Range::NonNegative,
            ),
            ..drive::read(&table, ["phase_resistance", "standby_power", "continuous_current"])
        };
        drive.check(&table, ["current", "continuous_current"], current);
        // A key that is none is a mistake of its own.
        if table.items().is_empty() {
            let keys = [
                "current",
                "continuous_current",
                "field_weakening_current",
                "phase_resistance",
                "standby_power",
                "supply_lead_resistance",
            ];
            let message = "[joint.drive] says nothing";
            let problem = Problem::at(table.span(), message, format!("expected one of {}", keys.join(", ")));
            table.note(problem.help("for example current = \"40 A\""));
        }
        table.finish();
        (current, drive)
    });
    let (drive_current, drive) = own_drive.unwrap_or_default();
    let motor_drag = section
        .choice(
            key("motor_drag", "`off` leaves out what no-load currents and estimates say of a motor's drag")
                .default("`counted`"),
            MotorDrag::NAMES,
        )
        .unwrap_or_default();
    if section.has(key("actuator", "refused by this version").value("–")) {
        let span = section.span_of("actuator");
        section.note(Problem::at(span, "`actuator` is not supported by this version", "remove it"));
    }
    let carries = carried::read(&section, columns.unwrap_or_default());
    let names = |about: &'static str, name: &'static str| {
        let asked = key(name, about).value("list of patterns");
        let texts = section.has(asked).then(|| section.texts(asked));
        texts.flatten().unwrap_or_default().into_iter().map(|text| text.into_inner()).collect()
    };
    let motors = Filter {
        allowed: names(
            "motors that may be chosen, by id or maker, `*` for any run of characters; all by default",
            "motors",
        ),
        excluded: names("motors that may not be chosen, by id or maker", "exclude"),
        turns: turns::read(&section),
        modules: names(
            "modules that may be chosen, by id or maker, `*` for any run of characters; next to motors where the joint has `ratio`, `gears` or `family`, else alone",
            "modules",
        ),
        only_modules: is_for_modules_alone(&section),
        made_for: Vec::new(),
    };
    if motors.only_modules && !motors.allowed.is_empty() {
        let message = "`motors` names motors, and this joint has modules alone";
        let problem = Problem::at(section.span_of("motors"), message, "motors need a ratio");
        section.note(problem.help("give `ratio`, `gears` or `family` for them too, or remove `motors`"));
    }
    let phases = read_phases(&section, count, motion.as_deref());
    if let (Some(objective), Some(motion)) = (&objective, &motion) {
        check_cycle(&section, objective, motion);
    }
    section.finish();
    let joint = Joint {
        name: name?,
        count,
        gear: map.as_ref().map_or(gear, |read| map_file::gear(&gear, &read.map, ratio.as_ref())),
        gear_map: map.map(|read| read.map),
        ratio: ratio?,
        motors,
        motion: motion.filter(|_| !is_broken)?,
        passed,
        objective: objective?,
        balancing: balancing?,
        limits,
        drive_current,
        drive,
        motor_drag,
        turns: Turns::AsWound,
        phases,
        carries: Vec::new(),
    };
    Some((joint, taken, carries))
}

/// Whether a joint names modules and neither a ratio nor gears for motors.
fn is_for_modules_alone(section: &Section) -> bool {
    section.has("modules") && !gear::RATIO_KEYS.into_iter().any(|key| section.has(key))
}

/// Energy per cycle needs a cycle.
fn check_cycle(section: &Section, objective: &Objective, motion: &Motion) {
    if objective.weight(Quantity::Energy) == 0.0 || motion.duration().is_some() {
        return;
    }
    let (message, help) = match motion.cases.is_some() {
        true => (
            "`energy` is that of a cycle, and the `share` of a load case says of none how long it is",
            "give the cases `cycles` or the joint an `order`, or ask for `loss`",
        ),
        false => (
            "`energy` is that of a cycle, and operating points without durations have none",
            "give every point a `duration`, or ask for `loss`",
        ),
    };
    section.note(Problem::at(section.span_of("objective"), message, "asked for here").help(help));
}

/// The limits of a joint, with the spring that stands in them or beside them.
fn read_limits(
    section: &Section,
    ambient: f64,
    money: &Money,
    no_springs: Option<&str>,
    motion: Option<&Motion>,
) -> Limits {
    let (mut limits, in_limits) = match section.section(key("limits", "what a choice must keep")) {
        Some(table) => {
            let spring = table
                .section(key("spring", "a parallel spring to be chosen with the ratio"))
                .map(|s| (s.span(), limits::read_spring(s)));
            (limits::read(table, ambient, money), spring)
        }
        None => (Limits::default(), None),
    };
    let of_joint = section
        .section(key("spring", "a parallel spring to be chosen with the ratio; may be in `[limits]`"))
        .map(|s| (s.span(), limits::read_spring(s)));
    if let (Some(_), Some((span, _))) = (&in_limits, &of_joint) {
        let message = "a joint has one `spring`, in [joint.limits] or in [[joint]], not in both";
        section.note(Problem::at(span.clone(), message, "remove one of the two"));
    }
    if limits.life.is_some() && motion.is_some_and(|motion| !motion.has_durations()) {
        let message = "the `life` of a gear needs to know how long the motion takes: its points have no durations";
        let problem = Problem::at(section.span_of("limits"), message, "[joint.limits] has `life`");
        section.note(problem.help("give each point a `duration`"));
    }
    if let Some((span, spring)) = in_limits.or(of_joint) {
        limits.spring = spring;
        if limits.life.is_some() {
            let message = "the `life` of a gear cannot be asked for where a spring is to be chosen";
            let help = "leave `life` out, choose the spring, and ask for the life of the joint with the spring's torque in its motion";
            section.note(Problem::at(span.clone(), message, "a spring, and [joint.limits] has `life`").help(help));
        }
        if let Some(what) = no_springs {
            let message = format!("{what} cannot choose a spring");
            let help = "`optimize` and `explain` choose it with the ratio; or remove `spring`";
            section.note(Problem::at(span, message, "asked for here").help(help));
        } else if section.has("points") {
            let message = "a spring needs a motion with a position, not operating points";
            section.note(
                Problem::at(span, message, "the points say no position").help("give `motion`, or remove `spring`"),
            );
        } else if spring.is_some() && motion.is_some_and(|m| m.cases.is_some() && !m.placed) {
            let message = "a spring needs the `position` of every load case: where each begins is not known without it";
            let help = "give a column `position` in the motion of every case; operating points have none";
            section.note(Problem::at(span, message, "asked for here").help(help));
        } else if spring.is_some() && motion.is_some_and(|m| m.position.is_none()) {
            let message = "a spring needs the position, but the motion does not come back to where it began";
            section.note(Problem::at(span, message, "the motion's position is not periodic").help(
                "give a column `position` that repeats its first row, or `periodic = false`, or remove `spring`",
            ));
        }
    }
    limits
}

/// How heat leaves the housing where the joint is mounted: thermal resistance to ambient \[K/W\].
fn read_mount(section: &Section) -> Option<f64> {
    let mount = section.section(key("mount", "how the motor is mounted here"))?;
    let resistance = mount.required_quantity(
        key("thermal_resistance_housing_ambient", "in place of the row's own, and of its continuous rating"),
        &units::THERMAL_RESISTANCE,
        Range::Positive,
    );
    mount.finish();
    resistance
}

/// By how much of the period each of several joints is late.
fn read_phases(section: &Section, count: u32, motion: Option<&Motion>) -> Vec<f64> {
    let Some(phases) = section
        .number_list(key("phases", "by how much of the period each of the `count` joints is late, 0 to 1"), Range::Any)
    else {
        return Vec::new();
    };
    let span = section.span_of("phases");
    if phases.len() != count as usize {
        let message = format!("`phases` has {} entries, but `count` is {count}", phases.len());
        section.note(
            Problem::at(span, message, "expected one for each of the joints")
                .help("for example count = 4 and phases = [0, 0.5, 0.5, 0]"),
        );
    } else if phases.iter().any(|p| !(0.0..=1.0).contains(p)) {
        let message = "`phases` are shares of the period";
        section.note(Problem::at(span, message, "expected numbers from 0 to 1").help("half a period late is 0.5"));
    } else if motion.is_some_and(|m| !m.courses().iter().any(|(_, c)| matches!(c, motion::Course::Periodic(_)))) {
        let message = "`phases` need a motion that repeats";
        section
            .note(Problem::at(span, message, "this joint has none").help("give a periodic `motion`, or remove them"));
    }
    phases
}
