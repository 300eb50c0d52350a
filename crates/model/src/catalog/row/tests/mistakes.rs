//! What a column may state of itself, alternatives, sides, versions: good, wrong and at the edge. Each mistake is said
//! once, with its place.

use super::{gears, motors, read};
use crate::catalog::audit::{audit_motor, conventions_line};
use crate::catalog::convention::CurrentConvention;
use crate::input::Problem;

const HEAD: &str = "id,terminals,current,resistance [ohm],source,source_kind";
const ROW: &str = "a,line_to_line,phase_amplitude,1,x,derived";

/// A table of motors with further columns.
fn with(columns: &str, cells: &str) -> String {
    format!("{HEAD},{columns}\n{ROW},{cells}\n")
}

/// The only mistake of a text, and what is marked.
fn only(name: &str, text: &str) -> (Problem, String) {
    let problems = read(name, text).expect_err(text);
    assert_eq!(problems.len(), 1, "{problems:#?}");
    let marked = problems[0].span.clone().map_or(String::new(), |span| text[span].to_string());
    (problems[0].clone(), marked)
}

fn said(text: &str) -> (String, String, String) {
    let (problem, marked) = only("a.csv", text);
    (problem.message, problem.help.unwrap_or_default(), marked)
}

#[test]
fn a_column_states_its_own_convention() {
    let text = with("torque_constant [N*m/A rms],continuous_current [A],peak_current [A]", "1.5,2,4");
    let motor = motors("a.csv", &text).remove(0);
    assert_eq!(motor.conventions.own.torque_constant, Some(CurrentConvention::Rms));
    assert!((motor.torque_constant - 1.5 / 3.0_f64.sqrt()).abs() < 1e-15);
    // The others have the row's: a phase amplitude.
    assert!((motor.peak_current.unwrap() - 4.0 * 1.5_f64.sqrt()).abs() < 1e-12);
    assert_eq!(conventions_line(&motor), "line_to_line, current phase_amplitude, torque_constant rms");
    let toml = "[[motor]]\nid = \"a\"\nterminals = \"line_to_line\"\ncurrent = \"phase_amplitude\"\nresistance = \"1 ohm\"\n\
                torque_constant = \"1.5 N*m/A rms\"\ncontinuous_current = \"2 A\"\npeak_current = \"4 A\"\nsource = \"x\"\n\
                source_kind = \"derived\"\n";
    assert_eq!(format!("{:?}", motors("a.toml", toml)[0]), format!("{motor:?}"));
}

/// What a price must say is the same for every kind of row, and is refused at its place.
#[test]
fn a_price_has_its_currency_and_its_day() {
    let gear = |columns: &str, cells: &str| {
        format!("id,kind,ratio,source,source_kind,{columns}\ng,planetary,9,x,derived,{cells}\n")
    };
    let module = |columns: &str, cells: &str| {
        format!("id,drive,ratio,source,source_kind,{columns}\nm,built_in,9,x,derived,{cells}\n")
    };
    let motor = |columns: &str, cells: &str| with(&format!("torque_constant [N*m/A],{columns}"), &format!("1,{cells}"));
    for table in [motor, gear, module] {
        for (columns, cells, message, marked) in [
            ("price,price_date", "90,2026-01-31", "`price` is given without `price_currency`", "90"),
            ("price,price_currency", "90,EUR", "`price` is given without `price_date`", "90"),
            ("price,price_currency,price_date", "90,eur,2026-01-31", "`eur` is no currency", "eur"),
            ("price,price_currency,price_date", "90,EUR,31.01.2026", "`31.01.2026` is no day", "31.01.2026"),
            ("price_quantity", "10", "`price_quantity` is given without `price`", "10"),
        ] {
            let (said, help, at) = said(&table(columns, cells));
            assert_eq!((said.as_str(), at.as_str()), (message, marked));
            assert!(!help.is_empty());
        }
        let good = table("price,price_currency,price_date,price_quantity,lead_time [d]", "90,EUR,2026-01-31,10,14");
        read("a.csv", &good).unwrap();
    }
    let motors = motors(
        "a.csv",
        &with("torque_constant [N*m/A],price,price_currency,price_date,lead_time [d]", "1,90,EUR,2026-01-31,14"),
    );
    let offer = &motors[0].sheet.offer;
    assert_eq!((offer.price().unwrap().value, offer.lead_time), (90.0, Some(14.0 * 86_400.0)));
}

#[test]
fn a_rewritten_convention_is_the_same_motor() {
    // The same machine, every number in another convention than the row's.
    let plain = with("inductance [H],torque_constant [N*m/A],continuous_current [A],peak_current [A]", "0.002,0.3,2,4");
    let r = std::f64::consts::SQRT_2;
    let other = format!(
        "{HEAD},inductance [H winding],torque_constant [N*m/A rms],continuous_current [A rms],peak_current [A rms],winding\n\
         {ROW},0.001,{},{},{},wye\n",
        0.3 * r,
        2.0 / r,
        4.0 / r
    );
    let (a, b) = (motors("a.csv", &plain).remove(0), motors("a.csv", &other).remove(0));
    let near = |x: f64, y: f64| assert!((x / y - 1.0).abs() < 1e-14, "{x} {y}");
    near(a.torque_constant, b.torque_constant);
    near(a.inductance.unwrap(), b.inductance.unwrap());
    near(a.continuous_current.unwrap(), b.continuous_current.unwrap());
    near(a.peak_current.unwrap(), b.peak_current.unwrap());
}

#[test]
fn the_audit_compares_in_one_convention() {
    // K_T per rms ampere with a peak current as amplitude: 1.5 N*m/A x 10 A / sqrt(2) = 10.6 N*m, not 15.
    let text = with("torque_constant [N*m/A rms],peak_current [A],peak_torque [N*m]", "1.5,10,10.6");
    assert!(audit_motor(&motors("a.csv", &text)[0]).is_empty());
    let text = with("torque_constant [N*m/A],peak_current [A],peak_torque [N*m]", "1.5,10,10.6");
    assert_eq!(audit_motor(&motors("a.csv", &text)[0])[0].code, "peak-torque");
}

#[test]
fn words_that_cannot_be_read() {
    let (message, help, marked) = said(&with("torque_constant [N*m/A rsm]", "1"));
    assert_eq!(message, "column `torque_constant`: unknown unit `rsm`");
    assert!(help.starts_with("did you mean `rms`? For example `torque_constant [N*m/A"), "{help}");
    assert_eq!(marked, "torque_constant [N*m/A rsm]");
    let (message, ..) = said(&with("torque_constant [N*m/A rms dc]", "1"));
    assert_eq!(message, "column `torque_constant`: two conventions are stated, `rms` and `dc`");
    let (message, ..) = said(&with("torque_constant [N*m/A],mass [kg rms]", "1,1"));
    assert_eq!(message, "column `mass`: unknown unit `rms`");
    let (message, ..) = said(&with("torque_constant [rms]", "1"));
    assert_eq!(message, "column `torque_constant`: a torque constant needs its unit");
    let (message, ..) = said(&with("torque_constant [N*m/A],torque_constant_tolerance [N*m/A rms]", "1,1"));
    assert_eq!(message, "column `torque_constant_tolerance`: unknown unit `rms`");
    let toml = "[[motor]]\nid = \"a\"\nterminals = \"line_to_line\"\ncurrent = \"dc\"\nresistance = \"1 ohm\"\n\
                torque_constant = \"1.5 N*m/A rsm\"\nsource = \"x\"\nsource_kind = \"derived\"\n";
    let (problem, marked) = only("a.toml", toml);
    assert_eq!(problem.message, "`torque_constant` of [[motor]]: unknown unit `rsm`");
    assert_eq!((problem.help.as_deref(), marked.as_str()), (Some("did you mean `rms`?"), "\"1.5 N*m/A rsm\""));
}

#[test]
fn a_convention_is_stated_once() {
    let text = with("torque_constant [N*m/A],back_emf_constant [V*s/rad dc],back_emf_convention", "1,1,");
    assert!(read("a.csv", &text).is_ok());
    assert!(read("a.csv", &with("torque_constant [N*m/A],back_emf_constant [V*s/rad dc]", "1,1")).is_ok());
    let text = with("torque_constant [N*m/A],back_emf_constant [V*s/rad dc],back_emf_convention", "1,1,q_axis");
    let (message, help, marked) = said(&text);
    assert_eq!(message, "`back_emf_constant`: it states `dc`, but `back_emf_convention` of this row says `q_axis`");
    assert_eq!((help.as_str(), marked.as_str()), ("leave `back_emf_convention` blank, or let the two agree", "1"));
    let text = format!("{HEAD},commutation,torque_constant [N*m/A rms]\na,line_to_line,dc,1,x,derived,brushed,1\n");
    assert_eq!(said(&text).0, "`torque_constant`: a brushed motor has DC amperes, not `rms`");
}

#[test]
fn one_of_several_columns_gives_a_number() {
    let columns = "torque_constant [N*m/A rms],torque_constant [mN*m/A],torque_constant_tolerance [%]";
    let text = format!("{}b,line_to_line,dc,1,x,derived,,70,10\n", with(columns, "1.5,,"));
    let read = motors("a.csv", &text);
    assert_eq!(read[0].conventions.own.torque_constant, Some(CurrentConvention::Rms));
    assert_eq!(read[1].conventions.own.torque_constant, None);
    let printed = read[1].sheet.torque_constant.unwrap();
    assert!((printed.value - 0.07).abs() < 1e-15 && (printed.tolerance.unwrap() - 0.007).abs() < 1e-15);
    let text = with(columns, "1.5,70,");
    let (message, help, marked) = said(&text);
    assert_eq!(message, "`torque_constant` is given twice in this row");
    assert_eq!((help.as_str(), marked.as_str()), ("leave one of the two cells blank", "70"));
    // The same words twice are a mistake, as a column twice has always been.
    for columns in
        ["torque_constant [N*m/A],torque_constant [mN*m/A]", "torque_constant [N*m/A dc],torque_constant [N*m/A dc]"]
    {
        assert_eq!(said(&with(columns, "1,1")).0, "duplicate column `torque_constant`");
    }
}

const GEAR: &str = "id,kind,ratio,source,source_kind";

fn gear(columns: &str, cells: &str) -> String {
    format!("{GEAR},{columns}\ng,planetary,10,x,derived,{cells}\n")
}

#[test]
fn a_number_of_a_gear_states_its_side() {
    let text = gear(
        "inertia [kg*m^2 output],backlash [rad motor],stiffness [N*m/rad motor],peak_torque [N*m output]",
        "0.02,0.5,3,7",
    );
    let g = gears("g.csv", &text).remove(0);
    let near = |x: Option<f64>, y: f64| assert!((x.unwrap() / y - 1.0).abs() < 1e-14, "{x:?} {y}");
    near(g.inertia, 2e-4);
    near(g.backlash, 0.05);
    near(g.stiffness, 300.0);
    near(g.peak_torque, 7.0);
    // Where it is kept, the word changes nothing.
    let plain = gears("g.csv", &gear("inertia [kg*m^2],backlash [rad]", "0.02,0.5"));
    assert_eq!(plain, gears("g.csv", &gear("inertia [kg*m^2 motor],backlash [rad output]", "0.02,0.5")));
    let toml = "[[gear]]\nid = \"g\"\nkind = \"planetary\"\nratio = 10\ninertia = \"0.02 kg*m^2 output\"\nsource = \"x\"\n\
                source_kind = \"derived\"\n";
    assert_eq!(gears("g.toml", toml)[0].inertia, g.inertia);
}

#[test]
fn a_side_that_cannot_be_converted_is_refused() {
    let (message, help, marked) = said(&gear("peak_torque [N*m motor]", "7"));
    assert_eq!(message, "`peak_torque`: `peak_torque` cannot be given at the side `motor`");
    assert_eq!(help, "what arrives at the output depends on the loss in the gear: give it there");
    assert_eq!(marked, "7");
    assert_eq!(
        said(&gear("max_input_speed [rpm output]", "7")).0,
        "`max_input_speed`: `max_input_speed` cannot be given at the side `output`"
    );
    assert_eq!(said(&gear("mass [kg output]", "7")).0, "column `mass`: unknown unit `output`");
}

#[test]
fn versions() {
    let text = with("torque_constant [N*m/A]", "1");
    for line in ["# gearwise catalogue 1", "#gearwise catalog 1", "# Gearwise Catalogue 1 of our motors"] {
        assert!(read("a.csv", &format!("{line}\n{text}")).is_ok(), "{line}");
    }
    // Comments as there have always been.
    for line in
        ["# motors of ours", "# gearwise catalogue of our motors", "# gearwise catalogue", "# my gearwise catalogue 7"]
    {
        assert!(read("a.csv", &format!("{line}\n{text}")).is_ok(), "{line}");
    }
    // Not the first line: a comment.
    assert!(read("a.csv", &format!("# motors\n# gearwise catalogue 7\n{text}")).is_ok());
    for name in ["a.csv", "a.toml"] {
        let (problem, marked) = only(name, &format!("# gearwise catalogue 12\n{text}"));
        assert_eq!(problem.message, "this catalogue is of version 12; this gearwise reads version 1");
        assert_eq!(marked, "12");
        for version in ["0", "-1", "1.0", "v2", "99999999999"] {
            let (problem, marked) = only(name, &format!("# gearwise catalogue {version}\n{text}"));
            assert_eq!(problem.message, "the version of a catalogue is a whole number from 1 on");
            assert_eq!(marked, version);
        }
    }
}

#[test]
fn lists_of_rows_in_toml() {
    let row = |id: &str| {
        format!(
            "[[motor]]\nid = \"{id}\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\nresistance = \"1 ohm\"\n\
             torque_constant = \"1 N*m/A\"\nsource = \"x\"\nsource_kind = \"derived\"\n"
        )
    };
    assert_eq!(motors("a.toml", &(row("a") + &row("b"))).len(), 2);
    let (problem, marked) = only("a.toml", &(row("a") + &row("a")));
    assert_eq!((problem.message.as_str(), marked.as_str()), ("duplicate id `a`", "\"a\""));
    let (problem, _) = only("a.toml", &row("a").replace("source = \"x\"\n", ""));
    assert_eq!(problem.message, "`source` of [[motor]] is missing");
    let (problem, _) = only("a.toml", &row("a").replace("source = \"x\"", "source = \" \""));
    assert_eq!(problem.message, "`source` is blank");
    let (problem, _) = only("a.toml", &row("a").replace("source = \"x\"", "source = \"x\"\ncolour = \"red\""));
    assert_eq!(problem.message, "unknown key `colour` in [[motor]]");
    let (problem, _) = only("a.toml", &row("a").replace("resistance = \"1 ohm\"\n", ""));
    assert_eq!(problem.message, "`resistance` of [[motor]] is missing");
    let (problem, _) = only("a.toml", &row("a").replace("\"1 ohm\"", "\"1 V\""));
    assert_eq!(problem.message, "`resistance` of [[motor]]: `V` is not a unit of resistance");
}

#[test]
fn a_tolerance_of_a_temperature_is_a_difference() {
    let row = |tolerance: &str| {
        format!(
            "[[motor]]\nid = \"a\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\nresistance = \"1 ohm\"\n\
             torque_constant = \"1 N*m/A\"\nreference_temperature = \"25 degC\"\n\
             reference_temperature_tolerance = \"{tolerance}\"\nsource = \"x\"\nsource_kind = \"derived\"\n"
        )
    };
    let of = |text| motors("a.toml", &row(text))[0].sheet.reference_temperature.unwrap().tolerance.unwrap();
    assert_eq!((of("2 K"), of("2 degC")), (2.0, 2.0));
    assert_eq!(
        only("a.toml", &row("2 m")).0.message,
        "`reference_temperature_tolerance` of [[motor]]: `m` is not a unit of temperature"
    );
}

#[test]
fn currents_of_one_dc_sheet_may_cross_on_the_q_axis() {
    // 10 A for ever and 10.2 A at most of a DC sheet are 14.14 A and 13.78 A on the q axis.
    let text = |current: &str, continuous: &str, peak: &str| {
        format!(
            "{HEAD},torque_constant [N*m/A],continuous_current [A],peak_current [A]\n\
             a,q_axis,{current},1,x,derived,1,{continuous},{peak}\n"
        )
    };
    assert!(read("a.csv", &text("q_axis", "14.14", "13.78")).is_ok());
    let swapped = "`peak_current` is less than `continuous_current`";
    assert_eq!(said(&text("q_axis", "14.14", "13.4")).0, swapped);
    assert_eq!(said(&text("rms", "14.14", "13.78")).0, swapped);
    // 10 A rms are 14.1 A amplitude: more than 12 A.
    let mixed = with("torque_constant [N*m/A],continuous_current [A rms],peak_current [A]", "1,10,12");
    assert_eq!(said(&mixed).0, swapped);
}
