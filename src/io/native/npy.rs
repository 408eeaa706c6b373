//! One numpy array as bytes: `.npy` version 1.0, little endian, C order.
//!
//! Written out here because a header parser for untrusted files must neither recurse nor multiply without a check.

use std::io::{self, Read, Write};

/// Headers are some hundred bytes; version 1.0 allows 64 KiB.
const MAX_HEADER_BYTES: usize = 1 << 16;
const BLOCK_BYTES: usize = 1 << 16;

/// A number type that arrays are written in.
pub(in crate::io) trait Scalar: Copy {
    /// numpy's name of the type.
    const DESCR: &'static str;
    /// Bytes of one number.
    const BYTES: usize;
    /// Appends the little-endian bytes.
    fn put(self, out: &mut Vec<u8>);
    /// From a number of any type in a file; `None` if this type cannot hold it.
    fn from_number(number: Number) -> Option<Self>;
}

/// A number as read.
#[derive(Debug, Clone, Copy)]
pub(in crate::io) enum Number {
    Float(f64),
    Integer(i64),
}

macro_rules! scalar {
    ($type:ty, $descr:literal, $number:ident => $from:expr) => {
        impl Scalar for $type {
            const DESCR: &'static str = $descr;
            const BYTES: usize = size_of::<$type>();
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn from_number($number: Number) -> Option<Self> {
                $from
            }
        }
    };
}

scalar!(f64, "<f8", n => Some(match n { Number::Float(v) => v, Number::Integer(v) => v as f64 }));
scalar!(f32, "<f4", n => Some(match n { Number::Float(v) => v as f32, Number::Integer(v) => v as f32 }));
scalar!(i64, "<i8", n => integer(n));
scalar!(i32, "<i4", n => integer(n)?.try_into().ok());
scalar!(u32, "<u4", n => integer(n)?.try_into().ok());
scalar!(u8, "|u1", n => integer(n)?.try_into().ok());

fn integer(number: Number) -> Option<i64> {
    match number {
        Number::Integer(v) => Some(v),
        Number::Float(_) => None,
    }
}

/// Writes header and numbers; `values` yields as many as `shape` says.
pub(super) fn write<T: Scalar>(
    out: &mut dyn Write,
    shape: &[usize],
    values: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    let dimensions: String = shape.iter().map(|d| format!("{d},")).collect();
    let mut text = format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({dimensions}), }}", T::DESCR);
    // Magic, version and length take 10 bytes; numpy wants the data aligned to 64.
    while (10 + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(text.len() as u16).to_le_bytes())?;
    out.write_all(text.as_bytes())?;
    let mut block = Vec::with_capacity(BLOCK_BYTES + 8);
    for value in values {
        value.put(&mut block);
        if block.len() >= BLOCK_BYTES {
            out.write_all(&block)?;
            block.clear();
        }
    }
    out.write_all(&block)
}

/// What a header says.
pub(super) struct Header {
    /// numpy's name of the number type.
    pub descr: String,
    /// Size of every dimension.
    pub shape: Vec<usize>,
}

/// Reads the header; the reader then stands at the first number.
pub(super) fn read_header(reader: &mut dyn Read) -> Result<Header, String> {
    let mut bytes = [0; 4];
    let mut magic = [0; 8];
    read_exact(reader, &mut magic)?;
    if &magic[..6] != b"\x93NUMPY" {
        return Err("found no numpy array, expected a .npy header".into());
    }
    let length_bytes = if magic[6] == 1 { 2 } else { 4 };
    read_exact(reader, &mut bytes[..length_bytes])?;
    let length = u32::from_le_bytes(bytes) as usize;
    if length > MAX_HEADER_BYTES {
        return Err(format!("found a header of {length} bytes, expected at most {MAX_HEADER_BYTES}"));
    }
    let mut text = vec![0; length];
    read_exact(reader, &mut text)?;
    let text = String::from_utf8_lossy(&text);
    parse_header(&text)
        .ok_or_else(|| format!("found the header '{}', expected one that numpy writes", text.trim()))?
}

fn read_exact(reader: &mut dyn Read, bytes: &mut [u8]) -> Result<(), String> {
    reader.read_exact(bytes).map_err(|e| format!("found damaged or cut-off data ({e})"))
}

/// `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }`; `None` if it does not look like that.
fn parse_header(text: &str) -> Option<Result<Header, String>> {
    let after = |key: &str| {
        let at = text.find(key)? + key.len();
        Some(text[at..].trim_start().strip_prefix(':')?.trim_start())
    };
    let descr = after("'descr'")?.strip_prefix('\'')?.split_once('\'')?.0.to_string();
    let is_fortran = after("'fortran_order'")?.starts_with("True");
    let inside = after("'shape'")?.strip_prefix('(')?.split_once(')')?.0;
    let mut shape = Vec::new();
    for size in inside.split(',').map(str::trim).filter(|s| !s.is_empty()) {
        shape.push(size.parse().ok()?);
    }
    if is_fortran && shape.len() > 1 {
        return Some(Err("found Fortran order, expected C order (numpy.ascontiguousarray)".into()));
    }
    Some(Ok(Header { descr, shape }))
}

/// Gives every number to `visit` (false: it cannot take it), then makes sure that nothing follows.
pub(super) fn read_numbers(
    reader: &mut dyn Read,
    header: &Header,
    mut visit: impl FnMut(Number) -> bool,
) -> Result<(), String> {
    let too_many = || format!("found shape {:?}, expected one that fits into memory", header.shape);
    let count = header.shape.iter().try_fold(1_usize, |n, &d| n.checked_mul(d)).ok_or_else(too_many)?;
    let (bytes, decode) = decoder(&header.descr)?;
    let mut left = count.checked_mul(bytes).ok_or_else(too_many)?;
    let mut block = vec![0; BLOCK_BYTES.min(left)];
    while left > 0 {
        let size = left.min(block.len());
        read_exact(reader, &mut block[..size])?;
        for item in block[..size].chunks_exact(bytes) {
            let number = decode(item);
            if !visit(number) {
                return Err(match number {
                    Number::Float(v) => format!("found {v}, expected whole numbers"),
                    Number::Integer(v) => format!("found {v}, which is out of range"),
                });
            }
        }
        left -= size;
    }
    match reader.read(&mut [0]) {
        Ok(0) => Ok(()),
        Ok(_) => Err(format!("found more than {count} numbers, expected the shape {:?}", header.shape)),
        Err(e) => Err(format!("found damaged data ({e})")),
    }
}

type Decode = fn(&[u8]) -> Number;

/// Bytes of a number, and how to read one. `BLOCK_BYTES` is a multiple of all sizes.
fn decoder(descr: &str) -> Result<(usize, Decode), String> {
    fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
        let mut array = [0; N];
        array.copy_from_slice(&bytes[..N]);
        array
    }
    Ok(match descr {
        "<f8" => (8, |b| Number::Float(f64::from_le_bytes(array(b)))),
        "<f4" => (4, |b| Number::Float(f32::from_le_bytes(array(b)).into())),
        "<i8" => (8, |b| Number::Integer(i64::from_le_bytes(array(b)))),
        "<i4" => (4, |b| Number::Integer(i32::from_le_bytes(array(b)).into())),
        "<u4" => (4, |b| Number::Integer(u32::from_le_bytes(array(b)).into())),
        "|u1" => (1, |b| Number::Integer(b[0].into())),
        _ => return Err(format!("found type '{descr}', expected one of <f8, <f4, <i8, <i4, <u4, |u1")),
    })
}
