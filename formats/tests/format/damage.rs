use crate::{
    fixture::{Forge, model, read_copy},
    golden::V1_3,
};
use restpose_formats::{AlignedBytes, FormatError, MAGIC, SectionKind, read, read_written};

#[test]
fn every_truncation_is_refused_by_name() {
    for len in 0..V1_3.len() {
        let error = read_copy(&V1_3[..len]).expect_err("cut short");
        assert!(matches!(error, FormatError::Truncated { .. }), "{len} bytes: {error}");
    }
}

#[test]
fn every_truncation_with_a_file_length_to_match_is_refused() {
    for len in 128..V1_3.len() {
        let file = Forge::of(&model()).bytes_with(|header, _| header.file_len = len as u64);
        assert!(read_copy(&file[..len]).is_err(), "{len} bytes");
    }
}

#[test]
fn one_byte_more_is_refused() {
    let longer = [V1_3, &[0]].concat();
    let (expected, found) = (V1_3.len() as u64, V1_3.len() as u64 + 1);
    assert_eq!(read_copy(&longer), Err(FormatError::TrailingBytes { expected, found }));
    let sealed = {
        let mut file = Forge::of(&model()).bytes_with(|header, _| header.file_len += 1);
        file.push(0);
        file
    };
    assert_eq!(
        read_copy(&sealed),
        Err(FormatError::BytesAfterSections { expected, found })
    );
}

#[test]
fn every_value_of_every_header_and_table_byte_but_its_own_is_refused() {
    let mut bytes = AlignedBytes::copy_of(V1_3);
    for at in 0..128 + SectionKind::ALL.len() * 40 {
        for change in 1..=255 {
            bytes.as_mut_slice()[at] ^= change;
            assert!(read(bytes.as_slice()).is_err(), "byte {at} changed by {change:#04x}");
            bytes.as_mut_slice()[at] ^= change;
        }
    }
    assert!(read(bytes.as_slice()).is_ok());
}

#[test]
fn every_changed_bit_of_the_file_is_refused() {
    let mut bytes = AlignedBytes::copy_of(V1_3);
    for at in 0..V1_3.len() {
        for bit in 0..8 {
            bytes.as_mut_slice()[at] ^= 1 << bit;
            assert!(read(bytes.as_slice()).is_err(), "byte {at}, bit {bit}");
            bytes.as_mut_slice()[at] ^= 1 << bit;
        }
    }
}

#[test]
fn another_kind_of_file_is_named_as_such() {
    for bytes in [&b"glTF\x02\0\0\0aaaaaaaaaaaa"[..], b"\x89PNG\r\n\x1a\n", b"x", b"{}"] {
        let error = read_copy(bytes).unwrap_err();
        assert!(matches!(error, FormatError::NotRestpose { .. }), "{error}");
    }
}

#[test]
fn a_transfer_in_text_mode_has_its_own_hint() {
    let body = &V1_3[MAGIC.len()..];
    let magics: [&[u8]; 8] = [
        b"\x8BRPOSE\n\x1A\n",
        b"\x8BRPOSE\r\n\x1A\r\n",
        b"\x8BRPOSE\r\r\n\x1A\r\n",
        b"\x8BRPOSE\r\r\x1A\r",
        b"\x0BRPOSE\r\n\x1A\n",
        b"\xC2\x8BRPOSE\r\n\x1A\n",
        b"\xEF\xBF\xBDRPOSE\r\n\x1A\n",
        b"?RPOSE\r\n\x1A\n",
    ];
    for magic in magics {
        let error = read_copy(&[magic, body].concat()).unwrap_err();
        assert!(matches!(error, FormatError::TextModeTransfer { .. }), "{error}");
        assert!(error.to_string().contains("copy it again in binary mode"), "{error}");
    }
}

/// A row per clip and one more, as before there were stretches: another clip's box would be taken for that of a stretch.
#[test]
fn bounds_of_whole_clips_are_refused_without_a_look_at_rows() {
    let mut model = model();
    model.clip_bounds.truncate(model.clips.len() + 1);
    let file = AlignedBytes::copy_of(&Forge::of(&model).bytes());
    let error = read_written(file.as_slice()).expect_err("too few rows");
    let expected = FormatError::RowCount {
        section: SectionKind::ClipBounds,
        expected: 65,
        found: 3,
    };
    assert_eq!(error, expected);
}
