//! Every mistake in an input file: exit status 2, and a report with file, line, column, the line, what
//! was expected and the nearest valid name. Each case is a good file with something spoilt; the reports
//! are kept as snapshots.

use std::fs;
use std::process::Command;

const REQUIREMENT: &str = r#"name = "leg"

[bus]
voltage = "48 V"
drive_current = "40 A"

[[joint]]
name = "knee"
count = 2
ratio = { min = 3, max = 30 }
motor_drag = "off"
gear = { efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2" }
motion = "knee.csv"
objective = "loss"
[joint.limits]
reflected_inertia = "0.02 kg*m^2"
safety = 1.2
"#;

/// A second joint before the first.
const HIP: &str = "[[joint]]
name = \"hip\"
ratio = { min = 3, max = 30 }
motion = \"knee.csv\"
# carries

[[joint]]";

/// Its motion.
pub const MOTION: &str = "time [s], torque [N*m], velocity [rad/s]
0,    1.0,  0.5
0.1,  2.0,  1.5
0.2,  1.5,  0.2
0.3, -0.5, -1.0
0.4,  1.0,  0.5
";

const MOTORS: &str = "id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],pole_pairs,continuous_torque [N*m],source,source_kind
alpha-1,line_to_line,dc,0.5,0.2,0.05,300,200,7,9,a sheet,datasheet
alpha-2,line_to_line,dc,0.7,0.3,0.06,320,210,7,9,a sheet,datasheet
";

const GEARS: &str = "id,kind,ratio,stages,efficiency,mass [g],inertia [g*cm^2],continuous_torque [N*m],peak_torque [N*m],fits,source,source_kind
planetary-1,planetary,9,2,0.9,150,5,4,8,*,a sheet,datasheet
";

/// Prices before the joint.
const PRICES: &str = "[prices]\ncurrency = \"EUR\"\nrates = { CNY = 0.128 }\ndate = \"2026-11-01\"\n\n[[joint]]";

/// In place of the joint's motion.
const TWO_CASES: &str =
    "[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n[[joint.case]]\nname = \"b\"\nmotion = \"knee.csv\"\n";

/// Runs `optimize` on a folder with these files and gives its report. It must refuse them.
fn report(requirement: &str, motion: &[u8], motors: &str, gears: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("robot.toml", requirement.as_bytes());
    write("knee.csv", motion);
    write("motors.csv", motors.as_bytes());
    write("gears.csv", gears.as_bytes());
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(output.stdout.is_empty(), "nothing may be printed beside the report");
    stderr
}

/// The good text with each `(from, to)` replaced; every `from` must occur.
fn spoil(good: &str, changes: &[(&str, &str)]) -> String {
    let mut text = good.to_string();
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}` is not in the good file");
        text = text.replacen(from, to, 1);
    }
    text
}

#[test]
fn the_good_files_are_good() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in
        [("robot.toml", REQUIREMENT), ("knee.csv", MOTION), ("motors.csv", MOTORS), ("gears.csv", GEARS)]
    {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn requirement_files() {
    let cases: &[(&str, &[(&str, &str)])] = &[
        ("typo in a key of the bus", &[("voltage =", "votlage =")]),
        ("typo in a key of a joint", &[("objective =", "objektive =")]),
        (
            "typo in the only key of a drive",
            &[("objective = \"loss\"", "objective = \"loss\"\ndrive = { curent = \"40 A\" }")],
        ),
        ("a drive without a key", &[("objective = \"loss\"", "objective = \"loss\"\ndrive = {}")]),
        ("unknown key at the top", &[("name = \"leg\"", "name = \"leg\"\ncolour = \"red\"")]),
        ("missing unit", &[("\"48 V\"", "\"48\"")]),
        ("bare number where a unit is needed", &[("\"48 V\"", "48")]),
        ("unit of something else", &[("\"48 V\"", "\"48 A\"")]),
        ("unknown unit", &[("\"2e-6 kg*m^2\"", "\"2e-6 kgm2\"")]),
        ("decimal comma", &[("\"48 V\"", "\"48,5 V\"")]),
        ("negative mass", &[("\"150 g\"", "\"-150 g\"")]),
        ("not a number", &[("safety = 1.2", "safety = nan")]),
        ("infinite", &[("safety = 1.2", "safety = inf")]),
        ("efficiency above one", &[("efficiency = 0.95", "efficiency = 95")]),
        ("efficiency of zero", &[("efficiency = 0.95", "efficiency = 0")]),
        ("ratio range upside down", &[("min = 3, max = 30", "min = 30, max = 3")]),
        ("ratio of zero", &[("min = 3", "min = 0")]),
        ("ratio step of zero", &[("max = 30 }", "max = 30, step = 0 }")]),
        ("ratio step past the range", &[("max = 30 }", "max = 30, step = 50 }")]),
        ("ratio step too fine", &[("max = 30 }", "max = 30, step = 0.001 }")]),
        ("ratio values and step", &[("min = 3, max = 30", "values = [3, 30], step = 1")]),
        ("ratio values unsorted", &[("min = 3, max = 30", "values = [5, 8, 6]")]),
        ("ratio values twice", &[("min = 3, max = 30", "values = [5, 6, 6.0]")]),
        ("ratio values negative", &[("min = 3, max = 30", "values = [-5, 6]")]),
        ("ratio values that are none", &[("min = 3, max = 30", "values = []")]),
        ("half a ratio range", &[("min = 3, max = 30", "min = 3")]),
        ("no ratio at all", &[("ratio = { min = 3, max = 30 }\n", "")]),
        ("ratio and gears", &[("count = 2", "count = 2\ngears = [\"planetary-*\"]")]),
        ("unknown objective", &[("\"loss\"", "\"lost\"")]),
        ("weighted objective without reference", &[("\"loss\"", "{ loss = 1, reflected_inertia = 0.5 }")]),
        ("motion that is not there", &[("knee.csv", "kne.csv")]),
        ("motion and points", &[("count = 2", "points = [ { torque = \"1 N*m\", speed = \"0 rad/s\" } ]")]),
        ("neither motion nor points", &[("motion = \"knee.csv\"\n", "")]),
        ("points that are empty", &[("motion = \"knee.csv\"", "points = []")]),
        (
            "points with and without duration",
            &[(
                "motion = \"knee.csv\"",
                "points = [ { torque = \"1 N*m\", speed = \"0 rad/s\", duration = \"1 s\" }, { torque = \"1 N*m\", speed = \"1 rad/s\" } ]",
            )],
        ),
        ("cases beside a motion", &[("objective = \"loss\"", "[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n")]),
        ("cases without shares", &[("motion = \"knee.csv\"\nobjective = \"loss\"", TWO_CASES)]),
        (
            "shares that do not sum to one",
            &[
                ("motion = \"knee.csv\"\nobjective = \"loss\"", TWO_CASES),
                ("name = \"a\"\n", "name = \"a\"\nshare = 0.9\n"),
                ("name = \"b\"\n", "name = \"b\"\nshare = 0.2\n"),
            ],
        ),
        (
            "a share that is missing",
            &[
                ("motion = \"knee.csv\"\nobjective = \"loss\"", TWO_CASES),
                ("name = \"a\"\n", "name = \"a\"\nshare = 1\n"),
            ],
        ),
        (
            "share and cycles",
            &[
                ("motion = \"knee.csv\"\nobjective = \"loss\"", TWO_CASES),
                ("name = \"a\"\n", "name = \"a\"\nshare = 0.5\n"),
                ("name = \"b\"\n", "name = \"b\"\nshare = 0.5\ncycles = 3\n"),
            ],
        ),
        (
            "an order with mistakes",
            &[(
                "motion = \"knee.csv\"\nobjective = \"loss\"",
                "order = [{ case = \"a\", duration = \"0.1 s\" }, { case = \"c\", count = 2 }, { case = \"b\" }]\n[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n[[joint.case]]\nname = \"b\"\nmotion = \"knee.csv\"\n",
            )],
        ),
        (
            "an order shorter than a case",
            &[(
                "motion = \"knee.csv\"\nobjective = \"loss\"",
                "order = [{ case = \"a\", duration = \"0.1 s\" }]\n[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n",
            )],
        ),
        (
            "a case that is not in the order",
            &[(
                "motion = \"knee.csv\"\nobjective = \"loss\"",
                "order = [{ case = \"a\", count = 2 }]\n[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n[[joint.case]]\nname = \"b\"\nmotion = \"knee.csv\"\n",
            )],
        ),
        (
            "points of a case without duration",
            &[(
                "motion = \"knee.csv\"\nobjective = \"loss\"",
                "[[joint.case]]\nname = \"a\"\npoints = [{ torque = \"1 N*m\", speed = \"0 rad/s\" }]\n",
            )],
        ),
        (
            "two cases of one name",
            &[(
                "motion = \"knee.csv\"\nobjective = \"loss\"",
                "[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n",
            )],
        ),
        (
            "a spring and cases without a position",
            &[(
                "motion = \"knee.csv\"\nobjective = \"loss\"",
                "spring = { stiffness = [\"0 N*m/rad\", \"9 N*m/rad\"], rest_angle = [\"-9 deg\", \"9 deg\"] }\n[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n",
            )],
        ),
        (
            "a case of the robot that names what is not there",
            &[
                ("[bus]", "[[case]]\nname = \"run\"\njoints = { kne = \"a\", knee = \"b\" }\n[bus]"),
                (
                    "motion = \"knee.csv\"\nobjective = \"loss\"",
                    "[[joint.case]]\nname = \"a\"\nmotion = \"knee.csv\"\n",
                ),
            ],
        ),
        ("speed in hertz", &[("motion = \"knee.csv\"", "points = [ { torque = \"1 N*m\", speed = \"2 Hz\" } ]")]),
        ("count that is not whole", &[("count = 2", "count = 2.5")]),
        ("count of zero", &[("count = 2", "count = 0")]),
        ("text where a number belongs", &[("safety = 1.2", "safety = \"much\"")]),
        ("no bus", &[("[bus]\nvoltage = \"48 V\"\ndrive_current = \"40 A\"\n", "")]),
        ("no joint", &[(&REQUIREMENT[REQUIREMENT.find("[[joint]]").unwrap()..], "")]),
        (
            "two joints of one name",
            &[(
                "[[joint]]",
                "[[joint]]\nname = \"knee\"\nratio = { min = 3, max = 30 }\nmotion = \"knee.csv\"\n\n[[joint]]",
            )],
        ),
        ("empty name", &[("name = \"leg\"", "name = \"\"")]),
        ("not TOML", &[("[bus]", "[bus")]),
        ("unquoted unit", &[("\"48 V\"", "48 V")]),
        ("key twice", &[("count = 2", "count = 2\ncount = 3")]),
        ("a key of a later version", &[("count = 2", "count = 2\nactuator = \"fitted.toml\"")]),
        (
            "carrying a joint that is not there",
            &[("[[joint]]", HIP), ("count = 2", "count = 2\ntorque_per_mass = { hipp = \"2.1 N*m/kg\" }")],
        ),
        ("carrying itself", &[("count = 2", "count = 2\ntorque_per_mass = { knee = \"2.1 N*m/kg\" }")]),
        (
            "carrying in a circle",
            &[
                ("[[joint]]", HIP),
                ("# carries", "torque_per_mass = { knee = \"3 N*m/kg\" }"),
                ("count = 2", "count = 2\ntorque_per_mass = { hip = \"2.1 N*m/kg\" }"),
            ],
        ),
        (
            "torque per mass in another unit",
            &[("[[joint]]", HIP), ("count = 2", "count = 2\ntorque_per_mass = { hip = \"2.1 N*m\" }")],
        ),
        ("negative count", &[("count = 2", "count = -2")]),
        ("phases of another length", &[("count = 2", "count = 2\nphases = [0, 0.5, 0.5]")]),
        ("phases in degrees", &[("count = 2", "count = 2\nphases = [0, 180]")]),
        (
            "phases of operating points",
            &[
                ("count = 2", "count = 2\nphases = [0, 0.5]"),
                ("motion = \"knee.csv\"", "points = [ { torque = \"1 N*m\", speed = \"1 rad/s\" } ]"),
            ],
        ),
        ("typo in a key of the budget", &[("[[joint]]", "[budget]\nactuator_mas = \"2 kg\"\n\n[[joint]]")]),
        (
            "spring range upside down",
            &[(
                "safety = 1.2",
                "safety = 1.2\nspring = { stiffness = [\"50 N*m/rad\", \"0 N*m/rad\"], rest_angle = [\"0 deg\", \"9 deg\"] }",
            )],
        ),
        (
            "spring without a unit",
            &[("safety = 1.2", "safety = 1.2\nspring = { stiffness = [0, 50], rest_angle = [\"0 deg\", \"9 deg\"] }")],
        ),
        (
            "spring of negative stiffness",
            &[(
                "safety = 1.2",
                "safety = 1.2\nspring = { stiffness = [\"-5 N*m/rad\", \"9 N*m/rad\"], rest_angle = [\"0 deg\", \"9 deg\"] }",
            )],
        ),
        ("spring without a rest angle", &[("safety = 1.2", "safety = 1.2\nspring = { stiffness = \"5 N*m/rad\" }")]),
        (
            "spring with operating points",
            &[
                ("motion = \"knee.csv\"", "points = [ { torque = \"1 N*m\", speed = \"2 rad/s\" } ]"),
                (
                    "safety = 1.2",
                    "safety = 1.2\nspring = { stiffness = [\"0 N*m/rad\", \"9 N*m/rad\"], rest_angle = [\"0 deg\", \"9 deg\"] }",
                ),
            ],
        ),
        ("unknown regeneration", &[("voltage = \"48 V\"", "voltage = \"48 V\"\nregeneration = \"maybe\"")]),
        ("stage ratio without mass", &[("mass = \"150 g\"", "stage_ratio = 5")]),
        ("a price without prices", &[("safety = 1.2", "safety = 1.2\nprice = \"250 EUR\"")]),
        (
            "a price in a currency without a rate",
            &[("[[joint]]", PRICES), ("safety = 1.2", "safety = 1.2\nprice = \"250 USD\"")],
        ),
        ("a price without its currency", &[("[[joint]]", PRICES), ("safety = 1.2", "safety = 1.2\nprice = \"250\"")]),
        ("a price of a unit", &[("[[joint]]", PRICES), ("safety = 1.2", "safety = 1.2\nprice = \"250 kg\"")]),
        ("a price of nothing", &[("[[joint]]", PRICES), ("safety = 1.2", "safety = 1.2\nprice = \"0 EUR\"")]),
        ("a price that is a number", &[("[[joint]]", PRICES), ("safety = 1.2", "safety = 1.2\nprice = 250")]),
        (
            "prices with mistakes",
            &[
                ("[[joint]]", PRICES),
                ("\"EUR\"", "\"eur\""),
                ("CNY = 0.128", "CNY = 0, Usd = 0.9"),
                ("2026-11-01", "01-11-2026"),
                // Is not said to have no [prices].
                ("safety = 1.2", "safety = 1.2\nprice = \"250 EUR\""),
            ],
        ),
        ("a rate of the currency itself", &[("[[joint]]", PRICES), ("CNY = 0.128", "EUR = 1.1")]),
        ("a day that is none", &[("[[joint]]", PRICES), ("2026-11-01", "2026-11-31")]),
        ("prices without a day", &[("[[joint]]", PRICES), ("date = \"2026-11-01\"\n", "")]),
        ("an arrangement without a length", &[("safety = 1.2", "safety = 1.2\narrangement = \"side_by_side\"")]),
        (
            "an unknown arrangement",
            &[("safety = 1.2", "safety = 1.2\naxial_length = \"70 mm\"\narrangement = \"side-by-side\"")],
        ),
        (
            "joint as a table",
            &[
                ("[[joint]]", "[joint]"),
                ("[joint.limits]\n", ""),
                ("reflected_inertia = \"0.02 kg*m^2\"\nsafety = 1.2\n", ""),
            ],
        ),
        (
            "many mistakes at once",
            &[
                ("\"48 V\"", "\"48\""),
                ("count = 2", "count = -1"),
                ("\"loss\"", "\"lss\""),
                ("safety = 1.2", "saftey = 1.2"),
                ("\"150 g\"", "\"150 mm\""),
            ],
        ),
    ];
    for (name, changes) in cases {
        let report = report(&spoil(REQUIREMENT, changes), MOTION.as_bytes(), MOTORS, GEARS);
        insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false, snapshot_path => "../../snapshots/mistakes" }, {
            insta::assert_snapshot!(format!("requirement {name}").replace(' ', "_"), report);
        });
    }
}

#[test]
fn motion_files() {
    let cases: &[(&str, &[(&str, &str)])] = &[
        ("unsorted time", &[("0.2,", "0.05,")]),
        ("time twice", &[("0.2,", "0.1,")]),
        ("time out of order in several rows", &[("0.2,", "0.05,"), ("0.4,", "0.25,")]),
        ("a cell is not a number", &[("2.0", "NaN")]),
        ("a cell has its unit", &[("2.0", "2.0 N*m")]),
        ("a cell is blank", &[("2.0", "")]),
        ("a cell too many", &[("0.2,  1.5,", "0.2,  1.5, 7,")]),
        ("a column without unit", &[("torque [N*m]", "torque")]),
        ("a column in a wrong unit", &[("torque [N*m]", "torque [rad]")]),
        ("an unknown column", &[("velocity [rad/s]", "velocty [rad/s]")]),
        ("a column twice", &[("velocity [rad/s]", "torque [N*m]")]),
        ("the end does not repeat the start", &[("0.4,  1.0,  0.5", "0.4,  1.5,  0.5")]),
        ("too short", &[("0.1,  2.0,  1.5\n0.2,  1.5,  0.2\n", "")]),
        ("header alone", &[(&MOTION[MOTION.find('\n').unwrap() + 1..], "")]),
        ("empty file", &[(MOTION, "")]),
        ("decimal commas", &[("0.1,  2.0,  1.5", "\"0,1\",  2.0,  1.5")]),
        ("semicolons", &[("time [s], torque [N*m], velocity [rad/s]", "time [s]; torque [N*m]; velocity [rad/s]")]),
    ];
    for (name, changes) in cases {
        let report = report(REQUIREMENT, spoil(MOTION, changes).as_bytes(), MOTORS, GEARS);
        insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false, snapshot_path => "../../snapshots/mistakes" }, {
            insta::assert_snapshot!(format!("motion {name}").replace(' ', "_"), report);
        });
    }
}

#[test]
fn catalogue_files() {
    let cases: &[(&str, &[(&str, &str)])] = &[
        ("no convention", &[("alpha-1,line_to_line,dc", "alpha-1,line_to_line,")]),
        ("unknown convention", &[("alpha-1,line_to_line,dc", "alpha-1,line_to_line,peak")]),
        ("winding without wye or delta", &[("alpha-1,line_to_line", "alpha-1,winding")]),
        ("duplicate id", &[("alpha-2", "alpha-1")]),
        ("no source", &[("a sheet,datasheet\nalpha-2", ",datasheet\nalpha-2")]),
        ("negative resistance", &[("0.5,0.2", "-0.5,0.2")]),
        ("resistance blank", &[("dc,0.5,", "dc,,")]),
        ("torque constant blank", &[("0.2,0.05,", "0.2,,")]),
        ("pole pairs not whole", &[("200,7,", "200,7.5,")]),
        ("an id with blanks", &[("alpha-1", "Alpha 1")]),
        ("a missing column", &[(",source_kind", ",note")]),
        ("a quote that never ends", &[("alpha-1", "\"alpha-1")]),
    ];
    for (name, changes) in cases {
        let report = report(REQUIREMENT, MOTION.as_bytes(), &spoil(MOTORS, changes), GEARS);
        insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false, snapshot_path => "../../snapshots/mistakes" }, {
            insta::assert_snapshot!(format!("motors {name}").replace(' ', "_"), report);
        });
    }
    let cases: &[(&str, &[(&str, &str)])] = &[
        ("unknown kind", &[("planetary,9", "planetry,9")]),
        ("torques swapped", &[("4,8,", "8,4,")]),
        ("efficiency in per cent without saying so", &[("0.9,", "90,")]),
        ("no ratio", &[("planetary,9,", "planetary,,")]),
    ];
    for (name, changes) in cases {
        let report = report(REQUIREMENT, MOTION.as_bytes(), MOTORS, &spoil(GEARS, changes));
        insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false, snapshot_path => "../../snapshots/mistakes" }, {
            insta::assert_snapshot!(format!("gears {name}").replace(' ', "_"), report);
        });
    }
}

#[test]
fn files_that_are_no_text() {
    let noise: Vec<u8> = (0..10_000_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let binary = report(REQUIREMENT, &noise, MOTORS, GEARS);
    assert!(binary.contains("not a text file") && binary.len() < 1000, "{binary}");
    // Noise that is text: one line of ten million letters, and ten million lines' worth of junk.
    let letters: Vec<u8> = noise.iter().map(|b| b'a' + b % 26).collect();
    let line = report(REQUIREMENT, &letters, MOTORS, GEARS);
    assert!(line.contains("unknown column") && line.len() < 4000, "{}", &line[..line.len().min(4000)]);
    let commas: Vec<u8> = noise
        .iter()
        .map(|b| {
            if b % 7 == 0 {
                b','
            } else if b % 11 == 0 {
                b'\n'
            } else {
                b'0' + b % 10
            }
        })
        .collect();
    let junk = report(REQUIREMENT, &commas, MOTORS, GEARS);
    assert!(junk.len() < 20_000, "{} bytes of report", junk.len());
    let mut rows = MOTION.as_bytes().to_vec();
    for _ in 0..100_000 {
        rows.extend(b"x,y,z\n");
    }
    let many = report(REQUIREMENT, &rows, MOTORS, GEARS);
    assert!(many.len() < 60_000, "{} bytes of report", many.len());
}

#[test]
fn line_ends_and_byte_order_marks_do_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let crlf = |text: &str| format!("\u{feff}{}", text.replace('\n', "\r\n"));
    let run = |convert: &dyn Fn(&str) -> String| {
        for (name, text) in
            [("robot.toml", REQUIREMENT), ("knee.csv", MOTION), ("motors.csv", MOTORS), ("gears.csv", GEARS)]
        {
            fs::write(folder.path().join(name), convert(text)).unwrap();
        }
        let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
            .args(["optimize", "robot.toml", "--json", "--catalog", "motors.csv"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    assert_eq!(run(&|t| t.to_string()), run(&crlf));
}
