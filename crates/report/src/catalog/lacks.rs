//! What rows of motors lack, and what that prevents.
//!
//! The one idea: a lack is a group of columns of which one would do, and the limits that ask for it. A test blanks each
//! group of a full row and asks the limits themselves.

use crate::counted;
use crate::table::{Column, Table, paragraph};
use gearwise_model::actuator::estimate::completed;
use gearwise_model::catalog::convention::Commutation;
use gearwise_model::catalog::drag::Drag;
use gearwise_model::catalog::estimate::{Estimate, Estimated};
use gearwise_model::catalog::{Catalog, Motor};

/// Something that a row may lack.
#[derive(Debug)]
pub struct Lack {
    /// Its name.
    pub name: &'static str,
    /// The columns that would say it, one of them or all.
    pub columns: &'static str,
    /// Whether a motor lacks it.
    pub is_lacking: fn(&Motor) -> bool,
    /// What fills it, where rows built alike say it.
    pub estimate: Option<Estimated>,
    /// Limits and needs that cannot be judged without it, where they are asked for.
    pub limits: &'static [&'static str],
    /// What else that prevents, in words.
    pub prevents: &'static str,
}

/// Every lack.
pub const LACKS: &[Lack] = &[
    Lack {
        name: "rotor inertia",
        columns: "rotor_inertia",
        is_lacking: |m| m.rotor_inertia.is_none(),
        estimate: Some(Estimated::RotorInertia),
        limits: &[],
        prevents: "the motor cannot be evaluated at all",
    },
    Lack {
        name: "heat",
        columns: "continuous_current, continuous_torque or both thermal_resistance_…",
        is_lacking: |m| {
            m.continuous_current.is_none() && m.continuous_torque.is_none() && m.thermal_resistance.is_none()
        },
        estimate: Some(Estimated::ThermalResistance),
        limits: &["winding_peak_temperature"],
        prevents: "it cannot be judged: the motor is never a choice",
    },
    Lack {
        name: "thermal time constants",
        columns: "thermal_time_constant_winding, thermal_time_constant_housing",
        is_lacking: |m| {
            m.sheet.thermal_time_constant_winding.is_none() || m.sheet.thermal_time_constant_housing.is_none()
        },
        estimate: None,
        limits: &[],
        prevents: "the winding is not followed over the motion: its heat has an upper bound only",
    },
    Lack {
        name: "mass",
        columns: "mass",
        is_lacking: |m| m.mass.is_none(),
        estimate: None,
        limits: &["actuator_mass", "mass_budget"],
        prevents: "a limit on mass cannot be judged, and nothing is estimated",
    },
    Lack {
        name: "inductance",
        columns: "inductance",
        is_lacking: |m| m.inductance.is_none(),
        estimate: Some(Estimated::Inductance),
        limits: &["torque_bandwidth_voltage", "inductance"],
        prevents: "voltage is checked without it; a torque bandwidth cannot be judged",
    },
    Lack {
        name: "pole pairs",
        columns: "pole_pairs",
        is_lacking: |m| m.pole_pairs.is_none() && m.conventions.commutation == Commutation::Brushless,
        estimate: None,
        limits: &["inductance", "torque_bandwidth_voltage"],
        prevents: "voltage is checked without the part across, p N ω L i",
    },
    Lack {
        name: "peak current",
        columns: "peak_current",
        is_lacking: |m| m.peak_current.is_none(),
        estimate: None,
        limits: &["demagnetisation"],
        prevents: "only the drive's current is checked: the magnets may bear less",
    },
    Lack {
        name: "maximum speed",
        columns: "max_speed, or voltage and no_load_speed",
        is_lacking: |m| m.max_speed.is_none() && m.sheet.no_load_speed.is_none(),
        estimate: None,
        limits: &["max_speed"],
        prevents: "speed cannot be judged on a bus above the row's rated voltage",
    },
    Lack {
        name: "outer diameter",
        columns: "outer_diameter",
        is_lacking: |m| m.sheet.outer_diameter.is_none(),
        estimate: None,
        limits: &["outer_diameter"],
        prevents: "a limit on it cannot be judged; a rotor inertia that is not known is not estimated",
    },
    Lack {
        name: "axial length",
        columns: "length",
        is_lacking: |m| m.sheet.length.is_none(),
        estimate: None,
        limits: &["axial_length"],
        prevents: "a limit on it cannot be judged",
    },
    Lack {
        name: "price and lead time",
        columns: "price (with price_currency and price_date), lead_time",
        is_lacking: |m| m.sheet.offer.price.is_none() || m.sheet.offer.lead_time.is_none(),
        estimate: None,
        limits: &["price", "lead_time"],
        prevents: "limits on them cannot be judged",
    },
    Lack {
        name: "friction",
        columns: "no_load_current (with no_load_speed), or coulomb_friction and viscous_friction",
        is_lacking: |m| matches!(m.drag(), Drag::Unknown | Drag::Estimated { .. }),
        estimate: Some(Estimated::Drag),
        limits: &["motor_drag", "backdriving_torque"],
        prevents: "the loss and the energy of a joint cannot be judged",
    },
];

impl Lack {
    /// The estimate that fills it for a motor as its row says it.
    pub fn filled(&self, motor: &Motor) -> Option<Estimate> {
        let of = self.estimate?;
        completed(motor.clone()).estimates.into_iter().find(|e| e.of == of)
    }
}

/// How many rows of a catalogue lack something.
#[derive(Debug)]
pub struct Count {
    /// What.
    pub lack: &'static Lack,
    /// Rows of motors that lack it.
    pub rows: usize,
    /// Of these, rows for which it is estimated.
    pub estimated: usize,
}

/// What the motors of a catalogue lack, most rows first; what no row lacks is left out.
pub fn counts(catalog: &Catalog) -> Vec<Count> {
    let of = |lack: &'static Lack| {
        let rows: Vec<&Motor> = catalog.motors.iter().filter(|m| (lack.is_lacking)(m)).collect();
        let estimated = rows.iter().filter(|m| lack.filled(m).is_some()).count();
        Count { lack, rows: rows.len(), estimated }
    };
    let mut counts: Vec<Count> = LACKS.iter().map(of).filter(|c| c.rows > 0).collect();
    counts.sort_by_key(|c| std::cmp::Reverse(c.rows));
    counts
}

/// For people: nothing where every row says everything.
pub fn text(catalog: &Catalog) -> String {
    let counts = counts(catalog);
    if counts.is_empty() {
        return String::new();
    }
    let columns = vec![
        Column::name("lacks"),
        Column::number("rows", ""),
        Column::number("estimated", ""),
        Column::prose("what that prevents"),
    ];
    let rows = counts.iter().map(|count| {
        let estimated = if count.lack.estimate.is_some() { count.estimated.to_string() } else { String::new() };
        vec![count.lack.name.to_string(), count.rows.to_string(), estimated, count.lack.prevents.to_string()]
    });
    let title = format!("What rows lack, of {}:", counted(catalog.motors.len(), "motor"));
    let table = Table::new(columns).indented(2).also_in("`--json`").rows(rows).text();
    let line = "`estimated`: rows for which rows built alike say it, at the pessimistic end; `gearwise catalog show ID` says what one row lacks.";
    format!("{}{table}{}", paragraph(&title, 0, 2), paragraph(line, 0, 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gearwise_model::actuator::Load;
    use gearwise_model::actuator::limits::{Check, Judge, Verdict};
    use gearwise_model::input::Source;
    use gearwise_model::requirement;
    use gearwise_select::Mount;

    /// Columns of a full row with a blank for each; the value of a full row.
    const COLUMNS: &[(&str, &str, &[&str])] = &[
        ("rotor_inertia [kg*m^2]", "1e-5", &["rotor inertia"]),
        ("mass [kg]", "1", &["mass"]),
        ("inductance [H]", "1e-3", &["inductance"]),
        ("pole_pairs", "7", &["pole pairs"]),
        ("peak_current [A]", "20", &["peak current"]),
        ("max_speed [rad/s]", "2000", &["maximum speed"]),
        ("outer_diameter [m]", "0.05", &["outer diameter"]),
        ("length [m]", "0.03", &["axial length"]),
        ("price", "90", &["price and lead time"]),
        ("price_currency", "EUR", &["price and lead time"]),
        ("price_date", "2026-01-31", &["price and lead time"]),
        ("lead_time [d]", "9", &["price and lead time"]),
        ("continuous_current [A]", "5", &["heat"]),
        ("coulomb_friction [N*m]", "0.001", &["friction"]),
        ("thermal_time_constant_winding [s]", "20", &["thermal time constants"]),
        ("thermal_time_constant_housing [s]", "900", &["thermal time constants"]),
    ];

    fn row(without: &str) -> Motor {
        let header: Vec<&str> = COLUMNS.iter().map(|(head, ..)| *head).collect();
        let of = |(_, value, lacks): &(&str, &'static str, &[&str])| if lacks.contains(&without) { "" } else { *value };
        let cells: Vec<&str> = COLUMNS.iter().map(of).collect();
        let text = format!(
            "id,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind,{}\nm,q_axis,q_axis,1,0.1,s,derived,{}\n",
            header.join(","),
            cells.join(",")
        );
        Catalog::from_sources(vec![Source::new("m.csv", text).into()])
            .unwrap_or_else(|e| panic!("{}", e[0]))
            .motors
            .remove(0)
    }

    /// Limits and needs of which nothing can be said.
    fn unknown(motor: &Motor) -> Result<Vec<&'static str>, String> {
        let robot = "name = \"x\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"40 A\"\n[budget]\nactuator_mass = \"9 kg\"\n[[joint]]\nname = \"j\"\n\
             ratio = { min = 3, max = 20 }\ngear = { efficiency = 0.9, mass = \"1 kg\", starting_torque = \"0 N*m\", outer_diameter = \"9 mm\", length = \"9 mm\", price = \"9 EUR\", lead_time = \"9 d\" }\n\
             points = [ { torque = \"1 N*m\", speed = \"1 rad/s\", duration = \"1 s\" } ]\n[joint.limits]\nactuator_mass = \"9 kg\"\n\
             outer_diameter = \"1 m\"\naxial_length = \"1 m\"\ntorque_bandwidth = { frequency = \"1 Hz\", amplitude = \"1 N*m\" }\n\
             max_backdriving_torque = \"9 N*m\"\nprice = \"999 EUR\"\nlead_time = \"99 d\"\n[prices]\ncurrency = \"EUR\"\ndate = \"2026-11-01\"\n";
        let robot =
            requirement::read_source(&Source::new("x.toml", robot).into()).unwrap_or_else(|e| panic!("{}", e[0]));
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, joint.ripple());
        let candidate = Mount::new(&robot, joint, &load, motor).candidate().map_err(|e| format!("{e:?}"))?;
        let judged = |judge: Judge| matches!(judge(&candidate, 9.0), Verdict::Unknown(_));
        let mut found: Vec<&'static str> = candidate
            .checks()
            .filter(|(_, check)| match check {
                Check::Unknown(_) => true,
                Check::AtRatio(judge) => judged(*judge),
                _ => false,
            })
            .map(|(limit, _)| limit.name)
            .collect();
        found.extend(candidate.lacking().map(|(name, _)| name));
        Ok(found)
    }

    #[test]
    fn each_lack_prevents_what_it_says_and_a_full_row_lacks_nothing() {
        let full = row("nothing");
        assert!(LACKS.iter().all(|lack| !(lack.is_lacking)(&full)));
        assert_eq!(unknown(&full).unwrap(), Vec::<&str>::new());
        for lack in LACKS {
            let motor = row(lack.name);
            let lacking: Vec<&str> = LACKS.iter().filter(|l| (l.is_lacking)(&motor)).map(|l| l.name).collect();
            assert_eq!(lacking, [lack.name]);
            match unknown(&motor) {
                Ok(mut found) => {
                    found.sort_unstable();
                    found.dedup();
                    let mut said = lack.limits.to_vec();
                    said.sort_unstable();
                    assert_eq!(found, said, "{}", lack.name);
                }
                // Without rotor inertia there is no candidate.
                Err(_) => assert_eq!(lack.name, "rotor inertia"),
            }
        }
    }
}
