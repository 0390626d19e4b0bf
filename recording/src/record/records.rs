//! The records of an MCAP file, which may break off, or be damaged, at any byte.
//!
//! The readers of the crate `mcap` expect whole files: they end at the first chunk that is not whole, some
//! damages make them panic, and a damaged length makes them ask for as much memory. Here, no length is
//! believed beyond the bytes that are there, and the checksum of a chunk is compared before its records are
//! read. Chunks are not compressed, because dotgen compresses none.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use mcap::MAGIC;
use mcap::read::parse_record;
use mcap::records::{Channel, Metadata, Record, op};

use super::Break;

/// Bytes of the opcode and the length of a record.
const HEAD: usize = 9;

/// Bytes of a chunk before its records: two times, a length, a checksum, no name of a compression, a length.
const CHUNK: usize = 40;

/// The reason why the records end before the file does.
enum Cause {
    /// Bytes are missing.
    Cut(&'static str),
    /// Bytes are wrong.
    Wrong(String),
    /// The file is not written as dotgen writes it.
    Foreign(&'static str),
}

/// The place of a cause is the address of the bytes that have it.
type Flow<'b> = ControlFlow<(Cause, &'b [u8])>;

/// Reads the records up to the end of the data, those of chunks too. `each` gets channels, messages and
/// metadata; it may end the file with a reason. Returns the place and the reason if the file breaks off.
///
/// # Errors
///
/// Returns a message if the bytes are no MCAP file.
pub(super) fn each(
    bytes: &[u8],
    each: &mut dyn FnMut(Record<'_>) -> ControlFlow<String>,
) -> Result<Option<Break>, String> {
    let ended = bytes.len() > MAGIC.len() && bytes.ends_with(MAGIC);
    // A power cut leaves zeros where the file system had room, and no data yet.
    let zeros = bytes.iter().rev().take_while(|&&byte| byte == 0 && !ended).count();
    let there = &bytes[..bytes.len() - zeros];
    let Some(rest) = there.strip_prefix(MAGIC) else {
        return Err(if bytes.is_empty() {
            "it is empty".to_owned()
        } else {
            "it is no MCAP file".to_owned()
        });
    };
    let (cause, place) = match records(rest, Some(there), each) {
        ControlFlow::Break(cause) => cause,
        ControlFlow::Continue(()) if !ended => {
            (Cause::Cut("its index is cut"), &there[there.len()..])
        }
        ControlFlow::Continue(()) => return Ok(None),
    };
    let at = place.as_ptr() as usize - bytes.as_ptr() as usize;
    Ok(Some(match cause {
        // What is missing in the middle of a file that has its end is a wrong length.
        Cause::Cut(_) if ended => Break { why: "a length is wrong".to_owned(), damaged: Some(at) },
        Cause::Cut(why) | Cause::Foreign(why) => Break { why: why.to_owned(), damaged: None },
        Cause::Wrong(why) => Break { why, damaged: Some(at) },
    }))
}

/// Reads records, those of a file (which is `file`, with its beginning) or those of a chunk.
fn records<'b>(
    mut bytes: &'b [u8],
    file: Option<&'b [u8]>,
    each: &mut dyn FnMut(Record<'_>) -> ControlFlow<String>,
) -> Flow<'b> {
    let wrong = |why: &str, place| ControlFlow::Break((Cause::Wrong(why.to_owned()), place));
    while file.is_some() || !bytes.is_empty() {
        let cut = ControlFlow::Break((Cause::Cut("a record is cut"), bytes));
        let Some((head, rest)) = bytes.split_first_chunk::<HEAD>() else {
            return cut;
        };
        let [opcode, length @ ..] = *head;
        let length = u64::from_le_bytes(length);
        let body = split(rest, length);
        match (opcode, file, body) {
            (op::CHUNK, Some(_), _) => {
                let (body, whole) = body.map_or((rest, false), |(body, _)| (body, true));
                chunk(bytes, body, length, whole, each)?;
            }
            (op::DATA_END, Some(file), Some((body, _))) => {
                let before = &file[..bytes.as_ptr() as usize - file.as_ptr() as usize];
                return match body.first_chunk().map(|crc| u32::from_le_bytes(*crc)) {
                    Some(0) => ControlFlow::Continue(()),
                    Some(crc) if crc == crc32fast::hash(before) => ControlFlow::Continue(()),
                    _ => wrong("the checksum of everything before differs", bytes),
                };
            }
            (0 | op::FOOTER | op::CHUNK_INDEX | op::STATISTICS | op::SUMMARY_OFFSET, _, _) => {
                return wrong("there is no such record", bytes);
            }
            (op::CHANNEL | op::MESSAGE | op::METADATA, _, Some((body, _))) => {
                let Some(record) = record(opcode, body) else {
                    return wrong("a record is none", bytes);
                };
                if let ControlFlow::Break(why) = each(record) {
                    return wrong(&why, bytes);
                }
            }
            _ => {}
        }
        match body {
            Some((_, after)) => bytes = after,
            None => return cut,
        }
    }
    ControlFlow::Continue(())
}

/// Reads the records of a chunk, as far as they are there. `length` is that of the record. A chunk that is
/// whole is read only if its checksum is right.
fn chunk<'b>(
    at: &'b [u8],
    body: &'b [u8],
    length: u64,
    whole: bool,
    each: &mut dyn FnMut(Record<'_>) -> ControlFlow<String>,
) -> Flow<'b> {
    let end = |cause| ControlFlow::Break((cause, at));
    let Some((head, content)) = body.split_first_chunk::<CHUNK>() else {
        return end(if whole {
            Cause::Wrong("a chunk is too short".to_owned())
        } else {
            Cause::Cut("a chunk is cut")
        });
    };
    let number = |from: usize| {
        let bytes = head[from..].first_chunk().copied();
        u64::from_le_bytes(bytes.unwrap_or_default())
    };
    // The checksum, and the length of the name.
    let (crc, name) = (number(24) as u32, number(24) >> 32);
    let is = |known: &[u8]| name == known.len() as u64 && head[32..].starts_with(known);
    if is(b"lz4") || is(b"zstd") {
        return end(Cause::Foreign("a chunk is compressed, which dotgen never does"));
    }
    // Three lengths say the same.
    let content_length = length.checked_sub(CHUNK as u64);
    if name != 0 || Some(number(16)) != content_length || Some(number(32)) != content_length {
        return end(Cause::Wrong("the length of a chunk is wrong".to_owned()));
    }
    if !whole {
        return records(content, None, each);
    }
    if crc != 0 && crc != crc32fast::hash(content) {
        return end(Cause::Wrong("the checksum of a chunk differs".to_owned()));
    }
    match records(content, None, each) {
        ControlFlow::Break((Cause::Cut(_), place)) => {
            ControlFlow::Break((Cause::Wrong("a length is wrong".to_owned()), place))
        }
        flow => flow,
    }
}

/// Parses a channel, a message or metadata. Returns `None` if the bytes are none.
fn record(opcode: u8, mut body: &[u8]) -> Option<Record<'_>> {
    let rest = &mut body;
    Some(match opcode {
        op::CHANNEL => Record::Channel(Channel {
            id: u16::from_le_bytes(take(rest)?),
            schema_id: u16::from_le_bytes(take(rest)?),
            topic: string(rest)?,
            message_encoding: string(rest)?,
            metadata: map(rest)?,
        }),
        op::METADATA => Record::Metadata(Metadata { name: string(rest)?, metadata: map(rest)? }),
        _ => return parse_record(opcode, body).ok(),
    })
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

/// Takes bytes with their length before them.
fn sized<'b>(bytes: &mut &'b [u8]) -> Option<&'b [u8]> {
    let length = u32::from_le_bytes(take(bytes)?);
    let (first, rest) = split(bytes, length.into())?;
    *bytes = rest;
    Some(first)
}

fn string(bytes: &mut &[u8]) -> Option<String> {
    String::from_utf8(sized(bytes)?.to_vec()).ok()
}

fn map(bytes: &mut &[u8]) -> Option<BTreeMap<String, String>> {
    let mut pairs = sized(bytes)?;
    let mut out = BTreeMap::new();
    while !pairs.is_empty() {
        out.insert(string(&mut pairs)?, string(&mut pairs)?);
    }
    Some(out)
}

/// Splits bytes after a length; returns `None` if they are fewer.
fn split(bytes: &[u8], length: u64) -> Option<(&[u8], &[u8])> {
    bytes.split_at_checked(usize::try_from(length).ok()?)
}
