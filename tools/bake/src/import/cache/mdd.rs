use super::{Cache, Counts, Times, short_header};
use crate::import::{Fault, fault_list::FaultList};

const HEADER_BYTES: usize = 8;

/// Reads an MDD file: i32 frames, i32 points, f32 seconds per frame; then the frames, three f32 per point. All
/// big-endian. The format has no magic: anything of the right length is taken for one.
///
/// # Errors
/// A fault, as [`Cache::new`].
pub(in crate::import) fn read<'a>(bytes: &'a [u8], faults: &mut FaultList) -> Result<Cache<'a>, Fault> {
    let Some((header, body)) = bytes.split_first_chunk::<HEADER_BYTES>() else {
        return Err(short_header(HEADER_BYTES, bytes.len()));
    };
    let [frames, points] = *header.as_chunks::<4>().0 else {
        return Err(short_header(HEADER_BYTES, bytes.len()));
    };
    let counts = Counts::new(i32::from_be_bytes(points), i32::from_be_bytes(frames))?;
    let split = counts
        .frames
        .checked_mul(4)
        .and_then(|bytes| body.split_at_checked(bytes));
    let Some((times, body)) = split else {
        let message = format!(
            "truncated: the header declares {} frames, the file ends before their times; copy or export it again",
            counts.frames
        );
        return Err(Fault::error("header", message));
    };
    let seconds = times.as_chunks::<4>().0.iter().map(|time| f32::from_be_bytes(*time));
    Cache::new(
        counts,
        Times::Seconds(seconds.collect()),
        body,
        f32::from_be_bytes,
        faults,
    )
}
