//! Writers of the formats that logs come in, for these tests alone.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

/// How a Parquet file is packed.
#[derive(Debug, Clone, Copy)]
pub enum Packed {
    Not,
    Snappy,
    Gzip,
    Lz4,
}

/// A Parquet file of numbers; NaN is a null.
pub fn parquet(columns: &[(String, Vec<f64>)], packed: Packed) -> Vec<u8> {
    let compression = match packed {
        Packed::Not => Compression::UNCOMPRESSED,
        Packed::Snappy => Compression::SNAPPY,
        Packed::Gzip => Compression::GZIP(Default::default()),
        Packed::Lz4 => Compression::LZ4_RAW,
    };
    let fields = columns.iter().map(|(name, _)| {
        let field = Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::OPTIONAL);
        Arc::new(field.build().unwrap())
    });
    let schema = Arc::new(Type::group_type_builder("schema").with_fields(fields.collect()).build().unwrap());
    let properties = WriterProperties::builder().set_compression(compression).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).unwrap();
    let length = columns[0].1.len();
    // Several groups, of which the last is short.
    for start in (0..length).step_by(1000) {
        let mut group = writer.next_row_group().unwrap();
        for (_, values) in columns {
            let part = &values[start..values.len().min(start + 1000)];
            let levels: Vec<i16> = part.iter().map(|v| i16::from(!v.is_nan())).collect();
            let numbers: Vec<f64> = part.iter().copied().filter(|v| !v.is_nan()).collect();
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&numbers, Some(&levels), None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    bytes
}

/// A Parquet file of one message type in the language of its schemas, with a writer of its columns.
pub fn typed(schema: &str, column: impl Fn(usize, &mut parquet::file::writer::SerializedColumnWriter<'_>)) -> Vec<u8> {
    let schema = Arc::new(parquet::schema::parser::parse_message_type(schema).unwrap());
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut at = 0;
    while let Some(mut next) = group.next_column().unwrap() {
        column(at, &mut next);
        next.close().unwrap();
        at += 1;
    }
    group.close().unwrap();
    writer.close().unwrap();
    bytes
}

/// A `.npy` of a kind and a shape as NumPy writes them.
pub fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let mut head = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
    while (head.len() + 11) % 64 != 0 {
        head.push(' ');
    }
    head.push('\n');
    let length = u16::try_from(head.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], head.as_bytes(), data].concat()
}

/// A `.npy` of numbers in one dimension.
pub fn numbers(values: &[f64]) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    npy("'<f8'", false, &format!("({},)", values.len()), &data)
}

/// An archive of files.
pub fn zip(files: &[(String, Vec<u8>)], packed: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = rawzip::ZipArchiveWriter::new(&mut bytes);
    for (name, content) in files {
        let method = if packed { rawzip::CompressionMethod::DEFLATE } else { rawzip::CompressionMethod::STORE };
        let (mut entry, config) = archive.new_file(name).compression_method(method).start().unwrap();
        if packed {
            let mut writer = config.wrap(flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::fast()));
            writer.write_all(content).unwrap();
            let (encoder, descriptor) = writer.finish().unwrap();
            encoder.finish().unwrap();
            entry.finish(descriptor).unwrap();
        } else {
            let mut writer = config.wrap(&mut entry);
            writer.write_all(content).unwrap();
            let (_, descriptor) = writer.finish().unwrap();
            entry.finish(descriptor).unwrap();
        }
    }
    archive.finish().unwrap();
    bytes
}

/// A `.npz` of numbers.
pub fn npz(columns: &[(String, Vec<f64>)], packed: bool) -> Vec<u8> {
    let files: Vec<_> = columns.iter().map(|(name, values)| (format!("{name}.npy"), numbers(values))).collect();
    zip(&files, packed)
}

/// A text with its length before it.
fn text(text: &str) -> Vec<u8> {
    [&u32::try_from(text.len()).unwrap().to_le_bytes(), text.as_bytes()].concat()
}

/// How chunks of an MCAP file are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chunks {
    /// There are none.
    No,
    Plain,
    Lz4,
    Zstd,
    /// Packed as something that no reader knows.
    Unknown,
}

/// An MCAP file after [its specification](https://mcap.dev/spec): records one after the other.
#[derive(Debug, Default)]
pub struct Mcap {
    records: Vec<u8>,
    channels: u16,
    sequence: u32,
}

fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

impl Mcap {
    /// Adds a topic: the name of its message, the language and the text of the definition, how messages are written.
    pub fn topic(&mut self, topic: &str, message: &str, language: &str, definition: &str, encoding: &str) -> u16 {
        self.channels += 1;
        let id = self.channels.to_le_bytes();
        let schema = [&id[..], &text(message), &text(language), &text(definition)].concat();
        self.records.extend(record(3, &schema));
        let channel = [&id[..], &id, &text(topic), &text(encoding), &0_u32.to_le_bytes()].concat();
        self.records.extend(record(4, &channel));
        self.channels
    }

    /// Adds a message.
    pub fn message(&mut self, channel: u16, log_time: u64, data: &[u8]) {
        let times = [log_time.to_le_bytes(), (log_time + 1).to_le_bytes()].concat();
        let head = [&channel.to_le_bytes()[..], &self.sequence.to_le_bytes(), &times].concat();
        self.records.extend(record(5, &[&head, data].concat()));
        self.sequence += 1;
    }

    /// The file.
    pub fn file(&self, chunks: Chunks) -> Vec<u8> {
        let magic = b"\x89MCAP0\r\n";
        let head = record(1, &[text("ros2"), text("a test")].concat());
        let (name, packed) = match chunks {
            Chunks::No => ("", Vec::new()),
            Chunks::Plain => ("", self.records.clone()),
            Chunks::Unknown => ("xz", self.records.clone()),
            Chunks::Zstd => (
                "zstd",
                ruzstd::encoding::compress_to_vec(&self.records[..], ruzstd::encoding::CompressionLevel::Fastest),
            ),
            Chunks::Lz4 => {
                let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
                encoder.write_all(&self.records).unwrap();
                ("lz4", encoder.finish().unwrap())
            }
        };
        let data = if chunks == Chunks::No {
            self.records.clone()
        } else {
            let mut sum = flate2::Crc::new();
            sum.update(&self.records);
            let sum = sum.sum();
            let size = (self.records.len() as u64).to_le_bytes();
            let times = [0; 16];
            let length = (packed.len() as u64).to_le_bytes();
            record(6, &[&times[..], &size, &sum.to_le_bytes(), &text(name), &length, &packed].concat())
        };
        let end = record(15, &0_u32.to_le_bytes());
        let footer = record(2, &[0; 20]);
        [magic, &head[..], &data, &end, &footer, magic].concat()
    }
}

/// Values one after the other as CDR, each at a multiple of its size.
#[derive(Debug, Default)]
pub struct Cdr(Vec<u8>);

impl Cdr {
    fn put(mut self, bytes: &[u8]) -> Cdr {
        while !self.0.len().is_multiple_of(bytes.len()) {
            self.0.push(0);
        }
        self.0.extend(bytes);
        self
    }

    pub fn whole(self, value: u32) -> Cdr {
        self.put(&value.to_le_bytes())
    }

    pub fn float(self, value: f64) -> Cdr {
        self.put(&value.to_le_bytes())
    }

    pub fn text(self, value: &str) -> Cdr {
        let mut cdr = self.whole(u32::try_from(value.len() + 1).unwrap());
        cdr.0.extend(value.as_bytes());
        cdr.0.push(0);
        cdr
    }

    /// A list of numbers.
    pub fn floats(self, values: &[f64]) -> Cdr {
        values.iter().fold(self.whole(u32::try_from(values.len()).unwrap()), |cdr, value| cdr.float(*value))
    }

    /// A list of texts.
    pub fn texts(self, values: &[&str]) -> Cdr {
        values.iter().fold(self.whole(u32::try_from(values.len()).unwrap()), |cdr, value| cdr.text(value))
    }

    /// The message, of little end.
    pub fn message(self) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &self.0].concat()
    }
}

/// The definition of sensor_msgs/JointState.
pub const JOINT_STATE: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
    ================================================================================\nMSG: std_msgs/Header\n\
    builtin_interfaces/Time stamp\nstring frame_id\n\
    ================================================================================\nMSG: builtin_interfaces/Time\n\
    int32 sec\nuint32 nanosec\n";

/// A message of sensor_msgs/JointState.
pub fn joint_state(time: u64, names: &[&str], position: &[f64], velocity: &[f64], effort: &[f64]) -> Vec<u8> {
    let (seconds, rest) = (time / 1_000_000_000, time % 1_000_000_000);
    let cdr = Cdr::default().whole(u32::try_from(seconds).unwrap()).whole(u32::try_from(rest).unwrap()).text("base");
    cdr.texts(names).floats(position).floats(velocity).floats(effort).message()
}
