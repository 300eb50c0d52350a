//! The state of the page: what is put in the place of a requirement's own values, and what is looked at.
//!
//! The one idea: a state is text, `KEY=VALUE&KEY=VALUE`, with the keys of `--set`, so that a link is a call of the program and the
//! other way round. What only says what is looked at (`joint`, `design`) has names without a point.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::requirement::Settings;

/// Most values that a state sets, and the longest that a key or a value may be, in bytes.
const MOST: (usize, usize) = (64, 1000);

/// What is asked.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ask {
    /// Which page asks: a newer question of the same page stops the older one.
    pub tab: String,
    /// The number of the question; larger is newer.
    pub ask: u64,
    /// What is set: keys of a requirement, values as in its file.
    pub state: BTreeMap<String, String>,
    /// The joint that is viewed; empty for the first.
    pub joint: String,
    /// The design that is looked at, as `explain` names it; empty for the first choice.
    pub design: String,
    /// States whose designs are compared, as texts.
    pub pins: Vec<String>,
    /// Whether only the design is asked for: what is said of the joint is there already.
    pub design_only: bool,
    /// Whether what is wrong is left out, as of a link.
    pub lenient: bool,
}

/// What is wrong with a question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// The key that it is about; empty where it is none.
    pub key: String,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl Wrong {
    /// Of a key.
    pub fn of(key: &str, message: impl Into<String>) -> Wrong {
        Wrong { key: key.into(), message: message.into(), help: String::new() }
    }
}

impl Ask {
    /// Reads a question of the page.
    ///
    /// # Errors
    /// In words.
    pub fn read(body: &str) -> Result<Ask, String> {
        // A list could stand for an object.
        if !body.trim_start().starts_with('{') {
            return Err("the question is not understood: it is no object".into());
        }
        let ask: Ask = serde_json::from_str(body).map_err(|why| format!("the question is not understood: {why}"))?;
        if ask.tab.len() > 64 || ask.pins.len() > 2 || ask.pins.iter().any(|pin| pin.len() > 16 * MOST.1) {
            return Err("the question is too long".into());
        }
        check(&ask.state)?;
        Ok(ask)
    }

    /// Reads a state as a link has it: `KEY=VALUE&KEY=VALUE`, each part with `%` in front of what is no letter.
    ///
    /// # Errors
    /// In words: what is no `KEY=VALUE`, what is not UTF-8, too much of it.
    pub fn of_link(link: &str) -> Result<Ask, String> {
        let mut ask = Ask { lenient: true, ..Ask::default() };
        for part in link.trim_start_matches('#').split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').ok_or(format!("`{part}` is no KEY=VALUE"))?;
            let (key, value) = (decoded(key)?, decoded(value)?);
            match key.as_str() {
                "joint" => ask.joint = value,
                "design" => ask.design = value,
                // What the page alone knows: the filter of its table, the file that the link is of, other pins.
                "filter" | "file" | "pin" => {}
                _ => drop(ask.state.insert(key, value)),
            }
        }
        check(&ask.state)?;
        Ok(ask)
    }

    /// What decides what is found for a joint: all that is set but what is set of other joints alone. `names` are those of all joints;
    /// `coupled`: what is set of one joint counts for all.
    pub fn of_joint(&self, joint: &str, names: &[&str], coupled: bool) -> String {
        // A name that could be a part of a path, or of another name's path, leaves it open whose a key is.
        let plain = |name: &&str| !name.contains(['.', '*']) && !name.trim().is_empty();
        let apart = !coupled && names.iter().all(plain);
        let of_other = |key: &str| {
            let of = key.strip_prefix("joint.").and_then(|rest| rest.split_once('.')).map(|(name, _)| name);
            of.is_some_and(|name| name != joint && names.contains(&name))
        };
        let set = self.state.iter().filter(|(key, _)| !(apart && of_other(key)));
        let all: Vec<String> = set.map(|(key, value)| format!("{key}\u{1}{value}")).collect();
        format!("{joint}\u{2}{}", all.join("\u{2}"))
    }
}

/// Whether two keys set the same value, or one a part of what the other sets; `*` is any joint.
pub fn overlap(one: &str, other: &str) -> bool {
    one.split('.').zip(other.split('.')).all(|(a, b)| a == b || a == "*" || b == "*")
}

/// That a state is not too large.
fn check(state: &BTreeMap<String, String>) -> Result<(), String> {
    if state.len() > MOST.0 {
        return Err(format!("more than {} values are set", MOST.0));
    }
    match state.iter().find(|(key, value)| key.len().max(value.len()) > MOST.1) {
        Some(_) => Err(format!("a key or a value is longer than {} bytes", MOST.1)),
        None => Ok(()),
    }
}

/// A text of a link as it is meant.
fn decoded(text: &str) -> Result<String, String> {
    let bytes = text.as_bytes();
    let (mut out, mut k) = (Vec::with_capacity(bytes.len()), 0);
    while k < bytes.len() {
        if bytes[k] != b'%' {
            out.push(bytes[k]);
            k += 1;
            continue;
        }
        let digit = |at: usize| bytes.get(at).and_then(|c| char::from(*c).to_digit(16));
        let (Some(high), Some(low)) = (digit(k + 1), digit(k + 2)) else {
            return Err(format!("`{text}` has a % that is followed by no two digits"));
        };
        out.push((16 * high + low) as u8);
        k += 3;
    }
    String::from_utf8(out).map_err(|_| format!("`{text}` is not UTF-8"))
}

/// A state as a link: what is no letter, digit or one of `-._~` has a `%` in front.
pub fn link(state: &BTreeMap<String, String>) -> String {
    let encoded = |text: &str| {
        let one = |byte: u8| match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => char::from(byte).to_string(),
            _ => format!("%{byte:02X}"),
        };
        text.bytes().map(one).collect::<String>()
    };
    let parts: Vec<String> = state.iter().map(|(key, value)| format!("{}={}", encoded(key), encoded(value))).collect();
    parts.join("&")
}

/// The values of a state, each with a home of its own, so that each mistake is told at its key.
///
/// # Errors
/// What is no key or no value.
pub fn settings(state: &BTreeMap<String, String>) -> Result<Settings, Vec<Wrong>> {
    let (mut all, mut wrong) = (Settings::default(), Vec::new());
    for (key, value) in state {
        match Settings::of_arguments(&[format!("{key}={value}")]) {
            // `key` alone may not decide where the value begins.
            Ok(_) if key.trim() != key => wrong.push(Wrong::of(key, "a key has no blanks around it")),
            Ok(_) if key.contains('=') => wrong.push(Wrong::of(key, "a key has no `=`")),
            Ok(one) => all = all.then(&one),
            Err(why) => wrong.push(Wrong::of(key, why.split_once("`: ").map_or(why.as_str(), |(_, why)| why))),
        }
    }
    if wrong.is_empty() { Ok(all) } else { Err(wrong) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_a_state() {
        let ask = Ask::of_link("#bus.voltage=36%20V&joint=knee&design=t-motor-ri50%4012.5&filter=x&file=ab").unwrap();
        assert_eq!(ask.state, BTreeMap::from([("bus.voltage".to_string(), "36 V".to_string())]));
        assert_eq!((ask.joint.as_str(), ask.design.as_str()), ("knee", "t-motor-ri50@12.5"));
        assert_eq!(Ask::of_link("").unwrap().state.len(), 0);
        let odd = BTreeMap::from([("joint.a b.limits.safety".to_string(), "{ é = \"&%#\" }".to_string())]);
        assert_eq!(Ask::of_link(&link(&odd)).unwrap().state, odd);
        for wrong in ["bus.voltage", "a=%2", "a=%ff", "a=%zz"] {
            assert!(Ask::of_link(wrong).is_err(), "{wrong}");
        }
        let many: Vec<String> = (0..65).map(|k| format!("a{k}=1")).collect();
        assert!(Ask::of_link(&many.join("&")).is_err());
    }

    #[test]
    fn what_is_set_of_another_joint_does_not_count() {
        let set = |pairs: &[(&str, &str)]| Ask {
            state: pairs.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect(),
            ..Ask::default()
        };
        let (all, plain) = (set(&[("joint.hip.limits.safety", "2")]), set(&[]));
        let names = ["hip", "knee"];
        assert_eq!(all.of_joint("knee", &names, false), plain.of_joint("knee", &names, false));
        assert_ne!(all.of_joint("knee", &names, true), plain.of_joint("knee", &names, true));
        assert_ne!(all.of_joint("hip", &names, false), plain.of_joint("hip", &names, false));
        // Where a name could be a part of a path, all counts.
        assert_ne!(
            all.of_joint("knee", &["hip", "knee", "*"], false),
            plain.of_joint("knee", &["hip", "knee", "*"], false)
        );
        assert_ne!(
            all.of_joint("knee", &["hip", "knee", "hip.two"], false),
            plain.of_joint("knee", &["hip", "knee", "hip.two"], false)
        );
        let of_all = set(&[("joint.*.limits.safety", "2")]);
        assert_ne!(of_all.of_joint("knee", &names, false), plain.of_joint("knee", &names, false));
    }

    #[test]
    fn keys_overlap_where_one_is_a_part_of_the_other() {
        assert!(overlap("joint.*.limits.safety", "joint.knee.limits.safety") && overlap("bus", "bus.voltage"));
        assert!(
            !overlap("joint.*.limits.safety", "joint.knee.limits.actuator_mass")
                && !overlap("bus.voltage", "bus.power")
        );
    }

    #[test]
    fn each_mistake_is_told_at_its_key() {
        let state = |key: &str, value: &str| BTreeMap::from([(key.to_string(), value.to_string())]);
        let wrong = |key: &str, value: &str| settings(&state(key, value)).unwrap_err();
        assert_eq!(wrong("bus.voltage", "")[0].key, "bus.voltage");
        assert_eq!(wrong("bus..voltage", "1")[0].key, "bus..voltage");
        assert_eq!(wrong("a=b", "1")[0].key, "a=b");
        assert_eq!(wrong(" bus.voltage", "1 V")[0].key, " bus.voltage");
        assert!(settings(&state("bus.voltage", "36 V")).is_ok());
    }
}
