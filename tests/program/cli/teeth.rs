//! A joint whose ratios are those of planetary stages: the teeth in text, JSON, explanations and design files; and gears of
//! the catalogue near a best ratio.

use std::fs;

use serde_json::Value;

use super::folder::{REQUIREMENT, Ran, folder, run};
use super::tables::collapsed;

const RATIO: &str = "ratio = { min = 3, max = 30 }";
const SHORT: &str = "ratio = { stages = [[3, 5], [3, 5]], teeth = { sun = [18, 21], ring_max = 80 } }";
const LONG: &str = "ratio = { stages = [[3, 8], [3, 8]], teeth = { sun = [18, 30], ring_max = 140 } }";

fn with(ratio: &str, words: &[&str]) -> (tempfile::TempDir, Ran) {
    let folder = folder();
    assert!(REQUIREMENT.contains(RATIO));
    fs::write(folder.path().join("robot.toml"), REQUIREMENT.replace(RATIO, ratio)).unwrap();
    let ran = run(&folder, words);
    (folder, ran)
}

fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}{}", ran.out, ran.err))
}

const OPTIMIZE: [&str; 4] = ["optimize", "robot.toml", "--catalog", "motors.csv"];

#[test]
fn the_answer_has_the_teeth_of_its_ratio() {
    let (folder, ran) = with(SHORT, &[&OPTIMIZE[..], &["--json"]].concat());
    let joint = json(&ran)["joints"][0].clone();
    let best = &joint["candidates"][0];
    let ratio = best["ratio"].as_f64().unwrap();
    let stages = best["teeth"]["stages"].as_array().unwrap();
    let of = |stage: &Value, k: usize| stage[k].as_f64().unwrap();
    let product: f64 = stages.iter().map(|stage| 1.0 + of(stage, 1) / of(stage, 0)).product();
    assert!((product / ratio - 1.0).abs() < 1e-9 && stages.len() == 2 && best["teeth"]["planets"] == 3, "{best}");
    assert!(joint["stages"]["within"].is_null() && joint["stages"]["ratios"] == joint["stages"]["looked_at"]);
    // The same in words, in each of its readings.
    let said = format!(
        "teeth: sun {} ring {}, then sun {} ring {}, 3 planets each",
        stages[0][0], stages[0][1], stages[1][0], stages[1][1]
    );
    let text = collapsed(&run(&folder, &OPTIMIZE).out);
    assert!(text.contains(&said) && !text.contains("can be assembled"), "{said} in {text}");
    for more in ["--why", "--full"] {
        let text = collapsed(&run(&folder, &[&OPTIMIZE[..], &[more]].concat()).out);
        assert!(text.contains(&said), "{more}: {said} in {text}");
    }
    assert!(collapsed(&run(&folder, &[&OPTIMIZE[..], &["--full"]].concat()).out).contains("by teeth ("));
    let page = run(&folder, &[&OPTIMIZE[..], &["--html", "page.html"]].concat());
    assert_eq!(page.status, 0, "{}", page.err);
    assert!(fs::read_to_string(folder.path().join("page.html")).unwrap().contains(&said));
    // A ratio that was read in four digits is that of the teeth.
    let motor = best["motor"].as_str().unwrap();
    let named = format!("{motor}@{}", gearwise::report::number(ratio));
    let ran = run(&folder, &["explain", &named, "robot.toml", "--catalog", "motors.csv"]);
    let text = collapsed(&ran.out);
    assert!(text.to_lowercase().contains(&said.to_lowercase()) && !text.contains("does not list"), "{text}{}", ran.err);
    // The design file has them, and passes its check.
    let ran = run(&folder, &[&OPTIMIZE[..], &["--write-design", "made.toml"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let made = fs::read_to_string(folder.path().join("made.toml")).unwrap();
    let comment = format!("# planetary: sun {}, ring {}; sun {}", stages[0][0], stages[0][1], stages[1][0]);
    assert!(made.contains(&comment), "{made}");
    let ran = run(&folder, &["check", "made.toml"]);
    assert_ne!(ran.status, 2, "{}{}", ran.out, ran.err);
}

#[test]
fn a_long_list_of_teeth_says_what_it_left_out() {
    let (folder, ran) = with(LONG, &[&OPTIMIZE[..], &["--json"]].concat());
    let stages = json(&ran)["joints"][0]["stages"].clone();
    let (all, looked) = (stages["ratios"].as_u64().unwrap(), stages["looked_at"].as_u64().unwrap());
    assert!(all > 1000 && looked <= 1000 && looked > 500, "{stages}");
    assert!(stages["within"].as_f64().unwrap() < 0.01);
    for more in [&[][..], &["--why"], &["--full"]] {
        let text = collapsed(&run(&folder, &[&OPTIMIZE[..], more].concat()).out);
        assert!(text.contains(&format!("Of {all} ratios that can be assembled {looked} are looked at")), "{text}");
    }
    // A mistake has its place.
    let (_, ran) = with(&SHORT.replace("sun = [18, 21]", "sun = [21, 18]"), &OPTIMIZE);
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("robot.toml:9:") && ran.err.contains("upside down: 21 to 18"), "{}", ran.err);
}

const GEARS: &str = "id,kind,ratio,efficiency,mass [g],inertia [g*cm^2],continuous_torque [N*m],peak_torque [N*m],max_input_speed [rpm],source,source_kind\n";

#[test]
fn gears_near_by_say_what_they_cost_and_what_is_not_known() {
    let folder = folder();
    let look = |rows: &str| {
        fs::write(folder.path().join("gears.csv"), format!("{GEARS}{rows}")).unwrap();
        let words = ["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv"];
        let json = json(&run(&folder, &[&words[..], &["--json"]].concat()));
        let text = run(&folder, &[&words[..], &["--why"]].concat()).out;
        (json["joints"][0]["near_gears"].clone(), collapsed(&text))
    };
    let best = json(&run(&folder, &[&OPTIMIZE[..], &["--json"]].concat()))["joints"][0]["candidates"][0].clone();
    let ratio = format!("{:.3}", best["ratio"].as_f64().unwrap() * 0.97);
    let row = |id: &str, ratio: &str, cells: &str| format!("{id},planetary,{ratio},{cells},sheet,datasheet\n");
    // One that does all, one of unknown torque, one that is too weak, one of unknown efficiency.
    let rows = row("good", &ratio, "0.9,200,30,500,900,20000")
        + &row("unsaid", &ratio, "0.92,200,30,,900,20000")
        + &row("weak", &ratio, "0.97,200,30,,0.5,20000");
    let (near, text) = look(&rows);
    let of = |k: usize, key: &str| near["gears"][k][key].clone();
    assert_eq!([of(0, "gear"), of(1, "gear"), of(2, "gear")], ["good", "unsaid", "weak"], "{near}");
    assert_eq!([of(0, "standing"), of(1, "standing"), of(2, "standing")], ["keeps", "less_known", "exceeds"], "{near}");
    assert_eq!(of(2, "exceeds")[0]["limit"], "gear_peak_torque");
    assert!(text.contains("exceeds gear_peak_torque (") && text.contains("mass +0.05 kg"), "{text}");
    assert!(text.contains("not checked with it: gear_continuous_torque"), "{text}");
    // Only where everything is known and kept are all limits said to be kept.
    assert_eq!(text.contains("; all limits kept"), of(0, "keeps_all") == true, "{text}");
    let (near, text) = look(&row("blank", &ratio, ",200,30,500,900,20000"));
    assert_eq!((&near["gears"][0]["standing"], &near["gears"][0]["parts"]), (&"unusable".into(), &Value::Null));
    assert!(
        text.contains("cannot be evaluated: the gear's efficiency is not known") && near["gap"].is_null(),
        "{text}"
    );
    assert!(text.contains("none of which is known to keep every limit"), "{text}");
    // Larger than any ratio that the requirement allows.
    let (near, text) = look(&row("high", "45", "0.9,200,30,500,900,20000"));
    assert_eq!((&near["looked_at"], &near["gap"]["above"]), (&0.into(), &Value::Null), "{near}");
    assert!(text.contains("no gear of the catalogue fits this motor and the requirement's ratios"), "{text}");
}
