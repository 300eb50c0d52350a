//! Pages: what a user gets with `--html`, and that nothing in a catalogue can make a page do anything.

use std::path::Path;

use gearwise::report::html::{Page, Part, Row, Section, Table, text};
use gearwise::report::plot::{Figure, Group, Mark, Panel, Series, Shape, Tone};
use sha2::{Digest, Sha256};

use crate::common;
use crate::common::run::gearwise;

/// The page of a command; what is printed is not looked at.
fn page_of(arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("page.html");
    let mut all = arguments.to_vec();
    let name = path.to_str().expect("a name").to_string();
    all.extend(["--html", &name]);
    let output = gearwise(&all);
    assert!(output.status.code().is_some_and(|c| c < 2), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::read_to_string(&path).expect("the page was written")
}

/// What stands between two marks, the first time.
fn between<'t>(text: &'t str, from: &str, to: &str) -> &'t str {
    let start = text.find(from).unwrap_or_else(|| panic!("no {from}")) + from.len();
    &text[start..start + text[start..].find(to).unwrap_or_else(|| panic!("no {to}"))]
}

/// Base 64, digit by digit over a string of bits: another way than the page's.
fn base64(bytes: &[u8]) -> String {
    let digits: Vec<char> = ('A'..='Z').chain('a'..='z').chain('0'..='9').chain(['+', '/']).collect();
    let mut bits: String = bytes.iter().map(|b| format!("{b:08b}")).collect();
    while !bits.len().is_multiple_of(6) {
        bits.push('0');
    }
    let digit = |k: usize| digits[usize::from_str_radix(&bits[6 * k..6 * k + 6], 2).expect("bits")];
    let mut out: String = (0..bits.len() / 6).map(digit).collect();
    while !out.len().is_multiple_of(4) {
        out.push('=');
    }
    out
}

/// Elements that the page may have; anything else came from outside.
fn elements(page: &str) -> Vec<String> {
    let mut names = Vec::new();
    for part in page.split('<').skip(1) {
        let name: String = part.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '!' || *c == '/').collect();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The markup without the script and the style, which are the program's own.
fn markup(page: &str) -> String {
    let style = between(page, "<style>", "</style>");
    let script = between(page, "<script>", "</script>");
    page.replace(style, "").replace(script, "")
}

const HOSTILE: [&str; 9] = [
    "<script>alert(1)</script>",
    "</script><script>alert(2)</script>",
    "\"><img src=x onerror=alert(3)>",
    "line\u{2028}separator\u{2029}",
    "=cmd|' /C calc'!A0",
    "<!--<script>",
    "a & b &lt;i&gt; ' ` ${alert(4)}",
    "\u{202e}gnp.rotom",
    "nul\u{0}\u{1b}[31m",
];

/// A page that has every kind of part, of things with these names.
fn page_about(names: &[String]) -> Page {
    let mut table = Table::new("Motors <b>", &["motor", ">loss [W]"]);
    for (k, name) in names.iter().enumerate() {
        table.rows.push(Row { id: name.clone(), cells: vec![name.clone(), k.to_string()], faint: k % 2 == 1 });
    }
    let points = (0..names.len()).map(|k| (k as f64 + 1.0, 1.0 / (k as f64 + 1.0))).collect();
    let series = Series::new(Tone::Blue, Mark::Points(Shape::Circle), points)
        .named(names[0].clone())
        .of(names.to_vec())
        .noted(names.iter().map(|n| format!("{n}: noted")).collect());
    let panel =
        Panel { title: names[0].clone(), x: "x".into(), y: "y".into(), series: vec![series], ..Panel::default() };
    let figure = Figure {
        groups: vec![Group { title: names[0].clone(), panels: vec![panel], ..Group::default() }],
        ..Figure::default()
    };
    let list = names.to_vec();
    Page {
        command: "rank",
        title: names[0].clone(),
        headline: names.join(" "),
        summary: vec![Part::Text(names[0].clone())],
        sections: vec![Section::new(
            names[0].clone(),
            vec![
                Part::List(list.clone()),
                Part::Plain(list.join("\n")),
                Part::Table(table),
                Part::Figure(figure),
                Part::Folded(names[0].clone(), Box::new(Part::Text(names[0].clone()))),
            ],
        )],
        warnings: list,
        call: format!("gearwise rank '{}'", names[0]),
        ..Page::default()
    }
}

#[test]
fn every_command_has_a_page() {
    let quadruped = "requirements/quadruped_mini_cheetah.toml";
    let cases: [(&[&str], &[&str]); 10] = [
        (&["check", GOOD], &["What was asked", "The design passes", "69 rules", "GW110"]),
        (
            &["characterize", "requirements/bench/motor_on_bench.toml"],
            &["What was found", "torque_constant", "drag: checks"],
        ),
        (&["optimize", quadruped, "--robust"], &["at worst", "over the tolerances", "is first then"]),
        (&["rank"], &["In short", "Motors", "Warnings", "Where this comes from"]),
        (&["compare", "t-motor-ri50", "t-motor-u8"], &["is ", "times as responsive", "Speed response"]),
        (
            &["explain", "t-motor-ri50", quadruped, "--joint", "knee"],
            &["Limits", "What it needs and weighs", "Where the loss is", "class=\"stack\"", "sha256"],
        ),
        (&["sweep", quadruped, "--ratios", "9"], &["every design", "designs are feasible"]),
        (&["audit"], &["What was checked", "Findings"]),
        (&["optimize", quadruped, "--pareto", "loss,mass"], &["points on the front", "The ends of each front"]),
        (
            &["optimize", quadruped, "--pareto", "loss,mass,reflected_inertia"],
            &[
                "a front of loss, mass and reflected_inertia",
                "The ends of each front",
                "in a quantity that is not in the panel",
            ],
        ),
    ];
    for (arguments, expected) in cases {
        let page = page_of(arguments);
        for text in expected {
            assert!(page.contains(text), "{arguments:?} has no {text}");
        }
        assert_eq!(page.matches("<h1>").count(), 1);
        // What was asked comes before the answer.
        let at = |id: &str| page.find(&format!("<section id=\"{id}\"")).unwrap_or_else(|| panic!("no {id}"));
        assert!(at("asked") < at("summary"), "{arguments:?}");
        assert!(page.ends_with("</html>\n"));
        // No address in the page but that of SVG-like names: nothing can be fetched.
        let own = markup(&page);
        for fetch in [" src=", "url(", "@import", "<iframe", "<object", "<base", " style=", " onclick="] {
            assert!(!own.contains(fetch), "{arguments:?} has {fetch}");
        }
    }
}

const GOOD: &str = "requirements/designs/quadruped_mini_cheetah/design.toml";

/// The text between a page's first and last mark of a section.
fn section<'p>(page: &'p str, id: &str) -> &'p str {
    between(page, &format!("<section id=\"{id}\""), "</section>")
}

#[test]
fn a_page_begins_with_the_requirement_and_its_motion() {
    let page = page_of(&["optimize", "requirements/quadruped_mini_cheetah.toml"]);
    let asked = section(&page, "asked");
    // By hand: the knee's file has 200 rows, its largest torque is 13.39 N·m; four points of the abduction.
    for expected in
        ["Bus of 24 V", "at most 40 A", "<td>knee", "<td class=n>200", "<td class=n>13.39", "safety 1.2 on peaks"]
    {
        assert!(asked.contains(expected), "no {expected} in {asked}");
    }
    assert!(asked.contains("data-figure=\"0\""), "the motion is drawn");
    // What nobody asked for is not said.
    for none in ["of the bus for one joint", "in reserve", "spring", "all actuators together"] {
        assert!(!asked.contains(none), "{none}");
    }
}

#[test]
fn a_whole_robot_is_tables_and_no_block_of_text() {
    let quadruped = "requirements/quadruped_mini_cheetah.toml";
    let page = page_of(&["optimize", quadruped, "--robot"]);
    let summary = section(&page, "summary");
    for table in ["The best combination", "The best, and the next best with another motor somewhere"] {
        assert!(summary.contains(&format!("<caption>{table}</caption>")), "{table}");
    }
    // Only the call is as it was typed.
    assert_eq!(markup(&page).matches("<pre").count(), 1);
    let alone = page_of(&["optimize", quadruped]);
    assert!(!alone.contains("The best combination"));
}

/// The shipped design with another ratio of the knee.
fn design(folder: &Path, ratio: &str) -> String {
    let root = common::repository("requirements");
    let text = std::fs::read_to_string(common::repository(GOOD)).expect("the design");
    let text = text.replace("../../quadruped", &format!("{}/quadruped", root.display()));
    let text = text.replace("rules = \"rules.toml\"\n", "").replace("ratio = 9.33", &format!("ratio = {ratio}"));
    let path = folder.join("design.toml");
    std::fs::write(&path, text).expect("a design");
    path.to_str().expect("a name").to_string()
}

#[test]
fn the_page_of_a_check_says_what_is_wrong_by_how_much_and_how_to_mend_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let bad = page_of(&["check", &design(folder.path(), "3")]);
    assert!(bad.contains("<span class=\"badge bad\">not satisfied</span>"));
    assert!(bad.contains("does not pass"));
    let knee = between(&bad, "<caption>knee: findings</caption>", "</table>");
    for heading in ["severity", "rule", "measured", "bound", "how to fix", "asked for in"] {
        assert!(knee.contains(&format!(">{heading}</th>")), "{heading}");
    }
    assert!(knee.contains("<td>error"), "{knee}");
    // Each number of the page is one of the JSON.
    let json = gearwise(&["check", &design(folder.path(), "3"), "--json"]).stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    let findings = json["findings"].as_array().expect("findings");
    let errors: Vec<_> = findings.iter().filter(|f| f["joint"] == "knee" && f["severity"] == "error").collect();
    assert_eq!(knee.matches("<td>error").count(), errors.len());
    for code in errors.iter().map(|f| f["code"].as_str().expect("a code")) {
        assert!(knee.contains(code), "{code}");
    }
    // Nothing wrong, and nothing said of it.
    let good = page_of(&["check", GOOD]);
    assert!(good.contains("<span class=\"badge good\">satisfied</span>"));
    assert!(!good.contains("<td>error") && !good.contains("does not pass"));
}

#[test]
fn the_page_of_a_study_says_what_was_varied_and_which_robots_are_best() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("result").to_str().expect("a name").to_string();
    // The shipped study with a pace that nothing keeps.
    let shipped =
        std::fs::read_to_string(common::repository("requirements/studies/quadruped.toml")).expect("the study");
    let robot = common::repository("requirements/quadruped_mini_cheetah.toml");
    let harder = shipped.replace("../quadruped_mini_cheetah.toml", robot.to_str().expect("a path"));
    let harder = harder.replace("\"scale.speed\" = [1, 1.25]", "\"scale.speed\" = [1, 6]");
    let file = folder.path().join("study.toml").to_str().expect("a name").to_string();
    std::fs::write(&file, harder).expect("written");
    let study = ["study", &file, "--out", &out];
    let page = page_of(&study);
    let asked = section(&page, "asked");
    for expected in ["18 robots", "bus.voltage", "24 V, 36 V, 48 V", "scale.speed"] {
        assert!(asked.contains(expected), "{expected}");
    }
    // The best robot by hand: the least sum of count times loss over first choices, all joints of a robot having one.
    let mut reader = csv::Reader::from_path(Path::new(&out).join("results.csv")).expect("results");
    let head = reader.headers().expect("a header").clone();
    let at = |name: &str| head.iter().position(|h| h == name).expect("a column");
    let (mut sums, mut broken) = (std::collections::BTreeMap::<u64, f64>::new(), Vec::new());
    for row in reader.records() {
        let row = row.expect("a row");
        let number = |name: &str| row[at(name)].parse::<f64>().ok();
        let robot: u64 = row[at("robot")].parse().expect("a number");
        match &row[at("rank")] {
            "1" => *sums.entry(robot).or_default() += number("joint_count").unwrap() * number("loss_w").unwrap(),
            "" => broken.push(robot),
            _ => {}
        }
    }
    sums.retain(|robot, _| !broken.contains(robot));
    let (best, loss) = sums.iter().min_by(|a, b| a.1.total_cmp(b.1)).expect("a robot");
    assert!(!broken.is_empty(), "a robot that cannot be built is not among the best");
    let summary = section(&page, "summary");
    assert!(summary.contains(&format!("<tr><td class=n>1<td class=n>{best}<td>")), "robot {best}");
    assert!(summary.contains(&gearwise::report::number(*loss)), "{loss}");
    assert!(summary.contains(&format!("{} of 18 robots can be built", sums.len())));
    for robot in broken {
        assert!(!summary.contains(&format!("<td class=n>{robot}<td>quadruped")), "robot {robot}");
    }
    // Again from the finished results: the same answer.
    let again = page_of(&[&study[..], &["--resume"]].concat());
    assert_eq!(section(&again, "summary"), section(&page, "summary"));
    // Nothing was varied: nothing is said of it. A part of a study has no page.
    let single = folder.path().join("single").to_str().expect("a name").to_string();
    let page = page_of(&["study", "requirements/exoskeleton_hip.toml", "--out", &single]);
    assert!(!page.contains("What was varied"));
    let part = folder.path().join("part").to_str().expect("a name").to_string();
    let refused = gearwise(&["study", study[1], "--out", &part, "--shard", "1/2", "--html", "x.html"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("merge --html"));
}

#[test]
fn robust_is_said_of_tolerances_and_not_of_printed_numbers() {
    // The built-in rows that come first here have no ±: the page must not say that they keep their limits over it.
    let page = page_of(&["optimize", "requirements/quadruped_mini_cheetah.toml", "--robust"]);
    let bare = section(&page, "summary").contains("none in the catalogue");
    let proud = page.contains("Every joint has a design that keeps all limits over the tolerances of its motor.");
    assert!(bare && !proud);
}

#[test]
fn units_are_printed_as_in_print() {
    let page = page_of(&["optimize", "requirements/ankle_prosthesis_parallel_spring.toml"]);
    let own = markup(&page);
    assert!(own.contains("N·m/rad"));
    for typed in ["N*m", "kg*m^2", "Nm]"] {
        assert!(!own.contains(typed), "{typed}");
    }
}

#[test]
fn the_choice_is_on_its_page_with_what_it_rests_on() {
    let arguments = ["optimize", "requirements/quadruped_mini_cheetah.toml"];
    let page = page_of(&arguments);
    let json: serde_json::Value =
        serde_json::from_slice(&gearwise(&["optimize", arguments[1], "--json"]).stdout).expect("JSON");
    for joint in json["joints"].as_array().expect("joints") {
        for candidate in joint["candidates"].as_array().expect("candidates") {
            let motor = candidate["motor"].as_str().expect("a motor");
            assert!(page.contains(&format!("<td>{motor}")), "{motor} is not on the page");
        }
    }
    // The hashes are those of the files as another program would find them.
    for file in ["requirements/quadruped_mini_cheetah.toml", "requirements/motions/quadruped_trot_knee.csv"] {
        let bytes = std::fs::read(common::repository(file)).expect("the file");
        let hash: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        assert!(page.contains(&format!("<td>{file}<td>{hash}")), "{file}");
    }
    assert!(page.contains("the built-in catalogue"));
    assert!(page.contains("<pre tabindex=\"0\">gearwise optimize requirements/quadruped_mini_cheetah.toml</pre>"));
}

#[test]
fn the_page_allows_its_own_script_and_style_and_nothing_else() {
    let page = text(&page_about(&["motor".to_string()]));
    let policy = between(&page, "Content-Security-Policy\" content=\"", "\"");
    let hash = |text: &str| format!("'sha256-{}'", base64(&Sha256::digest(text.as_bytes())));
    let expected = format!(
        "default-src 'none'; script-src {}; style-src {}; img-src data:; base-uri 'none'; form-action 'none'",
        hash(between(&page, "<script>", "</script>")),
        hash(between(&page, "<style>", "</style>"))
    );
    assert_eq!(policy, expected);
    assert_eq!(page.matches("<script").count() - between(&page, "<script>", "</script>").matches("<script").count(), 2);
    // A carriage return would be changed by the reader, and the hash with it.
    assert!(!page.contains('\r'));
}

#[test]
fn hostile_names_are_shown_and_do_nothing() {
    let names: Vec<String> = HOSTILE.iter().map(|n| (*n).to_string()).collect();
    let plain = text(&page_about(&["motor".to_string()]));
    let page = text(&page_about(&names));
    // The browser's check opens it too.
    std::fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join("hostile.html"), &page).expect("the page");
    let own = markup(&page);
    // Not one element more in kind than a harmless name gives.
    assert_eq!(elements(&own), elements(&markup(&plain)));
    assert!(!own.contains("onerror=alert(3)>\n") && !own.contains("<img"));
    assert!(own.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    assert!(own.contains("=cmd|"));
    let island = between(&page, "id=\"data\">", "</script>");
    for c in ['<', '>', '&', '\u{2028}', '\u{2029}', '\u{0}', '\u{1b}'] {
        assert!(!island.contains(c), "{c:?} in the data");
    }
    let data: serde_json::Value = serde_json::from_str(island).expect("the data are JSON");
    let ids: Vec<&str> = data["ids"].as_array().expect("ids").iter().map(|v| v.as_str().expect("text")).collect();
    // A turn of direction is shown, not done; all else comes out as it went in.
    let expected = HOSTILE.map(|n| n.replace('\u{202e}', "\u{fffd}"));
    assert_eq!(ids, expected);
    assert!(!page.contains('\u{202e}'));
}

#[test]
fn a_thousand_designs_fit_into_a_megabyte() {
    let page = page_of(&["sweep", "requirements/exoskeleton_hip.toml", "--ratios", "10"]);
    let rows = page.matches("<tr data-i").count() + page.matches("<tr class=\"faint\" data-i").count();
    assert!(rows >= 1000, "only {rows} rows");
    assert!(page.len() <= 1_000_000, "{} bytes for {rows} designs", page.len());
}

#[test]
fn a_thousand_motors_fit_into_a_megabyte() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("motors.csv");
    let mut text = String::from(
        "id,manufacturer,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A],\
         rotor_inertia [g*cm^2],mass [g],inductance [mH],peak_current [A],continuous_current [A]\n",
    );
    for k in 0..1000 {
        let (r, kt, j) = (0.05 + 0.00137 * f64::from(k), 0.05 + 0.000313 * f64::from(k), 90.1 + 7.0 * f64::from(k));
        text.push_str(&format!(
            "some-manufacturer-type-{k:04},maker {},a data sheet,datasheet,q_axis,q_axis,{r},{kt},{j},400,0.3,60,25\n",
            k % 12
        ));
    }
    std::fs::write(&path, text).expect("the catalogue");
    let name = path.to_str().expect("a name");
    for arguments in [vec!["rank", name], vec!["optimize", "requirements/exoskeleton_hip.toml", "--catalog", name]] {
        let page = page_of(&arguments);
        assert!(page.matches("data-i").count() >= 1000);
        assert!(page.len() <= 1_000_000, "{} bytes for {}", page.len(), arguments[0]);
    }
}

#[test]
fn the_same_input_gives_the_same_page() {
    let arguments = |threads| ["optimize", "requirements/exoskeleton_hip.toml", "--threads", threads];
    assert!(page_of(&arguments("1")) == page_of(&arguments("2")), "the pages differ");
}

#[test]
fn page_and_json_go_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("page.html");
    let name = path.to_str().expect("a name");
    let output = gearwise(&["rank", "--json", "--html", name]);
    assert!(output.status.success());
    assert!(serde_json::from_slice::<serde_json::Value>(&output.stdout).is_ok());
    assert!(path.is_file());
}

#[test]
fn a_page_that_cannot_be_written_is_a_mistake_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_string();
    std::fs::create_dir(folder.path().join("folder.html")).expect("a folder");
    for (name, why) in [
        (at("missing/page.html"), "there is no folder"),
        (at("folder.html"), "it is a folder"),
        (at("page.pdf"), "a page's name ends in .html"),
    ] {
        let output = gearwise(&["rank", "--html", &name]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{name}");
        assert!(error.contains(why), "{error}");
        assert!(output.stdout.is_empty());
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("the folder").collect();
    assert_eq!(left.len(), 1, "only the folder that was there");
}

#[test]
fn the_vendored_library_is_what_its_note_says() {
    let vendor = common::repository("crates/report/src/html/vendor");
    let note = std::fs::read_to_string(vendor.join("README.md")).expect("the note");
    let rows: Vec<Vec<&str>> = note
        .lines()
        .filter(|l| l.starts_with("| ") && !l.contains("sha256"))
        .map(|l| l.split('|').map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), 3);
    for row in rows {
        let bytes = std::fs::read(Path::new(&vendor).join(row[1])).expect("a vendored file");
        let hash: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!(hash, row[2], "{}", row[1]);
    }
}

#[test]
fn the_structure_of_a_page() {
    let page = markup(&text(&page_about(&["motor".to_string(), "other".to_string()])));
    let own = page.replace(between(&page, "script-src '", "'"), "…").replace(between(&page, "style-src '", "'"), "…");
    let own = own.replace(env!("CARGO_PKG_VERSION"), "VERSION");
    insta::with_settings!({ snapshot_path => "../../snapshots/html", prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!("structure", own);
    });
}
