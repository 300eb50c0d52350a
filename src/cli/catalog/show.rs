use clap::Args;

use super::{Done, Failure, Which};
use crate::catalog::filter::search;
use crate::catalog::module::audit::audit_module;
use crate::catalog::{Alternative, Catalog};
use crate::report::catalog::card::{self, Card};
use crate::report::catalog::family;
use crate::report::catalog::module::module_text;
use crate::report::{json, json_text};
use crate::words::nearest;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise catalog show t-motor-u8-lee\n  gearwise catalog show my-motor --catalog user\n  gearwise catalog show t-motor-ri50 --json"
)]
pub struct Arguments {
    /// Id of a motor, a gear or a module, or the name of a gear family
    id: String,
    #[command(flatten)]
    which: Which,
    /// Print JSON (SI units, the unit in the key)
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let catalog = arguments.which.read()?;
    let id = arguments.id.as_str();
    let motor = catalog.motors.iter().find(|m| m.id == id);
    let gear = catalog.gear(id);
    let elsewhere: Vec<&Alternative> = catalog.alternatives_of(id).collect();
    let mut texts = Vec::new();
    if let Some(motor) = motor {
        let card = Card::new(&catalog, motor);
        texts.push(match arguments.json {
            true => json_text(&json::catalog::motor_shown(&card, &elsewhere)),
            false => card::motor_text(&card) + &card::elsewhere_text(&elsewhere),
        });
    }
    // A gear may have the id of a motor.
    if let Some(gear) = gear.filter(|_| texts.is_empty() || !arguments.json) {
        texts.push(match arguments.json {
            true => json_text(&json::catalog::gear_shown(gear, &elsewhere)),
            false => card::gear_text(gear) + &card::elsewhere_text(&elsewhere),
        });
    }
    if let Some(module) = catalog.modules.iter().find(|m| m.id == id).filter(|_| texts.is_empty()) {
        let findings = audit_module(module, &catalog.modules, &catalog.motors, &catalog.alternatives);
        texts.push(match arguments.json {
            true => json_text(&json::catalog::module_shown(module, &findings, &elsewhere)),
            false => module_text(module, &findings) + &card::elsewhere_text(&elsewhere),
        });
    }
    if let Some(family) = catalog.families.iter().find(|f| f.name == id).filter(|_| texts.is_empty()) {
        texts.push(match arguments.json {
            true => json_text(&json::catalog::family_shown(family)),
            false => family::text(family),
        });
    }
    if texts.is_empty() {
        return Err(unknown(&catalog, id));
    }
    Ok(Done { text: texts.join("\n"), satisfied: true })
}

/// That there is no such row, with those that may have been meant.
fn unknown(catalog: &Catalog, id: &str) -> Failure {
    let found = search(catalog, id);
    let modules = found.modules.iter().map(|m| m.id.as_str());
    let gears = found.gears.iter().map(|g| g.id.as_str());
    let families = found.families.iter().map(|f| f.name.as_str());
    let has = found.motors.iter().map(|m| m.id.as_str()).chain(gears).chain(modules).chain(families);
    let mut near: Vec<&str> = has.take(3).collect();
    if near.is_empty() {
        let gears = catalog.all_gears().map(|g| g.id.as_str());
        let modules = catalog.modules.iter().map(|m| m.id.as_str());
        let families = catalog.families.iter().map(|f| f.name.as_str());
        let all = catalog.motors.iter().map(|m| m.id.as_str()).chain(gears).chain(modules).chain(families);
        near.extend(nearest(id, all));
    }
    let names: Vec<String> = near.iter().map(|n| format!("`{n}`")).collect();
    let help = match names.is_empty() {
        true => "`gearwise catalog list` shows them all".to_string(),
        false => format!("did you mean {}?", names.join(" or ")),
    };
    Failure::Argument(format!("there is no motor, gear, module or gear family `{id}` in the catalogue; {help}"))
}
