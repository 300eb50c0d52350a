//! Tables at every width: each row stands with what is said of it, none is missing, no number and no name is folded,
//! and no line is wider than was asked. What a table says is compared with the JSON of the same run. First the layout by
//! itself, counted by hand, then every command.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use gearwise::report::table::{Column, Table, paragraph_at, wrap_at};
use gearwise::report::{number, number_between};
use serde_json::Value;

use crate::common::repository;

fn motors() -> Table {
    let columns = vec![
        Column::number("#", ""),
        Column::name("motor"),
        Column::number("loss", "W"),
        Column::number("mass", "kg").dropped(2),
        Column::number("peak\ncurrent", "A").dropped(1),
    ];
    let mut table = Table::new(columns).indented(2).also_in("`--json`");
    for (k, motor) in ["a-motor", "another-motor"].iter().enumerate() {
        let cells = [&(k + 1).to_string(), *motor, "0.0774", "–", "12.5"].map(str::to_string);
        table.push(cells.to_vec(), vec![format!("feasible from 5.12 to 9.87; of {motor}")]);
    }
    table
}

#[test]
fn a_row_and_what_is_said_of_it_are_one_thing_at_every_width() {
    for width in 20..=120 {
        let text = motors().text_at(width);
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let [first, second] = [words.find(" a-motor").unwrap(), words.find(" another-motor").unwrap()];
        for (motor, row) in [("a-motor", &words[first..second]), ("another-motor", &words[second..])] {
            assert!(row.contains("0.0774") && row.contains("5.12") && row.contains("9.87"), "{width}: {text}");
            assert!(row.contains(&format!("of {motor}")), "{width}: {text}");
        }
        assert!(text.lines().all(|l| l.chars().count() <= width), "{width}: {text}");
    }
}

#[test]
fn what_does_not_fit_is_tried_in_its_order() {
    // In one line: 2 + 1 + 2 + 13 + 2 + 8 + 2 + 9 + 2 + 16 = 57 columns.
    assert_eq!(
        motors().text_at(57),
        "  #  motor          loss [W]  mass [kg]  peak current [A]\n\
         \u{20} 1  a-motor          0.0774          –              12.5\n\
         \u{20}    feasible from 5.12 to 9.87; of a-motor\n\
         \u{20} 2  another-motor    0.0774          –              12.5\n\
         \u{20}    feasible from 5.12 to 9.87; of another-motor\n"
    );
    // Units beneath their headings: 2 + 1 + 2 + 13 + 2 + 6 + 2 + 4 + 2 + 7 = 41.
    let broken = [
        "  #  motor            loss  mass     peak",
        "                       [W]  [kg]  current",
        "                                      [A]",
        "  1  a-motor        0.0774     –     12.5",
    ]
    .join("\n");
    for width in [56, 41] {
        assert!(motors().text_at(width).starts_with(&broken), "{}", motors().text_at(width));
    }
    // Without the first that may be dropped; that is said, with where it is.
    let text = motors().text_at(40);
    assert!(text.starts_with("  #  motor          loss [W]  mass [kg]\n"), "{text}");
    assert!(!text.contains("12.5"), "{text}");
    let said = "Not shown at 40 columns: peak current (shown from 41 columns on, and in `--json`)";
    assert!(text.split_whitespace().collect::<Vec<_>>().join(" ").ends_with(said), "{text}");
    // Without both: 2 + 1 + 2 + 13 + 2 + 6 = 26.
    assert!(motors().text_at(26).contains("mass, peak"), "{}", motors().text_at(26));
    // A block for each row, with every column.
    assert!(
        motors().text_at(25).starts_with(
            "  #             1\n  motor         a-motor\n  loss          0.0774 W\n  mass          –\n  peak current  12.5 A\n"
        ),
        "{}",
        motors().text_at(25)
    );
}

#[test]
fn prose_gives_way_and_nothing_else() {
    let columns = vec![Column::name("rule"), Column::prose("asks that"), Column::name("severity")];
    let row = ["a-long-name", "the winding stays below the temperature of its sheet", "error"].map(str::to_string);
    let text = Table::new(columns).rows([row.to_vec()]).text_at(52);
    assert_eq!(
        text,
        [
            "rule         asks that                      severity",
            "a-long-name  the winding stays below the    error",
            "             temperature of its sheet",
            "",
        ]
        .join("\n")
    );
}

#[test]
fn what_comes_from_files_does_not_break_a_row() {
    let table = Table::new(vec![Column::name("motor"), Column::number("N", "")]);
    let text = table.rows([vec!["a\nb\u{1b}[2J".to_string(), "3".into()]]).text_at(80);
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(!text.contains('\u{1b}'));
}

#[test]
fn characters_of_two_columns_are_counted_so() {
    let table = Table::new(vec![Column::name("motor"), Column::number("N", "")]);
    let text = table.rows([vec!["モータ".to_string(), "3".into()], vec!["motor1".into(), "4".into()]]).text_at(80);
    assert_eq!(text, "motor   N\nモータ  3\nmotor1  4\n");
}

#[test]
fn no_line_ends_between_a_number_and_its_sign_or_unit() {
    for width in 24..60 {
        let text = wrap_at("it needs N ≥ 12.5 and 3.25 kg*m^2 at N* = 47.3 ± 0.4 W, not 93 % of 20 motors", 2, width);
        for line in text.lines() {
            let ends = line.ends_with(['≥', '=', '±']) || line.ends_with("3.25") || line.ends_with("93");
            let line = line.trim_start();
            assert!(!ends && !line.starts_with(['≥', '=', '±', '%']), "{width}:\n{text}");
        }
    }
    assert_eq!(wrap_at("one two three", 2, 9), "one two\n  three");
    assert_eq!(paragraph_at("one two three", 1, 3, 10), " one two\n   three\n");
    assert_eq!(wrap_at("", 4, 80), "");
}

/// Widths at which everything is looked at; `None` is what a pipe gets.
pub(super) const WIDTHS: [Option<usize>; 6] = [Some(60), Some(80), Some(100), Some(120), Some(200), None];

/// Motors of the shipped catalogue: one of each kind of row, the longest names among them.
const MOTORS: [&str; 8] = [
    "t-motor-ri50",
    "t-motor-u8-lee",
    "t-motor-ak80-6",
    "mit-mini-cheetah",
    "tq-robodrive-ilm-70x18",
    "maxon-ec-frameless-ht-90-m-937612",
    "maxon-ec-frameless-ht-60-m-936176",
    "allied-mf0127020-48v",
];

/// Gears of the shipped catalogue.
const GEARS: [&str; 3] = ["planetary-apex-af042-20", "planetary-apex-af060-50", "strain-wave-harmonic-drive-csf-17-50"];

/// A folder with a small catalogue and requirements of its own.
pub(super) struct Folder(pub(super) tempfile::TempDir);

impl Folder {
    pub(super) fn new() -> Folder {
        let folder = Folder(tempfile::tempdir().unwrap());
        for (kind, ids) in [("motors", MOTORS.as_slice()), ("gears", GEARS.as_slice())] {
            let mut kept = 0;
            for entry in std::fs::read_dir(repository("catalogs").join(kind)).unwrap() {
                let path = entry.unwrap().path();
                let text = std::fs::read_to_string(&path).unwrap();
                let mut lines = text.lines().filter(|l| !l.starts_with('#'));
                let header = lines.next().unwrap();
                let rows: Vec<&str> = lines.filter(|l| ids.contains(&l.split(',').next().unwrap())).collect();
                kept += rows.len();
                if !rows.is_empty() {
                    folder.write(
                        &path.file_name().unwrap().to_string_lossy(),
                        &format!("{header}\n{}\n", rows.join("\n")),
                    );
                }
            }
            assert_eq!(kept, ids.len(), "{kind} of the shipped catalogue");
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(super) fn write(&self, name: &str, text: &str) {
        std::fs::create_dir_all(self.path("catalog")).unwrap();
        let place = if name.ends_with(".csv") { format!("catalog/{name}") } else { name.into() };
        std::fs::write(self.path(&place), text).unwrap();
    }

    /// A shipped requirement with other words for some of its own.
    pub(super) fn requirement(&self, shipped: &str, name: &str, changes: &[(&str, &str)]) {
        let mut text = std::fs::read_to_string(repository("requirements").join(shipped)).unwrap();
        for (from, to) in changes {
            assert!(text.contains(from), "{shipped}: {from}");
            text = text.replace(from, to);
        }
        let motions = format!("\"{}/", repository("requirements/motions").display());
        self.write(name, &text.replace("\"motions/", &motions).replace("\"../motions/", &motions));
    }

    /// What the program prints at a width; it may say that something is not satisfied.
    pub(super) fn run(&self, words: &[&str], width: Option<usize>) -> String {
        run(self.0.path(), words, width)
    }

    pub(super) fn json(&self, words: &[&str]) -> Value {
        serde_json::from_str(&self.run(&[words, &["--json"]].concat(), None)).unwrap()
    }
}

fn run(folder: &Path, words: &[&str], width: Option<usize>) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
    command.args(words).current_dir(folder).env_remove("COLUMNS");
    if let Some(width) = width {
        command.env("COLUMNS", width.to_string());
    }
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{words:?}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

/// A text with one blank between its words, and one at either end.
pub(super) fn collapsed(text: &str) -> String {
    format!(" {} ", text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The headings that a text says it leaves out, and the text without that saying.
pub(super) fn left_out(text: &str) -> (Vec<String>, String) {
    let (mut names, mut rest) = (Vec::new(), String::new());
    let text = collapsed(text);
    let mut parts = text.split(" Not shown at ");
    rest.push_str(parts.next().unwrap());
    for part in parts {
        let (list, after) = part.split_once(" (shown from ").unwrap();
        names.extend(list.split_once(" columns: ").unwrap().1.split(", ").map(str::to_string));
        rest.push(' ');
        rest.push_str(after.split_once(')').unwrap().1);
    }
    (names, rest)
}

/// No line is wider than the width, but for one word that is.
pub(super) fn assert_width(text: &str, width: usize, what: &str) {
    for line in text.lines() {
        let alone = line.split_whitespace().count() == 1;
        assert!(line.chars().count() <= width || alone, "{what}: wider than {width}:\n{line}");
    }
}

/// Where each row begins in a text: its first cells, with their headings, one after the other in a line or as a block.
fn starts(text: &str, rows: &[Vec<(&str, String)>], what: &str) -> Vec<usize> {
    let mut from = 0;
    rows.iter()
        .map(|row| {
            let line: Vec<&str> = row.iter().map(|(_, cell)| cell.as_str()).collect();
            let block: Vec<String> = row.iter().map(|(heading, cell)| format!("{heading} {cell}")).collect();
            let found = [format!(" {} ", line.join(" ")), format!(" {} ", block.join(" "))]
                .iter()
                .filter_map(|pattern| text[from..].find(pattern.as_str()))
                .min();
            let at = from + found.unwrap_or_else(|| panic!("{what}: {line:?} is missing after {from} of\n{text}"));
            from = at + 1;
            at
        })
        .collect()
}

/// Each row with what follows until the next one.
pub(super) fn rows_of(text: &str, rows: &[Vec<(&str, String)>], what: &str) -> Vec<String> {
    let starts = starts(text, rows, what);
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    starts.iter().zip(ends).map(|(start, end)| text[*start..end].to_string() + " ").collect()
}

pub(super) fn shown(value: &Value) -> String {
    value.as_f64().map_or_else(|| "–".into(), number)
}

/// The ratio of a design as it is printed: inside its window, so that it can be typed again.
pub(super) fn ratio_of(design: &Value) -> String {
    let ends = [&design["window"][0], &design["window"][1]].map(Value::as_f64);
    match (design["gear"].is_null(), ends) {
        (true, [Some(min), Some(max)]) => number_between(design["ratio"].as_f64().unwrap(), min, max),
        _ => shown(&design["ratio"]),
    }
}

pub(super) fn text_of(value: &Value) -> String {
    value.as_str().unwrap().to_string()
}

/// The candidates of one joint against its JSON: every rank with its own numbers, window and margin.
fn assert_candidates(text: &str, joint: &Value, top: usize, what: &str) {
    let candidates: Vec<&Value> = joint["candidates"].as_array().unwrap().iter().take(top).collect();
    let geared = candidates.iter().any(|c| !c["gear"].is_null());
    let keys: Vec<Vec<(&str, String)>> = candidates
        .iter()
        .enumerate()
        .map(|(k, c)| {
            let ratio = if geared { "N" } else { "N*" };
            vec![("#", (k + 1).to_string()), ("motor", text_of(&c["motor"])), (ratio, ratio_of(c))]
        })
        .collect();
    let (dropped, text) = left_out(text);
    for (row, c) in rows_of(&text, &keys, what).iter().zip(&candidates) {
        let cells = [
            ("loss", &c["loss_w"]),
            (
                "I peak",
                if c["peak_current_phase_a"].is_null() {
                    &c["peak_drive_current_a"]
                } else {
                    &c["peak_current_phase_a"]
                },
            ),
            ("J", &c["reflected_inertia_kgm2"]),
            ("mass", &c["mass_kg"]),
            ("objective", &c["objective"]),
        ];
        // Peak current is minimised on the q axis and shown as the drive's.
        let apart = |heading: &str| heading == "objective" && joint["objective"] == "peak_current";
        let there = |heading: &str| !dropped.iter().any(|d| d == heading) && !apart(heading);
        for (heading, value) in cells.iter().filter(|(heading, _)| there(heading)) {
            assert!(row.contains(&format!(" {} ", shown(value))), "{what}: {heading} {} in\n{row}", shown(value));
        }
        assert_eq!(row.matches("tightest margin").count(), 1, "{what}: of one row\n{row}");
        let (limit, margin) = tightest(&c["margins"]);
        let said = format!("tightest margin {limit} {:.0} %", (100.0 * margin).max(0.0));
        assert!(row.contains(&said), "{what}: {said} in\n{row}");
        match c["gear"].as_str() {
            Some(gear) => assert!(row.contains(&format!(" with {gear};")), "{what}: {gear} in\n{row}"),
            None => assert_windows(row, &c["windows"], what),
        }
        let count = c["not_checked"].as_array().unwrap().len();
        let things = if count == 1 { "1 thing not checked".into() } else { format!("{count} things not checked") };
        assert_eq!(row.contains(&things), count > 0, "{what}: {things} in\n{row}");
        if let Some(stiffness) = c["spring"]["stiffness_nm_per_rad"].as_f64().filter(|k| *k > 0.0) {
            assert!(row.contains(&format!("spring {} N*m/rad", number(stiffness))), "{what}: the spring in\n{row}");
        }
    }
}

fn assert_windows(row: &str, windows: &Value, what: &str) {
    for window in windows.as_array().unwrap() {
        for (end, limit) in [("min", "low"), ("max", "high")] {
            // Rounded inwards: what is printed is feasible.
            let at = |end: &str| window[end].as_f64().unwrap();
            let printed = number_between(at(end), at("min"), at("max"));
            let said = format!(" {printed} ({}", window[limit].as_str().unwrap());
            assert!(row.contains(&said), "{what}: {said} in\n{row}");
        }
    }
}

pub(super) fn tightest(margins: &Value) -> (String, f64) {
    let margins = margins.as_object().unwrap().iter().map(|(limit, m)| (limit.clone(), m.as_f64().unwrap()));
    margins.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

/// The part of a text that is about a joint: from its heading to the next one's, or to the summary.
fn part<'t>(text: &'t str, joint: &str, next: Option<&str>) -> &'t str {
    let heading = |name: &str| format!("\n{name} (×");
    let start = text.find(&heading(joint)).unwrap_or_else(|| panic!("{joint} in\n{text}"));
    let end = next.map_or_else(|| text.find("\nFirst choices"), |next| text.find(&heading(next)));
    &text[start..end.unwrap_or(text.len())]
}

pub(super) const OBJECTIVES: [&str; 7] = [
    "\"loss\"",
    "\"energy\"",
    "\"peak_power\"",
    "\"peak_current\"",
    "\"reflected_inertia\"",
    "\"mass\"",
    "{ loss = 1, mass = 0.5 }\nreference = { loss = \"10 W\", mass = \"1 kg\" }",
];

#[test]
fn every_rank_stands_with_its_own_motor_window_and_notes() {
    let folder = Folder::new();
    let mut files = Vec::new();
    for (k, objective) in OBJECTIVES.iter().enumerate() {
        let change = ("objective = \"loss\"", &*format!("objective = {objective}"));
        // Several joints of several names; wide limits, so that there is something to rank.
        folder.requirement(
            "quadruped_mini_cheetah.toml",
            &format!("legs_{k}.toml"),
            &[change, ("actuator_mass = \"0.55 kg\"\n", ""), ("\"0.01 kg*m^2\"", "\"0.05 kg*m^2\"")],
        );
        files.push(format!("legs_{k}.toml"));
        // Points have no energy per cycle where they have no durations, and no position for a spring.
        folder.requirement(
            "ankle_prosthesis_parallel_spring.toml",
            &format!("spring_{k}.toml"),
            &[change, ("actuator_mass = \"1.6 kg\"\n", "")],
        );
        if !matches!(k, 4 | 5) {
            files.push(format!("spring_{k}.toml"));
        }
    }
    folder.requirement("humanoid_hip_catalog_gears.toml", "gears.toml", &[]);
    files.push("gears.toml".into());
    let mut ranked = 0;
    for file in &files {
        // With a spring two motors with long names, because each takes its time.
        let catalog = if file.starts_with("spring") { "catalog/maxon.csv" } else { "catalog" };
        let words = ["optimize", file, "--catalog", catalog, "--full"];
        let json = folder.json(&words);
        let joints = json["joints"].as_array().unwrap();
        ranked += joints.iter().map(|j| j["candidates"].as_array().unwrap().len().min(5)).sum::<usize>();
        for width in WIDTHS {
            let text = folder.run(&words, width);
            let what = format!("{file} at {width:?}");
            assert_width(&text, width.unwrap_or(120), &what);
            for (k, joint) in joints.iter().enumerate() {
                let next = joints.get(k + 1).map(|j| j["joint"].as_str().unwrap());
                assert_candidates(part(&text, joint["joint"].as_str().unwrap(), next), joint, 5, &what);
            }
        }
    }
    assert!(ranked > 60, "{ranked} ranks were looked at");
}

#[test]
fn a_sweep_and_a_robust_choice_keep_rows_and_reasons_together() {
    let folder = Folder::new();
    folder.requirement("bench/leg_joint.toml", "leg.toml", &[("\"0.36 kg\"", "\"2 kg\"")]);
    let sweep = ["sweep", "leg.toml", "--catalog", "catalog", "--ratios", "4"];
    let swept = folder.json(&sweep);
    let joint = &swept["joints"][0];
    let listed = |list: &str| joint[list].as_array().unwrap().iter();
    // The table has designs that keep the limits, then those that do not.
    let candidates = listed("candidates").map(|d| (d, None));
    let rejected = listed("rejected").filter(|r| r["design"].is_object());
    let designs: Vec<(&Value, Option<&str>)> =
        candidates.chain(rejected.map(|r| (&r["design"], r["because"].as_str()))).collect();
    let robust = ["optimize", "leg.toml", "--robust", "--catalog", "catalog"];
    let chosen = folder.json(&robust);
    let robust_designs: Vec<&Value> = chosen["joints"][0]["candidates"].as_array().unwrap().iter().take(5).collect();
    assert!(robust_designs.iter().any(|d| !d["tolerances"].as_array().unwrap().is_empty()));
    for width in WIDTHS {
        let what = format!("at {width:?}");
        let text = folder.run(&[&sweep[..], &["--infeasible", "--top", "40"]].concat(), width);
        assert_width(&text, width.unwrap_or(120), &what);
        let (_, text) = left_out(&text);
        let key = |d: &Value| vec![("motor", text_of(&d["motor"])), ("N", shown(&d["ratio"]))];
        let keys: Vec<_> = designs.iter().map(|(d, _)| key(d)).collect();
        for (row, (d, because)) in rows_of(&text, &keys, &what).iter().zip(&designs) {
            let said = match because {
                Some(because) => format!("not feasible: {because}"),
                None => {
                    let (limit, margin) = tightest(&d["margins"]);
                    format!(" feasible, tightest margin {limit} {:.0} %", (100.0 * margin).max(0.0))
                }
            };
            assert!(row.contains(collapsed(&said).trim()), "{what}: {said} in\n{row}");
            assert_eq!(row.matches("feasible").count() - row.matches("Infeasible").count(), 1, "{what}: {row}");
        }
        let text = folder.run(&robust, width);
        assert_width(&text, width.unwrap_or(120), &what);
        let (_, text) = left_out(&text);
        let keys: Vec<_> = robust_designs
            .iter()
            .enumerate()
            .map(|(k, d)| vec![("#", (k + 1).to_string()), ("motor", text_of(&d["motor"]))])
            .collect();
        for (row, d) in rows_of(&text, &keys, &what).iter().zip(&robust_designs) {
            assert!(row.contains(&format!(" {} ", ratio_of(d))), "{what}: {row}");
            assert!(row.contains(&format!(" {} ", shown(&d["objective"]))), "{what}: {row}");
            let tolerances = d["tolerances"].as_array().unwrap();
            assert_eq!(row.contains("no tolerances in the catalogue"), tolerances.is_empty(), "{what}: {row}");
            if !tolerances.is_empty() {
                let window = d["window"].as_array().unwrap();
                let low = d["binds"]["low"].as_str().unwrap();
                // Ends of windows are rounded inwards.
                let (_, rest) = row.split_once("feasible at worst from ").unwrap_or_else(|| panic!("{what}: {row}"));
                let (end, by) = rest.split_once(" (").unwrap();
                let (end, low_end) = (end.parse::<f64>().unwrap(), window[0].as_f64().unwrap());
                assert!(by.starts_with(low) && (0.0..1e-3 * low_end).contains(&(end - low_end)), "{what}: {row}");
            }
        }
    }
}

#[test]
fn ranks_fronts_checks_and_whole_robots_are_in_their_order() {
    let folder = Folder::new();
    let budget = "name = \"quadruped_mini_cheetah\"\n[budget]\nactuator_mass = \"9 kg\"\nmax_distinct_motors = 2\npower = \"5 kW\"\n";
    folder.requirement(
        "quadruped_mini_cheetah.toml",
        "robot.toml",
        &[("name = \"quadruped_mini_cheetah\"\n", budget), ("actuator_mass = \"0.55 kg\"\n", "")],
    );
    let optimize = ["optimize", "robot.toml", "--catalog", "catalog"];
    folder.run(&[&optimize[..], &["--write-design", "design.toml"]].concat(), None);
    let best = folder.json(&optimize)["robot"]["choice"]["best"]["joints"].clone();
    let checked = folder.json(&["check", "design.toml"])["joints"].clone();
    let pareto = [&optimize[..], &["--pareto", "loss,mass"]].concat();
    let fronts = folder.json(&pareto)["joints"].clone();
    let ranks = folder.json(&["rank", "catalog", "--tolerance", "5%"])["motors"].clone();
    let all = |v: &Value| v.as_array().unwrap().clone();
    for width in WIDTHS {
        let what = format!("at {width:?}");
        let text = |words: &[&str]| {
            let text = folder.run(words, width);
            assert_width(&text, width.unwrap_or(120), &format!("{words:?} {what}"));
            text
        };
        let robot = text(&optimize);
        let (dropped, whole) = left_out(&robot[robot.find("The whole robot").unwrap()..]);
        let mark = |j: &Value| if all(&j["not_checked"]).is_empty() { "" } else { " *" };
        let key = |j: &Value| {
            let motor = format!("{}{}", j["motor"].as_str().unwrap(), mark(j));
            vec![("joint", text_of(&j["joint"])), ("×", j["count"].to_string()), ("motor", motor), ("N", ratio_of(j))]
        };
        let keys: Vec<_> = all(&best).iter().map(key).collect();
        for (row, j) in rows_of(&whole, &keys, &what).iter().zip(all(&best)) {
            let (limit, margin) = tightest(&j["margins"]);
            let said = format!(" {limit} {:.0} %", (100.0 * margin).max(0.0));
            assert!(row.contains(&said) || dropped.contains(&"tightest margin".into()), "{what}: {said} in\n{row}");
        }
        let (dropped, check) = left_out(&text(&["check", "design.toml"]));
        let key = |j: &Value| match dropped.contains(&"count".into()) {
            true => vec![("joint", text_of(&j["joint"])), ("motor", text_of(&j["motor"]))],
            false => {
                vec![
                    ("joint", text_of(&j["joint"])),
                    ("count", j["count"].to_string()),
                    ("motor", text_of(&j["motor"])),
                ]
            }
        };
        let keys: Vec<_> = all(&checked).iter().map(key).collect();
        for (row, j) in rows_of(&check, &keys, &what).iter().zip(all(&checked)) {
            let (limit, margin) = tightest(&j["design"]["margins"]);
            assert!(row.contains(&format!(" {limit} ")), "{what}: {limit} in\n{row}");
            let percent = number((1000.0 * margin).round() / 10.0);
            assert!(row.contains(&format!(" {percent} % ")), "{what}: {percent} in\n{row}");
        }
        let (_, rank) = left_out(&text(&["rank", "catalog", "--tolerance", "5%"]));
        let key = |m: &Value| vec![("#", m["rank"].to_string()), ("motor", text_of(&m["motor"]))];
        let keys: Vec<_> = all(&ranks).iter().map(key).collect();
        for (row, m) in rows_of(&rank, &keys, &what).iter().zip(all(&ranks)) {
            let value = number(1e3 * m["s_m_s"].as_f64().unwrap());
            assert!(row.contains(&format!(" {value} ±")), "{what}: {value} in\n{row}");
        }
        let front = text(&pareto);
        for joint in all(&fronts) {
            let points = all(&joint["candidates"]);
            let at = front.find(&format!("{}: loss", joint["joint"].as_str().unwrap())).unwrap();
            let (_, front) = left_out(&front[at..]);
            // Rounded to lie between the ratios of its motor.
            let ratio = |p: &Value| {
                let same = points.iter().filter(|o| o["motor"] == p["motor"]).map(|o| o["ratio"].as_f64().unwrap());
                let ratios: Vec<f64> = same.collect();
                let ends = [f64::min, f64::max].map(|f| ratios.iter().copied().reduce(f).unwrap());
                match ends[0] == ends[1] {
                    true => shown(&p["ratio"]),
                    false => number_between(p["ratio"].as_f64().unwrap(), ends[0], ends[1]),
                }
            };
            let key =
                |p: &Value| vec![("motor", text_of(&p["motor"])), ("N", ratio(p)), ("loss", shown(&p["values"][0]))];
            starts(&front, &[key(points.first().unwrap()), key(points.last().unwrap())][..points.len().min(2)], &what);
        }
    }
}

/// How often each word stands in a text, brackets of units taken away, without what is said of left-out columns.
fn counts(text: &str) -> HashMap<String, usize> {
    let mut counts = HashMap::new();
    for word in left_out(text).1.split_whitespace() {
        *counts.entry(word.trim_matches(['[', ']']).to_string()).or_default() += 1;
    }
    counts
}

/// A folded number or name leaves pieces that no wide text has, and takes away what the wide text has.
pub(super) fn assert_nothing_folded(folder: &Path, words: &[&str]) {
    let wide = counts(&run(folder, words, Some(1000)));
    for width in WIDTHS {
        let what = format!("{words:?} at {width:?}");
        let text = run(folder, words, width);
        assert_width(&text, width.unwrap_or(120), &what);
        let narrow = counts(&text);
        for word in narrow.keys() {
            assert!(wide.contains_key(word), "{what}: `{word}` is a piece of something:\n{text}");
        }
        if left_out(&text).0.is_empty() {
            for (word, count) in wide.iter().filter(|(word, _)| !word.is_empty()) {
                assert!(
                    narrow.get(word).is_some_and(|n| n >= count),
                    "{what}: `{word}` is not there {count} times:\n{text}"
                );
            }
        }
    }
}

#[test]
fn no_command_folds_a_number_or_a_name() {
    let folder = Folder::new();
    folder.requirement("bench/leg_joint.toml", "leg.toml", &[("\"0.36 kg\"", "\"2 kg\"")]);
    folder.requirement("exoskeleton_hip.toml", "hip.toml", &[]);
    folder.requirement("humanoid_hip_catalog_gears.toml", "gears.toml", &[]);
    let shipped = |path: &str| repository(path).display().to_string();
    let design = shipped("requirements/designs/arm_six_axis_pick_and_place/design.toml");
    let (urdf, path) = (shipped("requirements/robots/ur5e.urdf"), shipped("requirements/robots/ur5e_pick.csv"));
    let bench = shipped("requirements/bench/motor_on_bench.toml");
    let long = "maxon-ec-frameless-ht-60-m-936176";
    let catalog = ["--catalog", "catalog"];
    let of_catalog: [&[&str]; 9] = [
        &["optimize", "hip.toml", "--rejected", "--robot"],
        &["optimize", "hip.toml", "--only-top", "1"],
        &["optimize", "gears.toml", "--pareto", "loss,mass"],
        &["optimize", "gears.toml", "--robust"],
        &["sweep", "gears.toml", "--sort", "s_t"],
        &["explain", "t-motor-ri50", "leg.toml"],
        &["explain", long, "hip.toml"],
        &["explain", "allied-mf0127020-48v@3", "leg.toml"],
        &["compare", long, "maxon-ec-frameless-ht-90-m-937612"],
    ];
    for words in of_catalog {
        assert_nothing_folded(folder.0.path(), &[words, &catalog].concat());
    }
    let others: [&[&str]; 15] = [
        &["rank", "catalog"],
        &["rank", "catalog", "--tolerance", "5%", "--sort", "mass_s_t"],
        &["rank", "catalog", "--sort", "k_m"],
        &["audit"],
        &["catalog", "list", "--catalog", "catalog"],
        &["catalog", "search", "maxon"],
        &["catalog", "show", "t-motor-u8"],
        &["catalog", "diff", "builtin", "catalog"],
        &["catalog", "path"],
        &["rule"],
        &["rule", "GW106"],
        &["rule", "--measures"],
        &["check", &design],
        &["torques", &urdf, &path],
        &["characterize", &bench],
    ];
    for words in others {
        assert_nothing_folded(folder.0.path(), words);
    }
}

#[test]
fn no_identification_and_no_study_folds_a_number_or_a_name() {
    let folder = Folder::new();
    folder.requirement("bench/leg_joint.toml", "leg.toml", &[("\"0.36 kg\"", "\"2 kg\"")]);
    let bench = repository("requirements/bench/leg_actuator.toml").display().to_string();
    assert_nothing_folded(folder.0.path(), &["identify", &bench, "--requirement", "leg.toml"]);
    let study =
        "requirement = \"leg.toml\"\n[grid]\n\"bus.voltage\" = [\"24 V\", \"48 V\"]\n\"scale.torque\" = [1, 1.25]\n";
    folder.write("study.toml", study);
    assert_nothing_folded(
        folder.0.path(),
        &["study", "study.toml", "--out", "result", "--force", "--catalog", "catalog"],
    );
}
