//! The records of an MCAP file in their order, after [its specification](https://mcap.dev/spec); chunks are unpacked by decoders
//! that are written in Rust.
//!
//! The index at the end is not used: a log is read as a whole, once.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufReader, Read};

use gearwise_model::input::{Problem, limits};

/// At most this much of a record, and of what a chunk unpacks to \[bytes\].
const MAX_RECORD: u64 = 1 << 30;
/// What a file begins and ends with.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// What a file says of its messages.
pub enum Event<'a> {
    /// What messages are made of.
    Schema {
        /// Its number.
        id: u16,
        /// The name of the message.
        name: &'a str,
        /// The language that it is written in.
        encoding: &'a str,
        /// Its text.
        data: &'a [u8],
    },
    /// Where messages come from.
    Channel {
        /// Its number.
        id: u16,
        /// That of its schema.
        schema: u16,
        /// Its name.
        topic: &'a str,
        /// How its messages are written.
        encoding: &'a str,
    },
    /// A message.
    Message {
        /// Of which channel.
        channel: u16,
        /// When it was recorded \[ns\].
        log_time: u64,
        /// When it was sent \[ns\].
        publish_time: u64,
        /// Its bytes.
        data: &'a [u8],
    },
}

/// Hands every event of a file to `take`, until that says to stop.
///
/// # Errors
/// The file is damaged, cut off, or packed in a way that is not read.
pub fn each(file: &File, take: &mut dyn FnMut(Event) -> bool) -> Result<(), Problem> {
    let mut from = BufReader::with_capacity(1 << 16, file);
    let mut magic = [0; MAGIC.len()];
    from.read_exact(&mut magic).map_err(|e| cut(&e))?;
    let mut content = Vec::new();
    // Bytes that chunks may still unpack to.
    let mut room = limits::unpacked(file.metadata().map_or(0, |m| m.len()));
    loop {
        let opcode = record(&mut from, &mut content)?;
        match opcode {
            opcode::FOOTER => break,
            opcode::CHUNK => {
                if !chunk(&content, &mut room, take)? {
                    return Ok(());
                }
            }
            _ => {
                if !hand(opcode, &content, take)? {
                    return Ok(());
                }
            }
        }
    }
    from.read_exact(&mut magic).map_err(|e| cut(&e))?;
    if magic == *MAGIC { Ok(()) } else { Err(damaged("it does not end as it should")) }
}

/// The records that matter here.
mod opcode {
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
}

fn damaged(what: impl std::fmt::Display) -> Problem {
    Problem::whole(format!("the MCAP file cannot be read: {what}"))
        .help("a recording that was cut off is repaired by: mcap recover LOG.mcap -o repaired.mcap")
}

fn cut(error: &io::Error) -> Problem {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => damaged("it ends in the middle of a record"),
        _ => damaged(error),
    }
}

/// Reads the next record: its kind, and its content where that matters.
fn record(from: &mut impl Read, content: &mut Vec<u8>) -> Result<u8, Problem> {
    let mut head = [0; 9];
    from.read_exact(&mut head).map_err(|e| cut(&e))?;
    let [opcode, length @ ..] = head;
    let length = u64::from_le_bytes(length);
    content.clear();
    let matters = matches!(opcode, opcode::SCHEMA..=opcode::CHUNK);
    if matters && length > MAX_RECORD {
        return Err(damaged(format!("a record has {length} bytes, more than can be taken: at most {MAX_RECORD}")));
    }
    let mut part = from.take(length);
    let got = if matters { part.read_to_end(content).map(|n| n as u64) } else { io::copy(&mut part, &mut io::sink()) };
    match got {
        Ok(got) if got == length => Ok(opcode),
        Ok(_) => Err(damaged("it ends in the middle of a record")),
        Err(error) => Err(cut(&error)),
    }
}

/// The fields of a record, one after the other.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, count: u64) -> Result<&'a [u8], Problem> {
        let split = usize::try_from(count).ok().and_then(|count| self.0.split_at_checked(count));
        let (bytes, rest) = split.ok_or_else(|| damaged("a record is shorter than its fields"))?;
        self.0 = rest;
        Ok(bytes)
    }

    /// A whole number of so many bytes.
    fn number(&mut self, size: u64) -> Result<u64, Problem> {
        let mut wide = [0; 8];
        let bytes = self.bytes(size)?;
        wide[..bytes.len()].copy_from_slice(bytes);
        Ok(u64::from_le_bytes(wide))
    }

    /// A number of two bytes: the id of a channel or schema.
    fn id(&mut self) -> Result<u16, Problem> {
        self.number(2).map(|id| id as u16)
    }

    fn text(&mut self) -> Result<&'a str, Problem> {
        let length = self.number(4)?;
        std::str::from_utf8(self.bytes(length)?).map_err(|_| damaged("a name in it is not UTF-8"))
    }
}

/// Hands on a record, where it is about messages.
fn hand(opcode: u8, content: &[u8], take: &mut dyn FnMut(Event) -> bool) -> Result<bool, Problem> {
    let mut fields = Fields(content);
    Ok(match opcode {
        opcode::SCHEMA => {
            let (id, name, encoding) = (fields.id()?, fields.text()?, fields.text()?);
            let length = fields.number(4)?;
            take(Event::Schema { id, name, encoding, data: fields.bytes(length)? })
        }
        opcode::CHANNEL => {
            let (id, schema, topic, encoding) = (fields.id()?, fields.id()?, fields.text()?, fields.text()?);
            take(Event::Channel { id, schema, topic, encoding })
        }
        opcode::MESSAGE => {
            let (channel, _sequence) = (fields.id()?, fields.number(4)?);
            let (log_time, publish_time) = (fields.number(8)?, fields.number(8)?);
            take(Event::Message { channel, log_time, publish_time, data: fields.0 })
        }
        _ => true,
    })
}

/// The records of a chunk.
fn chunk(content: &[u8], room: &mut u64, take: &mut dyn FnMut(Event) -> bool) -> Result<bool, Problem> {
    let mut fields = Fields(content);
    let (_start, _end) = (fields.number(8)?, fields.number(8)?);
    let (size, sum) = (fields.number(8)?, fields.number(4)?);
    let compression = fields.text()?;
    let length = fields.number(8)?;
    let packed = fields.bytes(length)?;
    if size > MAX_RECORD {
        return Err(damaged(format!("a chunk has {size} bytes, more than can be taken: at most {MAX_RECORD}")));
    }
    let unpacked = match compression {
        "" => Cow::Borrowed(packed),
        "lz4" | "zstd" if size > *room => {
            return Err(damaged("its chunks unpack to many times its own size, more than is read"));
        }
        "lz4" => all(lz4_flex::frame::FrameDecoder::new(packed), size, room)?,
        "zstd" => all(ruzstd::decoding::StreamingDecoder::new(packed).map_err(damaged)?, size, room)?,
        other => {
            let problem = Problem::whole(format!("its chunks are compressed as {other:?}, which is not read"));
            return Err(problem.help("mcap decompress LOG.mcap -o plain.mcap"));
        }
    };
    if unpacked.len() as u64 != size {
        return Err(damaged(format!("a chunk does not have the {size} bytes that it says")));
    }
    let mut found = flate2::Crc::new();
    found.update(&unpacked);
    // Zero is that nobody made one.
    if sum != 0 && u64::from(found.sum()) != sum {
        return Err(damaged("the sum of a chunk is not that of its content"));
    }
    let mut rest = Fields(&unpacked);
    while !rest.0.is_empty() {
        let (opcode, length) = (rest.bytes(1)?[0], rest.number(8)?);
        if opcode == opcode::CHUNK {
            return Err(damaged("a chunk has a chunk in it"));
        }
        if !hand(opcode, rest.bytes(length)?, take)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// All that a decoder gives, and a byte more than there should be where it has that.
fn all<'a>(decoder: impl Read, size: u64, room: &mut u64) -> Result<Cow<'a, [u8]>, Problem> {
    *room = room.saturating_sub(size);
    let mut bytes = Vec::new();
    decoder.take(size + 1).read_to_end(&mut bytes).map_err(|e| damaged(format!("a chunk cannot be unpacked: {e}")))?;
    Ok(Cow::Owned(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    #[test]
    fn chunks_unpack_to_no_more_than_the_room_that_is_left() {
        let records = [&[0x0f][..], &991_u64.to_le_bytes(), &[0; 991]].concat();
        let packed = compress_to_vec(&records[..], CompressionLevel::Fastest);
        let of = |size: u64, name: &str, packed: &[u8]| {
            let name = [&4_u32.to_le_bytes()[..], name.as_bytes()].concat();
            let length = (packed.len() as u64).to_le_bytes();
            [&[0; 16][..], &size.to_le_bytes(), &[0; 4], &name, &length, packed].concat()
        };
        let content = of(1000, "zstd", &packed);
        let mut room = 2500;
        for left in [1500, 500] {
            assert!(matches!(chunk(&content, &mut room, &mut |_| true), Ok(true)));
            assert_eq!(room, left);
        }
        assert!(chunk(&content, &mut room, &mut |_| true).is_err());
        // A size that is stated too small.
        assert!(chunk(&of(400, "zstd", &packed), &mut room, &mut |_| true).is_err());
    }
}
