//! Columns of a Parquet file.

use std::cell::Cell;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use parquet::basic::{Compression, ConvertedType, LogicalType, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::arrays::{Asked, Loaded, too_large, unusable};
use super::record::{Series, TEXT_NUMBERS};
use gearwise_model::input::{Problem, limits};

/// Rows that are decoded at once.
const BATCH: usize = 1 << 14;

/// Reads the columns that are asked for. A null is missing.
///
/// # Errors
/// The file is damaged or cut off; a column is no list of numbers or texts, or packed in a way that is not read.
pub fn read(file: &File, asked: &Asked) -> Result<Loaded, Vec<Problem>> {
    let damaged = |e: ParquetError| {
        vec![Problem::whole(format!("the Parquet file cannot be read: {e}")).help("is it cut off? Write it again")]
    };
    let bytes = file.metadata().map_or(0, |m| m.len());
    let mut room = limits::log_numbers(bytes);
    let file = file.try_clone().map_err(|e| damaged(ParquetError::from(e)))?;
    let reader = guarded(|| SerializedFileReader::new(file)).map_err(damaged)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let header: Vec<String> = schema.columns().iter().map(|c| c.path().string()).collect();
    let needed: Vec<usize> = (0..header.len()).filter(|k| asked.names.contains(&header[*k].as_str())).collect();
    let groups = reader.metadata().row_groups();
    let rows = groups.iter().try_fold(0_usize, |sum, g| sum.checked_add(usize::try_from(g.num_rows()).ok()?));
    let rows = rows.filter(|rows| rows.checked_mul(needed.len().max(1)).is_some_and(|n| n <= room));
    let Some(rows) = rows else {
        return Err(vec![too_large("numbers in this file", "its", room)]);
    };
    let mut problems = Vec::new();
    let mut series: Vec<Option<Series>> = vec![None; header.len()];
    for at in needed {
        let descriptor = &schema.columns()[at];
        let packed = groups.iter().find_map(|g| refused(g.column(at).compression()));
        if let Some((what, help)) = packed.or_else(|| unreadable(descriptor)) {
            problems.push(unusable(&header[at], what, help));
            continue;
        }
        let unpacked = groups.iter().map(|g| g.column(at).uncompressed_size()).fold(0_i64, i64::saturating_add);
        if unpacked.cast_unsigned() > limits::unpacked(bytes) {
            let what = limits::too_many("bytes unpacked from this file", unpacked, limits::unpacked(bytes));
            problems.push(unusable(&header[at], what, "keep every n-th row, or cut the recording into several files"));
            continue;
        }
        let mut values = Vec::new();
        let read = || -> Result<Series, ParquetError> {
            let mut texts: Option<Vec<String>> = None;
            for group in 0..groups.len() {
                let group = reader.get_row_group(group)?;
                take(&*group, at, descriptor, &mut values, &mut texts, &mut room)?;
            }
            Ok(texts.map_or_else(|| Series::Numbers(std::mem::take(&mut values)), Series::Texts))
        };
        match guarded(read) {
            Ok(column) if column.len() == rows => series[at] = Some(column),
            Ok(column) => {
                let what = format!("it has {} values, the file has {rows} rows", column.len());
                problems.push(unusable(&header[at], what, "is the file cut off? Write it again"));
            }
            Err(error) => {
                let what = format!("it cannot be read: {error}");
                problems.push(unusable(&header[at], what, "is the file cut off or damaged? Write it again"));
            }
        }
    }
    if problems.is_empty() { Ok(Loaded { header, series, rows, latest: Vec::new() }) } else { Err(problems) }
}

/// Run a part of the library, which panics on some damaged files. Nothing of such a panic is printed.
///
/// # Errors
/// The error of the part, or one that stands for its panic.
fn guarded<T>(read: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    thread_local!(static IS_QUIET: Cell<bool> = const { Cell::new(false) });
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_QUIET.get() {
                before(panic);
            }
        }));
    });
    IS_QUIET.set(true);
    let result = catch_unwind(AssertUnwindSafe(read));
    IS_QUIET.set(false);
    result.unwrap_or_else(|_| Err(ParquetError::General("its pages contradict one another".into())))
}

/// Why a way of packing is not read, and what to do. Those that are, are written in Rust throughout.
fn refused(compression: Compression) -> Option<(String, String)> {
    let name = match compression {
        Compression::UNCOMPRESSED
        | Compression::SNAPPY
        | Compression::GZIP(_)
        | Compression::LZ4
        | Compression::LZ4_RAW => {
            return None;
        }
        Compression::ZSTD(_) => "zstd",
        Compression::BROTLI(_) => "Brotli",
        Compression::LZO => "LZO",
    };
    let help = "pandas.read_parquet(\"log.parquet\").to_parquet(\"log.parquet\", compression=\"snappy\")";
    Some((format!("it is compressed by {name}, which is not read in Parquet"), help.into()))
}

/// Why the values of a column are no numbers.
fn unreadable(column: &ColumnDescriptor) -> Option<(String, String)> {
    let wrong = |what: &str, help: &str| Some((what.to_string(), help.to_string()));
    let seconds = "save seconds: (t - t.iloc[0]).dt.total_seconds()";
    if column.max_rep_level() > 0 {
        return wrong("its cells are lists, not numbers", "save a column for each element of the list");
    }
    match column.logical_type_ref() {
        Some(LogicalType::Timestamp { .. }) => return wrong("it holds dates, not numbers", seconds),
        Some(LogicalType::Time { .. } | LogicalType::Date) => {
            return wrong("it holds times of day, not numbers", seconds);
        }
        Some(LogicalType::Decimal { .. }) => return wrong("it holds decimals, not numbers", "save it as float64"),
        Some(LogicalType::Float16) => return wrong("it holds numbers of 16 bits", "save it as float64"),
        _ => {}
    }
    match (column.physical_type(), column.converted_type()) {
        (Physical::INT96, _) => wrong("it holds dates, not numbers", seconds),
        (_, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIMESTAMP_MICROS) => {
            wrong("it holds dates, not numbers", seconds)
        }
        (_, ConvertedType::DECIMAL) => wrong("it holds decimals, not numbers", "save it as float64"),
        (Physical::FIXED_LEN_BYTE_ARRAY, _) => wrong("it holds bytes, not numbers", "save it as float64"),
        _ => None,
    }
}

/// Appends a column of a row group: numbers, or texts.
fn take(
    group: &dyn RowGroupReader,
    at: usize,
    column: &ColumnDescriptor,
    values: &mut Vec<f64>,
    texts: &mut Option<Vec<String>>,
    room: &mut usize,
) -> Result<(), ParquetError> {
    let unsigned = matches!(column.logical_type_ref(), Some(LogicalType::Integer(whole)) if !whole.is_signed)
        || matches!(column.converted_type(), ConvertedType::UINT_32 | ConvertedType::UINT_64);
    let level = column.max_def_level();
    let nan = f64::NAN;
    match group.get_column_reader(at)? {
        ColumnReader::DoubleColumnReader(reader) => every(reader, level, nan, |v| *v, values, room),
        ColumnReader::FloatColumnReader(reader) => every(reader, level, nan, |v| f64::from(*v), values, room),
        ColumnReader::Int32ColumnReader(reader) => every(
            reader,
            level,
            nan,
            |v| if unsigned { f64::from(v.cast_unsigned()) } else { f64::from(*v) },
            values,
            room,
        ),
        ColumnReader::Int64ColumnReader(reader) => {
            every(reader, level, nan, |v| if unsigned { v.cast_unsigned() as f64 } else { *v as f64 }, values, room)
        }
        ColumnReader::BoolColumnReader(reader) => {
            let texts = texts.get_or_insert_default();
            every(reader, level, String::new(), |v: &bool| v.to_string(), texts, room)
        }
        ColumnReader::ByteArrayColumnReader(reader) => {
            let texts = texts.get_or_insert_default();
            let text = |v: &ByteArray| String::from_utf8_lossy(v.data()).into_owned();
            every(reader, level, String::new(), text, texts, room)
        }
        _ => Err(ParquetError::General("its type is not read".into())),
    }
}

/// A value that is held.
trait Held {
    /// Numbers that take its memory.
    fn numbers(&self) -> usize;
}

impl Held for f64 {
    fn numbers(&self) -> usize {
        1
    }
}

impl Held for String {
    fn numbers(&self) -> usize {
        TEXT_NUMBERS + self.len() / 8
    }
}

/// Appends every value of a column of a row group, `missing` where it is null.
fn every<D: DataType, T: Clone + Held>(
    mut reader: ColumnReaderImpl<D>,
    level: i16,
    missing: T,
    of: impl Fn(&D::T) -> T,
    to: &mut Vec<T>,
    room: &mut usize,
) -> Result<(), ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    loop {
        levels.clear();
        values.clear();
        let (records, found, _) = reader.read_records(BATCH, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            return Ok(());
        }
        let mut next = values[..found].iter();
        for row in 0..records {
            // Without levels nothing is null.
            let there = level == 0 || levels.get(row).is_some_and(|l| *l == level);
            let value = if there { next.next().map(&of) } else { None };
            let value = value.unwrap_or_else(|| missing.clone());
            let left = room.checked_sub(value.numbers());
            *room = left.ok_or_else(|| ParquetError::General("its values take more memory than may be used".into()))?;
            to.push(value);
        }
    }
}
