//! What a page sends to `explore`: the head of a request, and a question.

use std::sync::{Arc, OnceLock};

use gearwise::ask::Rows;
use gearwise::catalog::Catalog;
use gearwise::cli::explore_http_head as head;
use gearwise::explore::state::Ask;
use gearwise::explore::work::Next;
use gearwise::explore::{Explorer, Ground};
use gearwise::input::Source;

/// What the inputs of the corpus are sent to.
const PORT: u16 = 4321;
const TOKEN: &str = "s3cret";

/// Any bytes as the first of a connection, whole and up to every place where a line may end.
pub fn http(bytes: &[u8]) {
    let whole = head(bytes, PORT, TOKEN);
    match &whole {
        Ok(Some(head)) => {
            assert!(head.size <= bytes.len().min(16 * 1024), "{} of {} bytes", head.size, bytes.len());
            assert!(head.length <= 64 * 1024, "a body of {} bytes", head.length);
            assert!(head.path.bytes().all(|b| b.is_ascii_lowercase()), "{:?}", head.path);
            // A head is over at the end of its empty line, and what follows changes nothing.
            assert!(bytes[..head.size].ends_with(b"\r\n\r\n"));
            assert_eq!(whole, self::head(&bytes[..head.size], PORT, TOKEN));
        }
        Ok(None) => assert!(bytes.len() < 16 * 1024, "more than 16 KiB and no verdict"),
        Err(refused) => assert!((400..=505).contains(&refused.status) && !refused.why.is_empty(), "{refused:?}"),
    }
    // What the first bytes decide is not decided otherwise by more.
    let ends = bytes.iter().enumerate().filter(|(_, b)| matches!(b, b'\n' | b' ' | b':')).map(|(at, _)| at);
    for end in ends.take(200) {
        let piece = head(&bytes[..end], PORT, TOKEN);
        assert!(piece == Ok(None) || piece == whole, "{piece:?} of {end} bytes, then {whole:?}");
    }
}

/// The requirement that questions are about: small, so that an answer takes little.
const REQUIREMENT: &str = "name = \"r\"\n[bus]\nvoltage = \"24 V\"\ndrive_current = \"40 A\"\n[ambient]\ntemperature = \"25 degC\"\n\
    [[joint]]\nname = \"knee\"\nratio = { min = 3, max = 20 }\ngear = { efficiency = 0.9, mass = \"150 g\", inertia = \"2e-6 kg*m^2\" }\n\
    points = [{ torque = \"5 N*m\", speed = \"1 rad/s\", duration = \"0.1 s\" }, { torque = \"1 N*m\", speed = \"8 rad/s\", duration = \"0.1 s\" }]\n\
    objective = \"loss\"\n[joint.limits]\nsafety = 1.2\n\
    [[joint]]\nname = \"hip\"\nratio = { min = 3, max = 9 }\ngear = { efficiency = 0.95, mass = \"150 g\", inertia = \"2e-6 kg*m^2\" }\n\
    points = [{ torque = \"2 N*m\", speed = \"3 rad/s\", duration = \"0.1 s\" }]\nobjective = \"mass\"\n";

fn explorer() -> &'static Explorer {
    static EXPLORER: OnceLock<Explorer> = OnceLock::new();
    EXPLORER.get_or_init(|| {
        let mut catalog = Catalog::builtin().expect("it is shipped");
        catalog.motors.truncate(4);
        catalog.modules.truncate(2);
        let source = Arc::new(Source::new("r.toml", REQUIREMENT));
        let rows = Rows::new(catalog, true, false);
        let ground = Ground { source, begin: Default::default(), rows, words: Vec::new() };
        Explorer::new(ground, |words| words.join(" ")).unwrap_or_else(|why| panic!("{why:?}"))
    })
}

/// Any bytes as a question, and as a link.
pub fn ask(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = Ask::of_link(text);
    let explorer = explorer();
    let Ok(work) = explorer.begin(text, Box::new(|| ())) else { return };
    explorer.run(&work);
    for have in 0.. {
        match work.next(have) {
            Next::Reply(reply) => {
                let reply: serde_json::Value = serde_json::from_str(&reply).expect("a reply is JSON");
                assert_eq!(reply["ask"], work.ask.ask);
                // Numbers that are none have no place in JSON.
                assert!(reply["joints"].as_array().into_iter().flatten().all(|joint| joint["joint"].is_string()));
            }
            Next::Broken(what) => panic!("{what}"),
            Next::Pending(..) | Next::Nothing => break,
        }
    }
    // What is saved is read again as it is.
    if let Ok(saved) = explorer.toml(text) {
        let read = gearwise::requirement::read_source(&Arc::new(Source::new("saved.toml", saved.clone())));
        assert!(read.is_ok(), "{saved}\n{read:?}");
    }
}
