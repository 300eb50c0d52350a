//! Pages of docs/ that are made from the program: the committed ones are those that it makes, and what they say
//! of files is what the readers know.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use gearwise::input::TableAsked;
use gearwise::pages::formats::{BENCH, DESIGN, FAMILY, FITTED, HARDWARE, REQUIREMENT, RULES, STUDY, formats};

use crate::common::repository;

#[test]
fn the_committed_pages_are_what_the_program_makes() {
    let pages = gearwise::cli::pages();
    assert!(pages.len() >= 6);
    for (name, text) in pages {
        let committed = std::fs::read_to_string(repository("docs").join(name)).unwrap_or_default();
        assert!(committed == text, "docs/{name} is not what `cargo run -- docs --out docs` writes");
        assert!(!text.contains("\\["), "{name}: a documentation comment's brackets");
        for line in text.lines().filter(|l| l.starts_with("| ")) {
            assert!(!line.contains("|  |  |  |"), "{name}: an empty row: {line}");
        }
    }
}

/// The table of formats on the page that people read is that of the page that is made.
#[test]
fn the_table_of_simulator_formats_is_that_of_the_program() {
    let page = |name: &str| std::fs::read_to_string(repository("docs").join(name)).unwrap();
    let (made, read) = (page("simulator-formats.md"), page("simulators.md"));
    let table = &made[made.find("|  | mjcf").unwrap()..made.find("\nEvery line of torque").unwrap()];
    let shown = read.split("<!-- formats -->\n").nth(1).and_then(|rest| rest.split("<!-- end of formats -->").next());
    assert_eq!(shown, Some(table));
    assert_eq!(table.lines().count(), 21);
}

/// Every link of README, docs/ and the pages beside README leads to a file, and to a heading where it names one.
#[test]
fn links_between_pages_lead_somewhere() {
    let pages = |folder: &str| {
        let entries = std::fs::read_dir(repository(folder)).unwrap().map(|e| e.unwrap().path());
        entries.filter(|p| p.extension().is_some_and(|e| e == "md")).collect::<Vec<_>>()
    };
    let slug = |heading: &str| {
        let kept = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.collect::<String>().replace(' ', "-")
    };
    for path in pages("").into_iter().chain(pages("docs")) {
        let text = std::fs::read_to_string(&path).unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            if file.starts_with("http") {
                continue;
            }
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: {link}", path.display());
            let found = anchor.is_empty() || {
                let target = std::fs::read_to_string(&target).unwrap();
                target.lines().filter(|l| l.starts_with('#')).any(|l| slug(l) == anchor)
            };
            assert!(found, "{}: {link}", path.display());
        }
    }
}

/// Keys that the reader says are valid, by table: asked with a key that nobody knows.
fn known(text: &str, arguments: &[&str]) -> Vec<(String, BTreeSet<String>)> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file.toml"), text).unwrap();
    std::fs::write(folder.path().join("x.csv"), "t,a\n0,1\n").unwrap();
    std::fs::copy(repository("requirements/exoskeleton_hip.toml"), folder.path().join("robot.toml")).unwrap();
    std::fs::create_dir(folder.path().join("motions")).unwrap();
    for entry in std::fs::read_dir(repository("requirements/motions")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join("motions").join(path.file_name().unwrap())).unwrap();
    }
    let output =
        Command::new(env!("CARGO_BIN_EXE_gearwise")).args(arguments).current_dir(folder.path()).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    let mut found = Vec::new();
    for part in message.split("error: ").filter(|p| p.starts_with("unknown key")) {
        let line = part.lines().next().unwrap();
        let path = line.split(" in ").nth(1).unwrap_or("").to_string();
        let valid = part.split("valid here: ").nth(1).unwrap_or_else(|| panic!("{part}"));
        let keys = valid.lines().next().unwrap().split(", ").map(str::to_string).collect();
        found.push((path, keys));
    }
    assert!(!found.is_empty(), "{message}");
    found
}

/// The tables that the page has of a kind of file are those that the reader knows, key by key. What a reader asks for may
/// depend on what a file has: `known` is of several files, which together have everything.
fn compare(title: &str, known: &[Vec<(String, BTreeSet<String>)>]) {
    let format = formats().into_iter().find(|f| f.title == title).unwrap();
    let mut read: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (path, keys) in known.iter().flatten() {
        read.entry(path).or_default().extend(keys.iter().map(String::as_str));
    }
    let keys = |t: &TableAsked| t.keys.iter().map(|key| key.name).collect::<BTreeSet<_>>();
    let documented: BTreeMap<&str, BTreeSet<&str>> = format.tables.iter().map(|t| (t.path.as_str(), keys(t))).collect();
    assert_eq!(documented, read, "{title}: documented on the left, read on the right");
}

/// Whoever asks for a key says what it is and what may stand there.
#[test]
fn every_key_says_what_it_is() {
    for format in formats() {
        for table in &format.tables {
            assert!(!table.keys.is_empty(), "{}: {} has no keys", format.title, table.path);
            for key in &table.keys {
                let place = format!("{}: `{}` of {}", format.title, key.name, table.path);
                assert!(!key.value.is_empty(), "{place} does not say what may stand there");
                assert!(!key.about.is_empty(), "{place} does not say what it is");
            }
        }
    }
}

const NO: &str = "qqqqqqqqqqqqqqqqqq = 1";

#[test]
fn requirements_are_documented() {
    let ask = |text: &str| known(text, &["optimize", "file.toml"]);
    let ratio = format!(
        "{NO}\nname = \"x\"\nbus = {{ voltage = \"1 V\", {NO} }}\n[ambient]\n{NO}\n[budget]\n{NO}\n[prices]\ncurrency = \"EUR\"\ndate = \"2026-11-01\"\n{NO}\n\
         [mechanism]\nmodel = \"a.urdf\"\ntrajectory = \"x.csv\"\npayload = {{ link = \"a\", mass = \"1 kg\", {NO} }}\n{NO}\n[[joint]]\n{NO}\nname = \"a\"\n\
         ratio = {{ min = 1, max = 2, {NO} }}\ngear = {{ {NO} }}\ndrive = {{ current = \"1 A\", {NO} }}\nobjective = {{ {NO} }}\n\
         reference = {{ {NO} }}\nscale = {{ {NO} }}\npoints = [ {{ torque = \"1 N*m\", speed = \"0 rad/s\", {NO} }} ]\n[joint.limits]\n{NO}\n\
         torque_bandwidth = {{ frequency = \"1 Hz\", amplitude = \"1 N*m\", {NO} }}\nspring = {{ {NO} }}\nreserve = {{ {NO} }}\n[joint.mount]\nthermal_resistance_housing_ambient = \"1 K/W\"\n{NO}\n\
         [joint.transmission]\n{NO}\nfour_bar = {{ {NO} }}\nlever = {{ {NO} }}\n[[coupling]]\n{NO}\nrods = [{{ {NO} }}]\n"
    );
    let joint =
        |lines: &str| format!("name = \"x\"\nbus = {{ voltage = \"1 V\" }}\n[[joint]]\nname = \"a\"\n{NO}\n{lines}\n");
    let teeth = joint(&format!(
        "ratio = {{ stages = [[3, 9]], teeth = {{ sun = [18, 20], ring_max = 90, {NO} }} }}\nmotion = \"x.csv\""
    ));
    let gears = joint("gears = [\"planetary-*\"]\nmotion = \"x.csv\"");
    let family = joint("family = [\"compact-*\"]\nmotion = \"x.csv\"");
    let driven = joint(&format!(
        "ratio = {{ min = 1, max = 2 }}\nmechanism_joint = \"b\"\nactuator_at = {{ {NO} }}\n[mechanism]\nmodel = \"a.urdf\"\n\
         trajectory = \"x.csv\""
    ));
    let case = |lines: &str| joint(&format!("ratio = {{ min = 1, max = 2 }}\n{lines}"));
    let cases = case(&format!(
        "order = [{{ case = \"a\", count = 1, {NO} }}]\n[[joint.case]]\nname = \"a\"\npoints = [{{ torque = \"1 N*m\", speed = \"0 rad/s\", duration = \"1 s\" }}]\n{NO}"
    ));
    let together = format!(
        "name = \"x\"\nbus = {{ voltage = \"1 V\" }}\n[[joint]]\nname = \"a\"\nratio = {{ min = 1, max = 2 }}\n\
         points = [{{ torque = \"1 N*m\", speed = \"0 rad/s\" }}]\n[[case]]\nname = \"a\"\n{NO}\n"
    );
    compare(
        REQUIREMENT,
        &[ask(&ratio), ask(&gears), ask(&family), ask(&driven), ask(&cases), ask(&together), ask(&teeth)],
    );
}

#[test]
fn fitted_actuators_are_documented() {
    let ask = |text: &str| known(text, &["rank", "file.toml"]);
    let row = format!(
        "{NO}\ngearwise = \"0\"\n[motor]\nid = \"m\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\nresistance = \"1 ohm\"\n\
         torque_constant = \"1 N*m/A\"\n[gear]\n{NO}\n[covariance]\n{NO}\n[[provenance]]\nlog = \"x\"\n{NO}\n"
    );
    compare(FITTED, &[ask(&row), ask(&format!("gearwise = \"0\"\n[axis]\n{NO}\n"))]);
}

#[test]
fn gear_families_are_documented() {
    let text = format!(
        "{NO}\nname = \"a\"\nkind = \"planetary\"\nsource = \"x\"\nsource_kind = \"derived\"\n[[point]]\nratio = 4\n"
    );
    compare(FAMILY, &[known(&text, &["audit", "file.toml"])]);
}

#[test]
fn designs_are_documented() {
    let text = format!(
        "{NO}\nrequirement = \"robot.toml\"\n[[joint]]\nname = \"hip\"\nmotor = \"t-motor-ri50\"\nratio = 9.0\n{NO}\nspring = {{ {NO} }}\n"
    );
    compare(DESIGN, &[known(&text, &["check", "file.toml"])]);
}

#[test]
fn rules_files_are_documented() {
    let text = format!(
        "{NO}\n[[rule]]\nname = \"own\"\nmeasure = \"loss\"\nmax = \"1 W\"\nreason = \"x\"\n{NO}\n\
         [[allow]]\nrule = \"voltage-headroom\"\nreason = \"x\"\n{NO}\n"
    );
    let design = repository("requirements/designs/quadruped_mini_cheetah/design.toml");
    compare(RULES, &[known(&text, &["check", design.to_str().unwrap(), "--rules", "file.toml"])]);
}

#[test]
fn files_of_hardware_are_documented() {
    let text = format!(
        "{NO}\n[[joint]]\nnames = [\"a\"]\nmodule = \"robstride-rs04\"\n{NO}\ntransmission = {{ four_bar = {{ {NO} }}, lever = {{ {NO} }}, {NO} }}\n\
         [[coupling]]\njoints = [\"a\", \"b\"]\nmatrix = [[1, 0], [0, 1]]\n{NO}\n[limits]\n{NO}\n"
    );
    compare(HARDWARE, &[known(&text, &["check-model", "a.urdf", "--against", "file.toml"])]);
}

/// The keys of a grid are the user's own: its table is not listed.
#[test]
fn studies_are_documented() {
    let text = format!("{NO}\nrequirement = \"robot.toml\"\n");
    compare(STUDY, &[known(&text, &["study", "file.toml", "--out", "out"])]);
}

#[test]
fn benches_are_documented() {
    let ask = |text: &str| known(text, &["identify", "file.toml"]);
    let log = |more: &str| format!("[[log]]\nfile = \"x.csv\"\n{more}\n");
    let rotary = format!(
        "{NO}\nkind = \"dynamometer\"\nactuator = {{ motor = \"t-motor-ri50\", ratio = 7.5, {NO} }}\n[columns]\n{NO}\n\
         time = {{ name = \"t\", unit = \"s\", {NO} }}\nvelocity = {{ name = \"w\", unit = \"rpm\", {NO} }}\n\
         position = {{ name = \"p\", unit = \"rad\", {NO} }}\n\
         duty = {{ name = \"d\", {NO} }}\ncurrent = {{ name = \"a\", unit = \"A\", {NO} }}\n[load]\n{NO}\n[terminals]\n{NO}\n\
         [rotor]\nmass = \"1 kg\"\nradius = \"1 m\"\n{NO}\n{}",
        log(NO)
    );
    let pendulum = format!(
        "kind = \"dynamometer\"\nactuator = {{ motor = \"t-motor-ri50\", ratio = 7.5 }}\ncontroller = {{ gain = 1, {NO} }}\n\
         [pendulum]\nmass = \"1 kg\"\nlength = \"1 m\"\n{NO}\n{}",
        log(&format!("select = {{ column = \"t\", equals = \"0\", {NO} }}\nexclude = {{ from = \"1 s\", {NO} }}"))
    );
    let linear = format!("kind = \"linear\"\nactuator = {{ mass = \"1 kg\", {NO} }}\n{}", log(""));
    let robot = format!(
        "kind = \"free\"\n[mechanism]\nmodel = \"arm.urdf\"\n{NO}\npayload = {{ link = \"a\", mass = \"1 kg\", {NO} }}\n\
         [[joint]]\nmechanism_joint = \"b\"\n{NO}\n{}",
        log(&format!("payload = {{ link = \"a\", mass = \"1 kg\" }}\n{NO}"))
    );
    compare(BENCH, &[ask(&rotary), ask(&pendulum), ask(&linear), ask(&robot)]);
}
