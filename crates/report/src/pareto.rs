//! Fronts of quantities.

use super::columns::{self, Entry, State};
use super::reason::reason_text;
use super::table::{Column, Table, paragraph, wrap};
use super::{number, optional, point_ratio, unjudged};
use gearwise_model::requirement::Quantity;
use gearwise_model::words::counted;
use gearwise_select::pareto::{Front, FrontPoint};

/// How many motors of a front of three or more quantities are shown where nobody says.
pub const MOTORS: usize = 10;

/// The motors on a front, the best in the first quantity first.
pub fn motors<'a>(front: &Front<'a>) -> Vec<&'a str> {
    let mut ids: Vec<&str> = Vec::new();
    for point in &front.points {
        if !ids.contains(&point.motor.id.as_str()) {
            ids.push(&point.motor.id);
        }
    }
    ids
}

/// At most so many of them, those first that are the best in a quantity; in the same order.
pub fn first_motors<'a>(front: &Front<'a>, most: usize) -> Vec<&'a str> {
    let all = motors(front);
    let best = (0..front.quantities.len()).filter_map(|k| best_of(front.points.iter(), k)).map(|p| p.motor.id.as_str());
    let mut chosen: Vec<&str> = Vec::new();
    for id in best.chain(all.iter().copied()) {
        if chosen.len() < most && !chosen.contains(&id) {
            chosen.push(id);
        }
    }
    all.into_iter().filter(|id| chosen.contains(id)).collect()
}

/// The point with the least of a quantity, of equal ones the first.
pub fn best_of<'f, 'a: 'f>(
    points: impl Iterator<Item = &'f FrontPoint<'a>>,
    quantity: usize,
) -> Option<&'f FrontPoint<'a>> {
    points.min_by(|x, y| x.values[quantity].total_cmp(&y.values[quantity]))
}

/// Quantities as people list them: `loss, mass and reflected_inertia`.
pub fn listed(quantities: &[Quantity]) -> String {
    let names: Vec<&str> = quantities.iter().map(|q| q.name()).collect();
    match names.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        all => all.join(""),
    }
}

/// The columns of a front, with a gear and the mass where they say something; the front's own are never dropped.
fn headings(front: &Front, geared: bool, with_mass: bool) -> Vec<Column> {
    let mut columns = vec![Column::name("motor")];
    columns.extend(geared.then(|| Column::name("gear")));
    columns.push(Column::number("N", ""));
    columns.extend(front.quantities.iter().map(|q| Column::number(q.name(), q.unit())));
    columns.extend(with_mass.then(|| Column::number("mass", "kg").dropped(1)));
    columns.push(Column::name("proof").dropped(2));
    columns
}

/// For people: of two quantities each run of ratios of one motor as its first and last point; of more the designs of at most so many
/// motors that are the best of theirs in a quantity.
pub fn text(fronts: &[Front], most: usize) -> String {
    let mut out = String::new();
    for front in fronts {
        let motors = motors(front);
        let points = counted(front.points.len(), "point");
        let (what, points) = match front.quantities.as_slice() {
            [a, b] => (format!("{} against {}", a.name(), b.name()), points),
            all => (listed(all), format!("{points} of {}", counted(motors.len(), "motor"))),
        };
        let feasible = counted(front.motors, "motor");
        let apart = unjudged::counted(front.unjudged.len());
        let heading =
            format!("{}: {what}; {feasible} with a feasible design{apart}, {points} on the front", front.joint.name);
        out.push_str(&format!("{}\n", paragraph(&heading, 0, 2)));
        let geared = front.points.iter().any(|p| p.gear.is_some());
        let with_mass = !front.quantities.contains(&Quantity::Mass);
        let shown = match front.quantities.len() {
            2 => ends_of_runs(front),
            _ => best_of_motors(front, &first_motors(front, most)),
        };
        let count = shown.len();
        let row = |p: &FrontPoint| {
            let mut row = vec![p.motor.id.clone()];
            if geared {
                row.push(p.gear.unwrap_or("").into());
            }
            row.push(point_ratio(p, front));
            row.extend(p.values.iter().map(|value| number(*value)));
            row.extend(with_mass.then(|| optional(p.evaluation.mass)));
            row.push(if p.certified { "exact".into() } else { "not certified".into() });
            row
        };
        let rows = shown.into_iter().map(row);
        let table = Table::new(headings(front, geared, with_mass)).also_in("`--csv`, `--json`").rows(rows);
        if table.is_empty() {
            let left_out = unjudged::left_out(front.rejected.iter().map(|(_, why)| why));
            let which = match (front.unjudged.len(), left_out) {
                (0, 0) => "of the catalogue",
                (0, _) => "that can be checked in full",
                _ => "that can be judged",
            };
            out.push_str(&format!("  no motor {which} can do it\n\n"));
        } else {
            let note = match (front.quantities.len(), geared) {
                (2, true) => "With gears of the catalogue each line is a design of its own.".into(),
                (2, false) if front.joint.gear_map.is_some() => {
                    "Two lines of one motor are the ends of a run of points on its front. With a gear map quantities may jump: what lies \
                     between points is not known (`--points` looks at more)."
                        .into()
                }
                (2, false) => {
                    "Two lines of one motor are the ends of a run: every ratio between them is on its front.".into()
                }
                _ => not_shown(front, count, motors.len(), most.min(motors.len())),
            };
            out.push_str(&format!("{}\n{}", table.text(), paragraph(&note, 0, 0)));
            proofs(front).iter().for_each(|line| out.push_str(&paragraph(line, 0, 0)));
            out.push('\n');
        }
        out.push_str(&beside(front));
    }
    out
}

/// The first and last point of each run of one motor, or with one gear.
fn ends_of_runs<'f, 'a>(front: &'f Front<'a>) -> Vec<&'f FrontPoint<'a>> {
    let is_inside = |i: usize, p: &FrontPoint| {
        let same = |other: Option<&FrontPoint>| other.is_some_and(|o| o.motor.id == p.motor.id && o.gear == p.gear);
        same(i.checked_sub(1).and_then(|j| front.points.get(j))) && same(front.points.get(i + 1))
    };
    front.points.iter().enumerate().filter(|(i, p)| !is_inside(*i, p)).map(|(_, p)| p).collect()
}

/// Of each of these motors its points that have the least of a quantity, by motor.
fn best_of_motors<'f, 'a>(front: &'f Front<'a>, motors: &[&str]) -> Vec<&'f FrontPoint<'a>> {
    let mut shown: Vec<&FrontPoint> = Vec::new();
    for motor in motors {
        let of = || front.points.iter().filter(|p| p.motor.id == *motor);
        let best: Vec<&FrontPoint> = (0..front.quantities.len()).filter_map(|k| best_of(of(), k)).collect();
        shown.extend(of().filter(|p| best.iter().any(|b| std::ptr::eq(*b, *p))));
    }
    shown
}

/// What of a front is not in the table, and where it is.
fn not_shown(front: &Front, shown: usize, motors: usize, of_motors: usize) -> String {
    let what = "Of each motor the designs with the least of a quantity";
    if shown == front.points.len() {
        return format!("{what}: these are all.");
    }
    let further = match motors - of_motors {
        0 => String::new(),
        1 => "1 motor is not shown (`--full` shows all), ".into(),
        more => format!("{more} motors are not shown (`--full` shows all), "),
    };
    let points = front.points.len() - shown;
    format!("{what}; {further}{points} further points: `--csv` and `--json` have all {}.", front.points.len())
}

/// What the proofs of a front say, where ratios are free.
pub fn proofs(front: &Front) -> Vec<String> {
    let is_free = |p: &&FrontPoint| front.efficient.iter().any(|e| e.motor.id == p.motor.id);
    let any = |certified: bool| front.points.iter().filter(is_free).any(|p| p.certified == certified);
    let exact = "exact: the motor's own front is proved, and no ratio of any such motor betters a point here.";
    let not =
        "not certified: the motor's ratios are those of a grid, and one between two of them may better a point here.";
    let told = [(true, exact), (false, not)];
    told.into_iter().filter(|(certified, _)| any(*certified)).map(|(_, line)| line.to_string()).collect()
}

/// What could not be checked and what was assumed of the front, and who is not on it because it cannot be judged.
fn beside(front: &Front) -> String {
    let lines = unjudged::front_remarks(front).into_iter().map(|line| format!("  {}\n", wrap(&line, 4)));
    let text = lines.collect::<String>() + unjudged::front_text(front).trim_start_matches('\n');
    if text.is_empty() { text } else { text + "\n" }
}

/// As rows: every point, then the motors that cannot be judged and those that cannot do it.
pub fn csv(fronts: &[Front]) -> String {
    let rows = fronts.iter().flat_map(|front| {
        let joint = front.joint;
        let points = front.points.iter().map(|p| Entry::design(joint, State::Candidate, None, p.facts(joint)));
        let apart = front
            .unjudged
            .iter()
            .map(|(motor, why)| Entry::without(joint, State::Unjudged, motor, None, unjudged::sentence(why)));
        let cannot = front
            .rejected
            .iter()
            .map(|(motor, why)| Entry::without(joint, State::Rejected, motor, None, reason_text(why, joint).1));
        points.chain(apart).chain(cannot).collect::<Vec<_>>()
    });
    columns::csv(rows, false)
}
