//! Just enough of MATLAB's level 5 files to read plain numeric arrays of them.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// Arrays by name: rows, columns, values by column.
pub type Arrays = BTreeMap<String, (usize, usize, Vec<f64>)>;

const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;

/// Reads every numeric array of an xz-compressed file.
pub fn read(path: &Path) -> std::io::Result<Arrays> {
    let mut bytes = Vec::new();
    lzma_rust2::XzReader::new(std::fs::File::open(path)?, true).read_to_end(&mut bytes)?;
    let mut arrays = Arrays::new();
    let mut rest = &bytes[128..];
    while let Some((kind, content, left)) = element(rest) {
        rest = left;
        if kind == MATRIX {
            array(content, &mut arrays);
        }
        if kind == COMPRESSED {
            let mut inner = Vec::new();
            flate2::read::ZlibDecoder::new(content).read_to_end(&mut inner)?;
            if let Some((MATRIX, matrix, _)) = element(&inner) {
                array(matrix, &mut arrays);
            }
        }
    }
    Ok(arrays)
}

/// The first element: its type, its content, and what follows.
fn element(bytes: &[u8]) -> Option<(u32, &[u8], &[u8])> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let tag = word(0)?;
    if tag >> 16 != 0 {
        // A small element: size and content within eight bytes.
        let size = (tag >> 16) as usize;
        return Some((tag & 0xffff, bytes.get(4..4 + size)?, bytes.get(8..)?));
    }
    let size = word(4)? as usize;
    let padded = if tag == COMPRESSED { size } else { size.div_ceil(8) * 8 };
    let content = bytes.get(8..8 + size)?;
    Some((tag, content, bytes.get(8 + padded..).unwrap_or_default()))
}

fn array(bytes: &[u8], arrays: &mut Arrays) {
    let parse = || {
        let (_, _, rest) = element(bytes)?;
        let (_, dimensions, rest) = element(rest)?;
        let (_, name, rest) = element(rest)?;
        let (kind, content, _) = element(rest)?;
        let dimension =
            |at: usize| Some(i32::from_le_bytes(dimensions.get(at..at + 4)?.try_into().ok()?) as usize);
        let values: Vec<f64> = match kind {
            9 => content.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("eight"))).collect(),
            7 => content
                .chunks_exact(4)
                .map(|b| f32::from_le_bytes(b.try_into().expect("four")).into())
                .collect(),
            _ => return None,
        };
        Some((String::from_utf8_lossy(name).into_owned(), (dimension(0)?, dimension(4)?, values)))
    };
    arrays.extend(parse());
}
