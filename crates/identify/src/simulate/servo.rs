//! Servo logs with only duty cycle (or goal) and position: identified by the error of the simulated
//! position.
//!
//! The same story as the regression's, told in position: the declared model, its own parameters refitted,
//! then effects one at a time, each judged on logs (or, with few logs, stretches of time) that were left
//! out, against chance over all that were tried, and against what is plausible.

mod candidate;
mod judges;
mod left;
mod refit;
mod report;
mod selection;

use self::candidate::{Candidate, is_a_lag};
use self::judges::Judges;
use self::refit::refit;
use self::report::report;
use self::selection::{OnPosition, candidates, stage};
use super::model::{Model, Slot, declared_machine, scale};
use super::track::Track;
use crate::answer::{Report, Step};
use crate::select;
use crate::{Bench, BenchKind, Channel};

/// Fewest samples of a log that is fitted.
const FEWEST: usize = 60;
/// Most effects that are added.
const STEPS: usize = 6;

/// Whether a bench has servo logs that simulation can identify: no current, but a duty cycle, or a goal
/// through a declared controller, and the supply; or a controller that asks for a torque.
pub fn serves(bench: &Bench) -> bool {
    tracks(bench).iter().any(|t| t.fits)
}

/// Whether what is missing for that is the supply voltage alone.
pub fn lacks_supply(bench: &Bench) -> bool {
    let mut with = bench.clone();
    for log in with.logs.iter_mut().filter(|l| l.channel(Channel::Supply).is_none()) {
        log.channels.insert(Channel::Supply, vec![1.0; log.time.len()]);
    }
    !serves(bench) && serves(&with)
}

fn tracks(bench: &Bench) -> Vec<Track> {
    if bench.declared.motor.is_none() {
        return Vec::new();
    }
    bench
        .logs
        .iter()
        .filter(|log| log.kind == BenchKind::Servo && log.channel(Channel::Current).is_none())
        .filter_map(|log| Track::new(log, &bench.declared))
        .collect()
}

/// Identifies the servo logs of a bench by the error of the simulated position. `None` where there are none
/// that simulation can tell anything of ([`serves`]). The report's errors are of position \[rad\].
pub fn identify_servo(bench: &Bench) -> Option<Report> {
    let all = tracks(bench);
    if !all.iter().any(|t| t.fits && t.count() >= FEWEST) {
        return None;
    }
    let judges = Judges::new(&all);
    let everything: Vec<&Track> = all.iter().collect();
    let machine = declared_machine(&bench.declared, Track::are_of_voltage(&all));
    let scale = scale(&all, &machine);
    let declared = Model { machine, slots: Vec::new(), scale };
    let mut stages = vec![stage(Step::Declared, &everything, &declared)];
    let known_terms = declared.machine.terms.len();
    let (model, held) = refit(&declared, &judges, &all, bench);
    stages.push(stage(Step::Refit, &everything, &model));
    let mut refused = Vec::new();
    let candidates = candidates(&all, &bench.declared.without, &mut refused);
    let mut selection = OnPosition {
        judges: &judges,
        everything: &everything,
        candidates,
        now: judges.left_out(&model),
        added: Vec::new(),
        is_late: model.slots.contains(&Slot::Lag),
        model,
        stages,
        refused,
    };
    select::forward(&mut selection, STEPS);
    selection.gather_added(known_terms);
    select::backward(&mut selection);
    let model = &mut selection.model;
    judges.fit(model, 30, 1e-7);
    if model.slots.contains(&Slot::Lag) && !is_a_lag(model.machine.lag) {
        *model = Candidate::Lag.removed(model);
        selection.added.retain(|c| *c != Candidate::Lag);
        judges.fit(model, 30, 1e-7);
    }
    let last = stage(Step::Final, &everything, &selection.model);
    selection.stages.push(last);
    Some(report(bench, &all, &declared, held, selection))
}
