//! The card of a module.

use super::card::{PRICED, audit_text, line, number_row, numbers_table, price_line, sourced, titled};
use crate::number;
use crate::table::paragraph;
use gearwise_model::catalog::Module;
use gearwise_model::catalog::audit::Finding;
use gearwise_model::catalog::module::{Depth, Drive, MODULE_FIELDS};
use gearwise_model::catalog::row::{Holds, Row, text};

/// Columns that the first lines of a card say.
const SAID: &[&str] = &[
    "id",
    "manufacturer",
    "model",
    "drive",
    "source",
    "source_kind",
    "source_date",
    "note",
    "audit_accept",
    "kind",
    "price_currency",
    "price_date",
];

/// What a module's row lacks and what that prevents.
pub fn module_lacks(module: &Module) -> Vec<(&'static str, &'static str)> {
    let (sheet, constants) = (&module.sheet, module.constants());
    let ratings = module.depth() == Depth::Ratings;
    let inside = module.depth() == Depth::Inside;
    let all = [
        (
            sheet.peak_torque.is_none() && sheet.stall_torque.is_none(),
            "peak_torque",
            "its largest torque is not checked",
        ),
        (sheet.rated_torque.is_none(), "rated_torque", "its heat cannot be judged, and it is no choice"),
        (
            module.driving_curve.is_empty(),
            "driving_curve",
            "what it gives at a speed is known below a straight line alone",
        ),
        (sheet.no_load_speed.is_none(), "no_load_speed", "less voltage than that of its curve cannot be judged"),
        (sheet.max_voltage.is_none(), "min_voltage, max_voltage", "its range of supply voltages is not checked"),
        (ratings, "resistance and torque_constant", "currents, losses, voltage and energy are not known"),
        (!ratings && !inside && constants.efficiency.is_none(), "efficiency", "what its gear loses is not known"),
        (
            !ratings && !inside && constants.back_emf_constant.is_none(),
            "back_emf_constant",
            "power and energy are not known",
        ),
        (
            !inside && constants.inertia.is_none(),
            "armature",
            "torques are without its own inertia; a limit on reflected inertia cannot be judged",
        ),
        (sheet.mass.is_none() && !inside, "mass", "a limit on mass cannot be judged"),
        (module.across().is_none(), "outer_diameter, or width and height", "a limit on the diameter cannot be judged"),
        (sheet.length.is_none(), "length", "a limit on the axial length cannot be judged"),
        (sheet.offer.price.is_none(), "price (with price_currency and price_date)", "a limit on it cannot be judged"),
        (sheet.offer.lead_time.is_none(), "lead_time", "a limit on it cannot be judged"),
        (module.overload.is_empty(), "overload", "more than the rated torque for a while is judged by its mean alone"),
    ];
    all.into_iter().filter(|(is, ..)| *is).map(|(_, column, why)| (column, why)).collect()
}

/// The card, for people.
pub fn module_text(module: &Module, findings: &[Finding]) -> String {
    let mut out = paragraph(&module.id, 0, 2);
    let name = [module.manufacturer.as_str(), module.model.as_str()].join(" ");
    let drive = match module.drive {
        Drive::BuiltIn => "drive inside",
        Drive::External => "without drive",
    };
    let kind = text(Module::BEFORE.iter().find(|c| c.name == "kind").expect("a column"), module);
    let parts = [name.trim(), kind.as_str(), drive];
    let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    line(&mut out, "module", &parts.join("; "));
    line(&mut out, "source", &sourced(&module.source, &module.source_date, module.source_kind));
    line(&mut out, "note", &module.note);
    price_line(&mut out, &module.sheet.offer);
    titled(&mut out, "Numbers as printed (torques, speeds, backlash and stiffness at the output)");
    let rows = MODULE_FIELDS.iter().filter(|f| !PRICED.contains(&f.name)).filter_map(|field| {
        let printed = (field.get)(module.numbers())?;
        Some(number_row(field, printed.value, printed.tolerance))
    });
    out.push_str(&numbers_table().rows(rows).text());
    for column in Module::BEFORE.iter().chain(Module::AFTER).filter(|column| !SAID.contains(&column.name)) {
        let value = text(column, module);
        let value = match column.holds {
            Holds::Pairs([(first, _), (second, _)], ..) if !value.is_empty() => {
                format!("{value} [{} : {}]", first.si, second.si)
            }
            _ => value,
        };
        line(&mut out, column.name, &value);
    }
    titled(&mut out, "At the output, on the q axis");
    let constants = module.constants();
    for (what, value, unit) in [
        ("K_T", constants.torque_constant, "N*m/A"),
        ("K_B", constants.back_emf_constant, "V*s/rad"),
        ("R", constants.resistance, "ohm"),
        ("L", constants.inductance, "H"),
        ("J", constants.inertia, "kg*m^2"),
        ("gear efficiency", constants.efficiency.map(|(efficiency, _)| efficiency), ""),
    ] {
        let text = value.map_or_else(|| "not known".to_string(), |v| format!("{} {unit}", number(v)));
        out.push_str(&paragraph(&format!("{what}: {}", text.trim_end()), 2, 6));
    }
    if let Some(says) = constants.efficiency.and_then(|(_, from)| from.says()) {
        out.push_str(&paragraph(says, 2, 6));
    }
    titled(&mut out, "What is not known");
    let lacks = module_lacks(module);
    for (column, why) in &lacks {
        out.push_str(&paragraph(&format!("{column}: {why}"), 2, 6));
    }
    if lacks.is_empty() {
        out.push_str(&paragraph("nothing that a limit asks for", 2, 6));
    }
    audit_text(&mut out, findings);
    out
}
