//! Channels of an MCAP file, as ROS 2 records them.
//!
//! The one idea: a log is one topic. Its messages are the rows, in the order of their log time; a field of a message is a column
//! that is named as topic and path, `/joint_states/velocity/knee`. A column of another topic has its latest value.

mod cdr;
mod node;
mod records;
mod schema;

use std::collections::BTreeMap;
use std::fs::File;
use std::rc::Rc;

use self::node::Leaf;
use self::records::Event;
use self::schema::Schema;
use super::arrays::{Asked, Loaded, too_large, unusable};
use super::record::{Series, TEXT_NUMBERS, short};
use gearwise_model::input::{Problem, limits};

/// Fields that each topic has beside those of its messages: the times of the recording \[ns\].
const LOG_TIME: &str = "log_time";
const PUBLISH_TIME: &str = "publish_time";
/// At most this many names of columns are kept for one topic.
const MAX_NAMES: usize = 2000;
/// At most this many names of columns are kept of a file.
const MAX_HEADER: usize = 100_000;

/// How the messages of a topic are read.
#[derive(Clone)]
enum Decoder {
    Cdr(Rc<Schema>),
    Ros1(Rc<Schema>),
    Json,
    /// Not at all: why, and what to do.
    Not(String, String),
}

/// A channel of the file.
struct Topic {
    name: String,
    decoder: Decoder,
    /// Names of its columns, from its first message; `None` before it.
    names: Option<Vec<String>>,
    /// What is asked of it: place in the list of names, and the path in its messages.
    asked: Vec<(usize, String)>,
}

/// What a message says of what is asked.
struct Row {
    log_time: u64,
    leaves: Vec<(usize, Leaf)>,
}

impl Row {
    /// Numbers that take its memory.
    fn numbers(&self) -> usize {
        let of = |(_, leaf): &(usize, Leaf)| match leaf {
            Leaf::Text(text) => TEXT_NUMBERS + text.len() / 8,
            Leaf::Number(_) | Leaf::Stamp(_) => 1,
        };
        1 + self.leaves.iter().map(of).sum::<usize>()
    }
}

/// Reads the columns that are asked for.
///
/// # Errors
/// The file is damaged, cut off, or packed or written in a way that is not read.
pub fn read(file: &File, asked: &Asked) -> Result<Loaded, Vec<Problem>> {
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
    let mut schemas: BTreeMap<u16, Described> = BTreeMap::new();
    let most = limits::log_numbers(file.metadata().map_or(0, |m| m.len()));
    let mut described = 0;
    // The messages of each topic by its name: several channels may write to one.
    let mut rows: BTreeMap<String, Vec<Row>> = BTreeMap::new();
    let mut problems: Vec<Problem> = Vec::new();
    let mut numbers = 0_usize;
    records::each(file, &mut |event| {
        match event {
            Event::Schema { id, name, encoding, data } => {
                // The summary at the end repeats them.
                schemas.entry(id).or_insert_with(|| {
                    described += data.len();
                    Described::of(name, encoding, data, described)
                });
            }
            Event::Channel { id, schema, topic, encoding } => {
                // The summary at the end repeats them.
                let decoder = || decoder(encoding, schemas.get(&schema));
                topics.entry(id).or_insert_with(|| Topic {
                    name: topic.into(),
                    decoder: decoder(),
                    names: None,
                    asked: asked_of(topic, asked),
                });
            }
            Event::Message { channel, log_time, publish_time, data } => {
                let Some(topic) = topics.get_mut(&channel) else {
                    problems.push(Problem::whole(format!(
                        "a message is of channel {channel}, which the file does not have"
                    )));
                    return false;
                };
                let found = rows.entry(topic.name.clone()).or_default();
                match topic.take(log_time, publish_time, data, found.len()) {
                    Ok(Some(row)) => {
                        numbers += row.numbers();
                        found.push(row);
                    }
                    Ok(None) => {}
                    Err(problem) => problems.push(problem),
                }
            }
        }
        problems.is_empty() && numbers <= most
    })
    .map_err(|problem| vec![problem])?;
    if numbers > most {
        return Err(vec![too_large("numbers in this file", numbers, most)]);
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    table(&topics, rows, asked)
}

/// Which columns are asked of a topic.
fn asked_of(topic: &str, asked: &Asked) -> Vec<(usize, String)> {
    let path = |name: &str| Some(name.strip_prefix(topic)?.strip_prefix('/')?.to_string());
    asked.names.iter().enumerate().filter_map(|(k, name)| Some((k, path(name)?))).collect()
}

/// A schema of the file, parsed once for all channels that use it.
struct Described {
    language: String,
    schema: Result<Rc<Schema>, String>,
}

impl Described {
    /// Parse a definition, unless those so far have more bytes than are read.
    fn of(name: &str, language: &str, text: &[u8], total: usize) -> Described {
        let schema = match language {
            _ if total > limits::SCHEMA_BYTES => {
                Err(limits::too_many("bytes of message definitions", total, limits::SCHEMA_BYTES))
            }
            "ros2msg" | "ros1msg" => Schema::parse(name, &String::from_utf8_lossy(text)).map(Rc::new),
            other => Err(format!("{} is not read", short(other.as_bytes()))),
        };
        Described { language: short(language.as_bytes()), schema }
    }
}

/// How messages are read, by their encoding and that of their schema.
fn decoder(encoding: &str, schema: Option<&Described>) -> Decoder {
    let language = schema.map_or("", |described| described.language.as_str());
    match (encoding, language) {
        ("cdr", "ros2msg") | ("ros1", "ros1msg") => match schema.map(|described| &described.schema) {
            Some(Ok(schema)) if encoding == "cdr" => Decoder::Cdr(schema.clone()),
            Some(Ok(schema)) => Decoder::Ros1(schema.clone()),
            Some(Err(what)) => Decoder::Not(format!("its messages cannot be read: {what}"), TO_PARQUET.into()),
            None => Decoder::Not("its messages have no schema".into(), TO_PARQUET.into()),
        },
        ("json", _) => Decoder::Json,
        ("cdr", language) => Decoder::Not(
            format!("its messages are described in {language:?}, which is not read"),
            "record with descriptions in ros2msg, as rosbag2 does for .msg files".into(),
        ),
        (encoding, _) => {
            let encoding = short(encoding.as_bytes());
            Decoder::Not(format!("its messages are encoded as {encoding:?}, which is not read"), TO_PARQUET.into())
        }
    }
}

/// The line that makes a Parquet file of the messages of a topic.
const TO_PARQUET: &str = "mcap cat LOG.mcap --topics TOPIC --json | python3 -c \"import json, sys, pandas; \
     pandas.json_normalize([json.loads(line) for line in sys.stdin]).to_parquet('log.parquet')\"";

impl Topic {
    /// What a message says of what is asked; nothing where it has none of it.
    fn take(&mut self, log_time: u64, publish_time: u64, data: &[u8], number: usize) -> Result<Option<Row>, Problem> {
        // The names are those of the first message; the rest only matters where something of it is asked.
        if self.asked.is_empty() && self.names.is_some() {
            return Ok(None);
        }
        let decoded = match &self.decoder {
            Decoder::Cdr(schema) => cdr::message(schema, data),
            Decoder::Ros1(schema) => cdr::ros1(schema, data),
            Decoder::Json if data.len() > limits::JSON_MESSAGE_BYTES => {
                Err(limits::too_many("bytes of a message in JSON", data.len(), limits::JSON_MESSAGE_BYTES))
            }
            Decoder::Json => serde_json::from_slice(data).map_err(|e| e.to_string()).map(|v| node::of_json(&v, 0)),
            Decoder::Not(what, help) if !self.asked.is_empty() => {
                let help = help.replace("TOPIC", &self.name);
                return Err(Problem::whole(format!("topic `{}`: {what}", self.name)).help(help));
            }
            Decoder::Not(..) => return Ok(None),
        };
        let message = match decoded {
            Ok(message) => message,
            Err(_) if self.asked.is_empty() => {
                self.names = Some(Vec::new());
                return Ok(None);
            }
            Err(what) => {
                let what = format!("message {} of topic `{}`: {what}", number + 1, self.name);
                return Err(Problem::whole(what).help("is the file damaged, or its schema another?"));
            }
        };
        if self.names.is_none() {
            let own = [LOG_TIME, PUBLISH_TIME].map(String::from);
            self.names = Some(message.names(MAX_NAMES).into_iter().chain(own).collect());
        }
        let mut any = false;
        let mut leaves = Vec::new();
        for (k, path) in &self.asked {
            let leaf = match message.at(path) {
                Some(leaf) => {
                    any |= !matches!(leaf, Leaf::Stamp(_));
                    leaf
                }
                None if path == LOG_TIME => Leaf::Stamp(log_time),
                None if path == PUBLISH_TIME => Leaf::Stamp(publish_time),
                None => continue,
            };
            leaves.push((*k, leaf));
        }
        // Of `/joint_states` some messages may be of other joints.
        let only_times = leaves.len() == self.asked.len();
        Ok((any || only_times).then_some(Row { log_time, leaves }))
    }
}

/// The columns: rows of the topic that has the time, the latest value of the others.
fn table(
    topics: &BTreeMap<u16, Topic>,
    mut rows: BTreeMap<String, Vec<Row>>,
    asked: &Asked,
) -> Result<Loaded, Vec<Problem>> {
    let mut loaded = Loaded { rows: 1, ..Loaded::default() };
    for topic in topics.values() {
        let names = topic.names.iter().flatten().filter(|name| topic.name.len() + name.len() < limits::NAME_BYTES);
        let room = MAX_HEADER.saturating_sub(loaded.header.len());
        loaded.header.extend(names.take(room).map(|name| format!("{}/{name}", topic.name)));
    }
    loaded.header.sort();
    loaded.header.dedup();
    for messages in rows.values_mut() {
        messages.sort_by_key(|row| row.log_time);
    }
    // The topic of each column: that of the longest name which has it.
    let topic_of = |k: usize| {
        let has = |rows: &Vec<Row>| rows.iter().any(|row| row.leaves.iter().any(|(at, _)| *at == k));
        rows.iter().filter(|(_, rows)| has(rows)).map(|(topic, _)| topic).max_by_key(|topic| topic.len())
    };
    let own: Vec<Option<&String>> = (0..asked.names.len()).map(topic_of).collect();
    let first = asked.time.and_then(|time| asked.names.iter().position(|name| *name == time));
    let Some(base) = first.map_or_else(|| own.iter().flatten().next().copied(), |k| own[k]) else {
        loaded.series.resize(loaded.header.len(), None);
        return Ok(loaded);
    };
    let base_rows = &rows[base];
    loaded.rows = base_rows.len();
    let mut problems = Vec::new();
    for (k, name) in asked.names.iter().enumerate() {
        let Some(topic) = own[k] else { continue };
        let at = loaded.header.iter().position(|h| h == name).unwrap_or_else(|| {
            loaded.header.push((*name).to_string());
            loaded.header.len() - 1
        });
        loaded.series.resize(loaded.header.len(), None);
        let leaf = |row: &Row| row.leaves.iter().find(|(asked, _)| *asked == k).map(|(_, leaf)| leaf.clone());
        let leaves: Vec<Option<Leaf>> = if topic == base {
            base_rows.iter().map(leaf).collect()
        } else {
            let (leaves, oldest) = latest(&rows[topic], base_rows, &leaf);
            loaded.latest.push((at, oldest));
            leaves
        };
        match series(leaves) {
            Some(series) => loaded.series[at] = Some(series),
            None => {
                problems.push(unusable(name, "some of its values are numbers, others are not", "name another column"))
            }
        }
    }
    loaded.series.resize(loaded.header.len(), None);
    if problems.is_empty() { Ok(loaded) } else { Err(problems) }
}

/// For each row the latest value of another topic at or before its log time, and the age of the oldest one that is used \[ns\].
fn latest(of: &[Row], rows: &[Row], leaf: &dyn Fn(&Row) -> Option<Leaf>) -> (Vec<Option<Leaf>>, u64) {
    let (mut next, mut oldest) = (0, 0);
    let mut now: Option<(u64, Leaf)> = None;
    let mut leaves = Vec::with_capacity(rows.len());
    for row in rows {
        while let Some(other) = of.get(next).filter(|other| other.log_time <= row.log_time) {
            now = leaf(other).map(|leaf| (other.log_time, leaf)).or(now);
            next += 1;
        }
        if let Some((time, _)) = &now {
            oldest = oldest.max(row.log_time - time);
        }
        leaves.push(now.as_ref().map(|(_, leaf)| leaf.clone()));
    }
    (leaves, oldest)
}

/// The values of a column; `None` where they are of several kinds. Stamps count from the first one \[s\].
fn series(leaves: Vec<Option<Leaf>>) -> Option<Series> {
    let first = leaves.iter().flatten().next()?;
    let is_text = matches!(first, Leaf::Text(_));
    if let Leaf::Stamp(start) = *first {
        // The difference of two stamps has few digits; each of them has more than a float.
        let seconds = |leaf: Option<Leaf>| match leaf {
            Some(Leaf::Stamp(stamp)) => Some((i128::from(stamp) - i128::from(start)) as f64 / 1e9),
            None => Some(f64::NAN),
            Some(_) => None,
        };
        return leaves.into_iter().map(seconds).collect::<Option<Vec<f64>>>().map(Series::Stamps);
    }
    if is_text {
        let text = |leaf: Option<Leaf>| match leaf {
            Some(Leaf::Text(text)) => Some(text),
            None => Some(String::new()),
            Some(_) => None,
        };
        return leaves.into_iter().map(text).collect::<Option<Vec<String>>>().map(Series::Texts);
    }
    let number = |leaf: Option<Leaf>| match leaf {
        Some(Leaf::Number(number)) => Some(number),
        None => Some(f64::NAN),
        Some(_) => None,
    };
    leaves.into_iter().map(number).collect::<Option<Vec<f64>>>().map(Series::Numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_topic_has_its_latest_value() {
        let row = |log_time, value: f64| Row { log_time, leaves: vec![(0, Leaf::Number(value))] };
        let base: Vec<Row> = [10, 20, 30, 40].map(|t| row(t, 0.0)).into();
        let other = [row(15, 1.0), row(20, 2.0), row(39, 3.0)];
        let leaf = |row: &Row| row.leaves.first().map(|(_, leaf)| leaf.clone());
        let (leaves, oldest) = latest(&other, &base, &leaf);
        let number = |x| Some(Leaf::Number(x));
        assert_eq!(leaves, [None, number(2.0), number(2.0), number(3.0)]);
        assert_eq!(oldest, 10);
    }

    #[test]
    fn stamps_count_from_the_first() {
        let stamps = [1_700_000_000_123_456_789, 1_700_000_000_125_956_789, 1_700_000_000_123_456_788];
        let leaves = stamps.map(|s| Some(Leaf::Stamp(s))).into();
        assert_eq!(series(leaves), Some(Series::Stamps(vec![0.0, 0.0025, -1e-9])));
        let mixed = vec![Some(Leaf::Number(1.0)), Some(Leaf::Text("a".into()))];
        assert_eq!(series(mixed), None);
        assert_eq!(series(vec![None, None]), None);
    }
}
