use crate::{
    error::FormatError,
    header::Header,
    section::{SectionCode, SectionEntry, SectionKind, align_up},
};

/// The bytes of every known section, after every check that needs no knowledge of what rows mean.
pub(crate) struct Sections<'a> {
    found: Vec<(SectionKind, &'a [u8])>,
}

impl<'a> Sections<'a> {
    /// Walks the section table of the file `bytes` and checks order, layout, bounds, gaps and checksums.
    pub(crate) fn open(bytes: &'a [u8], table: &[u8]) -> Result<Self, FormatError> {
        let entries = table.chunks_exact(size_of::<SectionEntry>());
        let entries: Vec<SectionEntry> = entries.map(bytemuck::pod_read_unaligned).collect();
        let kinds = check_kinds(&entries)?;
        let mut found = Vec::with_capacity(SectionKind::ALL.len());
        let mut end = Header::LEN + table.len();
        for (entry, kind) in entries.iter().zip(kinds) {
            let section = locate(entry, bytes, end)?;
            end = section.end;
            if let Some(kind) = kind {
                found.push((kind, section.bytes));
            }
        }
        if end != bytes.len() {
            return Err(FormatError::BytesAfterSections {
                expected: end as u64,
                found: bytes.len() as u64,
            });
        }
        Ok(Self { found })
    }

    /// The bytes of a section.
    pub(crate) fn bytes(&self, kind: SectionKind) -> Result<&'a [u8], FormatError> {
        let section = self.found.iter().find(|(found, _)| *found == kind);
        section
            .map(|(_, bytes)| *bytes)
            .ok_or(FormatError::SectionMissing { section: kind })
    }
}

/// The kind of each entry, `None` where it is unknown and may be skipped: every known section once, in file order.
fn check_kinds(entries: &[SectionEntry]) -> Result<Vec<Option<SectionKind>>, FormatError> {
    let mut expected = SectionKind::ALL.iter().copied();
    let mut kinds = Vec::with_capacity(entries.len());
    for (line, entry) in entries.iter().enumerate() {
        let kind = check_kind(entry)?;
        kinds.push(kind);
        let Some(section) = kind else { continue };
        match expected.next() {
            Some(next) if next == section => {}
            Some(next) if next < section && !entries.iter().any(|entry| entry.code == next.code()) => {
                return Err(FormatError::SectionMissing { section: next });
            }
            _ => return Err(FormatError::SectionOrder { section, line }),
        }
    }
    match expected.next() {
        Some(section) => Err(FormatError::SectionMissing { section }),
        None => Ok(kinds),
    }
}

/// The entry's kind, `None` where it is unknown and may be skipped.
fn check_kind(entry: &SectionEntry) -> Result<Option<SectionKind>, FormatError> {
    let code = SectionCode(entry.code);
    let Some(kind) = SectionKind::from_code(entry.code) else {
        return match entry.flags {
            SectionEntry::OPTIONAL => Ok(None),
            0 => Err(FormatError::SectionUnknown { code }),
            found => Err(FormatError::SectionFlags { code, found }),
        };
    };
    if entry.flags != 0 {
        return Err(FormatError::SectionFlags {
            code,
            found: entry.flags,
        });
    }
    if entry.version != SectionKind::VERSION {
        return Err(FormatError::SectionVersion {
            section: kind,
            expected: SectionKind::VERSION,
            found: entry.version,
        });
    }
    if entry.row_size != kind.row_size() {
        return Err(FormatError::RowSize {
            section: kind,
            expected: kind.row_size(),
            found: entry.row_size,
        });
    }
    Ok(Some(kind))
}

struct Located<'a> {
    bytes: &'a [u8],
    end: usize,
}

/// Finds the section's bytes in `bytes`, after whatever ended at byte `previous_end`.
fn locate<'a>(entry: &SectionEntry, bytes: &'a [u8], previous_end: usize) -> Result<Located<'a>, FormatError> {
    let SectionEntry {
        code,
        row_size,
        crc32,
        offset,
        byte_len,
        row_count,
        ..
    } = *entry;
    let code = SectionCode(code);
    if row_count.checked_mul(u64::from(row_size)) != Some(byte_len) {
        return Err(FormatError::SectionLength {
            code,
            row_size,
            row_count,
            byte_len,
        });
    }
    let out_of_bounds = FormatError::SectionOutOfBounds {
        code,
        offset,
        byte_len,
        file_len: bytes.len() as u64,
    };
    let expected = align_up(previous_end as u64).ok_or(out_of_bounds.clone())?;
    if offset != expected {
        return Err(FormatError::SectionOffset {
            code,
            expected,
            found: offset,
        });
    }
    let bounds = (|| {
        let first = usize::try_from(offset).ok()?;
        let end = first.checked_add(usize::try_from(byte_len).ok()?)?;
        Some((bytes.get(previous_end..first)?, bytes.get(first..end)?, end))
    })();
    let (gap, section, end) = bounds.ok_or(out_of_bounds)?;
    if let Some(at) = gap.iter().position(|byte| *byte != 0) {
        let found = gap.get(at).copied().unwrap_or_default();
        return Err(FormatError::GapNotZero {
            offset: (previous_end + at) as u64,
            found,
        });
    }
    let checksum = crc32fast::hash(section);
    if checksum != crc32 {
        return Err(FormatError::SectionChecksum {
            code,
            expected: crc32,
            found: checksum,
        });
    }
    Ok(Located { bytes: section, end })
}
