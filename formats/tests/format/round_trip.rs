use crate::fixture::{Forge, model, read_copy, wide_model};
use restpose_formats::{
    AlignedBytes, FormatError, SECTION_ALIGN, SectionEntry, SectionKind, read, rows::STRETCHES, write,
};

#[test]
fn bytes_become_a_model_and_the_same_bytes_again() {
    let bytes = write(&model()).expect("the fixture is valid");
    let read_back = read_copy(&bytes).expect("what was written reads");
    assert_eq!(read_back, model());
    assert_eq!(write(&read_back), Ok(bytes));
}

#[test]
fn the_independent_writer_of_these_tests_agrees() {
    assert_eq!(write(&model()), Ok(Forge::of(&model()).bytes()));
    assert_eq!(write(&wide_model()), Ok(Forge::of(&wide_model()).bytes()));
}

#[test]
fn every_section_of_the_fixtures_has_rows_but_those_of_the_other_kind_of_trees() {
    for (model, absent) in [
        (
            model(),
            &[SectionKind::WideNodes, SectionKind::NodeMovers, SectionKind::KeyBoxes][..],
        ),
        (wide_model(), &[SectionKind::KdNodes, SectionKind::ReferenceBoxes]),
    ] {
        let file = Forge::of(&model);
        assert_eq!(file.sections.len(), SectionKind::ALL.len());
        for ((entry, bytes), kind) in file.sections.iter().zip(SectionKind::ALL) {
            assert_eq!(bytes.is_empty(), absent.contains(kind), "{}", entry.code.escape_ascii());
        }
    }
}

#[test]
fn rows_are_borrowed_and_not_copied() {
    let bytes = AlignedBytes::copy_of(&write(&model()).unwrap());
    let range = bytes.as_slice().as_ptr_range();
    let view = read(bytes.as_slice()).unwrap();
    assert!(range.contains(&view.triangles.as_ptr().cast()));
    assert!(range.contains(&view.references.as_ptr().cast()));
}

#[test]
fn a_model_without_morphs_and_clips_round_trips() {
    let mut model = model();
    model.parts[1].morph_set = u32::MAX;
    model.morph_sets.clear();
    model.morph_targets.clear();
    model.morph_first.clear();
    model.morph_deltas.clear();
    model.cluster_morphs.clear();
    model.morph_envelopes.clear();
    for space in &mut model.pose_spaces {
        (space.morph_first, space.morph_count, space.morph_envelope_first) = (0, 0, 0);
    }
    model.clips.clear();
    model.clip_bounds.drain(..2 * STRETCHES);
    model.channels.clear();
    model.key_times.clear();
    model.key_values.clear();
    model.samples.truncate(1);
    model.meta.clip_names.clear();
    let bytes = write(&model).unwrap();
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn a_model_without_caches_round_trips() {
    let mut model = model();
    model.parts.truncate(2);
    model.meta.part_names.truncate(2);
    model.meta.degenerate_triangle_count = 1;
    model.primitives.truncate(3);
    model.vertices.drain(9..17);
    model.vertices[9].influence_first = 11;
    model.influences.truncate(11);
    model.morph_first.truncate(10);
    model.triangles.truncate(6);
    model.channels.truncate(4);
    model.clips[1].channel_count = 1;
    model.clips[1].end_seconds = 0.75;
    model.caches.clear();
    model.segments.clear();
    model.tracks.clear();
    model.keys.clear();
    model.key_vertices.clear();
    model.key_words.clear();
    model.clusters.truncate(3);
    model.cluster_bones.truncate(5);
    model.kd_nodes.truncate(5);
    model.references.truncate(6);
    model.reference_boxes.truncate(6);
    let bytes = write(&model).unwrap();
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn clips_may_share_key_times_and_have_no_channels() {
    let mut model = model();
    model.channels[1].time_first = 1;
    model.channels[1].key_count = 1;
    model.channels[1].value_first = 0;
    model.clips[0].end_seconds = 1.5;
    model.clips.push(restpose_formats::rows::ClipRow {
        start_seconds: 0.0,
        end_seconds: 0.0,
        channel_first: 5,
        channel_count: 0,
    });
    model.meta.clip_names.push("still".into());
    model.clip_bounds.clear();
    let bytes = write(&model).unwrap();
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn an_unknown_section_is_skipped_where_it_is_optional_and_refused_otherwise() {
    let extra = |flags| {
        let bytes = vec![1, 2, 3];
        let entry = SectionEntry {
            code: *b"XTRA",
            version: 9,
            flags,
            row_size: 1,
            crc32: 0,
            offset: 0,
            byte_len: 3,
            row_count: 3,
        };
        (entry, bytes)
    };
    for at in [0, 5, 19, SectionKind::ALL.len()] {
        let mut file = Forge::of(&model());
        file.sections.insert(at, extra(SectionEntry::OPTIONAL));
        assert_eq!(read_copy(&file.bytes()), Ok(model()), "at line {at}");
        file.sections[at] = extra(0);
        let error = read_copy(&file.bytes()).unwrap_err();
        assert!(matches!(error, FormatError::SectionUnknown { .. }), "{error}");
        file.sections[at] = extra(2);
        let error = read_copy(&file.bytes()).unwrap_err();
        assert!(matches!(error, FormatError::SectionFlags { .. }), "{error}");
    }
}

#[test]
fn bytes_off_the_boundary_are_refused_with_the_remainder() {
    let bytes = write(&model()).unwrap();
    for remainder in [1, 8, 63] {
        let mut moved = AlignedBytes::zeroed(bytes.len() + SECTION_ALIGN);
        let moved = &mut moved.as_mut_slice()[remainder..remainder + bytes.len()];
        moved.copy_from_slice(&bytes);
        assert_eq!(read(moved), Err(FormatError::Misaligned { remainder }));
    }
}
