//! Arrays of a NumPy archive: `np.savez`, `np.savez_compressed`.
//!
//! An array of one dimension is a column by its name. One of two dimensions has a column for each of its own, named as NumPy
//! takes it out: `q[:,0]`.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read};

use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, ReaderAt, ZipArchive, ZipArchiveEntryWayfinder};

use super::arrays::{Asked, Loaded, too_large, unusable};
use super::npy::{self, Head, Kind};
use gearwise_model::input::{Problem, limits};

/// An array of the archive: where it is.
struct Entry {
    name: String,
    way: ZipArchiveEntryWayfinder,
    packed: CompressionMethod,
}

/// At most this many arrays are looked at.
const MAX_ENTRIES: usize = 100_000;
/// Columns of an array of two dimensions that are listed.
const MAX_LISTED: usize = 64;

/// Reads the arrays that are asked for.
///
/// # Errors
/// The archive is damaged or cut off; an array is no list of numbers or texts; arrays differ in length.
pub fn read(file: &File, asked: &Asked) -> Result<Loaded, Vec<Problem>> {
    let damaged = |e: rawzip::Error| vec![damaged(&e)];
    let mut buffer = vec![0; rawzip::RECOMMENDED_BUFFER_SIZE];
    let bytes = file.metadata().map_or(0, |m| m.len());
    let file = file.try_clone().map_err(|e| damaged(e.into()))?;
    let archive = ZipArchive::from_file(file, &mut buffer).map_err(damaged)?;
    let entries = entries(&archive, &mut buffer)?;
    let mut loaded = Loaded::default();
    let mut problems = Vec::new();
    let mut columns: Vec<Column> = Vec::new();
    // All heads are compared before any values are held.
    for entry in &entries {
        let head = match open(&archive, entry).and_then(|mut array| npy::head(&mut array)) {
            Ok(head) => head,
            // What nobody asks for may be anything.
            Err(_) if !asked.names.iter().any(|name| column_of(name).0 == entry.name) => {
                loaded.header.push(entry.name.clone());
                loaded.series.push(None);
                continue;
            }
            Err(what) => {
                problems.push(unreadable(entry, what));
                continue;
            }
        };
        let first = loaded.header.len();
        loaded.header.extend(head.columns(&entry.name).take(MAX_LISTED));
        for name in asked.names.iter().filter(|name| column_of(name).0 == entry.name) {
            match wanted(name, &head) {
                Ok(Some(at)) => {
                    let position = loaded.header[first..].iter().position(|listed| listed == name);
                    let position = position.map_or_else(
                        || {
                            loaded.header.push((*name).to_string());
                            loaded.header.len() - 1
                        },
                        |p| first + p,
                    );
                    columns.push(Column { name, entry, head: head.clone(), at, position });
                }
                Ok(None) => {}
                Err((what, help)) => problems.push(unusable(name, what, help)),
            }
        }
        loaded.series.resize(loaded.header.len(), None);
    }
    loaded.series.resize(loaded.header.len(), None);
    // Only what is not there was asked for: one row lets the names be compared.
    loaded.rows = columns.first().map_or(1, |c| usize::try_from(c.head.rows).unwrap_or(usize::MAX));
    let heads: Vec<(&str, &Head)> = columns.iter().map(|c| (c.name, &c.head)).collect();
    problems.extend(check_sizes(&heads, bytes));
    if !problems.is_empty() {
        return Err(problems);
    }
    for Column { entry, head, at, position, .. } in columns {
        let values = open(&archive, entry).and_then(|mut array| {
            npy::head(&mut array)?;
            npy::column(&mut array, &head, at)
        });
        match values {
            Ok(series) => loaded.series[position] = Some(series),
            Err(what) => problems.push(unreadable(entry, what)),
        }
    }
    if problems.is_empty() { Ok(loaded) } else { Err(problems) }
}

/// A column that is asked for: its array, its place there, and its place among all columns.
struct Column<'a> {
    name: &'a str,
    entry: &'a Entry,
    head: Head,
    at: u64,
    position: usize,
}

/// Find out by their heads if columns differ in length, or unpack to more than a file of so many bytes may.
fn check_sizes(columns: &[(&str, &Head)], bytes: u64) -> Option<Problem> {
    let (first, one) = columns.first()?;
    if let Some((name, other)) = columns.iter().find(|(_, head)| head.rows != one.rows) {
        let what = format!("it has {} values, `{first}` has {}", other.rows, one.rows);
        return Some(unusable(name, what, "the arrays of a log are of one length, a value for each row"));
    }
    let (numbers, most) = (columns.iter().map(|(_, head)| head.numbers()), limits::log_numbers(bytes));
    let numbers = numbers.fold(0, u64::saturating_add);
    if numbers > most as u64 {
        return Some(too_large("numbers in this file", numbers, most));
    }
    let most = limits::unpacked(bytes);
    let (name, large) = columns.iter().find(|(_, head)| head.bytes() > most)?;
    let what = limits::too_many("bytes unpacked from this file", large.bytes(), most);
    Some(unusable(name, what, "save the columns that are needed as arrays of one dimension"))
}

/// That an array cannot be read.
fn unreadable(entry: &Entry, what: String) -> Problem {
    unusable(&entry.name, what, "is the file cut off or damaged? Write it again")
}

fn damaged(error: &rawzip::Error) -> Problem {
    Problem::whole(format!("the NumPy archive cannot be read: {error}")).help("is it cut off? Write it again")
}

/// The arrays of an archive, in its order.
fn entries<R: ReaderAt>(archive: &ZipArchive<R>, buffer: &mut [u8]) -> Result<Vec<Entry>, Vec<Problem>> {
    let mut found: Vec<Entry> = Vec::new();
    let mut names = BTreeSet::new();
    let mut listed = archive.entries(buffer);
    while let Some(record) = listed.next_entry().map_err(|e| vec![damaged(&e)])? {
        let name = String::from_utf8_lossy(record.file_path().as_ref()).into_owned();
        // NumPy names an array so in the archive.
        let Some(name) = name.strip_suffix(".npy") else { continue };
        if !names.insert(name.to_string()) {
            return Err(vec![unusable(name, "the archive has two arrays of this name", "write the file again")]);
        }
        found.push(Entry { name: name.into(), way: record.wayfinder(), packed: record.compression_method() });
        if found.len() > MAX_ENTRIES {
            return Err(vec![Problem::whole(limits::too_many("arrays in this file", found.len(), MAX_ENTRIES))]);
        }
    }
    if found.is_empty() {
        let problem = Problem::whole("the archive holds no array: no name in it ends in .npy");
        return Err(vec![problem.help("np.savez(\"log.npz\", time=time, current=current) makes such a file")]);
    }
    Ok(found)
}

/// The bytes of an array, unpacked; its end is checked against the archive's own sum.
fn open<'a, R: ReaderAt>(archive: &'a ZipArchive<R>, entry: &Entry) -> Result<Box<dyn Read + 'a>, String> {
    let found = archive.get_entry(entry.way).map_err(|e| e.to_string())?;
    let bytes = found.reader();
    match entry.packed {
        CompressionMethod::STORE => Ok(Box::new(found.verifying_reader(bytes))),
        CompressionMethod::DEFLATE => {
            Ok(Box::new(BufReader::with_capacity(1 << 16, found.verifying_reader(DeflateDecoder::new(bytes)))))
        }
        other => Err(format!("it is packed by method {other:?} of ZIP, which NumPy does not write")),
    }
}

/// The array that a column is of, and its place there.
fn column_of(name: &str) -> (&str, Option<u64>) {
    let split = |name: &'_ str| -> Option<(usize, u64)> {
        let (array, rest) = name.split_once("[:,")?;
        Some((array.len(), rest.strip_suffix(']')?.trim().parse().ok()?))
    };
    split(name).map_or((name, None), |(length, at)| (&name[..length], Some(at)))
}

/// Which column of an array is asked for; `None` where it has no such column.
fn wanted(name: &str, head: &Head) -> Result<Option<u64>, (String, String)> {
    let savez = "save it as float64";
    match head.kind {
        Kind::Other(what) => return Err((format!("it holds {what} ({}), not numbers", head.written), savez.into())),
        Kind::Float(_) | Kind::Signed(_) | Kind::Unsigned(_) | Kind::Bool | Kind::Wide(_) | Kind::Bytes(_) => {}
    }
    match (column_of(name).1, head.columns) {
        _ if head.dimensions == 0 => {
            Err(("it is a single value, not one for each row".into(), "np.full(len(time), x) repeats it".into()))
        }
        (None, None) => Ok(Some(0)),
        (None, Some(0)) | (Some(_), None) => Ok(None),
        (None, Some(columns)) => {
            let array = column_of(name).0;
            let last = columns - 1;
            let what = format!("it has two dimensions, {} by {columns}", head.rows);
            Err((what, format!("name one of its columns: \"{array}[:,0]\" to \"{array}[:,{last}]\"")))
        }
        (Some(at), Some(columns)) => Ok((at < columns).then_some(at)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The head that an array begins with.
    fn head(written: &str, shape: &str) -> Head {
        let text = format!("{{'descr': '{written}', 'fortran_order': False, 'shape': {shape}, }}\n");
        let length = u16::try_from(text.len()).unwrap().to_le_bytes();
        npy::head(&mut &[b"\x93NUMPY\x01\x00", &length[..], text.as_bytes()].concat()[..]).unwrap()
    }

    #[test]
    fn sizes_are_compared_by_the_heads_alone() {
        let file = 1 << 20;
        let most = limits::log_numbers(file);
        assert!(most * 8 * 4 <= 256 << 20, "numbers, with the copy of each log, within 256 MB");
        let of = |written: &str, rows: usize| head(written, &format!("({rows},)"));
        let (short, long) = (of("<f8", 500), of("|u1", 200_000_000));
        let found = check_sizes(&[("t", &short), ("x", &long)], file).unwrap();
        assert!(found.message.starts_with("column `x`"), "{}", found.message);
        // Columns of one length, together within the limit, and beyond it.
        let half = of("|u1", most / 2);
        assert!(check_sizes(&[("t", &half), ("x", &half)], file).is_none());
        assert!(check_sizes(&[("t", &half), ("x", &half), ("y", &half)], file).is_some());
        // A text takes the memory of its characters.
        let rows = most / 1000;
        assert!(check_sizes(&[("x", &of("<f8", rows))], file).is_none());
        assert!(check_sizes(&[("x", &of("|S1000000", rows))], file).is_some());
        assert!(check_sizes(&[("x", &of("<U500000", rows))], file).is_some());
        // A column of a wide array is read past all the others.
        let wide = |columns: u64| head("<f8", &format!("(1000, {columns})"));
        let fit = limits::unpacked(file) / 8000;
        assert!(check_sizes(&[("x", &wide(fit))], file).is_none());
        assert!(check_sizes(&[("x", &wide(fit + 1))], file).is_some());
        // A larger file may hold more.
        assert!(check_sizes(&[("t", &half), ("x", &half), ("y", &half)], 1 << 24).is_none());
    }

    #[test]
    fn texts_without_characters_are_no_column() {
        for written in ["|S0", "<U0", "|a0"] {
            assert!(wanted("x", &head(written, "(89000000,)")).is_err(), "{written}");
        }
        assert_eq!(wanted("x", &head("|S1", "(5,)")), Ok(Some(0)));
    }
}
