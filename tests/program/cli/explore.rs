//! The explorer, asked over its socket as a browser asks, and as a browser never would.
#![allow(clippy::disallowed_types, clippy::disallowed_methods, reason = "the test is the browser")]

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use gearwise::ask::Rows;
use gearwise::catalog::Catalog;
use gearwise::explore::work::Next;
use gearwise::explore::{Explorer, Ground};
use gearwise::input::Source;
use serde_json::{Value, json};

use crate::common::repository;
use crate::common::run::{gearwise, gearwise_in, stderr, stdout};

/// A server of its own, which ends with the test.
struct Served {
    child: Child,
    port: u16,
    token: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Served {
    fn start(folder: &Path, arguments: &[&str]) -> Served {
        let mut program = Command::new(env!("CARGO_BIN_EXE_gearwise"));
        program.arg("explore").args(arguments).current_dir(folder);
        let mut child = program.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("the program starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let rest = line.strip_prefix("http://127.0.0.1:").unwrap_or_else(|| panic!("no address: {line}"));
        let (port, token) = rest.trim_end().trim_end_matches('/').split_once('/').expect("a port and a token");
        Served { port: port.parse().unwrap(), token: token.to_string(), child }
    }

    fn shipped(name: &str) -> Served {
        Served::start(&repository(""), &[&format!("requirements/{name}.toml")])
    }

    /// What comes back for these bytes: status, head and body.
    fn raw(&self, bytes: &[u8]) -> (u16, String, String) {
        let mut socket = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        // A server that refuses may close before all was sent.
        let _ = socket.write_all(bytes);
        let mut answer = Vec::new();
        let _ = socket.read_to_end(&mut answer);
        let answer = String::from_utf8(answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
        (status, head.to_string(), body.to_string())
    }

    fn get(&self, path: &str) -> (u16, String, String) {
        let Served { port, token, .. } = self;
        self.raw(
            format!("GET /{token}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n").as_bytes(),
        )
    }

    fn post(&self, path: &str, body: &str) -> (u16, String, String) {
        let Served { port, token, .. } = self;
        let head = format!(
            "POST /{token}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
            body.len()
        );
        self.raw(format!("{head}{body}").as_bytes())
    }

    /// All replies to a question.
    fn ask(&self, ask: &Value) -> Vec<Value> {
        let (mut replies, mut next) = (Vec::new(), self.post("ask", &ask.to_string()));
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < Duration::from_secs(120), "no answer: {replies:?}");
            let (status, _, body) = &next;
            if *status == 204 {
                return replies;
            }
            assert_eq!(*status, 200, "{body}");
            let reply: Value = serde_json::from_str(body).unwrap();
            let pending = reply["pending"] == true;
            if reply.get("far").is_none() {
                replies.push(reply);
            }
            if !pending {
                return replies;
            }
            let more = json!({ "tab": ask["tab"], "ask": ask["ask"], "have": replies.len() });
            next = self.post("more", &more.to_string());
        }
    }
}

/// The first choice of each joint: motor and ratio, to the last digit.
fn choices(replies: &[Value]) -> Vec<(String, String, Value)> {
    let each = replies.iter().filter_map(|reply| reply["joints"].as_array()).flatten();
    let mut all: Vec<(String, String, Value)> = each
        .map(|joint| {
            let text = |key: &str| joint[key].as_str().unwrap_or_default().to_string();
            (text("joint"), text("motor"), joint["ratio"].clone())
        })
        .collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// The same of `optimize`.
fn chosen(answer: &Value) -> Vec<(String, String, Value)> {
    let first = |joint: &Value| {
        let best = &joint["candidates"][0];
        let motor = best["motor"].as_str().unwrap_or_default().to_string();
        (joint["joint"].as_str().unwrap().to_string(), motor, best["ratio"].clone())
    };
    let mut all: Vec<_> = answer["joints"].as_array().unwrap().iter().map(first).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// A copy of the shipped requirements, to save files next to their motions.
fn copied() -> (tempfile::TempDir, PathBuf) {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
            match entry.file_type().unwrap().is_dir() {
                true => copy(&entry.path(), &to.join(entry.file_name())),
                false => drop(std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap()),
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("requirements");
    std::fs::create_dir_all(&to).unwrap();
    for name in ["motions", "robots"] {
        copy(&repository("requirements").join(name), &to.join(name));
    }
    (folder, to)
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn what_is_shown_is_what_optimize_chooses_from_the_saved_file() {
    let (_folder, to) = copied();
    let states: [(&str, Value); 5] = [
        (
            "quadruped_mini_cheetah",
            json!({ "bus.voltage": "31 V", "scale.torque": "1.13", "joint.knee.limits.safety": "1.05" }),
        ),
        (
            "quadruped_mini_cheetah",
            json!({ "joint.*.objective": "mass", "scale.speed": "1.2", "joint.hip.ratio.max": "14" }),
        ),
        ("exoskeleton_hip", json!({ "ambient.temperature": "38 degC" })),
        ("humanoid_hip_catalog_gears", json!({ "scale.torque": "0.9" })),
        ("quadruped_knee_linkage", json!({ "bus.voltage": "40 V" })),
    ];
    for (name, state) in states {
        let served = Served::shipped(name);
        let ask = json!({ "tab": "t", "ask": 1, "state": state });
        let shown = choices(&served.ask(&ask));
        let (status, _, text) = served.post("toml", &ask.to_string());
        assert_eq!(status, 200, "{text}");
        let file = to.join("saved.toml");
        std::fs::write(&file, &text).unwrap();
        let optimized = gearwise_in(&to, &["optimize", "saved.toml", "--json"]);
        assert!(optimized.status.code().is_some_and(|code| code < 2), "{}", stderr(&optimized));
        let answer: Value = serde_json::from_slice(&optimized.stdout).unwrap();
        assert_eq!(shown, chosen(&answer), "{name} with {state}");
        // Comments stay.
        let own = std::fs::read_to_string(repository("requirements").join(format!("{name}.toml"))).unwrap();
        let first = own.lines().find(|line| line.starts_with('#')).unwrap();
        assert!(text.contains(first), "{name}: {first}");
    }
}

#[test]
fn an_answer_that_was_kept_is_of_the_state_that_is_asked() {
    let served = Served::shipped("quadruped_mini_cheetah");
    let mut number = 0;
    let mut asked = |joint: &str, state: Value| {
        number += 1;
        choices(&served.ask(&json!({ "tab": "t", "ask": number, "state": state, "joint": joint })))
    };
    let plain = asked("knee", json!({}));
    let states = [
        json!({ "bus.voltage": "48 V" }),
        json!({ "joint.knee.limits.actuator_mass": "0.4 kg" }),
        json!({ "joint.hip.ratio.max": "10" }),
    ];
    let first: Vec<_> = states.iter().map(|state| asked("knee", state.clone())).collect();
    assert!(first.iter().all(|other| *other != plain), "each state changes something");
    // Seen from another joint, in another order, and after others: the same.
    let again: Vec<_> = states.iter().rev().map(|state| asked("hip", state.clone())).collect();
    assert_eq!(first, again.into_iter().rev().collect::<Vec<_>>());
    assert_eq!(plain, asked("hip_abad", json!({})));
}

#[test]
fn a_page_is_answered_only_where_it_comes_from() {
    let served = Served::shipped("exoskeleton_hip");
    let Served { port, token, .. } = &served;
    let (status, head, page) = served.get("");
    assert_eq!(status, 200);
    let policy = head.lines().find_map(|line| line.strip_prefix("Content-Security-Policy: ")).expect("a policy");
    assert!(
        policy.starts_with("default-src 'none';")
            && policy.contains("connect-src 'self'")
            && policy.ends_with("frame-ancestors 'none'"),
        "{policy}"
    );
    for wanted in [
        "Cache-Control: no-store",
        "X-Content-Type-Options: nosniff",
        "Referrer-Policy: no-referrer",
        "Cross-Origin-Resource-Policy: same-origin",
    ] {
        assert!(head.contains(wanted), "{wanted}: {head}");
    }
    // The secret is in the address alone.
    assert!(!page.contains(token));
    let get = |path: &str, more: &str| {
        let host = if more.contains("Host:") { String::new() } else { format!("Host: 127.0.0.1:{port}\r\n") };
        served.raw(format!("GET {path} HTTP/1.1\r\n{host}{more}Connection: close\r\n\r\n").as_bytes()).0
    };
    let here = format!("/{token}/");
    assert_eq!(get(&here, ""), 200);
    assert_eq!(get(&here, &format!("Host: localhost:{port}\r\n")), 200);
    for more in [
        "Host: evil.example\r\n",
        "Host: 127.0.0.1\r\n",
        "Origin: http://evil.example\r\n",
        "Origin: null\r\n",
        "Sec-Fetch-Site: cross-site\r\n",
    ] {
        assert_eq!(get(&here, more), 403, "{more}");
    }
    let other = token.chars().rev().collect::<String>();
    for path in [
        "/",
        "/ask",
        &format!("/{token}"),
        &format!("/{other}/"),
        &format!("/{token}/../"),
        &format!("/{token}/%2e%2e/"),
        &format!("/{token}/?a"),
        &format!("{here}nothing"),
    ] {
        assert_eq!(get(path, ""), 404, "{path}");
    }
    let post = |kind: &str, length: &str| {
        let head =
            format!("POST {here}ask HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{kind}{length}Connection: close\r\n\r\n{{}}");
        served.raw(head.as_bytes()).0
    };
    assert_eq!(post("Content-Type: text/plain\r\n", "Content-Length: 2\r\n"), 415);
    assert_eq!(post("Content-Type: application/json\r\n", ""), 411);
    assert_eq!(post("Content-Type: application/json\r\n", "Content-Length: 70000\r\n"), 413);
    assert_eq!(post("Content-Type: application/json\r\n", "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n"), 400);
    // It still answers.
    assert_eq!(get(&here, ""), 200);
}

#[test]
fn what_is_no_question_is_refused_in_words() {
    let served = Served::shipped("exoskeleton_hip");
    let refused = |body: &str| {
        let (status, _, text) = served.post("ask", body);
        assert_eq!(status, 400, "{body}: {text}");
        assert!(!text.is_empty() && text.len() < 300, "{text}");
    };
    let many: serde_json::Map<String, Value> = (0..65).map(|k| (format!("a.b{k}"), "1".into())).collect();
    let long = "x".repeat(2000);
    for body in [
        "".to_string(),
        "[]".into(),
        "{".into(),
        "\u{0}".into(),
        r#"{"tab":"a","ask":-1}"#.into(),
        r#"{"tab":"a","ask":1,"no_such":1}"#.into(),
        r#"{"tab":"a","ask":1,"state":{"bus.voltage":36}}"#.into(),
        json!({ "tab": "a", "ask": 1, "state": many }).to_string(),
        json!({ "tab": "a", "ask": 1, "state": { "bus.voltage": long } }).to_string(),
        json!({ "tab": long, "ask": 1 }).to_string(),
        json!({ "tab": "a", "ask": 1, "pins": ["", "", ""] }).to_string(),
        "[".repeat(50_000),
    ] {
        refused(&body);
    }
    // What is asked of a question that nobody knows has no answer.
    assert_eq!(served.post("more", r#"{"tab":"z","ask":1,"have":0}"#).0, 204);
}

#[test]
fn each_mistake_stands_at_its_key_and_a_link_applies_what_is_good() {
    let served = Served::shipped("quadruped_mini_cheetah");
    let problems = |state: &Value, lenient: bool| {
        let replies = served.ask(&json!({ "tab": "t", "ask": 1, "state": state, "lenient": lenient }));
        let all = replies[0]["problems"].as_array().unwrap().clone();
        let keys: Vec<String> = all.iter().map(|p| p["key"].as_str().unwrap().to_string()).collect();
        (keys, replies, all)
    };
    let state = json!({ "bus.voltage": "36 X", "no.such_key": "1", "scale.torque": "1.1", "joint.knee.limits.safety": "-1", "scale.speed": "nan" });
    let (mut keys, replies, _) = problems(&state, false);
    keys.sort();
    keys.dedup();
    assert_eq!(keys, ["bus.voltage", "joint.knee.limits.safety", "no.such_key", "scale.speed"]);
    assert!(replies.len() == 1 && replies[0].get("views").is_none(), "nothing is answered: {replies:?}");
    let (mut keys, replies, _) = problems(&state, true);
    keys.sort();
    keys.dedup();
    assert_eq!(keys, ["bus.voltage", "joint.knee.limits.safety", "no.such_key", "scale.speed"]);
    assert_eq!(replies[0]["state"], json!({ "scale.torque": "1.1" }));
    assert_eq!(choices(&replies).len(), 3);
    // Two values that go together only.
    let (keys, replies, all) = problems(&json!({ "joint.knee.ratio.max": "60", "joint.knee.ratio.min": "40" }), true);
    assert!(keys.is_empty(), "{all:?}");
    assert_eq!(replies[0]["state"].as_object().unwrap().len(), 2);
    let (_, replies, all) = problems(&json!({}), true);
    assert!(all.is_empty() && replies[0]["joint"] == "hip_abad");
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn a_state_names_no_files() {
    let secret = tempfile::tempdir().unwrap();
    let file = secret.path().join("secret.csv");
    std::fs::write(&file, "the secret of this file\n").unwrap();
    let path = file.to_str().unwrap();
    let text = |value: &str| toml::Value::String(value.into()).to_string();
    for (name, key, value) in [
        ("quadruped_mini_cheetah", "joint.knee.motion", text(path)),
        ("quadruped_mini_cheetah", "joint.knee", format!("{{ name = \"knee\", motion = {} }}", text(path))),
        ("quadruped_mini_cheetah", "rules", text(path)),
        ("quadruped_mini_cheetah", "joint.knee.transmission", format!("{{ table = {} }}", text(path))),
        ("arm_from_its_description", "mechanism.model", text(path)),
        ("arm_from_its_description", "mechanism.trajectory", text(path)),
        (
            "quadruped_trot_and_jump",
            "joint.knee.case",
            format!("[{{ name = \"a\", share = 1.0, motion = {} }}]", text(path)),
        ),
    ] {
        let served = Served::shipped(name);
        for lenient in [false, true] {
            let ask = json!({ "tab": "t", "ask": 1, "state": { key: value }, "lenient": lenient, "joint": "knee" });
            let replies = served.ask(&ask);
            let said = Value::from(replies.clone()).to_string();
            assert!(!said.contains("the secret of"), "{name}: {key}");
            assert!(!replies[0]["problems"].as_array().unwrap().is_empty(), "{name}: {key} is taken: {said:.300}");
            for path in ["toml", "report", "fronts"] {
                let (status, _, body) =
                    served.post(path, &json!({ "tab": "t", "ask": 2, "state": { key: value } }).to_string());
                assert!(
                    status == 200 && body.contains("problems") && !body.contains("the secret of"),
                    "{path}: {body:.300}"
                );
            }
        }
    }
}

#[test]
fn a_newer_question_of_a_page_makes_the_older_one_stale_and_no_other_page_s() {
    let served = Served::shipped("ankle_prosthesis_parallel_spring");
    let ask = |tab: &str, number: u64, torque: &str| json!({ "tab": tab, "ask": number, "state": { "scale.torque": torque } });
    let far = |answer: &(u16, String, String)| serde_json::from_str::<Value>(&answer.2).unwrap();
    let first = served.post("ask", &ask("a", 1, "1.01").to_string());
    assert!(far(&first)["far"].is_array(), "a spring takes longer than a moment: {first:?}");
    let other = served.post("ask", &ask("b", 1, "1.02").to_string());
    assert!(far(&other)["pending"] == true);
    let second = served.ask(&ask("a", 2, "1.03"));
    assert!(choices(&second).iter().all(|(_, motor, _)| !motor.is_empty()), "{second:?}");
    assert_eq!(served.post("more", r#"{"tab":"a","ask":1,"have":0}"#).0, 204, "the older one is gone");
    let other = served.ask(&ask("b", 2, "1.02"));
    assert_eq!(choices(&other).len(), 1);
}

#[test]
fn names_of_files_cannot_make_the_page_do_anything() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "</script><img src=x onerror=alert(1)>";
    let text = format!(
        "name = '{hostile}'\n[bus]\nvoltage = \"24 V\"\n[[joint]]\nname = '{hostile}'\nratio = {{ min = 3, max = 20 }}\n\
         gear = {{ efficiency = 0.9, mass = \"100 g\", inertia = \"1e-6 kg*m^2\" }}\n\
         points = [{{ torque = \"1 N*m\", speed = \"2 rad/s\", duration = \"1 s\" }}]\nobjective = \"loss\"\n"
    );
    std::fs::write(folder.path().join("r.toml"), text).unwrap();
    let served = Served::start(folder.path(), &["r.toml"]);
    let (_, _, page) = served.get("");
    assert!(!page.contains("<img") && page.contains("\\u003cimg"), "the page has it escaped");
    let replies = served.ask(&json!({ "tab": "t", "ask": 1 }));
    for reply in &replies {
        for (name, view) in reply["views"].as_object().into_iter().flatten() {
            let html = view["html"].as_str().unwrap();
            assert!(!html.contains("<img") && !html.contains("<script"), "{name}");
        }
    }
    assert!(replies[0]["views"]["headline"]["html"].as_str().unwrap().contains("Take "));
    // A key that has a name of a joint with points and quotes in it still is a key or is refused at its place.
    let key = format!("joint.{hostile}.limits.safety");
    let replies = served.ask(&json!({ "tab": "t", "ask": 2, "state": { &key: "1.5" } }));
    assert!(
        replies[0]["problems"].as_array().unwrap().iter().all(|p| p["key"] == key.as_str()),
        "{:?}",
        replies[0]["problems"]
    );
}

#[test]
fn the_report_of_a_state_is_that_of_optimize() {
    let served = Served::shipped("exoskeleton_hip");
    assert_eq!(served.get("report").0, 404, "none was made");
    let ask = json!({ "tab": "t", "ask": 1, "state": { "scale.torque": "1.1", "ambient.temperature": "40 degC" } });
    let (status, _, name) = served.post("report", &ask.to_string());
    assert!(status == 200 && name.starts_with("report"), "{name}");
    // Of two pages each gets its own.
    let other = served.post("report", &json!({ "tab": "u", "ask": 1 }).to_string()).2;
    assert_ne!(name, other);
    assert!(!served.get(&other).2.contains("--set"));
    let (status, _, report) = served.get(&name);
    assert_eq!(status, 200);
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let set = ["--set", "ambient.temperature=40 degC", "--set", "scale.torque=1.1"];
    let path = ["optimize", "requirements/exoskeleton_hip.toml", "--html", page.to_str().unwrap()];
    let made = gearwise(&[&path[..2], &set[..], &path[2..]].concat());
    assert!(made.status.code().is_some_and(|code| code < 2), "{}", stderr(&made));
    assert_eq!(report, std::fs::read_to_string(&page).unwrap());
}

#[test]
#[cfg(unix)]
fn ctrl_c_and_what_kill_sends_end_it() {
    for signal in ["-INT", "-TERM"] {
        let mut served = Served::shipped("ankle_prosthesis_parallel_spring");
        // While it is asked.
        assert_eq!(served.post("ask", r#"{"tab":"a","ask":1}"#).0, 200);
        let id = served.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
        let began = Instant::now();
        let status = loop {
            if let Some(status) = served.child.try_wait().unwrap() {
                break status;
            }
            assert!(began.elapsed() < Duration::from_secs(20), "it goes on");
            std::thread::sleep(Duration::from_millis(20));
        };
        assert_eq!(status.code(), Some(0), "{signal}");
        assert!(TcpStream::connect(("127.0.0.1", served.port)).is_err());
    }
}

/// Pages that nobody speaks for any more make no work: of more pages than are known the oldest ones' questions end.
#[test]
fn questions_of_pages_that_are_forgotten_are_stopped() {
    let source = Source::read(&repository("requirements/ankle_prosthesis_parallel_spring.toml")).unwrap();
    let rows = Rows::new(Catalog::builtin().unwrap(), true, false);
    let ground = Ground { source, begin: BTreeMap::new(), rows, words: Vec::new() };
    let explorer = Explorer::new(ground, |words| words.join(" ")).unwrap();
    let ask = |tab: usize| {
        let body = json!({ "tab": format!("tab {tab}"), "ask": 1, "state": { "scale.torque": "1.01" } }).to_string();
        explorer.begin(&body, Box::new(|| ())).unwrap()
    };
    let works: Vec<_> = (0..100).map(ask).collect();
    let going: Vec<usize> = (0..100).filter(|k| !works[*k].course.is_stopped()).collect();
    assert_eq!(going, (36..100).collect::<Vec<_>>());
    // One that was stopped before its turn came is not begun.
    explorer.run(&works[0]);
    assert_eq!((works[0].next(0), works[0].course.far().1), (Next::Nothing, 0));
}

/// However many pages ask, a process has no thread for each.
#[test]
#[cfg(target_os = "linux")]
fn many_pages_take_no_thread_each() {
    let served = Served::shipped("ankle_prosthesis_parallel_spring");
    for tab in 0..80 {
        let ask = json!({ "tab": format!("tab {tab}"), "ask": 1, "state": { "scale.torque": format!("1.{tab:02}") } });
        assert_eq!(served.post("ask", &ask.to_string()).0, 200);
    }
    let threads = std::fs::read_dir(format!("/proc/{}/task", served.child.id())).unwrap().count();
    let cores = std::thread::available_parallelism().unwrap().get();
    // The two pools, the connections that are open, and the one that listens.
    assert!(threads <= 2 * cores + 16 + 2, "{threads} threads");
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn a_page_without_a_program_has_every_answer_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let file = "requirements/quadruped_mini_cheetah.toml";
    let grid = ["--grid", "bus.voltage=24 V,48 V", "--grid", "scale.torque=1,1.25"];
    let made = |path: &str, threads: &str| {
        let output = gearwise(&[&["explore", file, "--static", path, "--threads", threads][..], &grid[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(stdout(&output).contains("bus.voltage (2), scale.torque (2)"), "{}", stdout(&output));
        std::fs::read_to_string(path).unwrap()
    };
    let page = made(&at("a.html"), "1");
    assert_eq!(page, made(&at("b.html"), "2"), "the same for any number of threads");
    assert!(!page.contains("connect-src") && page.contains("default-src 'none'"));
    let data = page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    let answers = data["explore"]["grid"]["answers"].as_object().unwrap();
    assert_eq!(answers.len(), 2 * 2 * 3);
    let set = gearwise(&["optimize", file, "--json", "--set", "bus.voltage=48 V", "--set", "scale.torque=1.25"]);
    for (joint, motor, ratio) in chosen(&serde_json::from_slice(&set.stdout).unwrap()) {
        let answer = answers[&format!("1,1|{joint}")]["joints"]
            .as_array()
            .unwrap()
            .iter()
            .find(|j| j["joint"] == joint.as_str())
            .unwrap();
        assert_eq!((answer["motor"].as_str().unwrap(), &answer["ratio"]), (motor.as_str(), &ratio));
    }
}

#[test]
fn a_wrong_call_is_told_before_anything_is_done() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("p.html");
    let page = page.to_str().unwrap();
    let file = "requirements/exoskeleton_hip.toml";
    for (arguments, said) in [
        (vec!["explore", "no_such.toml"], "no_such.toml"),
        (vec!["explore", file, "--state", "bus.voltage"], "no KEY=VALUE"),
        (vec!["explore", file, "--state", "a=%zz"], "%"),
        (vec!["explore", file, "--grid", "bus.voltage=24 V,36 V"], "--static"),
        (vec!["explore", file, "--static", "p.txt"], ".html"),
        (vec!["explore", file, "--static", page, "--grid", "bus.voltage=24 V"], "two values"),
        (vec!["explore", file, "--static", page, "--grid", "bus.voltage=24 V,36 X"], "unknown unit"),
        (vec!["explore", file, "--static", page, "--grid", "no.such=1,2"], "no.such"),
        (vec!["explore", "requirements/studies/quadruped.toml"], "is a study"),
    ] {
        let output = gearwise(&arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stdout(&output));
        assert!(stderr(&output).contains(said), "{arguments:?}: {}", stderr(&output));
        assert!(!Path::new(page).exists());
    }
    let many: Vec<String> = (1..=500).map(|k| format!("{k} V")).collect();
    let grid = format!("bus.voltage={}", many.join(","));
    let output = gearwise(&["explore", file, "--static", page, "--grid", &grid]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("400 answers at most"), "{}", stderr(&output));
}

#[test]
fn a_stale_question_solves_no_more_motors() {
    let source = Source::read(&repository("requirements/ankle_prosthesis_parallel_spring.toml")).unwrap();
    let rows = Rows::new(Catalog::builtin().unwrap(), true, false);
    let ground = Ground { source, begin: BTreeMap::new(), rows, words: Vec::new() };
    let explorer = Explorer::new(ground, |words| words.join(" ")).unwrap();
    let ask = |number: u64, torque: &str| {
        let body = json!({ "tab": "a", "ask": number, "state": { "scale.torque": torque } }).to_string();
        explorer.begin(&body, Box::new(|| ())).unwrap()
    };
    let first = ask(1, "1.01");
    let (done, of) = std::thread::scope(|scope| {
        let running = scope.spawn(|| explorer.run(&first));
        while first.course.far().0 == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        let second = ask(2, "1.02");
        running.join().unwrap();
        assert!(!second.course.is_stopped());
        first.course.far()
    });
    assert!(of > 100 && done < of / 2, "{done} of {of}");
    assert_eq!(first.next(0), Next::Nothing);
    // Of another page nothing is stopped, and what was stopped left nothing behind: asked again it is found.
    let again = ask(3, "1.01");
    explorer.run(&again);
    assert!(matches!(again.next(0), Next::Reply(reply) if reply.contains("Take ")));
}

/// The text of a part of a reply, without its markup.
fn text_of(reply: &Value, view: &str) -> String {
    let html = reply["views"][view]["html"].as_str().unwrap_or_default();
    let mut out = String::new();
    for part in html.split('<') {
        out.push_str(part.split_once('>').map_or(part, |(_, text)| text));
        out.push(' ');
    }
    out.replace("&quot;", "\"").replace("&amp;", "&")
}

#[test]
fn proved_is_said_of_what_is_proved_alone() {
    let served = Served::shipped("exoskeleton_hip");
    let mut number = 0;
    let mut headline = |state: Value| {
        number += 1;
        let replies = served.ask(&json!({ "tab": "t", "ask": number, "state": state }));
        text_of(&replies[0], "headline")
    };
    assert!(headline(json!({})).contains("; proved to be the best ratio of this motor."));
    // A better ratio of this one cannot be judged.
    let not = headline(json!({ "joint.hip.motors": "[\"maxon-ec-i-40-496660\"]" }));
    assert!(not.contains("; not proved to be the best ratio of this motor.") && !not.contains("; proved"), "{not}");
    // What none can do is not said where some cannot be judged.
    let none = headline(json!({ "scale.torque": "30" }));
    assert!(!none.contains("Take ") && none.contains("can be judged"), "{none}");
}

#[test]
fn what_the_file_chooses_is_said_as_far_as_it_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(repository("requirements/quadruped_mini_cheetah.toml")).unwrap();
    let text = text
        .replace("voltage = \"24 V\"", "voltage = \"3 V\"")
        .replace("motions/", &format!("{}/", repository("requirements/motions").display()));
    std::fs::write(folder.path().join("low.toml"), text).unwrap();
    let served = Served::start(folder.path(), &["low.toml"]);
    let replies = served.ask(&json!({ "tab": "t", "ask": 1, "joint": "knee", "state": { "bus.voltage": "24 V" } }));
    let said = replies.iter().map(|reply| text_of(reply, "headline")).rfind(|text| !text.trim().is_empty()).unwrap();
    assert!(said.contains("By the file as it is: none that can be judged can do it"), "{said}");
    assert!(said.contains("Take "), "{said}");
}

#[test]
fn a_design_that_exceeds_a_limit_keeps_nothing_and_says_what_it_would_take() {
    let served = Served::shipped("quadruped_mini_cheetah");
    let mut number = 0;
    let mut looked = |design: &str, voltage: &str| {
        number += 1;
        let ask = json!({ "tab": "t", "ask": number, "joint": "knee", "design": design, "state": { "bus.voltage": voltage } });
        let reply = served.ask(&ask).remove(0);
        assert_eq!(reply["problems"], json!([]), "{reply:.300}");
        (reply["design"].clone(), text_of(&reply, "design"))
    };
    // The voltage that it is told to need is in the requirement's terms, and is enough.
    let (design, text) = looked("t-motor-ri50@14", "24 V");
    assert_eq!((&design["feasible"], &design["choice"]), (&json!(false), &json!(false)));
    assert!(text.contains("is not feasible") && !text.contains("keeps every limit"), "{text:.400}");
    let needed: Vec<f64> = text
        .match_indices(": a bus of ")
        .map(|(at, mark)| text[at + mark.len()..].split(' ').next().unwrap().parse().unwrap())
        .collect();
    let most = needed.iter().copied().fold(0.0, f64::max);
    assert!(most > 24.0, "{text:.600}");
    let over = |text: &str| {
        text.contains("What is exceeded") && text.split("torque over speed").next().unwrap().contains(": a bus of ")
    };
    assert!(!over(&looked("t-motor-ri50@14", &format!("{most} V")).1), "{most} V is enough");
    assert!(over(&looked("t-motor-ri50@14", &format!("{} V", 0.99 * most)).1), "{} V is not", 0.99 * most);
    // A ratio outside of what the requirement allows is no choice, whatever it keeps.
    let (design, text) = looked("tq-robodrive-ilm-e70x18-delta-serial@21", "48 V");
    assert_eq!(design["choice"], json!(false), "{text:.300}");
    assert!(text.contains("outside of the ratios that the requirement allows"), "{text:.300}");
}

#[test]
fn a_design_pinned_twice_has_no_difference() {
    let served = Served::shipped("quadruped_mini_cheetah");
    let pin = "joint=knee&design=tq-robodrive-ilm-e70x18-delta-serial%4013";
    let cells = |pins: [&str; 2]| {
        let replies = served.ask(&json!({ "tab": "t", "ask": 1, "pins": pins }));
        let html = replies[0]["views"]["pins"]["html"].as_str().unwrap().to_string();
        let rows = html.split("<tr>").skip(2).map(|row| {
            row.split("<td")
                .skip(1)
                .map(|cell| cell.split_once('>').unwrap().1.split('<').next().unwrap().trim().to_string())
                .collect::<Vec<_>>()
        });
        rows.collect::<Vec<_>>()
    };
    let same = cells([pin, pin]);
    assert!(same.len() > 15, "{same:?}");
    for row in &same {
        assert_eq!(row[2], row[3], "{row:?}");
        assert!(["0", "–"].contains(&row[4].as_str()), "{row:?}");
    }
    // Amperes of two kinds have one name.
    assert_eq!(same.iter().filter(|row| row[0] == "current, rms").count(), 2);
    let other = cells([pin, "joint=knee&design=tq-robodrive-ilm-e70x18-delta-serial%4012"]);
    assert!(other.iter().any(|row| row[4].contains('%')), "{other:?}");
    // One that cannot be read leaves the other its name.
    let replies = served.ask(&json!({ "tab": "t", "ask": 2, "pins": ["joint=knee&design=nomotor", pin] }));
    assert!(text_of(&replies[0], "pins").contains("B: At knee") && replies[0]["problems"][0]["key"] == "pin");
}

#[test]
fn the_joints_stay_those_of_the_file() {
    let served = Served::shipped("quadruped_mini_cheetah");
    for (key, value) in
        [("joint", "[]"), ("joint.knee.name", "hip2"), ("joint.knee", "{ name = \"knee\" }"), ("joint.*.name", "x")]
    {
        for (path, status) in [("ask", 200), ("toml", 200), ("fronts", 200), ("report", 200)] {
            let ask = json!({ "tab": "t", "ask": 1, "state": { key: value } });
            let (got, _, body) = served.post(path, &ask.to_string());
            assert_eq!(got, status, "{key} {path}: {body:.300}");
            assert!(body.contains("problems") && !body.contains("views"), "{key} {path}: {body:.300}");
        }
    }
}

#[test]
fn what_the_call_sets_is_the_state_that_is_begun_with() {
    let file = "requirements/quadruped_mini_cheetah.toml";
    let served = Served::start(&repository(""), &[file, "--set", "scale.torque=1.4", "--set", "bus.voltage=30 V"]);
    let (_, _, page) = served.get("");
    assert!(page.contains("\"link\":\"bus.voltage=30%20V\\u0026scale.torque=1.4\""), "the link is in the page");
    // The file is the file.
    let replies = served.ask(&json!({ "tab": "t", "ask": 1 }));
    let plain = gearwise(&["optimize", file, "--json"]);
    assert_eq!(choices(&replies), chosen(&serde_json::from_slice(&plain.stdout).unwrap()));
    let voltage = replies[0]["controls"].as_array().unwrap().iter().find(|c| c["key"] == "bus.voltage").unwrap();
    assert_eq!(voltage["file"], 24.0);
    let wrong = gearwise(&["explore", file, "--set", "bus.voltage=30 V", "--state", "bus.voltage=31%20V"]);
    assert!(
        wrong.status.code() == Some(2) && stderr(&wrong).contains("by `--set` and by `--state`"),
        "{}",
        stderr(&wrong)
    );
    let wrong = gearwise(&["explore", file, "--set", "bus.voltage=30 X"]);
    assert!(wrong.status.code() == Some(2) && stderr(&wrong).contains("unknown unit"), "{}", stderr(&wrong));
}

#[test]
fn grids_that_say_a_thing_twice_or_too_much_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("p.html");
    let page = page.to_str().unwrap();
    let file = "requirements/exoskeleton_hip.toml";
    let said = |more: &[String]| {
        let base = ["explore", file, "--static", page].map(str::to_string);
        let all: Vec<String> = base.into_iter().chain(more.iter().cloned()).collect();
        let output = gearwise(&all.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        stderr(&output)
    };
    let grid = |text: &str| ["--grid".to_string(), text.to_string()];
    assert!(
        said(&[grid("bus.voltage=24 V,36 V"), grid("bus.voltage=30 V,40 V")].concat()).contains("has values already")
    );
    assert!(
        said(&[&grid("bus.voltage=24 V,36 V")[..], &["--set".into(), "bus.voltage=30 V".into()]].concat())
            .contains("`--set` gives")
    );
    let many: Vec<String> = (0..64).flat_map(|k| grid(&format!("a{k}=1,2"))).collect();
    assert!(said(&many).contains("More points than can be counted"));
}

#[test]
fn what_would_not_help_is_not_advised() {
    let served = Served::shipped("quadruped_mini_cheetah");
    let looked = |state: Value, design: &str| {
        let ask = json!({ "tab": "t", "ask": 1, "joint": "knee", "design": design, "state": state });
        let reply = served.ask(&ask).remove(0);
        assert_eq!(reply["problems"], json!([]), "{reply:.300}");
        text_of(&reply, "design")
    };
    // What a drive gives for long is another number than what it gives at once.
    let text = looked(json!({ "bus.drive_continuous_current": "6 A" }), "allied-mf0127008-48v");
    let advice = |limit: &str| {
        let from = text.find(&format!("{limit} of at least")).unwrap_or_else(|| panic!("{limit}: {text:.900}"));
        text[from..].split("  ").next().unwrap().to_string()
    };
    assert!(!advice("drive_continuous_current").contains(": a drive of"), "{text:.900}");
    // A bus that may not rise so far is told with what it may.
    let text = looked(json!({ "bus.max_voltage": "25 V" }), "t-motor-ri50@14");
    assert!(text.contains(": a bus of ") && text.contains(", more than its max_voltage of 25 V"), "{text:.900}");
}

#[test]
fn a_mistake_of_several_values_is_told_at_one_of_them() {
    let served = Served::shipped("quadruped_mini_cheetah");
    let state = json!({ "joint.hip_abad.ratio.min": "118", "scale.torque": "1.1" });
    let replies = served.ask(&json!({ "tab": "t", "ask": 1, "state": state }));
    let keys: Vec<&str> =
        replies[0]["problems"].as_array().unwrap().iter().map(|p| p["key"].as_str().unwrap()).collect();
    assert_eq!(keys, ["joint.hip_abad.ratio.min"]);
}

#[test]
fn values_of_the_same_thing_have_no_order() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("p.html");
    let page = page.to_str().unwrap();
    let file = "requirements/quadruped_knee_linkage.toml";
    let (one, all) = ("joint.knee.limits.actuator_mass=0.4 kg", "joint.*.limits.actuator_mass=0.6 kg");
    let output = gearwise(&["explore", file, "--set", one, "--set", all]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("set the same value"), "{}", stderr(&output));
    let grid =
        ["explore", file, "--static", page, "--set", one, "--grid", "joint.*.limits.actuator_mass=0.5 kg,0.7 kg"];
    let output = gearwise(&grid);
    assert!(
        output.status.code() == Some(2) && stderr(&output).contains("`--set` gives this key"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn what_the_whole_robot_may_draw_is_said_not_to_be_looked_at() {
    let served = Served::shipped("quadruped_mini_cheetah");
    let whole = |number: u64, state: Value| {
        let replies = served.ask(&json!({ "tab": "t", "ask": number, "state": state }));
        (text_of(replies.last().unwrap(), "whole"), replies[0]["notes"].as_array().unwrap().len())
    };
    let (text, notes) = whole(1, json!({}));
    assert!(
        text.contains("each joint by itself: actuator mass") && !text.contains("not looked at") && notes == 0,
        "{text}"
    );
    let (text, notes) = whole(2, json!({ "budget.power": "100 W", "budget.actuator_mass": "5 kg" }));
    assert!(text.contains("OVER the budget of 5 kg") && text.contains("is not looked at here") && notes == 1, "{text}");
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn a_motor_that_needs_a_spring_is_looked_at_with_one() {
    let served = Served::shipped("ankle_prosthesis_parallel_spring");
    let spring = "{ stiffness = [\"50 N*m/rad\", \"400 N*m/rad\"], rest_angle = [\"-30 deg\", \"30 deg\"] }";
    let ask = json!({ "tab": "t", "ask": 1, "design": "allied-ht03000-a00", "state": { "joint.ankle.limits.spring": spring } });
    let text = text_of(&served.ask(&ask)[0], "design");
    assert!(
        text.contains("No spring will do") && text.contains("with the allowed spring that came nearest"),
        "{text:.600}"
    );
    assert!(text.contains("is not feasible"), "{text:.300}");
}
