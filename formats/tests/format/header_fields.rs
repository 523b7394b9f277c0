//! Each field of the header changed in turn, checksums made right again: the error names the field's fault.
//!
//! The two hashes are not here: any 32 bytes are a hash.

use crate::fixture::{Forge, model, read_copy, sampled_model};
use restpose_formats::{FormatError, FormatVersion, Header, SectionKind};

fn error_of(change: impl FnOnce(&mut Header)) -> FormatError {
    let bytes = Forge::of(&model()).bytes_with(|header, _| change(header));
    read_copy(&bytes).expect_err("the header is wrong")
}

#[test]
fn version() {
    for (major, minor) in [
        (0, 0),
        (0, 9),
        (1, 0),
        (1, 1),
        (1, 2),
        (1, 4),
        (2, 0),
        (u16::MAX, u16::MAX),
    ] {
        let error = error_of(|header| (header.major, header.minor) = (major, minor));
        let supported = FormatVersion::READABLE;
        assert_eq!(
            error,
            FormatError::Version {
                major,
                minor,
                supported
            }
        );
    }
}

#[test]
fn header_length() {
    for found in [0, 127, 192, u32::MAX] {
        let error = error_of(|header| header.header_len = found);
        assert_eq!(error, FormatError::HeaderLength { expected: 128, found });
    }
}

#[test]
fn file_length() {
    let error = error_of(|header| header.file_len += 1);
    assert!(matches!(error, FormatError::Truncated { what: "file", .. }), "{error}");
    let error = error_of(|header| header.file_len -= 1);
    assert!(matches!(error, FormatError::TrailingBytes { .. }), "{error}");
    let error = error_of(|header| header.file_len = u64::MAX);
    assert!(matches!(error, FormatError::Truncated { .. }), "{error}");
}

#[test]
fn checksum() {
    let mut bytes = Forge::of(&model()).bytes();
    bytes[20] ^= 1;
    let error = read_copy(&bytes).unwrap_err();
    assert!(matches!(error, FormatError::HeaderChecksum { .. }), "{error}");
}

#[test]
fn required_features() {
    for bit in [0, 1, 63] {
        let error = error_of(|header| header.required_features = 1 << bit);
        assert_eq!(error, FormatError::RequiredFeatures { unknown: 1 << bit });
    }
}

#[test]
fn optional_features() {
    for (model, expected) in [(model(), false), (sampled_model(), true)] {
        let bytes = Forge::of(&model).bytes_with(|header, _| header.optional_features ^= 1);
        let (bit, found) = (1, !expected);
        assert_eq!(
            read_copy(&bytes),
            Err(FormatError::FeatureMismatch { bit, expected, found })
        );
    }
    let bytes = Forge::of(&model()).bytes_with(|header, _| header.optional_features |= 1 << 40);
    assert_eq!(read_copy(&bytes), Ok(model()), "an unknown optional feature is ignored");
}

#[test]
fn section_count() {
    let error = error_of(|header| header.section_count = u32::MAX);
    assert!(matches!(error, FormatError::SectionTableOutOfBounds { .. }), "{error}");
    let error = error_of(|header| header.section_count -= 1);
    assert_eq!(
        error,
        FormatError::SectionMissing {
            section: SectionKind::MorphEnvelopes
        }
    );
    let error = error_of(|header| header.section_count = 0);
    assert_eq!(
        error,
        FormatError::SectionMissing {
            section: SectionKind::Meta
        }
    );
}

#[test]
fn reserved_fields() {
    let changes: [fn(&mut Header); 3] = [
        |header| header.reserved_a = 1,
        |header| header.reserved_b = 1,
        |header| header.reserved_c = 1,
    ];
    for change in changes {
        let error = error_of(change);
        assert!(matches!(error, FormatError::HeaderReserved { found: 1, .. }), "{error}");
    }
}
