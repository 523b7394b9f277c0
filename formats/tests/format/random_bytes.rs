//! Nothing panics, whatever the bytes; what is accepted is written back as it was.

use crate::{
    fixture::{Forge, model, read_copy, reseal, wide_model},
    golden::{V1_3, V1_3_WIDE},
};
use proptest::prelude::*;
use restpose_formats::{MAGIC, Model, SectionKind, rows::MAX_MOVERS, write};

/// Reads, and where that succeeds writes again: an accepted file is reproduced but for what the writer does not know.
fn read_and_rewrite(bytes: &[u8]) {
    if let Ok(model) = read_copy(bytes) {
        decode_positions(&model);
        decode_movers(&model);
        decode_key_boxes(&model);
        let again = write(&model).expect("an accepted model can be written");
        assert!(read_copy(&again) == Ok(model));
    }
}

/// Decodes the first and last records of all key vertices: they lie within the words, and raw ones are finite.
fn decode_positions(model: &Model) {
    for cache in &model.caches {
        let vertex_count = model.parts[cache.part as usize].vertex_count as usize;
        for segment in &model.segments[cache.segment_first as usize..][..cache.segment_count as usize] {
            for row in &model.key_vertices[segment.key_vertex_first as usize..][..vertex_count] {
                for key in [0, segment.key_count - 1] {
                    let words = |key| segment.key_words(&model.key_words, key);
                    let bounds = row.bounds((0..segment.key_count).map(words));
                    assert!(bounds.contains(row.stored(words(key))));
                }
            }
        }
    }
}

/// The movers of every wide node are among the file's.
fn decode_movers(model: &Model) {
    let all = &model.node_movers;
    let of_nodes = model.wide_nodes.iter().map(|node| node.movers(all).len());
    assert_eq!(of_nodes.sum::<usize>(), all.len());
    assert!(all.iter().all(|row| (row.mover as usize) < MAX_MOVERS));
}

/// Every node of a tree whose track says so has its boxes at keys, and nothing else has any; no box has exchanged corners.
fn decode_key_boxes(model: &Model) {
    let mut count = 0;
    for segment in &model.segments {
        for cluster in &model.clusters[segment.cluster_first as usize..][..segment.cluster_count as usize] {
            let track = &model.tracks[cluster.track as usize];
            let rows = track.key_box_count(cluster, segment.key_count) as usize;
            let boxes = &model.key_boxes[track.box_first as usize..][..rows];
            count += rows;
            for (at, row) in boxes.iter().enumerate() {
                let node = &model.wide_nodes[cluster.node_first as usize + at % cluster.node_count as usize];
                for place in 0..node.children().count() {
                    let sides = node.box_at(row, place);
                    assert!(sides.iter().all(|[least, greatest]| least <= greatest));
                }
            }
        }
    }
    assert_eq!(count, model.key_boxes.len());
}

/// Values that are likely to be at a limit.
fn word() -> impl Strategy<Value = u32> {
    prop_oneof![
        0..10u32,
        any::<u32>(),
        Just(u32::MAX),
        Just(u32::MAX - 1),
        Just(1 << 31),
        Just(f32::NAN.to_bits()),
        Just(f32::INFINITY.to_bits()),
        Just((-1.0f32).to_bits()),
        Just(f32::MIN_POSITIVE.to_bits()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_bytes_do_not_panic(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
        read_and_rewrite(&bytes);
        read_and_rewrite(&[&MAGIC, &bytes[..]].concat());
    }

    #[test]
    fn random_words_under_valid_checksums_do_not_panic(
        changes in proptest::collection::vec((any::<usize>(), word()), 1..4),
    ) {
        for golden in [V1_3, V1_3_WIDE] {
            let mut bytes = golden.to_vec();
            for (at, word) in &changes {
                let at = at % (golden.len() / 4);
                bytes[at * 4..at * 4 + 4].copy_from_slice(&word.to_le_bytes());
            }
            reseal(&mut bytes);
            read_and_rewrite(&bytes);
        }
    }

    #[test]
    fn sections_of_random_length_do_not_panic(
        at in 0..SectionKind::ALL.len(),
        rows in 0..20usize,
        words in proptest::collection::vec(word(), 40),
    ) {
        for fixture in [model(), wide_model()] {
            let mut file = Forge::of(&fixture);
            let (entry, bytes) = &mut file.sections[at];
            let old = bytes.clone();
            let row_size = entry.row_size as usize;
            bytes.resize(rows * row_size, 0);
            let grown = bytes.get_mut(old.len()..).unwrap_or_default();
            for (byte, new) in grown.iter_mut().zip(words.iter().flat_map(|word| word.to_le_bytes())) {
                *byte = new;
            }
            (entry.row_count, entry.byte_len) = (rows as u64, bytes.len() as u64);
            read_and_rewrite(&file.bytes());
        }
    }
}

#[test]
fn every_word_at_every_limit_does_not_panic() {
    let limits = [
        0,
        1,
        2,
        3,
        7,
        u32::MAX,
        u32::MAX - 1,
        1 << 31,
        0x7FC0_0000,
        0x7F80_0000,
        0xBF80_0000,
    ];
    for golden in [V1_3, V1_3_WIDE] {
        for at in 0..golden.len() / 4 {
            for limit in limits {
                let mut bytes = golden.to_vec();
                bytes[at * 4..at * 4 + 4].copy_from_slice(&limit.to_le_bytes());
                reseal(&mut bytes);
                read_and_rewrite(&bytes);
            }
        }
    }
}
