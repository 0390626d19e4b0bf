//! The records of an MCAP file, which may break off at any byte.
//!
//! The readers of the crate `mcap` expect whole files: they end at the first chunk that is not whole, and
//! some damages make them panic. Chunks are not compressed, because dotgen compresses none.

use std::ops::ControlFlow;

use mcap::MAGIC;
use mcap::read::parse_record;
use mcap::records::{Record, op};

/// Bytes of the opcode and the length of a record.
const HEAD: usize = 9;

/// Bytes of a chunk before the name of its compression: two times, a length, a checksum.
const CHUNK: usize = 28;

/// Reads the records up to the end of the data, those of chunks too. `each` gets channels, messages and
/// metadata; it may end the file with a reason. Returns the reason if the file breaks off.
///
/// # Errors
///
/// Returns a message if the bytes are no MCAP file.
pub(super) fn each(
    bytes: &[u8],
    each: &mut dyn FnMut(Record<'_>) -> ControlFlow<String>,
) -> Result<Option<String>, String> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Err(match bytes.is_empty() {
            true => "it is empty".to_owned(),
            false => "it is no MCAP file".to_owned(),
        });
    };
    Ok(match records(rest, true, each) {
        ControlFlow::Break(why) => Some(why),
        ControlFlow::Continue(()) if !bytes.ends_with(MAGIC) => Some("its index is cut".to_owned()),
        ControlFlow::Continue(()) => None,
    })
}

fn records(
    mut bytes: &[u8],
    is_file: bool,
    each: &mut dyn FnMut(Record<'_>) -> ControlFlow<String>,
) -> ControlFlow<String> {
    let cut = || ControlFlow::Break("a record is cut".to_owned());
    let damaged = || ControlFlow::Break("a record is damaged".to_owned());
    while is_file || !bytes.is_empty() {
        let Some((head, rest)) = bytes.split_first_chunk::<HEAD>() else {
            return cut();
        };
        let [opcode, length @ ..] = *head;
        let body = split(rest, u64::from_le_bytes(length));
        match (opcode, body) {
            (op::CHUNK, _) if is_file => {
                let length = u64::from_le_bytes(length);
                let available =
                    usize::try_from(length).map_or(rest.len(), |length| length.min(rest.len()));
                chunk(rest.get(..available).unwrap_or_default(), each)?;
            }
            (op::DATA_END, Some(_)) if is_file => return ControlFlow::Continue(()),
            (0, _) => return damaged(),
            (op::CHANNEL | op::MESSAGE | op::METADATA, Some((body, _))) => {
                match parse_record(opcode, body) {
                    Ok(record) => each(record)?,
                    Err(_) => return damaged(),
                }
            }
            _ => {}
        }
        match body {
            Some((_, after)) => bytes = after,
            None => return cut(),
        }
    }
    ControlFlow::Continue(())
}

/// Reads the records of a chunk, as far as they are there.
fn chunk(
    body: &[u8],
    each: &mut dyn FnMut(Record<'_>) -> ControlFlow<String>,
) -> ControlFlow<String> {
    let cut = || ControlFlow::Break("a chunk is cut".to_owned());
    let Some((_, rest)) = body.split_at_checked(CHUNK) else {
        return cut();
    };
    let Some((length, rest)) = rest.split_first_chunk() else {
        return cut();
    };
    if u32::from_le_bytes(*length) != 0 {
        return ControlFlow::Break("a chunk is compressed, which dotgen never does".to_owned());
    }
    let Some((_, content)) = rest.split_first_chunk::<8>() else {
        return cut();
    };
    records(content, false, each)
}

/// Splits bytes after a length; returns `None` if they are fewer.
fn split(bytes: &[u8], length: u64) -> Option<(&[u8], &[u8])> {
    bytes.split_at_checked(usize::try_from(length).ok()?)
}
