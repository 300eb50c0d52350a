//! One NumPy array: the format of `.npy`, [NEP 1](https://numpy.org/neps/nep-0001-npy-format.html) with versions 1 to 3.

use std::io::{self, Read};

use super::record::{Series, TEXT_NUMBERS};

/// What an array holds, with the bytes of each value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// IEEE 754 of 2, 4 or 8 bytes.
    Float(usize),
    /// A whole number with its sign.
    Signed(usize),
    /// A whole number without sign.
    Unsigned(usize),
    /// A truth value.
    Bool,
    /// Text of so many characters of 4 bytes.
    Wide(usize),
    /// Text of so many bytes.
    Bytes(usize),
    /// Something that is no number, in words.
    Other(&'static str),
}

/// What the head of an array says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// What it holds.
    pub kind: Kind,
    /// The same as NumPy writes it, `<f8`.
    pub written: String,
    /// Of how many dimensions it is: 0 to 2.
    pub dimensions: usize,
    /// Its length.
    pub rows: u64,
    /// Its width, where it has two dimensions.
    pub columns: Option<u64>,
    big_endian: bool,
    fortran: bool,
}

/// What is written in place of a type where there are several.
const FIELDS: &str = "fields";
/// A head is no longer than this \[bytes\].
const MAX_HEAD: usize = 1 << 16;

impl Head {
    /// The names of its columns.
    pub fn columns<'a>(&self, array: &'a str) -> Box<dyn Iterator<Item = String> + 'a> {
        match self.columns {
            None => Box::new(std::iter::once(array.to_string())),
            Some(columns) => Box::new((0..columns).map(move |k| format!("{array}[:,{k}]"))),
        }
    }

    /// Size of all its values \[bytes\].
    pub fn bytes(&self) -> u64 {
        self.rows.saturating_mul(self.columns.unwrap_or(1)).saturating_mul(self.width() as u64)
    }

    /// Numbers that take the memory of one of its columns.
    pub fn numbers(&self) -> u64 {
        let text = match self.kind {
            Kind::Wide(n) | Kind::Bytes(n) => TEXT_NUMBERS + n / 8,
            Kind::Bool => TEXT_NUMBERS,
            _ => 1,
        };
        self.rows.saturating_mul(text as u64)
    }

    fn width(&self) -> usize {
        match self.kind {
            Kind::Float(n) | Kind::Signed(n) | Kind::Unsigned(n) | Kind::Bytes(n) => n,
            Kind::Wide(n) => 4 * n,
            Kind::Bool => 1,
            Kind::Other(_) => 0,
        }
    }
}

fn cut(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "it ends before its last value".into(),
        _ => format!("it cannot be read: {error}"),
    }
}

/// Reads the head of an array.
///
/// # Errors
/// It is no array of at most two dimensions.
pub fn head(from: &mut dyn Read) -> Result<Head, String> {
    let mut bytes = |n: usize| -> Result<Vec<u8>, String> {
        let mut buffer = vec![0; n];
        from.read_exact(&mut buffer).map_err(|e| cut(&e))?;
        Ok(buffer)
    };
    let start = bytes(8)?;
    if !start.starts_with(b"\x93NUMPY") {
        return Err("it is no NumPy array".into());
    }
    let length = match start[6] {
        1 => bytes(2).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))?,
        2 | 3 => bytes(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)?,
        version => return Err(format!("version {version} of the format of NumPy arrays is not known")),
    };
    if length > MAX_HEAD {
        return Err(format!("its head has {length} bytes"));
    }
    let text = bytes(length)?;
    let text = String::from_utf8_lossy(&text);
    let value = |key: &str| text.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start());
    let (Some(descr), Some(order), Some(shape)) = (value("descr"), value("fortran_order"), value("shape")) else {
        return Err("its head does not say what it holds".into());
    };
    let written = match descr.strip_prefix('\'').and_then(|rest| rest.split_once('\'')) {
        Some((written, _)) => written.to_string(),
        None => FIELDS.into(),
    };
    let sizes = shape.strip_prefix('(').and_then(|rest| rest.split_once(')')).map(|(sizes, _)| sizes);
    let sizes: Option<Vec<u64>> =
        sizes.and_then(|s| s.split(',').map(str::trim).filter(|s| !s.is_empty()).map(|s| s.parse().ok()).collect());
    let Some(sizes) = sizes else { return Err("its head does not say its shape".into()) };
    if sizes.len() > 2 {
        return Err(format!("it has {} dimensions", sizes.len()));
    }
    let kind = kind_of(&written);
    let head = Head {
        kind,
        big_endian: written.starts_with('>'),
        written,
        dimensions: sizes.len(),
        rows: sizes.first().copied().unwrap_or(1),
        columns: sizes.get(1).copied(),
        fortran: order.starts_with("True"),
    };
    let size = head.rows.checked_mul(head.columns.unwrap_or(1)).and_then(|n| n.checked_mul(head.width() as u64));
    if size.is_none_or(|size| size > 1 << 46) {
        return Err("its head gives a size that no file has".into());
    }
    Ok(head)
}

fn kind_of(written: &str) -> Kind {
    if written == FIELDS {
        return Kind::Other("records of several fields");
    }
    let plain = written.trim_start_matches(['<', '>', '|', '=']);
    let (letter, size) = plain.split_at(plain.chars().next().map_or(0, char::len_utf8));
    let size = size.parse::<usize>().ok();
    match (letter, size) {
        ("f", Some(n @ (2 | 4 | 8))) => Kind::Float(n),
        ("f", _) => Kind::Other("numbers of another size than 64 bits"),
        ("i", Some(n @ (1 | 2 | 4 | 8))) => Kind::Signed(n),
        ("u", Some(n @ (1 | 2 | 4 | 8))) => Kind::Unsigned(n),
        ("b", Some(1)) => Kind::Bool,
        // Values without a character take no bytes, however many there are.
        ("U" | "S" | "a", Some(0)) => Kind::Other("texts without characters"),
        ("U", Some(n)) if n < 1 << 20 => Kind::Wide(n),
        ("S" | "a", Some(n)) if n < 1 << 20 => Kind::Bytes(n),
        ("c", _) => Kind::Other("complex numbers"),
        ("M", _) => Kind::Other("dates"),
        ("m", _) => Kind::Other("time spans of NumPy"),
        ("O", _) => Kind::Other("Python objects"),
        ("V", _) => Kind::Other("bytes"),
        _ => Kind::Other("something else"),
    }
}

/// Reads one column of an array, which stands after its head; then to its end, where the archive's sum is checked.
///
/// # Errors
/// It ends too early, or has more than its head says.
pub fn column(from: &mut dyn Read, head: &Head, at: u64) -> Result<Series, String> {
    let width = head.width();
    let columns = head.columns.unwrap_or(1);
    // How far its values are apart, and what comes before the first and after the last.
    let (before, between) = if head.fortran { (at * head.rows, 0) } else { (at, columns - 1) };
    let skip = |from: &mut dyn Read, values: u64| -> Result<(), String> {
        let bytes = values * width as u64;
        match io::copy(&mut from.take(bytes), &mut io::sink()) {
            Ok(count) if count == bytes => Ok(()),
            Ok(_) => Err("it ends before its last value".into()),
            Err(error) => Err(cut(&error)),
        }
    };
    skip(from, before)?;
    let mut cell = vec![0; width];
    let (mut numbers, mut texts) = (Vec::new(), Vec::new());
    for row in 0..head.rows {
        if row > 0 && between > 0 {
            skip(from, between)?;
        }
        from.read_exact(&mut cell).map_err(|e| cut(&e))?;
        if head.big_endian {
            match head.kind {
                Kind::Wide(_) => cell.chunks_exact_mut(4).for_each(<[u8]>::reverse),
                Kind::Bytes(_) => {}
                _ => cell.reverse(),
            }
        }
        match head.kind {
            Kind::Wide(_) => texts.push(wide(&cell)),
            Kind::Bytes(_) => texts.push(String::from_utf8_lossy(&cell).trim_end_matches('\0').to_string()),
            Kind::Bool => texts.push((cell[0] != 0).to_string()),
            _ => numbers.push(number(&cell, head.kind)),
        }
    }
    let rest = io::copy(from, &mut io::sink()).map_err(|e| cut(&e))?;
    let after = (head.rows * columns).saturating_sub(before + head.rows + between * head.rows.saturating_sub(1));
    if rest != after * width as u64 {
        return Err("it has more or fewer values than its head says".into());
    }
    Ok(if texts.is_empty() { Series::Numbers(numbers) } else { Series::Texts(texts) })
}

/// A number of a little-endian cell.
fn number(cell: &[u8], kind: Kind) -> f64 {
    let mut wide = [0; 8];
    wide[..cell.len()].copy_from_slice(cell);
    let bits = u64::from_le_bytes(wide);
    match kind {
        Kind::Float(8) => f64::from_bits(bits),
        Kind::Float(4) => f64::from(f32::from_bits(bits as u32)),
        Kind::Float(_) => half(bits as u16),
        // The sign is spread over the bytes that are not there.
        Kind::Signed(n) => (bits.cast_signed() << (64 - 8 * n) >> (64 - 8 * n)) as f64,
        _ => bits as f64,
    }
}

/// A number of 16 bits, IEEE 754 binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    sign * match exponent {
        0 => fraction * (-24_f64).exp2(),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * f64::from(exponent - 15).exp2(),
    }
}

/// Text of four bytes a character, without what fills it up.
fn wide(cell: &[u8]) -> String {
    let character = |c: &[u8]| char::from_u32(u32::from_le_bytes([c[0], c[1], c[2], c[3]])).unwrap_or('\u{fffd}');
    cell.chunks_exact(4).map(character).collect::<String>().trim_end_matches('\0').to_string()
}
