//! Rules about the rows of the catalogue that a design stands on.

use crate::facts::{JointFacts, RobotFacts};
use crate::lock::LockState;
use crate::place::Place;
use crate::rule::{Remark, Rule, Severity, Test};
use gearwise_model::catalog::SourceKind;
use gearwise_model::catalog::audit::{Severity as AuditSeverity, audit_motor};
use gearwise_model::catalog::module::BUILT_IN;

pub(super) const GEAR_FIT: Rule = Rule {
    code: "GW042",
    name: "gear-fit",
    summary: "the gear is made for the motor",
    severity: Severity::Error,
    what: "Compares the motor with the patterns in `fits` of a gear of the catalogue. A gear that says nothing is taken to fit.",
    why: "Pinion, flange and input speed belong together; a gear of another frame size cannot be mounted.",
    example: "A gearhead of 22 mm that fits `maxon-*-22-*` on a motor of 52 mm.",
    fix: "A gear whose `fits` names the motor, or a requirement whose `gears` only match those.",
    test: Test::Joint(|facts| match facts.choice.gear {
        Some(gear) if gear.fits(facts.choice.motor.machine_id()) == Some(false) => {
            let message = format!("{} is not made for {}", gear.id, facts.choice.motor.id);
            let mut remark = Remark::new(message, gear.id.clone(), Place::Reduction);
            remark.help = Some(format!("it fits {}", gear.fits.join(", ")));
            vec![remark]
        }
        _ => Vec::new(),
    }),
};

pub(super) const ROW_AUDIT: Rule = Rule {
    code: "GW201",
    name: "row-audit",
    summary: "the motor's row does not contradict itself",
    severity: Severity::Error,
    what: "Runs `gearwise audit` on the row of the chosen motor and reports each error that the row's note does not explain.",
    why: "A row whose redundant numbers contradict each other is read in a wrong convention or misprinted: K_T off by the root of three spoils torque, loss and voltage at once, and every margin with them.",
    example: "K_T = 0.1 N*m/A with 240 rpm/V, which would be 0.0398 N*m/A.",
    fix: "Correct the row or its convention columns; where the sheet really is inconsistent, say so in `note` and list the code in `audit_accept`.",
    test: Test::Joint(row_audit),
};

fn row_audit(facts: &JointFacts) -> Vec<Remark> {
    let errors = audit_motor(facts.choice.motor).into_iter();
    let broken = errors.filter(|f| f.severity == AuditSeverity::Error && !f.accepted);
    broken
        .map(|finding| {
            let message = format!("row of {}: {}", finding.id, finding.message);
            let mut remark = Remark::new(message, finding.code, Place::Motor);
            remark.help = finding.explanation;
            remark
        })
        .collect()
}

pub(super) const ROW_SECONDARY: Rule = Rule {
    code: "GW202",
    name: "row-secondary",
    summary: "the motor's numbers come from first hand",
    severity: Severity::Note,
    what: "Notes a motor or gear whose row is quoted at second hand (`source_kind = secondary`).",
    why: "Numbers that were copied lose their conventions and conditions on the way (line or phase, amplitude or rms, with or without a heat sink).",
    example: "A row from a table in a paper about another robot.",
    fix: "Compare with the maker's data sheet, or measure, and set `source_kind`.",
    test: Test::Joint(|facts| {
        let motor = facts.choice.motor;
        let secondary = |kind| kind == SourceKind::Secondary;
        let mut remarks = Vec::new();
        if secondary(motor.source_kind) {
            let message = format!("{} is quoted at second hand: {}", motor.id, motor.source);
            remarks.push(Remark::new(message, motor.id.clone(), Place::Motor));
        }
        // The gear of a module is of the same row.
        if let Some(gear) = facts.choice.gear.filter(|g| secondary(g.source_kind) && g.id != BUILT_IN) {
            let message = format!("{} is quoted at second hand: {}", gear.id, gear.source);
            remarks.push(Remark::new(message, gear.id.clone(), Place::Reduction));
        }
        remarks
    }),
};

/// A row that is no longer what it was when the lock was written.
pub(crate) const LOCK_MISMATCH: Rule = Rule {
    code: "GW203",
    name: "lock-mismatch",
    summary: "the rows are those that were locked",
    severity: Severity::Error,
    what: "Compares the catalogue rows that the design uses with its lock file (`design.lock` next to `design.toml`), value by value. Rows that the lock lacks, and locked rows that the design no longer uses, are reported too.",
    why: "A catalogue that changes under a design changes the design: the torque constant that was corrected last week may have been the one the ratio was chosen for. A lock makes that a decision instead of an accident.",
    example: "torque_constant of t-motor-ri50: was 0.105 N*m/A, is 0.098 N*m/A.",
    fix: "See whether the design still passes with the new row, then `gearwise check design.toml --update-lock` and commit the lock.",
    test: Test::Robot(|facts| match &facts.lock {
        LockState::Compared { differences, .. } => {
            let each = differences.iter().map(|difference| {
                let mut remark = Remark::new(difference.message.clone(), difference.subject.clone(), Place::Design);
                remark.help = Some("if the change is meant, run `gearwise check` with `--update-lock`".into());
                // Shown where the first joint names the row.
                if let Some(joint) = difference.used_by.first() {
                    remark.place = if difference.gear { Place::Reduction } else { Place::Motor };
                    remark.at_joint = Some(joint.clone());
                }
                remark
            });
            each.collect()
        }
        _ => Vec::new(),
    }),
};

pub(super) const LOCK_MISSING: Rule = Rule {
    code: "GW204",
    name: "lock-missing",
    summary: "the design has a lock",
    severity: Severity::Off,
    what: "Reports a design without a lock file next to it. Off by default; a rules file gives it a severity.",
    why: "Without a lock nobody sees that a row of the catalogue has changed.",
    example: "design.toml without design.lock in the same folder.",
    fix: "`gearwise check design.toml --lock`, and commit the file.",
    test: Test::Robot(lock_missing),
};

fn lock_missing(facts: &RobotFacts) -> Vec<Remark> {
    match &facts.lock {
        LockState::Missing(path) => {
            let message = format!("there is no lock file `{}`", path.display());
            vec![Remark::new(message, "lock", Place::Design)]
        }
        _ => Vec::new(),
    }
}
