//! `transmission` of a requirement or of a hardware file.

use std::path::Path;
use std::sync::Arc;

use super::four_bar::{Branch, FourBar};
use super::lever::Lever;
use super::table::Table;
use super::{Coupler, Coupling, JacobianTable, Numbers, Rod, Transmission, Way};
use crate::input::csv::{self, Column, Content};
use crate::input::kind::{self, FileKind};
use crate::input::{InputError, Key, Problem, Range, Section, Source, key};
use crate::units;

/// How files that a transmission names are opened, and what was wrong in them.
pub struct Files<'f> {
    /// Opens a file.
    pub open: &'f mut dyn FnMut(&Path) -> Result<Arc<Source>, InputError>,
    /// Mistakes in them.
    pub errors: &'f mut Vec<InputError>,
}

const RATIO: Key = key(
    "ratio",
    "turns of the actuator for one of the joint, dθ/dq: belt, chain, bevel gear; negative where it reverses",
);

/// Reads the keys of a transmission but for what it weighs and bears: how the angles go together.
pub fn read_way(section: &Section, files: &mut Files) -> Option<Way> {
    let ratio = section.number(RATIO.or("table"), Range::Any);
    let table = read_table(section, files);
    let four_bar = section
        .section(key("four_bar", "planar linkage: crank on the actuator, coupler, rocker on the joint").or("ratio"))
        .map(|inner| read_four_bar(inner));
    let lever = section
        .section(key("lever", "screw or linear actuator on a lever of the joint").or("ratio"))
        .map(|inner| read_lever(inner));
    let example = "1.9  # or table = \"knee.csv\", four_bar = { … }, lever = { … }";
    match one_of(section, "a transmission", &["ratio", "table", "four_bar", "lever"], example)? {
        "ratio" => {
            let ratio = ratio?;
            if !(1e-6..=1e6).contains(&ratio.abs()) {
                let message = format!("{ratio} is not a ratio");
                let label = "expected a number that is not zero";
                let problem = Problem::at(section.span_of("ratio"), message, label);
                section.note(problem.help("1 is no reduction; a negative one reverses"));
                return None;
            }
            Some(Way::Ratio(ratio))
        }
        "table" => table.map(Way::Table),
        "four_bar" => four_bar.flatten().map(Way::FourBar),
        _ => lever.flatten().map(Way::Lever),
    }
}

/// Which one of several keys is there; `None` where it is none or more, which is noted.
fn one_of(section: &Section, what: &str, keys: &[&'static str], example: &str) -> Option<&'static str> {
    let given: Vec<&'static str> = keys.iter().copied().filter(|key| section.has(*key)).collect();
    match given.as_slice() {
        [] => {
            section.missing(keys[0], example);
            None
        }
        [one] => Some(one),
        [first, second, ..] => {
            let message = format!("{what} has `{first}` or `{second}`, not both");
            section.note(Problem::at(section.span_of(second), message, "a second one").help("remove one of the two"));
            None
        }
    }
}

/// A direction, where the key is there.
fn direction(section: &Section, asked: Key) -> Option<[f64; 3]> {
    let read = section.number_list(asked, Range::Any)?;
    let direction = <[f64; 3]>::try_from(read).ok();
    if direction.is_none() {
        let message = format!("`{}` is not a direction [x, y, z]", asked.name());
        section.note(Problem::at(section.span_of(asked.name()), message, "expected three numbers"));
    }
    direction
}

/// Reads a transmission.
pub(crate) fn read(section: &Section, files: &mut Files) -> Option<Transmission> {
    let way = read_way(section, files);
    let numbers = read_numbers(section, &["ratio", "table"], "`four_bar` or `lever`");
    Some(Transmission { way: way?, numbers })
}

/// Reads what a transmission loses, weighs and bears; of the keys that say no rod no force is known.
fn read_numbers(section: &Section, without_rods: &[&'static str], rods: &str) -> Numbers {
    let efficiency = section.number(key("efficiency", "when the actuator drives").default("1"), Range::Fraction);
    let backdrive = section.number(
        key("backdrive_efficiency", "when the joint drives; at most 1").default("2 − 1/efficiency"),
        Range::Any,
    );
    if let Some(above) = backdrive.filter(|b| *b > 1.0) {
        let message = format!("`backdrive_efficiency` of {} is out of range", crate::words::number(above));
        section.note(Problem::at(section.span_of("backdrive_efficiency"), message, "expected at most 1"));
    }
    let inertia = |name: &'static str, about: &'static str| {
        section.quantity(key(name, about).default("none"), &units::INERTIA, Range::NonNegative).unwrap_or(0.0)
    };
    let of_actuator = inertia("inertia", "of what turns with the actuator's output: pulley, crank");
    let of_joint = inertia("joint_inertia", "of what turns with the joint, where the motion's torque has it not in it");
    let mass = section.quantity(
        key("mass", "counts in the actuator's mass").default("none"),
        &units::MASS,
        Range::NonNegative,
    );
    let peak_torque = section.quantity(key("peak_torque", "largest at the joint"), &units::TORQUE, Range::Positive);
    let max_force = section.quantity(key("max_force", "largest of a rod or screw"), &units::FORCE, Range::Positive);
    let max_input_speed =
        section.quantity(key("max_input_speed", "largest at the actuator's side"), &units::SPEED, Range::Positive);
    let backlash = section.quantity(key("backlash", "of its own, at the joint"), &units::ANGLE, Range::NonNegative);
    let stiffness = section.quantity(key("stiffness", "of its own, at the joint"), &units::STIFFNESS, Range::Positive);
    if section.has("max_force") && without_rods.iter().any(|key| section.has(*key)) {
        let message = "`max_force` needs a rod or a screw: of a ratio or a table no moment arm is known";
        let problem = Problem::at(section.span_of("max_force"), message, "a force of what?");
        section.note(problem.help(format!("give `peak_torque` at the joint; or describe the linkage as {rods}")));
    }
    let efficiency_or_one = efficiency.unwrap_or(1.0);
    Numbers {
        efficiency: efficiency_or_one,
        backdrive_efficiency: backdrive.unwrap_or(2.0 - 1.0 / efficiency_or_one),
        says_loss: efficiency.is_some() || backdrive.is_some(),
        inertia: of_actuator,
        joint_inertia: of_joint,
        mass,
        peak_torque,
        max_force,
        max_input_speed,
        backlash,
        stiffness,
        outer_diameter: section.quantity(
            key("outer_diameter", "across the actuator's axis; counts in the limit `outer_diameter`"),
            &units::LENGTH,
            Range::NonNegative,
        ),
        length: section.quantity(
            key("length", "that it adds to the actuator along its axis; counts in the limit `axial_length`"),
            &units::LENGTH,
            Range::NonNegative,
        ),
        price: None,
        lead_time: section.quantity(
            key("lead_time", "counts in the limit `lead_time`"),
            &units::TIME,
            Range::NonNegative,
        ),
    }
}

fn read_four_bar(section: Section) -> Option<FourBar> {
    let at = key("ground", "the actuator's axis as seen from the joint's").required().value("[x, y] with units");
    if !section.has("ground") {
        section.missing("ground", "[\"0 mm\", \"250 mm\"]");
    }
    let ground = section.planar(at, &units::LENGTH);
    let length = |name: &'static str, about: &'static str| {
        section.required_quantity(key(name, about), &units::LENGTH, Range::Positive)
    };
    let crank = length("crank", "on the actuator");
    let coupler = length("coupler", "the rod between the two pins");
    let rocker = length("rocker", "on the joint");
    let zero = section.quantity(
        key("rocker_zero", "angle of the rocker where the joint is at zero").default("0 deg"),
        &units::ANGLE,
        Range::Any,
    );
    let about = "`open`: in the middle of the motion the crank's pin and the joint's axis are on opposite sides of the line \
                 from the crank's axis to the rocker's pin";
    let branch = section.choice(key("branch", about).default("`open`"), Branch::NAMES);
    section.finish();
    Some(FourBar {
        ground: ground?,
        crank: crank?,
        coupler: coupler?,
        rocker: rocker?,
        rocker_zero: zero.unwrap_or(0.0),
        branch: branch.unwrap_or(Branch::Open),
        side: f64::NAN,
    })
}

fn read_lever(section: Section) -> Option<Lever> {
    let at = key("pivot", "the screw's foot as seen from the joint's axis").required().value("[x, y] with units");
    if !section.has("pivot") {
        section.missing("pivot", "[\"0 mm\", \"180 mm\"]");
    }
    let pivot = section.planar(at, &units::LENGTH);
    let arm =
        section.required_quantity(key("arm", "length of the lever on the joint"), &units::LENGTH, Range::Positive);
    let zero = section.quantity(
        key("arm_zero", "angle of the lever where the joint is at zero").default("0 deg"),
        &units::ANGLE,
        Range::Any,
    );
    let lead = section.required_quantity(
        key("lead", "travel of the screw per turn of the actuator"),
        &units::LENGTH,
        Range::Positive,
    );
    section.finish();
    Some(Lever { pivot: pivot?, arm: arm?, arm_zero: zero.unwrap_or(0.0), lead: lead? })
}

/// Two ways to say a table that differ by more than this share of its largest value do not agree.
const AGREES: f64 = 0.01;

fn read_table(section: &Section, files: &mut Files) -> Option<Table> {
    let about = "CSV file next to this one: `position`, with `ratio` or `actuator_position` or both";
    let file = section.text(key("table", about).value("file").or("ratio"))?;
    open(section, &file, files, read_rows)
}

fn read_rows(source: &Arc<Source>, problems: &mut Vec<Problem>) -> Option<Table> {
    let column = |name: &str, kind, required| Column {
        name: name.into(),
        content: Content::Quantity(kind, Range::Any),
        required,
    };
    let columns = vec![
        column("position", &units::ANGLE, true),
        column("ratio", &units::RATIO, false),
        column("actuator_position", &units::ANGLE, false),
    ];
    let table = csv::Table::read(source, columns, problems)?;
    let mut whole = |name: &str| table.whole_column(name, "a table has no gaps", problems);
    let (position, ratio, angle) = (whole("position")?, whole("ratio"), whole("actuator_position"));
    if !problems.is_empty() {
        return None;
    }
    if ratio.is_none() && angle.is_none() {
        let problem = Problem::at(
            table.header_span(),
            "the table needs a column `ratio` or `actuator_position`",
            "neither is in the header",
        );
        problems
            .push(problem.help("`ratio` is dθ/dq; `actuator_position` is θ, for example `actuator_position [rad]`"));
        return None;
    }
    if position.len() < Table::LEAST {
        let message = format!("the table has {}", crate::words::counted(position.len(), "row"));
        problems.push(Problem::at(table.header_span(), message, format!("expected at least {}", Table::LEAST)));
        return None;
    }
    if let Some(k) = (1..position.len()).find(|k| position[*k] <= position[k - 1]) {
        let message = format!("the positions do not rise: {} in row {} after {}", position[k], k + 1, position[k - 1]);
        let problem = Problem::at(table.cell_span(k, "position"), message, "not more than the row above");
        problems.push(problem.help("sort the rows by position"));
        return None;
    }
    let Some(ratio) = ratio else { return Some(Table::of_angles(position, &angle?)) };
    let first = angle.as_ref().map_or(0.0, |angle| angle[0]);
    let made = Table::new(position, ratio, first);
    if let Some(angle) = angle {
        let reach = angle.iter().fold(0.0_f64, |most, a| most.max((a - first).abs()));
        let apart = |k: &usize| (made.angles()[*k] - angle[*k]).abs();
        let worst = (0..angle.len()).max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        if apart(&worst) > AGREES * reach {
            let message = format!(
                "`ratio` and `actuator_position` do not agree: the ratio gives {} rad in row {}, the table {} rad",
                crate::words::number(made.angles()[worst]),
                worst + 1,
                crate::words::number(angle[worst])
            );
            let problem = Problem::at(table.cell_span(worst, "actuator_position"), message, "differs most here");
            problems.push(problem.help("a wrong unit, sign or column? Leave one of the two columns out"));
            return None;
        }
    }
    Some(made)
}

/// Reads a coupling of two joints, but for its name and theirs.
pub(crate) fn read_coupling(section: &Section, files: &mut Files) -> Option<Coupling> {
    let matrix = section.matrix(key("matrix", "θ = M q: a row for each actuator, a column for each joint").or("table"));
    let about =
        "CSV file next to this one: `position_1`, `position_2`, `j11`, `j12`, `j21`, `j22` over a grid of both angles";
    let named = section.text(key("table", about).value("file").or("matrix"));
    let table = named.as_ref().and_then(|file| open(section, file, files, read_jacobian));
    let rods: Vec<Section> = section.sections(
        key("rods", "a rod from each actuator's crank to the moved link, where all angles are zero").or("matrix"),
    );
    let about =
        "with `rods`: direction of a joint's axis where both joints are at zero; the second moves with the first joint";
    let [first, second] = [("first_axis", "[0, 1, 0]"), ("second_axis", "[1, 0, 0]")]
        .map(|(name, default)| key(name, about).default(default));
    let axes =
        [direction(section, first).unwrap_or([0.0, 1.0, 0.0]), direction(section, second).unwrap_or([1.0, 0.0, 0.0])];
    for axis in ["first_axis", "second_axis"].into_iter().filter(|axis| section.has(*axis) && !section.has("rods")) {
        let message = format!("`{axis}` says nothing without `rods`");
        let problem = Problem::at(section.span_of(axis), message, "a matrix or a table has the axes in it");
        section.note(problem.help("remove it"));
    }
    let rods: Vec<Option<Rod>> = rods.into_iter().map(|rod| read_rod(rod, axes)).collect();
    let numbers = read_numbers(section, &["matrix", "table"], "`rods`");
    let example = "[[1, 1], [1, -1]]  # or table = \"ankle.csv\", rods = [ { … }, { … } ]";
    let coupler = match one_of(section, "a coupling", &["matrix", "table", "rods"], example)? {
        "matrix" => {
            let two = |row: Vec<f64>| <[f64; 2]>::try_from(row).ok();
            let rows = matrix?.into_iter().map(two).collect::<Option<Vec<_>>>();
            let read = rows.and_then(|rows| <[[f64; 2]; 2]>::try_from(rows).ok());
            let sound = read.filter(|m| {
                let size = m.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
                (m[0][0] * m[1][1] - m[0][1] * m[1][0]).abs() > 1e-3 * size * size
            });
            if sound.is_none() {
                let (message, label) = match read {
                    None => ("`matrix` is not two rows of two numbers", "two joints, two actuators"),
                    Some(_) => (
                        "`matrix` cannot be inverted: both actuators pull in nearly the same direction",
                        "near zero determinant",
                    ),
                };
                let problem = Problem::at(section.span_of("matrix"), message, label);
                section
                    .note(problem.help(
                        "a differential is [[1, 1], [1, -1]]; a motor that drives past a joint [[1, 0], [1, 1]]",
                    ));
            }
            sound.map(Coupler::Matrix)
        }
        "table" => table.map(Coupler::Table),
        _ => {
            if rods.len() != 2 {
                let message = format!("a coupling has two rods, not {}", rods.len());
                section.note(Problem::at(section.span_of("rods"), message, "two joints, two actuators"));
            }
            let read = rods.into_iter().collect::<Option<Vec<Rod>>>();
            read.and_then(|rods| <[Rod; 2]>::try_from(rods).ok()).map(|rods| Coupler::Rods(rods.into()))
        }
    };
    Some(Coupling { coupler: coupler?, numbers })
}

fn read_rod(section: Section, joints: [[f64; 3]; 2]) -> Option<Rod> {
    let point = |name: &'static str, about: &'static str| {
        if !section.has(name) {
            section.missing(name, "[\"10 mm\", \"40 mm\", \"250 mm\"]");
        }
        section.vector(key(name, about).required(), &units::LENGTH)
    };
    let axis_at = point("axis_at", "a point of the crank's axis, as seen from where the joints' axes meet");
    let crank_pin = point("crank_pin", "the rod's pin on the crank");
    let link_pin = point("link_pin", "the rod's pin on the moved link");
    let axis = direction(&section, key("axis", "direction of the crank's axis").default("[0, 1, 0]"));
    let axis = axis.unwrap_or([0.0, 1.0, 0.0]);
    let complete = axis_at.zip(crank_pin.zip(link_pin));
    let rod = complete.map(|(axis_at, (crank_pin, link_pin))| Rod { axis_at, axis, crank_pin, link_pin, joints });
    if rod.is_some_and(|rod| !rod.is_sound()) {
        let message = "the rod has no lever: a length or a direction is zero";
        let help = "the crank's pin is off its axis, rod and axes have a length, and the joints' axes are not parallel";
        section.note(Problem::at(section.span(), message, "nothing can turn here").help(help));
    }
    section.finish();
    rod.filter(Rod::is_sound)
}

/// Opens a file that `table` names, and reads it; what is wrong in it is its own report.
fn open<T>(
    section: &Section,
    file: &toml::Spanned<String>,
    files: &mut Files,
    read: impl FnOnce(&Arc<Source>, &mut Vec<Problem>) -> Option<T>,
) -> Option<T> {
    let opened = (files.open)(&section.source().folder().join(file.get_ref()));
    let named = |error: InputError| section.note(error.where_named("table", file.get_ref(), file.span()));
    let source = opened.map_err(named).ok()?;
    let mut problems = Vec::new();
    let made = read(&source, &mut problems);
    match InputError::unless_empty(&source, problems) {
        Ok(()) => made,
        Err(error) => {
            files.errors.push(kind::instead(error, &[FileKind::Table, FileKind::GearMap, FileKind::Empty]));
            None
        }
    }
}

fn read_jacobian(source: &Arc<Source>, problems: &mut Vec<Problem>) -> Option<JacobianTable> {
    const ENTRIES: [&str; 4] = ["j11", "j12", "j21", "j22"];
    let column =
        |name: &str, kind| Column { name: name.into(), content: Content::Quantity(kind, Range::Any), required: true };
    let columns = [column("position_1", &units::ANGLE), column("position_2", &units::ANGLE)];
    let entries = ENTRIES.map(|name| column(name, &units::RATIO));
    let table = csv::Table::read(source, columns.into_iter().chain(entries).collect(), problems)?;
    let mut whole = |name: &str| table.whole_column(name, "a table has no gaps", problems);
    let (a, b) = (whole("position_1")?, whole("position_2")?);
    let entries: Vec<Vec<f64>> = ENTRIES.iter().map(|name| whole(name)).collect::<Option<_>>()?;
    if !problems.is_empty() {
        return None;
    }
    let axis = |values: &[f64]| {
        let mut all = values.to_vec();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let (first, second) = (axis(&a), axis(&b));
    let least = JacobianTable::LEAST;
    if first.len() < least || second.len() < least || first.len() * second.len() != a.len() {
        let message = format!(
            "the table is no grid: {} with {} and {} different angles",
            crate::words::counted(a.len(), "row"),
            first.len(),
            second.len()
        );
        let problem = Problem::at(
            table.header_span(),
            message,
            format!("expected each pair of at least {least} angles of either joint once"),
        );
        problems.push(problem.help("write every angle of the second joint for every angle of the first"));
        return None;
    }
    let mut order: Vec<usize> = (0..a.len()).collect();
    order.sort_by(|x, y| a[*x].total_cmp(&a[*y]).then(b[*x].total_cmp(&b[*y])));
    if let Some(twice) = order.windows(2).find(|w| a[w[0]] == a[w[1]] && b[w[0]] == b[w[1]]) {
        let message = format!("the pair of angles in row {} is there twice", twice[1] + 1);
        problems.push(Problem::at(table.row_span(twice[1]), message, "second time"));
        return None;
    }
    let sorted = |values: &Vec<f64>| order.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let sorted: Vec<Vec<f64>> = entries.iter().map(sorted).collect();
    let entries = <[Vec<f64>; 4]>::try_from(sorted).ok()?;
    Some(JacobianTable::new(first, second, entries))
}
