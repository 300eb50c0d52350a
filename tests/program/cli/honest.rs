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
