use crate::{
    error::FormatError,
    section::{SECTION_ALIGN, SectionEntry},
    version::FormatVersion,
};
use bytemuck::{Pod, Zeroable};

#[cfg(target_endian = "big")]
compile_error!("rows are read in place and little-endian; a big-endian host needs a reader that copies");

/// The first ten bytes of a file, in the manner of PNG: a byte above 127 and both kinds of line ending, so that
/// a transfer in text mode shows.
pub const MAGIC: [u8; 10] = *b"\x8BRPOSE\r\n\x1A\n";

/// Optional-feature bit: the boxes bound sampled poses only; [`Bounds::Sampled`](crate::Bounds::Sampled).
pub const FEATURE_SAMPLED_BOUNDS: u64 = 1;

/// The required-feature bits that this library knows. None is in use.
pub const KNOWN_REQUIRED_FEATURES: u64 = 0;

/// The first 128 bytes of a file; the section table follows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 10],
    /// Major version.
    pub major: u16,
    /// Minor version.
    pub minor: u16,
    /// Zero.
    pub reserved_a: u16,
    /// Bytes of this header, 128.
    pub header_len: u32,
    /// CRC-32 of header and section table, taken with this field zero.
    pub crc32: u32,
    /// Bytes of the whole file.
    pub file_len: u64,
    /// Bits of features without which the file cannot be read.
    pub required_features: u64,
    /// Bits of features that a reader may ignore.
    pub optional_features: u64,
    /// Lines of the section table.
    pub section_count: u32,
    /// Zero.
    pub reserved_b: u32,
    /// [`Hashes::source`](crate::Hashes::source).
    pub source_hash: [u8; 32],
    /// [`Hashes::options`](crate::Hashes::options).
    pub options_hash: [u8; 32],
    /// Zero.
    pub reserved_c: u64,
}

impl Header {
    /// Bytes of a header.
    pub const LEN: usize = size_of::<Self>();

    /// Bytes of header and section table together; `None` beyond 2⁶⁴.
    pub(crate) fn table_end(&self) -> Option<u64> {
        let table = u64::from(self.section_count).checked_mul(size_of::<SectionEntry>() as u64)?;
        table.checked_add(Self::LEN as u64)
    }

    /// CRC-32 of this header, its own field taken as zero, and the section table's bytes.
    pub(crate) fn checksum(&self, table: &[u8]) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(bytemuck::bytes_of(&Self { crc32: 0, ..*self }));
        hasher.update(table);
        hasher.finalize()
    }
}

/// Reads the header at the start of `bytes` and checks everything in it.
///
/// Returns it with the bytes of the section table.
///
/// # Errors
/// The cause, most general first: foreign, damaged by text mode, another version, cut short, too long, checksum,
/// reserved fields, features.
pub(crate) fn read_header(bytes: &[u8]) -> Result<(Header, &[u8]), FormatError> {
    check_magic(bytes)?;
    let Some(first) = bytes.get(..Header::LEN) else {
        return Err(FormatError::Truncated {
            what: "header",
            expected: Header::LEN as u64,
            found: bytes.len() as u64,
        });
    };
    let header: Header = bytemuck::pod_read_unaligned(first);
    if FormatVersion::from_numbers(header.major, header.minor).is_none() {
        return Err(FormatError::Version {
            major: header.major,
            minor: header.minor,
            supported: FormatVersion::READABLE,
        });
    }
    if header.header_len as usize != Header::LEN {
        return Err(FormatError::HeaderLength {
            expected: Header::LEN as u32,
            found: header.header_len,
        });
    }
    let found = bytes.len() as u64;
    if found < header.file_len {
        return Err(FormatError::Truncated {
            what: "file",
            expected: header.file_len,
            found,
        });
    }
    if found > header.file_len {
        return Err(FormatError::TrailingBytes {
            expected: header.file_len,
            found,
        });
    }
    let table = header
        .table_end()
        .and_then(|end| bytes.get(Header::LEN..usize::try_from(end).ok()?))
        .ok_or(FormatError::SectionTableOutOfBounds {
            section_count: header.section_count,
            file_len: header.file_len,
        })?;
    let checksum = header.checksum(table);
    if checksum != header.crc32 {
        return Err(FormatError::HeaderChecksum {
            expected: header.crc32,
            found: checksum,
        });
    }
    check_reserved(&header)?;
    let unknown = header.required_features & !KNOWN_REQUIRED_FEATURES;
    if unknown != 0 {
        return Err(FormatError::RequiredFeatures { unknown });
    }
    Ok((header, table))
}

fn check_magic(bytes: &[u8]) -> Result<(), FormatError> {
    if bytes.starts_with(&MAGIC) {
        return Ok(());
    }
    if MAGIC.starts_with(bytes) {
        return Err(FormatError::Truncated {
            what: "header",
            expected: Header::LEN as u64,
            found: bytes.len() as u64,
        });
    }
    let mut found = [0; MAGIC.len()];
    for (to, from) in found.iter_mut().zip(bytes) {
        *to = *from;
    }
    // What is left of the name and what stands before it depends on what the transfer did: line endings changed,
    // the high bit cut off, the high byte encoded or replaced as if it were text.
    let name = &MAGIC[1..6];
    let starts: [&[u8]; 5] = [b"\x8B", b"\x0B", b"\xC2\x8B", b"\xEF\xBF\xBD", b"?"];
    if starts
        .iter()
        .any(|start| bytes.strip_prefix(*start).is_some_and(|rest| rest.starts_with(name)))
    {
        return Err(FormatError::TextModeTransfer { found });
    }
    Err(FormatError::NotRestpose { found })
}

fn check_reserved(header: &Header) -> Result<(), FormatError> {
    let fields = [
        ("reserved at byte 14", u64::from(header.reserved_a)),
        ("reserved at byte 52", u64::from(header.reserved_b)),
        ("reserved at byte 120", header.reserved_c),
    ];
    match fields.into_iter().find(|(_, found)| *found != 0) {
        Some((field, found)) => Err(FormatError::HeaderReserved { field, found }),
        None => Ok(()),
    }
}

const _: () = assert!(Header::LEN == 128 && Header::LEN.is_multiple_of(SECTION_ALIGN));
