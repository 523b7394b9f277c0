use super::{Cache, Counts, Times, short_header};
use crate::import::{Fault, fault_list::FaultList};

/// What a PC2 file begins with.
pub(in crate::import) const MAGIC: &[u8] = b"POINTCACHE2\0";

const HEADER_BYTES: usize = 32;

/// Reads a PC2 file: magic, i32 version 1, i32 points, f32 start frame, f32 frames per sample, i32 samples; then the
/// samples, three f32 per point. All little-endian.
///
/// # Errors
/// A fault: not this format or version, or as [`Cache::new`].
pub(in crate::import) fn read<'a>(bytes: &'a [u8], faults: &mut FaultList) -> Result<Cache<'a>, Fault> {
    if !bytes.starts_with(MAGIC) && !MAGIC.starts_with(bytes) {
        return Err(Fault::error(
            "header",
            "the file does not begin with POINTCACHE2; it is no PC2 file",
        ));
    }
    let Some((header, body)) = bytes.split_first_chunk::<HEADER_BYTES>() else {
        return Err(short_header(HEADER_BYTES, bytes.len()));
    };
    let [_, _, _, version, points, start, step, frames] = *header.as_chunks::<4>().0 else {
        return Err(short_header(HEADER_BYTES, bytes.len()));
    };
    let version = i32::from_le_bytes(version);
    if version != 1 {
        let message = format!("is version {version} of PC2; expected version 1, export the cache again");
        return Err(Fault::error("header", message));
    }
    let counts = Counts::new(i32::from_le_bytes(points), i32::from_le_bytes(frames))?;
    let times = Times::Frames {
        start: f32::from_le_bytes(start),
        step: f32::from_le_bytes(step),
    };
    Cache::new(counts, times, body, f32::from_le_bytes, faults)
}
