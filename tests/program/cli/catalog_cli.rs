//! `gearwise catalog`: every sub-command, its wrong inputs, and what it must not say.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use gearwise::catalog::Catalog;
use serde_json::Value;

const MINE: &str = "id,manufacturer,construction,terminals,current,resistance [ohm],inductance [uH],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],continuous_current [A],source,source_kind\n\
mine-1,My Lab,outrunner,line_to_line,phase_amplitude,0.2,100,0.1,800,300,8,bench,measured\n";

/// A motor of which nothing says its heat, and no law can: it does not say how it is built.
const COLD: &str = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind\ncold,q_axis,q_axis,0.2,0.1,bench,measured\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    fn at(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.at().join(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.at().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The program in the folder, with the user's own catalogue in `own`.
    fn run(&self, words: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
        command.env_remove("COLUMNS").env("GEARWISE_CATALOG", self.at().join("own"));
        command.args(words).current_dir(self.at()).output().unwrap()
    }

    fn catalog(&self, words: &[&str]) -> Output {
        self.run(&[&["catalog"], words].concat())
    }

    /// What a command says that does its work.
    fn good(&self, words: &[&str]) -> String {
        let output = self.catalog(words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", said(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The one message of a command whose input is wrong; nothing is printed beside it.
    fn wrong(&self, words: &[&str]) -> String {
        let output = self.catalog(words);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{words:?}: {}", said(&output));
        said(&output)
    }

    fn json(&self, words: &[&str]) -> Value {
        let output = self.catalog(&[words, &["--json"]].concat());
        serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{words:?}: {e}: {}", said(&output)))
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn ids(rows: &Value) -> Vec<String> {
    rows.as_array().unwrap().iter().map(|r| r["id"].as_str().unwrap().to_string()).collect()
}

#[test]
fn list_keeps_what_filters_ask_and_counts_what_is_not_known() {
    let folder = Folder::new();
    let builtin = Catalog::builtin().unwrap();
    let all = folder.json(&["list"]);
    assert_eq!(ids(&all["motors"]).len(), builtin.motors.len());
    assert_eq!(ids(&all["gears"]).len(), builtin.gears.len());
    let light = folder.json(&["list", "motors", "mass<0.5kg", "maker=maxon"]);
    let expected: Vec<String> = builtin
        .motors
        .iter()
        .filter(|m| m.mass.is_some_and(|mass| mass < 0.5) && m.manufacturer.eq_ignore_ascii_case("maxon"))
        .map(|m| m.id.clone())
        .collect();
    assert!(expected.len() > 5);
    assert_eq!(ids(&light["motors"]), expected);
    // What nobody knows is neither light nor heavy: it is counted, and not listed.
    let unknown = builtin.motors.iter().filter(|m| m.mass.is_none()).count();
    assert!(unknown > 0);
    for filter in ["mass<0.5kg", "mass>=0.5kg", "mass!=1kg"] {
        let found = folder.json(&["list", "motors", filter]);
        assert_eq!(found["unknown_rows"], unknown, "{filter}");
        assert!(ids(&found["motors"]).iter().all(|id| builtin.motor(id).unwrap().mass.is_some()), "{filter}");
        let text = flat(&folder.good(&["list", "motors", filter]));
        assert!(text.contains(&format!("Not listed, because a number is not known: {unknown} rows")), "{text}");
    }
    // Where every row knows it, nothing is said of unknown ones.
    assert!(!folder.good(&["list", "gears", "ratio>=5"]).contains("not known"));
    let gears = folder.json(&["list", "kind=planetary", "ratio>=60"]);
    let expected = builtin.gears.iter().filter(|g| g.kind == gearwise::catalog::GearKind::Planetary && g.ratio >= 60.0);
    assert_eq!((ids(&gears["gears"]).len(), ids(&gears["motors"]).len()), (expected.count(), 0));
    // Patterns, aliases, capitals, and units of any kind.
    assert_eq!(
        ids(&folder.json(&["list", "motors", "id=maxon-*", "diameter<=9 cm"])["motors"]),
        ids(&folder.json(&["list", "motors", "id=maxon-*", "outer_diameter<=90mm"])["motors"])
    );
}

#[test]
fn a_wrong_filter_is_one_clear_error() {
    let folder = Folder::new();
    for (filters, expected) in [
        (vec!["mas<1kg"], "there is no column `mas`; did you mean `mass`?"),
        (vec!["mass<1 s"], "`s` is not a unit of mass"),
        (vec!["mass<1"], "a mass needs its unit"),
        (vec!["mass<light"], "`mass<light`"),
        (vec!["kind=planetari"], "did you mean `planetary`?"),
        (vec!["maker<3"], "which is compared by = or != only"),
        (vec!["robot"], "it has no comparison"),
        (vec!["mass<"], "there is no value after `<`"),
        (vec!["KV>100rpm/V"], "line_to_line_peak or dc"),
        (vec!["Kt>0.1N*m/A rms dc"], "two conventions are stated"),
        (vec!["motors", "ratio>5"], "motors have no column `ratio`"),
        (vec!["ratio>5", "construction=outrunner"], "no row keeps all"),
    ] {
        let said = folder.wrong(&[&["list"], filters.as_slice()].concat());
        assert!(said.contains(expected) && said.matches("error").count() == 1, "{filters:?}: {said}");
    }
    // A maker that no row has is no mistake; near names are named.
    let text = folder.good(&["list", "maker=maxxon"]);
    assert!(text.contains("Did you mean `maxon`?"), "{text}");
    assert!(folder.wrong(&["list", "--csv"]).contains("add `motors`, `gears` or `modules`"));
}

#[test]
fn a_list_as_csv_is_a_catalogue_that_is_the_same() {
    let folder = Folder::new();
    for kind in ["motors", "gears", "modules"] {
        folder.write(&format!("{kind}.csv"), &folder.good(&["list", kind, "--csv"]));
    }
    fs::create_dir(folder.at().join("all")).unwrap();
    for kind in ["motors", "gears", "modules"] {
        fs::rename(folder.at().join(format!("{kind}.csv")), folder.at().join(format!("all/{kind}.csv"))).unwrap();
    }
    // Families are no tables: without their files their points are missing.
    let text = String::from_utf8(folder.catalog(&["diff", "builtin", "all"]).stdout).unwrap();
    assert!(text.contains("0 added, 22 removed, 0 changed"), "{text}");
    fs::create_dir(folder.at().join("all/gear_families")).unwrap();
    for file in fs::read_dir(crate::common::repository("catalogs/gear_families")).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), folder.at().join("all/gear_families").join(file.file_name())).unwrap();
    }
    let text = folder.good(&["diff", "builtin", "all"]);
    assert_eq!(text, "No difference.\n");
}

#[test]
fn search_finds_parts_of_names_and_names_what_is_near() {
    let folder = Folder::new();
    let found = ids(&folder.json(&["search", "RoboDrive", "85"])["motors"]);
    assert!(
        found.len() >= 2
            && found.iter().all(|id| ["robodrive-ilm-85", "robodrive-ilm-e85"].iter().any(|part| id.contains(part))),
        "{found:?}"
    );
    let output = folder.catalog(&["search", "ec-fremless"]);
    assert_eq!(output.status.code(), Some(1));
    let none = folder.catalog(&["search", "xyzzyxyzzy"]);
    assert_eq!(none.status.code(), Some(1));
    assert!(!String::from_utf8_lossy(&none.stdout).contains("Did you mean"));
    let near = folder.catalog(&["search", "maxxon"]);
    assert!(String::from_utf8_lossy(&near.stdout).contains("Did you mean `maxon`"));
    assert!(folder.wrong(&["search", "--", "--"]).contains("letters or digits"));
}

#[test]
fn show_says_what_a_row_lacks_and_never_that_its_heat_is_judged_where_it_is_not() {
    let folder = Folder::new();
    folder.write("cold.csv", COLD);
    let cold = flat(&folder.good(&["show", "cold", "--catalog", "cold.csv"]));
    assert!(
        cold.contains("Heat cannot be judged") && !cold.contains("is judged") && !cold.contains("estimated:"),
        "{cold}"
    );
    assert!(cold.contains("mass: a limit on mass cannot be judged"), "{cold}");
    assert_eq!(folder.json(&["show", "cold", "--catalog", "cold.csv"])["heat"], "unknown");
    // An estimate says that it is one, with its law; a known heat does not.
    let estimated = flat(&folder.good(&["show", "t-motor-u8"]));
    assert!(estimated.contains("Heat is judged by the estimate") && estimated.contains("pessimistic end of 90 %"));
    assert!(estimated.contains("R_th = ") && estimated.contains("the same motor: t-motor-u8-lee"), "{estimated}");
    let known = flat(&folder.good(&["show", "maxon-re-40-148877"]));
    assert!(known.contains("Heat is judged by the row's continuous current") && !known.contains("heat: estimated"));
    // Inside a module: no free choice, and nothing is estimated.
    let builtin = Catalog::builtin().unwrap();
    let inside = builtin.motors.iter().find(|m| !m.about.only_inside.is_empty()).unwrap();
    assert!(flat(&folder.good(&["show", &inside.id])).contains("it is no free choice"));
    // Numbers in every convention are those of the q axis.
    let card = folder.json(&["show", "t-motor-u8"]);
    let value = |column: &str, convention: &str| {
        let all = card["conventions"].as_array().unwrap();
        let one = all.iter().find(|c| c["column"] == column && c["convention"] == convention);
        one.unwrap_or_else(|| panic!("{column} {convention}"))["value"].as_f64().unwrap()
    };
    let (rms, amplitude) = (value("torque_constant", "rms"), value("torque_constant", "phase_amplitude"));
    assert!(
        (rms / amplitude - 2.0_f64.sqrt()).abs() < 1e-12 && (value("torque_constant", "q_axis") - 0.14).abs() < 1e-12
    );
    assert!((value("resistance", "line_to_line") / value("resistance", "q_axis") - 2.0).abs() < 1e-12);
    // Friction as a phase amplitude: K_T = 8.27/Kv.
    let kv = value("speed_constant", "line_to_line_peak") * 60.0 / std::f64::consts::TAU;
    assert!((amplitude * kv - 8.27).abs() < 0.01);
    assert!(folder.wrong(&["show", "robodrive-ilm-85"]).contains("did you mean `tq-robodrive-ilm-85"));
    assert!(
        folder
            .good(&["show", "planetary-maxon-gp52c-66-223091"])
            .contains("max_input_speed: its input speed is not checked")
    );
}

#[test]
fn every_template_is_read_by_its_own_reader_and_works_as_it_stands() {
    let folder = Folder::new();
    for kind in ["requirement", "rules", "design", "bench"] {
        assert_eq!(folder.good(&["new", kind, "--write", &format!("{kind}.toml")]).trim(), format!("{kind}.toml"));
    }
    for kind in ["motor", "gear"] {
        folder.good(&["new", kind, "--write", &format!("{kind}.csv")]);
        let audit = folder.run(&["audit", &format!("{kind}.csv")]);
        assert_eq!(audit.status.code(), Some(0), "{}", said(&audit));
        assert!(String::from_utf8_lossy(&audit.stdout).contains("0 errors"));
    }
    let works = |words: &[&str]| {
        let output = folder.run(words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", said(&output));
    };
    works(&["optimize", "requirement.toml"]);
    works(&["optimize", "requirement.toml", "--rules", "rules.toml", "--write-design", "chosen.toml"]);
    works(&["check", "chosen.toml"]);
    works(&["check", "design.toml"]);
    works(&["check", "design.toml", "--rules", "rules.toml"]);
    works(&["characterize", "bench.toml"]);
    // Readings alone make no row, which the template says.
    let output = folder.run(&["characterize", "bench.toml", "--write", "row.csv"]);
    assert!(said(&output).contains("it needs torque_constant") && folder.read("bench.toml").contains("no row without"));
    works(&["optimize", "requirement.toml", "--also", "motor.csv"]);
    // No template says a key that its reader does not know; no file is replaced.
    let before = folder.read("rules.toml");
    assert!(folder.wrong(&["new", "design", "--write", "rules.toml"]).contains("is not replaced"));
    assert_eq!(folder.read("rules.toml"), before);
    assert!(folder.wrong(&["new", "rules", "--write", "no/such/rules.toml"]).contains("there is no folder"));
}

#[test]
fn a_row_of_flags_is_what_they_say_or_nothing() {
    let folder = Folder::new();
    let good = [
        "id=second",
        "terminals=line_to_line",
        "current=phase_amplitude",
        "R=186 mohm",
        "KV=100 rpm/V line_to_line_peak",
        "J=1200 g*cm^2",
        "mass=0.3 kg",
        "mass_tolerance=2 %",
        "pole_pairs=21",
        "source=a sheet, 2024",
        "source_kind=datasheet",
    ];
    let flags = |set: &[&str]| -> Vec<String> {
        ["new", "motor"]
            .iter()
            .map(|s| (*s).to_string())
            .chain(set.iter().flat_map(|s| ["--set".to_string(), (*s).to_string()]))
            .collect()
    };
    let run = |set: &[&str]| {
        let words = flags(set);
        folder.catalog(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let output = run(&good);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    folder.write("second.csv", &String::from_utf8(output.stdout).unwrap());
    let catalog = Catalog::read(&[folder.at().join("second.csv")]).unwrap();
    let motor = &catalog.motors[0];
    assert_eq!((motor.id.as_str(), motor.pole_pairs, motor.source.as_str()), ("second", Some(21), "a sheet, 2024"));
    assert!(
        (motor.resistance - 0.093).abs() < 1e-12
            && (motor.sheet.mass.unwrap().tolerance.unwrap() - 0.006).abs() < 1e-12
    );
    // 60/(2π · 100) V s/rad peak, line to line; by √2 on the q axis.
    assert!((motor.back_emf_constant - 60.0 / std::f64::consts::TAU / 100.0 / 2.0_f64.sqrt()).abs() < 1e-12);
    // Nothing is assumed for what is left out, and an alias hides no convention.
    for (left_out, expected) in [
        ("terminals=line_to_line", "`terminals` is missing"),
        ("current=phase_amplitude", "`current` is missing"),
        ("source=a sheet, 2024", "`source` is missing"),
        ("KV=100 rpm/V line_to_line_peak", "no torque constant"),
    ] {
        let set: Vec<&str> = good.iter().copied().filter(|s| *s != left_out).collect();
        let output = run(&set);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
        assert!(said(&output).contains(expected), "{left_out}: {}", said(&output));
    }
    for (instead, expected) in [
        ("KV=100 rpm/V", "`speed_constant` is given without `speed_constant_convention`"),
        ("KV=100", "needs its unit"),
        ("KV=100 kg", "is not a unit"),
    ] {
        let set: Vec<&str> = good.iter().copied().map(|s| if s.starts_with("KV") { instead } else { s }).collect();
        assert!(said(&run(&set)).contains(expected), "{instead}: {}", said(&run(&set)));
    }
    assert!(said(&run(&["colour=red"])).contains("there is no column `colour`"));
    assert!(said(&run(&["mas=1 kg"])).contains("did you mean `mass`?"));
    assert!(said(&run(&["mass="])).contains("it has no value"));
    assert!(said(&run(&["mass"])).contains("write it like mass=240g"));
    assert!(folder.wrong(&["new", "rules", "--set", "a=b"]).contains("makes a row of a motor, a gear or a module"));
}

#[test]
fn aliases_are_names_and_hide_nothing() {
    let folder = Folder::new();
    let full = "id,manufacturer,terminals,current,resistance [ohm],torque_constant [N*m/A rms],torque_constant_tolerance [%],rotor_inertia [g*cm^2],mass [g],source,source_kind\n";
    let short = "name,maker,terminals,current,R [ohm],Kt [N*m/A rms],Kt_tolerance [%],J [g*cm^2],weight [g],source,source_kind\n";
    let row = "m,me,line_to_line,rms,0.2,0.1,3,100,200,bench,measured\n";
    folder.write("full.csv", &format!("{full}{row}"));
    folder.write("short.csv", &format!("{short}{row}"));
    folder.write(
        "short.toml",
        "[[motor]]\nname = \"m\"\nmaker = \"me\"\nterminals = \"line_to_line\"\ncurrent = \"rms\"\nR = \"0.2 ohm\"\nKt = \"0.1 N*m/A rms\"\n\
         Kt_tolerance = \"3 %\"\nJ = \"100 g*cm^2\"\nweight = \"200 g\"\nsource = \"bench\"\nsource_kind = \"measured\"\n",
    );
    for other in ["short.csv", "short.toml"] {
        assert_eq!(folder.good(&["diff", "full.csv", other]), "No difference.\n", "{other}");
    }
    // Under two names it is a mistake, whichever comes first, even where both say the same.
    for (from, to) in [("R [ohm]", "R [ohm],resistance [ohm]"), ("R [ohm]", "resistance [ohm],R [ohm]")] {
        folder.write("twice.csv", &format!("{}{}", short.replace(from, to), row.replace(",0.2,", ",0.2,0.2,")));
        let said = folder.wrong(&["list", "--catalog", "twice.csv"]);
        assert!(said.contains("are the same column, `resistance`"), "{said}");
    }
    let text = folder.read("short.toml");
    folder.write("twice.toml", &format!("{text}torque_constant = \"0.1 N*m/A\"\n"));
    assert!(folder.wrong(&["list", "--catalog", "twice.toml"]).contains("are the same column, `torque_constant`"));
    // A convention still has to be stated.
    folder.write("blank.csv", &format!("{short}{}", row.replace(",rms,", ",,")));
    assert!(folder.wrong(&["list", "--catalog", "blank.csv"]).contains("`current` is blank"));
}

#[test]
fn add_puts_rows_behind_what_is_there_whole_or_not_at_all() {
    let folder = Folder::new();
    folder.write("mine.csv", MINE);
    // Into one's own catalogue, which is made.
    assert!(flat(&folder.good(&["add", "mine.csv"])).contains("1 row added: mine-1"));
    assert!(folder.good(&["path"]).contains("1 motor, 0 gears and 0 modules"));
    assert_eq!(ids(&folder.json(&["list", "--catalog", "user"])["motors"]), ["mine-1"]);
    let own = folder.read("own/motors/mine.csv");
    // An id that is there is refused, and nothing changes, even where another row is new.
    let both =
        format!("{MINE}mine-2,My Lab,outrunner,line_to_line,phase_amplitude,0.2,100,0.1,800,300,8,bench,measured\n");
    folder.write("both.csv", &both);
    assert!(folder.wrong(&["add", "both.csv"]).contains("the id `mine-1` is already in"));
    assert_eq!(folder.read("own/motors/mine.csv"), own);
    // Comments, units and order of a file stay; cells are converted to its units, other columns come at its end.
    folder.write("kept.csv", &format!("# my file\n{MINE}\n# the end\n"));
    folder.write(
        "new.csv",
        "id,terminals,current,R [mohm],L [mH],Kt [mN*m/A],Kt_tolerance [%],mass [kg],J [kg*m^2],source,source_kind,note\n\
         new-1,winding,rms,93,0.07,120,2,0.25,7e-5,bench,measured,\"wye, by hand\"\n",
    );
    let refused = folder.wrong(&["add", "new.csv", "--to", "kept.csv"]);
    assert!(refused.contains("`winding` does not say wye or delta"), "{refused}");
    folder.write("new.csv", &folder.read("new.csv").replace(",winding,", ",line_to_line,"));
    let before = folder.read("kept.csv");
    folder.good(&["add", "new.csv", "--to", "kept.csv"]);
    let after = folder.read("kept.csv");
    assert!(after.starts_with("# my file\nid,manufacturer,construction,"), "{after}");
    assert!(
        after
            .contains("# the end\nnew-1,,,line_to_line,rms,0.093,70,0.12,700,250,,bench,measured,2,\"wye, by hand\"\n"),
        "{after}"
    );
    for line in before.lines().skip(2) {
        assert!(after.contains(line), "{line}");
    }
    let catalog = Catalog::read(&[folder.at().join("kept.csv")]).unwrap();
    let alone = Catalog::read(&[folder.at().join("new.csv")]).unwrap();
    let (there, new) = (catalog.motor("new-1").unwrap(), &alone.motors[0]);
    assert!((there.torque_constant / new.torque_constant - 1.0).abs() < 1e-12);
    assert!((there.rotor_inertia.unwrap() / new.rotor_inertia.unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(catalog.motors.len(), 2);
    // What contradicts itself is not added, unless it says why.
    let spoiled = MINE.replace("mine-1", "mine-3").replace("inductance [uH]", "inductance [mH]");
    folder.write("spoiled.csv", &spoiled);
    let why = folder.wrong(&["add", "spoiled.csv", "--to", "kept.csv"]);
    assert!(why.contains("contradicts itself, [inductance-unit]") && why.contains("the resistance"), "{why}");
    assert_eq!(folder.read("kept.csv"), after);
    // Wrong places.
    folder.good(&["new", "gear", "--write", "gear.csv"]);
    for (words, expected) in [
        (["add", "gear.csv", "--to", "kept.csv"], "holds motors; gears need a file of their own"),
        (["add", "gear.csv", "--to", "own"], "is a folder"),
        (["add", "gear.csv", "--to", "builtin"], "is a word, not a file"),
        (["add", "gear.csv", "--to", "x.toml"], "is no .csv file"),
        (["add", "gear.csv", "--to", "no/x.csv"], "there is no folder"),
        (["add", "none.csv", "--to", "x.csv"], "there is no such file"),
    ] {
        let said = folder.wrong(&words);
        assert!(said.contains(expected), "{words:?}: {said}");
    }
    // Rows of TOML go into a table as well; an id of the built-in catalogue is said.
    folder.write("row.toml", "[[motor]]\nid = \"t-motor-u8\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\nR = \"1 ohm\"\nKt = \"0.1 N*m/A\"\nsource = \"x\"\nsource_kind = \"measured\"\n");
    let output = folder.catalog(&["add", "row.toml", "--to", "kept.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("in the built-in catalogue too: t-motor-u8"), "{}", said(&output));
}

fn status(output: &Output) -> Option<i32> {
    output.status.code()
}

#[test]
fn diff_tells_blank_from_zero_and_a_unit_from_a_change() {
    let folder = Folder::new();
    folder.write("a.csv", MINE);
    assert_eq!(folder.good(&["diff", "a.csv", "a.csv"]), "No difference.\n");
    // The same number in another unit is no difference.
    folder.write("units.csv", &MINE.replace("inductance [uH]", "inductance [mH]").replace(",100,", ",0.1,"));
    assert_eq!(folder.good(&["diff", "a.csv", "units.csv"]), "No difference.\n");
    folder.write("zero.csv", &MINE.replace(",100,", ",0,"));
    folder.write("blank.csv", &MINE.replace(",100,", ",,"));
    for (a, b, expected) in [
        ("a.csv", "zero.csv", "inductance: 0.1 mH → 0 mH"),
        ("a.csv", "blank.csv", "inductance: 0.1 mH → blank"),
        ("zero.csv", "blank.csv", "→ blank"),
    ] {
        let output = folder.catalog(&["diff", a, b]);
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(status(&output), Some(1), "{a} {b}");
        assert!(text.contains(expected) && text.contains("0 added, 0 removed, 1 changed"), "{text}");
    }
    // A change that four digits do not show is shown.
    folder.write("near.csv", &MINE.replace(",100,", ",100.00001,"));
    let text = String::from_utf8(folder.catalog(&["diff", "a.csv", "near.csv"]).stdout).unwrap();
    let line = text.lines().find(|l| l.contains("inductance")).unwrap();
    let (before, after) = line.split_once('→').unwrap();
    assert_ne!(before.trim().rsplit(": ").next(), Some(after.trim()));
    // A convention that changes changes what the number means.
    folder.write("rms.csv", &MINE.replace("torque_constant [N*m/A]", "torque_constant [N*m/A rms]"));
    let text = String::from_utf8(folder.catalog(&["diff", "a.csv", "rms.csv"]).stdout).unwrap();
    assert!(text.contains("torque_constant: 0.1 N*m/A → 0.1 N*m/A rms"), "{text}");
    let text = String::from_utf8(folder.catalog(&["diff", "a.csv", "builtin"]).stdout).unwrap();
    let builtin = Catalog::builtin().unwrap();
    let rows = builtin.motors.len() + builtin.all_gears().count() + builtin.modules.len();
    assert!(text.contains(&format!("{rows} added, 1 removed, 0 changed")), "no such counts");
    assert!(folder.wrong(&["diff", "a.csv", "none.csv"]).contains("there is no such file"));
    let found = folder.json(&["diff", "zero.csv", "blank.csv"]);
    let change = &found["rows"][0]["changes"][0];
    assert_eq!((&change["before"]["value"], &change["after"]), (&Value::from(0.0), &Value::Null));
}

#[test]
fn path_says_what_is_there_and_what_is_not() {
    let folder = Folder::new();
    let places = folder.json(&["path"]);
    assert_eq!((&places["user"]["state"], &places["user"]["motors"]), (&Value::from("absent"), &Value::Null));
    assert_eq!(places["user"]["by_variable"], true);
    assert!(flat(&folder.good(&["path"])).contains("nothing is there yet"));
    folder.write("own", "id,terminals\nx,y\n");
    assert_eq!(folder.json(&["path"])["user"]["state"], "wrong");
    assert!(!folder.good(&["path"]).contains("nothing is there"));
}

fn robot(limits: &str) -> String {
    format!(
        "name = \"leg\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"40 A\"\n[[joint]]\nname = \"knee\"\nratio = {{ min = 3, max = 30 }}\nmotor_drag = \"off\"\n\
         gear = {{ efficiency = 0.9, mass = \"200 g\", outer_diameter = \"20 mm\", length = \"0 mm\" }}\nobjective = \"loss\"\n\
         points = [ {{ torque = \"3 N*m\", speed = \"6 rad/s\", duration = \"0.3 s\" }}, {{ torque = \"0 N*m\", speed = \"-3 rad/s\", duration = \"0.6 s\" }} ]\n\
         [joint.limits]\n{limits}\n"
    )
}

#[test]
fn a_motor_whose_size_is_not_known_is_no_choice_where_a_size_is_asked() {
    let folder = Folder::new();
    let rows = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],continuous_current [A],outer_diameter [mm],length [mm],source,source_kind\n\
        blank,q_axis,q_axis,0.1,0.1,800,300,8,,,bench,measured\n\
        large,q_axis,q_axis,0.12,0.1,800,300,8,90,60,bench,measured\n\
        small,q_axis,q_axis,0.2,0.1,800,300,8,60,40,bench,measured\n";
    folder.write("rows.csv", rows);
    let run = |limits: &str| {
        folder.write("robot.toml", &robot(limits));
        let output = folder.run(&["optimize", "robot.toml", "--catalog", "rows.csv", "--json"]);
        let found: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", said(&output)));
        let joint = found["joints"][0].clone();
        let motors = |list: &str| -> Vec<String> {
            joint[list].as_array().unwrap().iter().map(|m| m["motor"].as_str().unwrap().to_string()).collect()
        };
        (status(&output), motors("candidates"), motors("unjudged"), motors("rejected"))
    };
    let list = |ids: &[&str]| -> Vec<String> { ids.iter().map(|s| (*s).to_string()).collect() };
    // Nobody asks for a size: the best motor is the one of which least is known.
    assert_eq!(run("").1, list(&["blank", "large", "small"]));
    for limits in [
        "outer_diameter = \"80 mm\"",
        "axial_length = \"50 mm\"",
        "outer_diameter = \"6 cm\"\naxial_length = \"40 mm\"",
    ] {
        assert_eq!(run(limits), (Some(0), list(&["small"]), list(&["blank"]), list(&["large"])), "{limits}");
    }
    // Where only it is left, nothing can do the joint.
    let (status, candidates, unjudged, rejected) = run("outer_diameter = \"50 mm\"");
    assert_eq!((status, candidates, unjudged, rejected.len()), (Some(1), list(&[]), list(&["blank"]), 2));
    // A reserve of it holds; a wrong unit is a mistake with its place.
    assert_eq!(run("outer_diameter = \"90 mm\"\nreserve = { outer_diameter = 0.2 }").1, list(&["small"]));
    folder.write("robot.toml", &robot("outer_diameter = \"90 g\""));
    let output = folder.run(&["optimize", "robot.toml"]);
    assert!(self::status(&output) == Some(2) && said(&output).contains("outer_diameter"), "{}", said(&output));
}

#[test]
fn the_audit_says_what_rows_lack_and_offers_both_explanations() {
    let folder = Folder::new();
    folder.write("cold.csv", COLD);
    let text = |name: &str| flat(&String::from_utf8(folder.run(&["audit", name]).stdout).unwrap());
    let cold = text("cold.csv");
    assert!(cold.contains("What rows lack, of 1 motor:") && cold.contains("heat 1 0 it cannot be judged"), "{cold}");
    // A row that has a heat is not counted among those that lack it.
    folder.write("mine.csv", MINE);
    assert!(!text("mine.csv").contains("heat 1"), "{}", text("mine.csv"));
    // Gears alone lack nothing of a motor.
    folder.good(&["new", "gear", "--write", "gear.csv"]);
    assert!(!text("gear.csv").contains("What rows lack"));
    // L/R cannot say which of the two is wrong.
    folder.write("off.csv", &MINE.replace(",100,", ",0.1,"));
    let off = text("off.csv");
    assert!(off.contains("the inductance may be headed µH for mH, or the resistance ohm for mohm"), "{off}");
}
