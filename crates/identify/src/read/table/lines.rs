//! A CSV log, read as a stream: only the cells that a log needs are parsed, and the text is not kept.

use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use csv::{ByteRecord, Position};
use hmac_sha256::Hash as Sha256;

use super::gather::Gather;
use super::record::{Mistakes, Record};
use super::wanted::{Rows, Wanted, hash_of, shared, too_long};
use gearwise_model::input::csv::other_separator;
use gearwise_model::input::{InputError, Opened, Problem, Source, limits, utf_16};

/// Feeds all bytes that are read through the hash.
struct Hashing {
    opened: Opened,
    hash: Sha256,
    count: u64,
}

impl Read for Hashing {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.opened.file.read(buffer)?;
        self.hash.update(&buffer[..count]);
        self.count += count as u64;
        // It was smaller when it was opened.
        if self.count > limits::LOG_BYTES {
            return Err(io::Error::other("it grows faster than it can be read"));
        }
        Ok(count)
    }
}

impl Hashing {
    /// The hash of all that was read, where the file is still what it was.
    fn finish(self) -> Result<String, Problem> {
        let hash = self.hash.finalize();
        self.opened.unchanged(|file| Ok(hash_of(file)? == hash)).map(|()| gearwise_model::input::hex(&hash))
    }
}

/// Reads the logs of one file in one pass.
///
/// # Errors
/// What is wrong with the log file.
pub fn read(
    (path, name): (&Path, &str),
    opened: Opened,
    wanted: &[Wanted],
    note: &mut dyn FnMut(Problem),
) -> Result<Option<(String, Vec<Rows>)>, InputError> {
    let mut mistakes = Mistakes::new(path);
    let wrong = |problem: Problem| InputError { source: Arc::new(Source::new(name, "")), problems: vec![problem] };
    let whole = |message: String| wrong(Problem::whole(message));
    let hashing = Hashing { opened, hash: Sha256::new(), count: 0 };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .buffer_capacity(1 << 16)
        .from_reader(hashing);
    let failed = |e: csv::Error| whole(format!("cannot read the file: {e}"));
    let mut record = ByteRecord::new();
    if !reader.read_byte_record(&mut record).map_err(failed)? {
        return Err(whole("the file is empty: it has no header row".into()));
    }
    let Some(header) = read_header(&record, &mut mistakes) else { return Err(mistakes.into_error(name)) };
    let logs: Vec<Option<Gather>> =
        wanted.iter().map(|w| Gather::new(w, &header, Record::Line(&record), name, &mut mistakes, note)).collect();
    if !mistakes.problems.is_empty() {
        return Err(mistakes.into_error(name));
    }
    let Some(mut logs) = logs.into_iter().collect::<Option<Vec<Gather>>>() else { return Ok(None) };

    let width = header.len();
    let mut both = 0_usize;
    let mut numbers = 0_usize;
    while reader.read_byte_record(&mut record).map_err(failed)? {
        if record.len() != width {
            if record.len() == 1 && record[0].trim_ascii().is_empty() {
                continue;
            }
            let more = record.len() > width;
            let message = format!("this row has {} cells, the header has {width}", record.len());
            let help = if more {
                "numbers have a decimal point, not a comma; text with commas needs double quotes"
            } else {
                "was the recording cut off here? Remove the row"
            };
            mistakes.add(Record::Line(&record), None, message, "the cells do not match the header", help);
        } else {
            let (mut fit, mut held_out) = (false, false);
            for log in &mut logs {
                if log.selects(Record::Line(&record), &mut mistakes) {
                    *(if log.wanted.held_out { &mut held_out } else { &mut fit }) = true;
                    log.take(Record::Line(&record), &mut mistakes);
                    numbers += log.width();
                }
            }
            both += usize::from(fit && held_out);
        }
        if mistakes.are_enough() {
            break;
        }
        if numbers > limits::LOG_NUMBERS {
            return Err(wrong(too_long(record.position().map_or(0, Position::record))));
        }
    }
    if !mistakes.problems.is_empty() {
        // The mistakes may be those of two texts that were taken for one.
        reader.into_inner().opened.unchanged(|_| Ok(true)).map_err(wrong)?;
        return Err(mistakes.into_error(name));
    }
    if both > 0 {
        note(shared(wanted, both, name));
        return Ok(None);
    }
    let hash = reader.into_inner().finish().map_err(wrong)?;
    let rows: Vec<Option<Rows>> = logs.into_iter().map(|log| log.finish(name, note)).collect();
    Ok(rows.into_iter().collect::<Option<Vec<Rows>>>().map(|rows| (hash, rows)))
}

fn read_header(record: &ByteRecord, mistakes: &mut Mistakes) -> Option<Vec<String>> {
    if let Some(problem) = utf_16(record.as_slice()) {
        mistakes.problems.push(problem);
        return None;
    }
    let mut header = Vec::new();
    for cell in record {
        match std::str::from_utf8(cell.trim_ascii()) {
            Ok(text) => header.push(text.to_string()),
            Err(_) => {
                mistakes.problems.push(
                    Problem::whole("not a text file: its header row is not UTF-8").help("save the log as CSV in UTF-8"),
                );
                return None;
            }
        }
    }
    if header.len() == 1 && header[0].is_empty() {
        mistakes.problems.push(Problem::whole("the file is empty: it has no header row"));
        return None;
    }
    if let Some((message, help)) = other_separator(header.iter().map(String::as_str)) {
        mistakes.add(Record::Line(record), None, message, "expected commas", help);
        return None;
    }
    Some(header)
}
