//! Messages in binary: CDR as ROS 2 writes it ([DDS-XTypes 1.3](https://www.omg.org/spec/DDS-XTypes/1.3), 7.4), and the
//! serialisation of ROS 1, which has no padding.

use super::node::{Leaf, Node, stamp};
use super::schema::{Schema, Type};
use gearwise_model::input::limits;

/// Decodes a message of CDR.
///
/// # Errors
/// It ends too early, or is of a variant that is not read.
pub fn message(schema: &Schema, data: &[u8]) -> Result<Node, String> {
    let [0, variant, _, _, content @ ..] = data else {
        return Err("it does not begin as CDR does".into());
    };
    // Plain CDR of version 1, then 2, each of big and little end.
    let (little, align) = match variant {
        0 | 1 => (*variant == 1, 8),
        6 | 7 => (*variant == 7, 4),
        other => return Err(format!("it is written as variant {other} of CDR, which is not read")),
    };
    decode(schema, Cursor { data: content, at: 0, align, little, values: 0 })
}

/// Decodes a message of ROS 1.
///
/// # Errors
/// It ends too early.
pub fn ros1(schema: &Schema, data: &[u8]) -> Result<Node, String> {
    decode(schema, Cursor { data, at: 0, align: 1, little: true, values: 0 })
}

fn decode(schema: &Schema, mut cursor: Cursor) -> Result<Node, String> {
    let node = cursor.fields(schema, 0)?;
    // What is padded has up to three bytes more; a message without fields has one.
    if cursor.data.len() - cursor.at > 8 {
        return Err(format!("it has {} bytes more than its schema says", cursor.data.len() - cursor.at));
    }
    Ok(node)
}

struct Cursor<'a> {
    data: &'a [u8],
    at: usize,
    /// Values begin at multiples of their size, at most of this.
    align: usize,
    little: bool,
    /// Values so far, with those that hold others.
    values: usize,
}

impl Cursor<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let size = N.min(self.align);
        let start = self.at.next_multiple_of(size);
        let bytes: Option<[u8; N]> = self.data.get(start..start + N).and_then(|b| b.try_into().ok());
        let mut bytes = bytes.ok_or("it ends before its last value")?;
        self.at = start + N;
        if !self.little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn length(&mut self) -> Result<usize, String> {
        let length = u32::from_le_bytes(self.bytes()?) as usize;
        // Each element has at least one byte, or is a message without any.
        if length > self.data.len() { Err("it ends before its last value".into()) } else { Ok(length) }
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.length()?;
        let bytes = self.data.get(self.at..self.at + length).ok_or("it ends before its last value")?;
        self.at += length;
        // CDR counts the zero at the end.
        let bytes = bytes.strip_suffix(b"\0").unwrap_or(bytes);
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    fn fields(&mut self, schema: &Schema, message: usize) -> Result<Node, String> {
        let fields = &schema.messages[message];
        let mut nodes = Vec::with_capacity(fields.len());
        for (name, kind) in fields {
            nodes.push((name.clone(), self.value(schema, kind)?));
        }
        Ok(Node::Struct(nodes))
    }

    fn value(&mut self, schema: &Schema, kind: &Type) -> Result<Node, String> {
        self.values += 1;
        // A value takes a byte or more; a few messages may enclose each.
        if self.values > limits::MESSAGE_VALUES.min(1024 + 4 * self.data.len()) {
            return Err(limits::too_many("values of a message", self.values, limits::MESSAGE_VALUES));
        }
        let number = |value: f64| Node::Leaf(Leaf::Number(value));
        Ok(match kind {
            Type::Bool => Node::Leaf(Leaf::Text((self.bytes::<1>()?[0] != 0).to_string())),
            Type::Float(4) => number(f64::from(f32::from_le_bytes(self.bytes()?))),
            Type::Float(_) => number(f64::from_le_bytes(self.bytes()?)),
            Type::Whole(1, true) => number(f64::from(i8::from_le_bytes(self.bytes()?))),
            Type::Whole(1, false) => number(f64::from(u8::from_le_bytes(self.bytes()?))),
            Type::Whole(2, true) => number(f64::from(i16::from_le_bytes(self.bytes()?))),
            Type::Whole(2, false) => number(f64::from(u16::from_le_bytes(self.bytes()?))),
            Type::Whole(4, true) => number(f64::from(i32::from_le_bytes(self.bytes()?))),
            Type::Whole(4, false) => number(f64::from(u32::from_le_bytes(self.bytes()?))),
            Type::Whole(_, true) => number(i64::from_le_bytes(self.bytes()?) as f64),
            Type::Whole(_, false) => number(u64::from_le_bytes(self.bytes()?) as f64),
            Type::Text => Node::Leaf(Leaf::Text(self.text()?)),
            Type::Time => {
                let (seconds, rest) = (u32::from_le_bytes(self.bytes()?), u32::from_le_bytes(self.bytes()?));
                // ROS 2 has a sign, which no recording uses.
                let stamp = stamp(i64::from(seconds.cast_signed()), rest).ok_or("its time is before 1970")?;
                Node::Leaf(Leaf::Stamp(stamp))
            }
            Type::Duration => {
                let (seconds, rest) = (i32::from_le_bytes(self.bytes()?), u32::from_le_bytes(self.bytes()?));
                number((f64::from(seconds) * 1e9 + f64::from(rest.cast_signed())) / 1e9)
            }
            Type::Message(inner) => self.fields(schema, *inner)?,
            Type::Array(of, count) => self.list(schema, of, *count)?,
            Type::Sequence(of) => {
                let count = self.length()?;
                self.list(schema, of, count)?
            }
        })
    }

    fn list(&mut self, schema: &Schema, of: &Type, count: usize) -> Result<Node, String> {
        // Elements without fields take no bytes and are no columns.
        let count = if of.is_empty(schema) { 0 } else { count };
        (0..count).map(|_| self.value(schema, of)).collect::<Result<Vec<Node>, String>>().map(Node::List)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schema() -> Schema {
        Schema::parse("p/A", "int8 a\nfloat64 b\nstring c\nfloat32[] d\nuint16 e\nbuiltin_interfaces/Time t\nbool f")
            .unwrap()
    }

    /// Written by hand after the rules of alignment.
    fn data(little: bool, align: usize) -> Vec<u8> {
        let mut out: Vec<u8> = Vec::new();
        let mut put = |bytes: &[u8]| {
            while !out.len().is_multiple_of(bytes.len().min(align)) {
                out.push(0);
            }
            let mut bytes = bytes.to_vec();
            if !little {
                bytes.reverse();
            }
            out.extend(bytes);
        };
        put(&[0xff]);
        put(&2.5_f64.to_le_bytes());
        put(&3_u32.to_le_bytes());
        for byte in b"xy\0" {
            put(&[*byte]);
        }
        put(&2_u32.to_le_bytes());
        put(&1.5_f32.to_le_bytes());
        put(&(-0.5_f32).to_le_bytes());
        put(&7_u16.to_le_bytes());
        put(&12_u32.to_le_bytes());
        put(&34_u32.to_le_bytes());
        put(&[1]);
        out
    }

    #[test]
    fn every_type_at_its_place() {
        for (variant, align) in [(0, 8), (1, 8), (6, 4), (7, 4)] {
            let bytes = [&[0, variant, 0, 0][..], &data(variant % 2 == 1, align)].concat();
            let node = message(&schema(), &bytes).unwrap();
            let number = |x| Some(Leaf::Number(x));
            assert_eq!(node.at("a"), number(-1.0));
            assert_eq!(node.at("b"), number(2.5));
            assert_eq!(node.at("c"), Some(Leaf::Text("xy".into())));
            assert_eq!((node.at("d/0"), node.at("d/1"), node.at("d/2")), (number(1.5), number(-0.5), None));
            assert_eq!(node.at("e"), number(7.0));
            assert_eq!(node.at("t"), Some(Leaf::Stamp(12_000_000_034)));
            assert_eq!(node.at("f"), Some(Leaf::Text("true".into())));
            for cut in 4..bytes.len() {
                assert!(message(&schema(), &bytes[..cut]).is_err());
            }
        }
        assert!(ros1(&schema(), &data(true, 1)).is_ok());
        for (bytes, part) in [(&[0, 3, 0, 0][..], "variant 3"), (b"", "does not begin"), (&[0, 1, 0, 0], "ends before")]
        {
            assert!(message(&schema(), bytes).unwrap_err().contains(part));
        }
        let more = [&[0, 1, 0, 0][..], &data(true, 8), &[0; 9]].concat();
        assert!(message(&schema(), &more).unwrap_err().contains("more than its schema says"));
    }

    #[test]
    fn values_are_bounded_by_the_bytes_of_the_message() {
        let text = "Empty[] a\nEmpty[1048576] b\nuint8 c\n===\nMSG: p/Empty\n";
        let schema = Schema::parse("p/A", text).unwrap();
        let node = ros1(&schema, &[4, 0, 0, 0, 9]).unwrap();
        assert_eq!((node.at("c"), node.names(10)), (Some(Leaf::Number(9.0)), vec!["c".to_string()]));
        let bytes = Schema::parse("p/A", "uint8[] a").unwrap();
        let mut data = u32::try_from(limits::MESSAGE_VALUES).unwrap().to_le_bytes().to_vec();
        data.resize(4 + limits::MESSAGE_VALUES, 1);
        assert!(ros1(&bytes, &data).is_err());
        data[..4].copy_from_slice(&1000_u32.to_le_bytes());
        assert!(ros1(&bytes, &data[..1004]).is_ok());
    }
}
