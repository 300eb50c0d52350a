//! Which gear fits which motor: MGDB lists for each motor its gears, the catalogue for each gear its
//! motors. `*` in an entry stands for any characters.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use super::super::{FileRead, Holds, Import, Lines, Remark, RemarkKind};
use super::Refused;
use crate::catalog::matches_pattern;
use crate::input::{Problem, Source};
use crate::words::nearest;

/// What `fits` says of a gear that no motor lists: blank would mean that any motor may have it. No motor
/// is given this id.
pub const NONE: &str = "no-motor-listed";

/// Keys of one kind, and which of them an entry names.
struct Names<'a> {
    what: &'static str,
    keys: Vec<&'a str>,
    index: HashMap<&'a str, usize>,
    refused: &'a HashSet<String>,
    found: HashMap<String, Vec<usize>>,
}

impl<'a> Names<'a> {
    fn new(what: &'static str, keys: Vec<&'a str>, refused: &'a HashSet<String>) -> Names<'a> {
        let index = keys.iter().enumerate().map(|(i, key)| (*key, i)).collect();
        Names { what, keys, index, refused, found: HashMap::new() }
    }

    /// The rows that an entry names.
    fn named(&mut self, entry: &str) -> &[usize] {
        if !self.found.contains_key(entry) {
            let rows = match entry.contains('*') {
                true => (0..self.keys.len()).filter(|i| matches_pattern(entry, self.keys[*i])).collect(),
                false => self.index.get(entry).copied().into_iter().collect(),
            };
            self.found.insert(entry.to_string(), rows);
        }
        &self.found[entry]
    }

    /// Why an entry names nothing.
    fn why_none(&self, entry: &str) -> String {
        let what = self.what;
        let entry: String = entry.chars().take(60).collect();
        if self.refused.iter().any(|key| matches_pattern(&entry, key)) {
            return format!("`{entry}` names a {what} whose row was refused");
        }
        match nearest(&entry, self.keys.iter().copied()).filter(|_| !entry.contains('*')) {
            Some(near) => format!("`{entry}` names no {what} of the database; the nearest is `{near}`"),
            None => format!("`{entry}` names no {what} of the database"),
        }
    }
}

/// Reads the compatibility files and gives every gear its `fits`.
pub fn apply(import: &mut Import, refused: &Refused, sources: &[Arc<Source>]) {
    let mut remarks = Vec::new();
    let mut files = Vec::new();
    let mut motors_of_gear = vec![BTreeSet::new(); import.gears.len()];
    let mut motors = Names::new("motor", import.motors.iter().map(|m| m.key.as_str()).collect(), &refused.motors);
    let mut gears = Names::new("gear", import.gears.iter().map(|g| g.key.as_str()).collect(), &refused.gears);
    for source in sources {
        files.push(read(source, &mut motors, &mut gears, &mut motors_of_gear, &mut remarks));
    }
    let listed: BTreeSet<usize> = motors_of_gear.iter().flatten().copied().collect();
    let mut assume = |code, key: &str, place: &Option<super::super::Place>, message: &str| {
        if let Some(place) = place.clone() {
            let (key, message) = (key.to_string(), message.to_string());
            remarks.push(Remark { kind: RemarkKind::Assumed, code, place, key, message });
        }
    };
    for (i, motor) in import.motors.iter().enumerate() {
        if !listed.contains(&i) {
            assume(
                "no-gear-listed",
                &motor.key,
                &motor.place,
                "no gear is listed for it: taken to fit direct drive only",
            );
        }
    }
    let ids: Vec<String> = import.motors.iter().map(|m| m.item.id.clone()).collect();
    let mut sorted: Vec<&str> = ids.iter().map(String::as_str).collect();
    sorted.sort_unstable();
    let mut known: HashMap<BTreeSet<usize>, Vec<String>> = HashMap::new();
    for (gear, motors) in import.gears.iter_mut().zip(motors_of_gear) {
        import.compatible_pairs += motors.len();
        if motors.is_empty() {
            assume("no-motor-listed", &gear.key, &gear.place, "no motor lists it: taken to fit none");
            gear.item.fits = vec![NONE.into()];
            continue;
        }
        let patterns = known
            .entry(motors)
            .or_insert_with_key(|motors| compress(&sorted, &motors.iter().map(|i| ids[*i].as_str()).collect()));
        gear.item.fits.clone_from(patterns);
    }
    import.files.extend(files);
    import.remarks.extend(remarks);
}

/// Reads one file: on each line a motor and its gears.
fn read(
    source: &Source,
    motors: &mut Names,
    gears: &mut Names,
    motors_of_gear: &mut [BTreeSet<usize>],
    remarks: &mut Vec<Remark>,
) -> FileRead {
    let lines = Lines::new(source);
    let mut file = FileRead { file: source.name().to_string(), holds: Holds::Compatibility, rows: 0, taken: 0 };
    let mut start = 0;
    for line in source.text().split_inclusive('\n') {
        let mut at = start;
        start += line.len();
        let mut cells = Vec::new();
        for cell in line.trim_end_matches(['\n', '\r']).split(',') {
            let lead = cell.len() - cell.trim_start().len();
            let entry = cell.trim().trim_matches('"').trim();
            if !entry.is_empty() {
                cells.push((at + lead..at + lead + cell.trim().len(), entry));
            }
            at += cell.len() + 1;
        }
        let Some(((span, motor), entries)) = cells.split_first() else { continue };
        if motor.starts_with('#') {
            continue;
        }
        file.rows += 1;
        let of_line = motors.named(motor).to_vec();
        if of_line.is_empty() {
            let message = format!("{}; its {} entries are not used", motors.why_none(motor), entries.len());
            remarks.push(lines.refused("names-no-motor", motor, &[Problem::at(span.clone(), message, "")]));
            continue;
        }
        file.taken += 1;
        for (span, entry) in entries {
            let named = gears.named(entry);
            named.iter().for_each(|gear| motors_of_gear[*gear].extend(&of_line));
            if named.is_empty() {
                let problem = Problem::at(span.clone(), gears.why_none(entry), "");
                remarks.push(lines.refused("names-no-gear", motor, &[problem]));
            }
        }
    }
    file
}

/// A pattern that ends in `*` has at least this many characters before it: a maker's prefix such as
/// `mm-` alone must not take in motors of other catalogues.
const SHORTEST_PREFIX: usize = 5;

/// The patterns that match exactly `wanted` among `all` (sorted): `mm-14*` where every motor whose id
/// starts so is wanted, else the ids themselves.
fn compress(all: &[&str], wanted: &HashSet<&str>) -> Vec<String> {
    fn go(group: &[&str], length: usize, wanted: &HashSet<&str>, patterns: &mut Vec<String>) {
        match group.iter().filter(|id| wanted.contains(*id)).count() {
            0 => return,
            count if count == group.len() && count > 1 && length >= SHORTEST_PREFIX => {
                patterns.push(format!("{}*", &group[0][..length]));
                return;
            }
            _ => {}
        }
        if let [id] = group {
            patterns.push((*id).to_string());
            return;
        }
        // An id that ends here stands before those that go on; ids are ASCII.
        let byte = |id: &str| id.as_bytes().get(length).copied();
        for part in group.chunk_by(|a, b| byte(a) == byte(b)) {
            go(part, length + 1, wanted, patterns);
        }
    }
    let mut patterns = Vec::new();
    go(all, 0, wanted, &mut patterns);
    patterns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_what_is_wanted_and_nothing_else() {
        let all = ["fh-2264w012", "fh-2264w024", "fh-2264w048", "fh-3274g", "mm-1", "mm-12", "mm-123456", "mm-123457"];
        for bits in 0..1 << all.len() {
            let wanted: HashSet<&str> = (0..all.len()).filter(|i| bits >> i & 1 == 1).map(|i| all[i]).collect();
            let patterns = compress(&all, &wanted);
            for id in all {
                let matched = patterns.iter().any(|p| matches_pattern(p, id));
                assert_eq!(matched, wanted.contains(id), "{patterns:?} {id}");
            }
        }
        assert_eq!(compress(&all, &all[..4].iter().copied().collect()), ["fh-22*", "fh-3274g"]);
        assert_eq!(compress(&all, &all.into_iter().collect()), ["fh-22*", "fh-3274g", "mm-1", "mm-12*"]);
    }
}
