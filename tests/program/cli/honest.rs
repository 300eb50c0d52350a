//! Sentences that must not be said: each with a case where the tool knows less, or something else.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use super::folder::{MOTORS, REQUIREMENT, Ran, folder, run};
use super::tables::collapsed;

fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}{}", ran.out, ran.err))
}

/// Text that stands in lines of any width.
fn says(ran: &Ran, what: &str) -> bool {
    collapsed(&ran.out).contains(what)
}

const POINTS: &str = "points = [{ torque = \"1 N*m\", speed = \"4 rad/s\", duration = \"1 s\" }]";

/// A motor whose sheet has K_B below K_T gives no more than the shaft takes.
#[test]
fn no_motor_makes_energy() {
    let folder = folder();
    let head = "id,terminals,current,back_emf_convention,resistance [ohm],inductance [mH],torque_constant [N*m/A],back_emf_constant [V*s/rad],rotor_inertia [g*cm^2],mass [g],pole_pairs,continuous_torque [N*m],peak_current [A],max_winding_temperature [degC],source,source_kind";
    let row = "less,q_axis,q_axis,q_axis,0.1,0.05,0.05,0.04,300,200,7,9,60,120,a sheet,datasheet";
    fs::write(folder.path().join("less.csv"), format!("{head}\n{row}\n")).unwrap();
    let robot = REQUIREMENT.replace("motion = \"knee.csv\"", POINTS);
    for (objective, least) in [("energy", "energy_per_cycle_j"), ("peak_power", "peak_electrical_power_w")] {
        fs::write(folder.path().join("other.toml"), robot.replace("\"loss\"", &format!("\"{objective}\""))).unwrap();
        let ran = run(&folder, &["optimize", "other.toml", "--catalog", "less.csv", "--json"]);
        let first = &json(&ran)["joints"][0]["candidates"][0];
        // 1 N·m at 4 rad/s for 1 s through a gear of 95 %: 4.21 W and 4.21 J, and heat.
        assert!(first[least].as_f64().unwrap() > 4.0 / 0.95, "{objective}: {first}");
    }
    let shown = run(&folder, &["catalog", "show", "less", "--catalog", "less.csv"]);
    assert!(says(&shown, "would make energy"), "{}", shown.out);
}

/// Shares of the time say of no cycle how long it is: energy per cycle is refused, not every motor.
#[test]
fn energy_of_no_cycle_is_refused_where_it_is_asked() {
    let folder = folder();
    let timeless = REQUIREMENT.replace("motion = \"knee.csv\"", &POINTS.replace(", duration = \"1 s\"", ""));
    let share = |often: [&str; 2]| {
        let case = |name: &str, often: &str| format!("[[joint.case]]\nname = \"{name}\"\n{POINTS}\n{often}\n");
        let cases = case("walk", often[0]) + &case("stand", often[1]);
        REQUIREMENT.replace("motion = \"knee.csv\"\n", "") + &cases
    };
    let (shares, cycles) = (share(["share = 0.5", "share = 0.5"]), share(["cycles = 3", "cycles = 1"]));
    for (text, why) in [(&timeless, "operating points without durations"), (&shares, "the `share` of a load case")] {
        fs::write(folder.path().join("other.toml"), text).unwrap();
        let words = ["optimize", "other.toml", "--catalog", "motors.csv"];
        assert_eq!(run(&folder, &words).status, 0, "loss has an answer");
        let ran = run(&folder, &[&words[..], &["--set", "joint.knee.objective=energy"]].concat());
        assert_eq!((ran.status, ran.out.as_str()), (2, ""));
        assert!(ran.err.contains("is that of a cycle") && ran.err.contains(why), "{}", ran.err);
    }
    fs::write(folder.path().join("other.toml"), cycles.replace("\"loss\"", "\"energy\"")).unwrap();
    let ran = run(&folder, &["optimize", "other.toml", "--catalog", "motors.csv", "--json"]);
    let energy = json(&ran)["joints"][0]["candidates"][0]["energy_per_cycle_j"].as_f64().unwrap();
    assert!(energy > 16.0 / 0.95 && energy < 40.0, "four cycles of 4 J: {energy}");
}

/// A motor whose rotor inertia nobody knows is not one that cannot do it.
#[test]
fn unknown_is_not_cannot() {
    let folder = folder();
    let rows: Vec<String> = MOTORS.lines().map(|row| row.replace(",300,200,", ",,200,")).collect();
    fs::write(folder.path().join("less.csv"), rows.join("\n")).unwrap();
    let words = ["optimize", "robot.toml", "--no-estimates", "--full", "--catalog", "less.csv"];
    let text = run(&folder, &words);
    assert!(says(&text, "0 cannot, 1 cannot be judged"), "{}", text.out);
    let answer = json(&run(&folder, &[&words[..], &["--json"]].concat()));
    let joint = &answer["joints"][0];
    assert_eq!(joint["unjudged"][0]["motor"], "alpha-1");
    assert_eq!(joint["rejected"].as_array().unwrap().len(), 0);
    // Every other reading of the same catalogue says the same.
    let set = |command: &str, more: &[&str]| {
        let words = [&[command, "robot.toml", "--no-estimates", "--catalog", "less.csv", "--json"][..], more].concat();
        json(&run(&folder, &words))
    };
    let swept = set("sweep", &[]);
    let of_motor = |list: &str| {
        let all = swept["joints"][0][list].as_array().unwrap();
        all.iter().filter(|d| d["motor"] == "alpha-1").count()
    };
    assert_eq!((of_motor("candidates"), of_motor("unjudged"), of_motor("rejected")), (0, 1, 0));
    let whole = set("optimize", &["--robot"]);
    assert_eq!(whole["robot"]["choice"]["unjudged"][0]["motor"], "alpha-1", "{whole}");
    let study = "requirement = \"robot.toml\"\ncatalog = [\"less.csv\"]\n[grid]\n\"bus.voltage\" = [\"48 V\"]\n";
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let ran = run(&folder, &["study", "study.toml", "--no-estimates", "--out", "results"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let results = fs::read_to_string(folder.path().join("results/results.csv")).unwrap();
    let cells: Vec<Vec<&str>> = results.lines().map(|row| row.split(',').collect()).collect();
    let column = cells[0].iter().position(|name| *name == "unjudged_motors").unwrap();
    assert_eq!(cells[1][column], "1", "{results}");
    // With none left that is known, that no motor can do it is not known.
    fs::write(folder.path().join("less.csv"), rows[..2].join("\n")).unwrap();
    let none = run(&folder, &words);
    assert_eq!(none.status, 1);
    assert!(says(&none, "NO motor that can be judged can do"), "{}", none.out);
    assert!(!says(&none, "NO motor of the catalogue can do"), "{}", none.out);
    let front = run(
        &folder,
        &["optimize", "robot.toml", "--no-estimates", "--pareto", "loss,mass", "--catalog", "less.csv", "--json"],
    );
    assert_eq!(json(&front)["joints"][0]["unjudged"][0]["motor"], "alpha-1");
}

/// That something would be feasible is not promised where a limit is not known.
#[test]
fn what_cannot_be_judged_is_not_promised() {
    let folder = folder();
    let rows: Vec<String> = MOTORS.lines().map(|row| row.replace(",0.5,0.2,0.05,", ",0.5,,0.05,")).collect();
    fs::write(folder.path().join("less.csv"), rows.join("\n")).unwrap();
    let explain = |catalog: &str| {
        run(
            &folder,
            &["explain", "alpha-1", "robot.toml", "--no-estimates", "--set", "bus.voltage=1 V", "--catalog", catalog],
        )
    };
    let (known, unknown) = (explain("motors.csv"), explain("less.csv"));
    assert!(says(&known, "Any one of these would make it feasible"), "{}", known.out);
    assert!(!says(&unknown, "would make it feasible"), "{}", unknown.out);
    assert!(says(&unknown, "every limit that can be judged"), "{}", unknown.out);
    let why =
        |catalog: &str| run(&folder, &["optimize", "robot.toml", "--no-estimates", "--why", "--catalog", catalog]);
    fs::write(folder.path().join("less.csv"), rows[..2].join("\n")).unwrap();
    assert!(says(&why("motors.csv"), "all limits kept"));
    assert!(!says(&why("less.csv"), "all limits kept") && says(&why("less.csv"), "all checked limits kept"));
}

/// What stands in a design file is true of the design in it.
#[test]
fn a_written_design_tells_its_own_numbers() {
    let folder = folder();
    let ran = run(&folder, &["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "made.toml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let made = fs::read_to_string(folder.path().join("made.toml")).unwrap();
    assert!(made.contains("optimal_ratio"), "{made}");
    let checked = json(&run(&folder, &["check", "made.toml", "--json"]));
    let loss = checked["joints"][0]["design"]["loss_w"].as_f64().unwrap_or_else(|| panic!("{checked}"));
    assert!(made.contains(&format!("# loss {} W (", gearwise::report::number(loss))), "{loss} in {made}");
    assert!(ran.err.contains("which can be built"), "{}", ran.err);
}

/// A margin of what a reserve leaves is told as such.
#[test]
fn a_reserve_is_not_taken_for_the_limit() {
    let folder = folder();
    let words = ["explain", "alpha-1@9", "robot.toml", "--catalog", "motors.csv"];
    let set = ["--set", "joint.knee.limits.reserve={ voltage = 0.15 }"];
    assert!(!says(&run(&folder, &words), "reserve"));
    assert!(says(&run(&folder, &[&words[..], &set].concat()), "bus, less 15 % reserve"));
}

/// A motor that `--only-checked` leaves out was not found to be unable.
#[test]
fn what_is_left_out_as_unchecked_is_not_said_to_be_unable() {
    let folder = folder();
    let mut rows: Vec<String> = MOTORS.lines().map(Into::into).collect();
    let at = rows[0].split(',').position(|c| c.starts_with("inductance")).unwrap();
    for row in &mut rows[1..] {
        let mut cells: Vec<&str> = row.split(',').collect();
        cells[at] = "";
        *row = cells.join(",");
    }
    fs::write(folder.path().join("bare.csv"), rows.join("\n")).unwrap();
    let words = ["optimize", "robot.toml", "--catalog", "bare.csv", "--no-estimates"];
    let able = json(&run(&folder, &[&words[..], &["--json"]].concat()))["joints"][0]["candidates"].clone();
    let able = able.as_array().unwrap().len();
    assert!(able > 0, "without the option they can do it");
    for more in [&["--only-checked"][..], &["--only-checked", "--top", "1"]] {
        let ran = run(&folder, &[&words[..], more].concat());
        assert!(says(&ran, &format!(", {able} cannot be checked in full")), "{more:?}: {}", ran.out);
        let told = collapsed(&ran.out);
        let cannot = told.split(" can do it, ").nth(1).and_then(|t| t.split(" cannot").next()).unwrap();
        assert_eq!(cannot.parse(), Ok(rows.len() - 1 - able), "{}", ran.out);
    }
}

/// Columns of a sheet, and a motor that is wound for a high voltage.
const SHEET: &str = "id,terminals,current,resistance [ohm],inductance [mH],speed_constant [rpm/V],speed_constant_convention,rotor_inertia [g*cm^2],mass [g],pole_pairs,continuous_torque [N*m],peak_current [A],max_winding_temperature [degC],source,source_kind";
const WOUND_HIGH: &str = "fine,line_to_line,dc,8,3.2,47.75,dc,300,200,7,9,15,120,a sheet,datasheet";

/// One motor wound for too high a voltage, one too small for any winding, one that a fit describes: of each only what holds.
#[test]
fn other_turns_help_only_where_they_do() {
    let folder = folder();
    let rows = [WOUND_HIGH, "weak,line_to_line,dc,0.5,0.2,191,dc,300,200,7,0.01,60,120,a sheet,datasheet"];
    fs::write(folder.path().join("wound.csv"), format!("{SHEET}\n{}\n", rows.join("\n"))).unwrap();
    // So low a voltage that only the fourth of the turns reaches the speed at a ratio that carries the heat.
    let robot = REQUIREMENT.replace("motion = \"knee.csv\"", &POINTS.replace("4 rad/s", "30 rad/s"));
    fs::write(folder.path().join("other.toml"), robot.replace("48 V", "6 V").replace("min = 3", "min = 8")).unwrap();
    let ran = run(&folder, &["optimize", "other.toml", "--catalog", "wound.csv", "--json"]);
    let answer = json(&ran);
    let rejected = answer["joints"][0]["rejected"].as_array().unwrap();
    let of =
        |id: &str| &rejected.iter().find(|r| r["motor"] == id).unwrap_or_else(|| panic!("{id}: {answer:#}"))["turns"];
    let (fine, weak) = (of("fine"), of("weak"));
    assert_eq!(
        (fine["verdict"].as_str(), weak["verdict"].as_str()),
        (Some("possible"), Some("impossible")),
        "{answer:#}"
    );
    let best = &fine["best"];
    let [min, max] = ["min", "max"].map(|key| best[key].as_f64().unwrap());
    let [least, most] = ["min", "max"].map(|key| best["constant"][key].as_f64().unwrap());
    assert!(min < max && max < 1.0 && best["max_by"] == "voltage", "{fine:#}");
    assert!(best["constant"]["symbol"] == "Kv", "{fine:#}");
    assert!((least * max / 47.75 - 1.0).abs() < 1e-9 && (most * min / 47.75 - 1.0).abs() < 1e-9, "{fine:#}");
    let text = run(&folder, &["optimize", "other.toml", "--catalog", "wound.csv", "--rejected"]);
    assert!(says(&text, "possible with") && says(&text, "no number of turns helps"), "{}", text.out);
    assert!(says(&text, "could do it with another number of turns"), "{}", text.out);
    // At the voltage that it is wound for nothing is said of its turns.
    let text =
        run(&folder, &["optimize", "other.toml", "--catalog", "wound.csv", "--set", "bus.voltage=200 V", "--why"]);
    assert!(!says(&text, "could do it with another number of turns"), "{}", text.out);
}

/// A range of turns: the winding of it is chosen, proved over ratio and turns, no winding of a dense list is better, and the design
/// file that is written from it passes its check. At a voltage that suits the row as it is wound, that stays.
#[test]
fn a_range_of_turns_is_chosen_from_with_its_proof() {
    let folder = folder();
    fs::write(folder.path().join("wound.csv"), format!("{SHEET}\n{WOUND_HIGH}\n")).unwrap();
    let robot = REQUIREMENT.replace("motion = \"knee.csv\"", &POINTS.replace("4 rad/s", "30 rad/s"));
    let robot = robot.replace("48 V", "6 V").replace("min = 3", "min = 8");
    let with = |turns: &str| {
        fs::write(folder.path().join("other.toml"), robot.replace("ratio =", &format!("{turns}\nratio ="))).unwrap();
        let ran =
            run(&folder, &["optimize", "other.toml", "--catalog", "wound.csv", "--json", "--write-design", "d.toml"]);
        let joint = &json(&ran)["joints"][0];
        // Each winding is one motor of the answer.
        let all =
            ["candidates", "rejected", "not_judged"].map(|list| joint[list].as_array().cloned().unwrap_or_default());
        let ids: Vec<String> = all.concat().iter().map(|motor| motor["motor"].to_string()).collect();
        assert_eq!(ids.len(), ids.iter().collect::<BTreeSet<_>>().len(), "{turns}: {ids:?}");
        joint["candidates"][0].clone()
    };
    let free = with("turns = { min = 0.05, max = 2 }");
    let id = free["motor"].as_str().unwrap().to_string();
    assert!(id.starts_with("fine:0."), "{free:#}");
    assert_eq!(free["certificate"]["method"], "over ratio and turns", "{free:#}");
    let objective = free["objective"].as_f64().unwrap();
    let design = fs::read_to_string(folder.path().join("d.toml")).unwrap();
    assert!(design.contains(&id), "{design}");
    let checked = run(&folder, &["check", "d.toml", "--catalog", "wound.csv"]);
    assert!(checked.status == 0, "{}", checked.out);
    let explained = run(&folder, &["explain", &id, "other.toml", "--catalog", "wound.csv"]);
    // Of one winding, what is proved is that no ratio is better.
    assert!(says(&explained, "no ratio is better") && !says(&explained, "over ratio and turns"), "{}", explained.out);
    let list: Vec<String> = (1..40).map(|k| format!("{}", 0.05 * f64::from(k))).collect();
    let listed = with(&format!("turns = [{}]", list.join(", ")));
    assert!(objective <= listed["objective"].as_f64().unwrap() * (1.0 + 1e-6), "{free:#} {listed:#}");
    assert_ne!(listed["certificate"]["method"], "over ratio and turns", "{listed:#}");
    // None of these windings does it: none is chosen.
    assert!(with("turns = { min = 0.9, max = 2 }").is_null());
    let own =
        run(&folder, &["optimize", "other.toml", "--catalog", "wound.csv", "--set", "bus.voltage=200 V", "--json"]);
    assert_eq!(json(&own)["joints"][0]["candidates"][0]["motor"], "fine");
    for (turns, more, what) in [
        ("turns = { min = 2, max = 0.5 }", &[][..], "upside down"),
        ("turns = { min = 0.01, max = 2 }", &[], "no winding of one frame"),
        ("turns = { min = 0.5 }", &[], "max"),
        ("turns = { min = 0.5, max = 2, step = 0.1 }", &[], "step"),
        ("turns = { min = 0.5, max = \"2\" }", &[], "max"),
        ("turns = { min = 0.5, max = 2 }", &["--set", "bus.internal_resistance=10 mohm"], "resistance of the supply"),
        ("turns = { min = 0.5, max = 2 }", &["--set", "bus.drive_phase_resistance=10 mohm"], "drive and leads"),
        ("turns = { min = 0.5, max = 2 }", &["--set", "bus.field_weakening_current=10 A"], "weakened field"),
        ("turns = { min = 0.5, max = 2 }", &["--robust"], "--robust"),
        ("turns = { min = 0.5, max = 2 }", &["--robot"], "--robot"),
        ("turns = { min = 0.5, max = 2 }", &["--pareto", "loss,mass"], "--pareto"),
        ("turns = { min = 0.5, max = 2 }", &["--set", "joint.knee.objective=peak_current"], "counts a current"),
    ] {
        let text = robot.replace("ratio =", &format!("{turns}\nratio ="));
        fs::write(folder.path().join("wrong.toml"), text).unwrap();
        let ran = run(&folder, &[&["optimize", "wrong.toml", "--catalog", "wound.csv"][..], more].concat());
        assert!(ran.status == 2 && collapsed(&ran.err).contains(what), "{turns} {more:?}: {} {}", ran.out, ran.err);
    }
}

/// What a card calls printed is what the row has, and a derived constant is not.
#[test]
fn a_card_calls_printed_what_the_row_has() {
    let catalog = gearwise::catalog::Catalog::builtin().unwrap();
    let mut looked = 0;
    for motor in catalog.motors.iter().filter(|m| m.sheet.speed_constant.is_some()) {
        let shown: Value = json_of(&["catalog", "show", &motor.id, "--json"]);
        let said = shown["conventions"].as_array().unwrap();
        let printed: Vec<f64> = said
            .iter()
            .filter(|s| s["column"] == "speed_constant" && s["printed"] == true)
            .map(|s| s["value"].as_f64().unwrap())
            .collect();
        let own = motor.sheet.speed_constant.unwrap().value;
        assert_eq!(printed.len(), 1, "{}", motor.id);
        assert!((printed[0] / own - 1.0).abs() < 1e-12, "{}: {} for {own}", motor.id, printed[0]);
        looked += 1;
    }
    assert!(looked > 20);
}

/// An estimate is marked where two motors are compared, and so is what is made from it; a number of the row is not.
#[test]
fn compare_marks_what_is_estimated() {
    let folder = tempfile::tempdir().unwrap();
    let header = "id,construction,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],source,source_kind\n";
    let row = |id: &str, l: &str| format!("{id},outrunner,q_axis,q_axis,0.2,{l},0.1,500,400,a sheet,datasheet\n");
    std::fs::write(folder.path().join("m.csv"), [header, &row("blank", ""), &row("known", "0.1")].concat()).unwrap();
    let run = |more: &[&str]| {
        let words = [&["compare", "blank", "known", "--catalog", "m.csv"][..], more].concat();
        String::from_utf8(crate::common::run::gearwise_in(folder.path(), &words).stdout).unwrap()
    };
    let text = run(&[]);
    let line =
        |of: &str| text.lines().find(|l| l.starts_with(of)).unwrap_or_else(|| panic!("{of}: {text}")).to_string();
    assert_eq!(line("inductance L").matches("estimated").count(), 1, "{text}");
    assert_eq!(line("63 % with inductance").matches("estimated").count(), 1, "{text}");
    for of in ["rotor inertia", "S_M", "63 % without inductance"] {
        assert!(!line(of).contains("estimated"), "{text}");
    }
    let answer: Value = serde_json::from_str(&run(&["--json"])).unwrap();
    let estimated = |k: usize| answer["motors"][k]["estimated"].as_array().unwrap().clone();
    assert!(estimated(0).iter().any(|e| e["quantity"] == "inductance"));
    assert!(estimated(1).iter().all(|e| e["quantity"] != "inductance"));
}

/// A gear that nobody can evaluate is named; where all can be, nothing is said. A motor that is not allowed is called so.
#[test]
fn gears_that_are_not_evaluated_are_named() {
    let text =
        std::fs::read_to_string(crate::common::repository("requirements/humanoid_hip_catalog_gears.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let with = |gears: &str| {
        let text = text
            .replace("gears = [\"planetary-*\"]", gears)
            .replace("gears = [\"planetary-*\", \"strain-wave-*\"]", gears);
        let motion = crate::common::repository("requirements");
        let text = text.replace("motion = \"", &format!("motion = \"{}/", motion.display()));
        std::fs::write(folder.path().join("r.toml"), text).unwrap();
        let words = ["optimize", "r.toml", "--json"];
        let out = crate::common::run::gearwise_in(folder.path(), &words);
        serde_json::from_slice::<Value>(&out.stdout)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&out.stderr)))
    };
    let found = with("gears = [\"planetary-t-motor-ak80-9\", \"planetary-faulhaber-*\"]");
    let named = found["joints"][0]["gears_without_efficiency"].as_array().unwrap();
    assert!(named.iter().any(|g| g == "planetary-t-motor-ak80-9") && named.len() > 3, "{named:?}");
    let found = with("gears = [\"planetary-compact-*\"]");
    assert!(found["joints"][0].get("gears_without_efficiency").is_none());
    let found = with("gears = [\"planetary-compact-*\"]\nmotors = [\"t-motor-u8-lee\"]");
    let rejected = found["joints"][0]["rejected"].as_array().unwrap();
    let not_allowed = rejected.iter().filter(|r| r["because"] == "the requirement does not allow it").count();
    assert!(not_allowed + 1 >= rejected.len() && not_allowed > 100, "{not_allowed} of {}", rejected.len());
}

/// An audit finds a slip of a decimal point or of a unit; of rows as they are shipped it calls none an error.
#[test]
fn an_audit_finds_slips_of_units() {
    let rows = std::fs::read_to_string(crate::common::repository("catalogs/motors/maxon.csv")).unwrap();
    let gears = std::fs::read_to_string(crate::common::repository("catalogs/gears/harmonic-drive.csv")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let audit = |text: &str, id: &str, column: &str, cell: &str| {
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let header = reader.headers().unwrap().clone();
        let at = header.iter().position(|h| h.split(" [").next() == Some(column)).unwrap();
        let mut writer = csv::Writer::from_path(folder.path().join("c.csv")).unwrap();
        writer.write_record(&header).unwrap();
        for record in reader.records().map(Result::unwrap) {
            let cells = record.iter().enumerate().map(|(k, old)| if k == at && &record[0] == id { cell } else { old });
            writer.write_record(cells).unwrap();
        }
        writer.flush().unwrap();
        let out = crate::common::run::gearwise_in(folder.path(), &["audit", "c.csv", "--json"]);
        let answer: Value = serde_json::from_slice(&out.stdout).unwrap();
        let of_row = |f: &&Value| f["id"] == id && f["severity"] != "accepted";
        let codes = answer["findings"]
            .as_array()
            .unwrap()
            .iter()
            .filter(of_row)
            .map(|f| f["code"].as_str().unwrap().to_string());
        codes.collect::<Vec<_>>()
    };
    let motor = "maxon-ec-i-40-496660";
    for (column, cell, code) in [
        ("rotor_inertia", "44000", "rotor-inertia-for-size"),
        ("rotor_inertia", "0.044", "rotor-inertia-for-size"),
        ("thermal_resistance_housing_ambient", "8000", "thermal-resistance-for-mass"),
        ("continuous_current", "1000", "continuous-torque-for-mass"),
        ("outer_diameter", "400", "diameter-for-mass"),
        ("outer_diameter", "4000", "out-of-range"),
        ("max_speed", "15", "max-speed-for-mass"),
        ("max_winding_temperature", "1550", "out-of-range"),
        ("pole_pairs", "700", "out-of-range"),
    ] {
        let found = audit(&rows, motor, column, cell);
        assert!(found.iter().any(|c| c == code), "{column} = {cell}: {found:?}");
    }
    assert!(audit(&rows, motor, "id", motor).is_empty());
    let gear = "strain-wave-harmonic-drive-csg-25-100";
    for (column, cell, code) in [
        ("mass", "15", "gear-mass-for-torque"),
        ("mass", "150000", "gear-mass-for-torque"),
        ("inertia", "4000000", "gear-inertia-for-mass"),
        ("stiffness", "29", "gear-stiffness-for-torque"),
        ("max_input_speed", "3", "gear-speed-for-mass"),
    ] {
        let found = audit(&gears, gear, column, cell);
        assert!(found.iter().any(|c| c == code), "{column} = {cell}: {found:?}");
    }
    assert!(audit(&gears, gear, "id", gear).is_empty());
}

/// A day that is none is refused at its cell.
#[test]
fn a_source_has_a_day_a_month_or_a_year() {
    let folder = tempfile::tempdir().unwrap();
    let row = |date: &str| {
        format!(
            "id,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_date,source_kind\nm,q_axis,q_axis,1,0.1,s,{date},derived\n"
        )
    };
    let run = |date: &str| {
        std::fs::write(folder.path().join("m.csv"), row(date)).unwrap();
        crate::common::run::gearwise_in(folder.path(), &["audit", "m.csv"])
    };
    for good in ["", "2024", "2024-02", "2024-02-29"] {
        assert_eq!(run(good).status.code(), Some(0), "{good}");
    }
    for bad in ["May 2024", "29.02.2024", "2023-02-29", "24", "1066", "9999-01-01"] {
        let out = run(bad);
        let said = String::from_utf8_lossy(&out.stderr).to_string();
        assert!(
            out.status.code() == Some(2) && said.contains("is no day, month or year") && said.contains(":2:"),
            "{bad}: {said}"
        );
    }
}

fn json_of(words: &[&str]) -> Value {
    serde_json::from_slice(&crate::common::run::gearwise(words).stdout).unwrap()
}
