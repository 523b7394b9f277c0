//! Each field of each line of the section table changed in turn, checksums made right again.

use crate::fixture::{Forge, model, read_copy};
use restpose_formats::{FormatError, SectionCode, SectionEntry, SectionKind};

/// Calls `check` with each section and the error that its changed line gives.
fn for_each_line(change: impl Fn(&mut SectionEntry), check: impl Fn(SectionKind, &FormatError) -> bool) {
    for (line, kind) in SectionKind::ALL.iter().enumerate() {
        let bytes = Forge::of(&model()).bytes_with(|_, table| change(&mut table[line]));
        let error = read_copy(&bytes).expect_err("the table is wrong");
        assert!(check(*kind, &error), "{kind}: {error}");
    }
}

fn is_code(code: SectionCode, kind: SectionKind) -> bool {
    code == SectionCode(kind.code())
}

#[test]
fn code() {
    for_each_line(
        |entry| entry.code = *b"NOPE",
        |_, error| matches!(error, FormatError::SectionUnknown { code: SectionCode(code) } if code == b"NOPE"),
    );
    for_each_line(
        |entry| (entry.code, entry.flags) = (*b"NOPE", SectionEntry::OPTIONAL),
        |kind, error| *error == FormatError::SectionMissing { section: kind },
    );
}

#[test]
fn version() {
    for_each_line(
        |entry| entry.version = 2,
        |kind, error| {
            *error
                == FormatError::SectionVersion {
                    section: kind,
                    expected: 1,
                    found: 2,
                }
        },
    );
}

#[test]
fn flags() {
    for flags in [SectionEntry::OPTIONAL, 2, 0x8000] {
        for_each_line(
            |entry| entry.flags = flags,
            |kind, error| matches!(error, FormatError::SectionFlags { code, found } if is_code(*code, kind) && *found == flags),
        );
    }
}

#[test]
fn row_size() {
    for_each_line(
        |entry| entry.row_size *= 2,
        |kind, error| matches!(error, FormatError::RowSize { section, .. } if *section == kind),
    );
}

#[test]
fn checksum() {
    for_each_line(
        |entry| entry.crc32 ^= 1,
        |kind, error| matches!(error, FormatError::SectionChecksum { code, .. } if is_code(*code, kind)),
    );
}

#[test]
fn offset() {
    let changes: [fn(&mut SectionEntry); 4] = [
        |entry| entry.offset += 64,
        |entry| entry.offset += 1,
        |entry| entry.offset = 0,
        |entry| entry.offset = u64::MAX,
    ];
    for change in changes {
        for_each_line(
            change,
            |kind, error| matches!(error, FormatError::SectionOffset { code, .. } if is_code(*code, kind)),
        );
    }
}

#[test]
fn byte_length_or_row_count_alone() {
    let changes: [fn(&mut SectionEntry); 4] = [
        |entry| entry.byte_len += 1,
        |entry| entry.byte_len = u64::MAX,
        |entry| entry.row_count += 1,
        |entry| entry.row_count = u64::MAX / 2 + 1,
    ];
    for change in changes {
        for_each_line(
            change,
            |kind, error| matches!(error, FormatError::SectionLength { code, .. } if is_code(*code, kind)),
        );
    }
}

#[test]
fn byte_length_and_row_count_together() {
    for_each_line(
        |entry| {
            entry.row_count = u64::MAX / u64::from(entry.row_size);
            entry.byte_len = entry.row_count * u64::from(entry.row_size);
        },
        |kind, error| matches!(error, FormatError::SectionOutOfBounds { code, .. } if is_code(*code, kind)),
    );
}

#[test]
fn a_missing_section_is_named() {
    for (line, kind) in SectionKind::ALL.iter().enumerate() {
        let mut file = Forge::of(&model());
        file.sections.remove(line);
        assert_eq!(
            read_copy(&file.bytes()),
            Err(FormatError::SectionMissing { section: *kind })
        );
    }
}

#[test]
fn a_repeated_section_is_named() {
    for (line, kind) in SectionKind::ALL.iter().enumerate() {
        let mut file = Forge::of(&model());
        let again = (file.sections[line].0, file.sections[line].1.clone());
        file.sections.insert(line + 1, again);
        let error = read_copy(&file.bytes()).unwrap_err();
        let expected = FormatError::SectionOrder {
            section: *kind,
            line: line + 1,
        };
        assert_eq!(error, expected);
    }
}

#[test]
fn sections_in_another_order_are_refused() {
    for line in 0..SectionKind::ALL.len() - 1 {
        let mut file = Forge::of(&model());
        file.sections.swap(line, line + 1);
        let error = read_copy(&file.bytes()).unwrap_err();
        assert!(matches!(error, FormatError::SectionOrder { .. }), "{error}");
    }
}

#[test]
fn every_byte_between_sections_must_be_zero() {
    let valid = Forge::of(&model());
    let mut gaps = Vec::new();
    let bytes = valid.bytes_with(|_, table| {
        let mut end = 128 + 40 * table.len() as u64;
        for entry in table {
            gaps.extend(end..entry.offset);
            end = entry.offset + entry.byte_len;
        }
    });
    assert!(gaps.len() > 100, "the fixture has gaps");
    for offset in gaps {
        let mut bytes = bytes.clone();
        bytes[offset as usize] = 7;
        assert_eq!(read_copy(&bytes), Err(FormatError::GapNotZero { offset, found: 7 }));
    }
}
