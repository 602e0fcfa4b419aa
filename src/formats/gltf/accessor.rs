//! The bytes of a glTF file and the numbers in them. Whatever offset, length or count a file names is checked before it is
//! used (glTF 2.0, §3.6).

use super::corrupt;
use super::document::{Accessor, Buffer, Document, Index, Kind};
use super::write::{F32, I8, I16, U8, U16, U32};
use crate::formats::Error;
use crate::formats::model::{Budget, beside, unsuitable};
use std::path::Path;

/// Numbers as an accessor sees them, all within the file.
pub struct Numbers<'a> {
    bytes: &'a [u8],
    stride: usize,
    kind: Kind,
    component: u32,
    normalized: bool,
    pub count: usize,
}

/// The numbers of an accessor.
///
/// # Errors
/// What is wrong with it.
pub fn numbers<'a>(document: &Document, buffers: &'a [Vec<u8>], index: Index) -> Result<Numbers<'a>, String> {
    let wrong = |what: &str| format!("accessor {index} {what}");
    let accessor = document.accessors.get(index as usize).ok_or_else(|| wrong("is missing"))?;
    let &Accessor { byte_offset, component_type, normalized, count, kind, .. } = accessor;
    if accessor.sparse.is_some() {
        return Err(wrong("is sparse, which is not supported"));
    }
    let view = accessor.buffer_view.ok_or_else(|| wrong("has no buffer view"))?;
    let (bytes, byte_stride) = view_bytes(document, buffers, view)?;
    let size =
        component_bytes(component_type).ok_or_else(|| wrong("has an unknown type"))? * kind.components();
    let stride = match byte_stride {
        None => size,
        // The schema's bounds; less than an element would let a short buffer hold any number of them.
        Some(stride) if (4..=252).contains(&stride) && stride >= size as u64 => stride as usize,
        Some(_) => return Err(wrong("has a stride that is none")),
    };
    let end = match count {
        0 => Some(byte_offset),
        count => (count - 1)
            .checked_mul(stride as u64)
            .and_then(|last| last.checked_add(size as u64)?.checked_add(byte_offset)),
    };
    if end.is_none_or(|end| end > bytes.len() as u64) {
        return Err(wrong("reaches beyond its buffer view"));
    }
    let bytes = &bytes[byte_offset as usize..];
    Ok(Numbers { bytes, stride, kind, component: component_type, normalized, count: count as usize })
}

/// The bytes of a buffer view, with its stride.
pub fn view_bytes<'a>(
    document: &Document,
    buffers: &'a [Vec<u8>],
    index: Index,
) -> Result<(&'a [u8], Option<u64>), String> {
    let wrong = |what: &str| format!("buffer view {index} {what}");
    let view = document.buffer_views.get(index as usize).ok_or_else(|| wrong("is missing"))?;
    let buffer = buffers.get(view.buffer as usize).ok_or_else(|| wrong("has no buffer"))?;
    let end = view.byte_offset.checked_add(view.byte_length).filter(|end| *end <= buffer.len() as u64);
    let end = end.ok_or_else(|| wrong("reaches beyond its buffer"))?;
    Ok((&buffer[view.byte_offset as usize..end as usize], view.byte_stride))
}

impl Numbers<'_> {
    /// Refuses anything but vectors of `N` numbers with or without a point.
    pub fn vectors<const N: usize>(self) -> Result<Self, String> {
        let fits = self.kind.components() == N && self.component != U32;
        if fits { Ok(self) } else { Err(format!("an accessor has not the vectors of {N} that are needed")) }
    }

    /// Refuses anything but vectors of `N` whole numbers without a sign.
    pub fn wholes<const N: usize>(self) -> Result<Self, String> {
        let whole = matches!(self.component, U8 | U16 | U32) && !self.normalized;
        let fits = self.kind.components() == N && whole;
        if fits { Ok(self) } else { Err("an accessor has not the whole numbers that are needed".into()) }
    }

    /// Integers as shares of their range if the accessor says so. Elements and components beyond the last are 0.
    pub fn vector<const N: usize>(&self, element: usize) -> [f32; N] {
        std::array::from_fn(|component| {
            let (value, most) = match self.component {
                F32 => return f32::from_le_bytes(self.at(element, component)),
                I8 => (f32::from(i8::from_le_bytes(self.at(element, component))), f32::from(i8::MAX)),
                U8 => (f32::from(u8::from_le_bytes(self.at(element, component))), f32::from(u8::MAX)),
                I16 => (f32::from(i16::from_le_bytes(self.at(element, component))), f32::from(i16::MAX)),
                _ => (f32::from(u16::from_le_bytes(self.at(element, component))), f32::from(u16::MAX)),
            };
            if self.normalized { (value / most).max(-1.0) } else { value }
        })
    }

    /// As [`vector`](Self::vector).
    pub fn whole<const N: usize>(&self, element: usize) -> [u32; N] {
        std::array::from_fn(|component| match self.component {
            U8 => u8::from_le_bytes(self.at(element, component)).into(),
            U16 => u16::from_le_bytes(self.at(element, component)).into(),
            _ => u32::from_le_bytes(self.at(element, component)),
        })
    }

    fn at<const BYTES: usize>(&self, element: usize, component: usize) -> [u8; BYTES] {
        let start = element * self.stride + component * BYTES;
        let bytes = self.bytes.get(start..start + BYTES).and_then(|bytes| bytes.try_into().ok());
        bytes.unwrap_or([0; BYTES])
    }
}

fn component_bytes(component_type: u32) -> Option<usize> {
    match component_type {
        I8 | U8 => Some(1),
        I16 | U16 => Some(2),
        U32 | F32 => Some(4),
        _ => None,
    }
}

/// The buffers of a file: `binary` is the second chunk of a .glb, which the first of them may be.
pub fn buffers(
    path: &Path,
    document: &Document,
    binary: Vec<u8>,
    budget: &mut Budget,
) -> Result<Vec<Vec<u8>>, Error> {
    let mut binary = Some(binary);
    let buffer = |(index, buffer): (usize, &Buffer)| {
        let bytes = match &buffer.uri {
            Some(uri) => resource(path, uri, budget)?,
            None if index == 0 => binary.take().unwrap_or_default(),
            None => Vec::new(),
        };
        if (bytes.len() as u64) < buffer.byte_length {
            return Err(corrupt(path, format!("buffer {index} is shorter than it says")));
        }
        Ok(bytes)
    };
    document.buffers.iter().enumerate().map(buffer).collect()
}

/// What a URI names: data in itself, or a file in the folder of `path` or below.
pub fn resource(path: &Path, uri: &str, budget: &mut Budget) -> Result<Vec<u8>, Error> {
    if let Some(data) = uri.strip_prefix("data:") {
        let broken = || corrupt(path, "it holds data that is not base64");
        let (kind, text) = data.split_once(',').ok_or_else(broken)?;
        if !kind.ends_with(";base64") {
            return Err(broken());
        }
        let mut decoded = budget.room(text.len() as u64 / 4 * 3 + 3)?;
        return decode(text, &mut decoded).map(|()| decoded).ok_or_else(broken);
    }
    let Some(file) = percent_decoded(uri).and_then(|name| beside(path, &name)) else {
        let reason = "it names a file outside of its folder; write it again with everything in one .glb file";
        return Err(unsuitable(path, reason));
    };
    budget.bytes(&file)
}

/// Base64 (RFC 4648, §4).
fn decode(text: &str, into: &mut Vec<u8>) -> Option<()> {
    let (mut bits, mut held) = (0_u32, 0);
    for letter in text.trim_end_matches('=').bytes() {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            into.push((bits >> held) as u8);
        }
    }
    Some(())
}

/// A path that is written as a URI (RFC 3986, §2.1).
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let digits = [rest.next()?, rest.next()?];
                u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
            }
            byte => byte,
        });
    }
    String::from_utf8(bytes).ok()
}
