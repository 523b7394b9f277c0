//! Decodes the golden file as `FORMAT.md` describes it, by byte offsets alone: a check of the text, so nothing here may
//! use the library but to know what the numbers must be.

use crate::{
    fixture::{FLAG, FLAG_CACHE, SPARK, SPARK_CACHE, model},
    golden::V1_3,
};
use restpose_formats::rows::ClipBoundsRow;

pub fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

pub fn f32s<const N: usize>(bytes: &[u8], at: usize) -> [f32; N] {
    std::array::from_fn(|i| f32::from_bits(u32_at(bytes, at + 4 * i)))
}

pub fn u16s(bytes: &[u8], at: usize) -> [u16; 3] {
    std::array::from_fn(|i| u16_at(bytes, at + 2 * i))
}

pub fn u32s<const N: usize>(bytes: &[u8], at: usize) -> [u32; N] {
    std::array::from_fn(|i| u32_at(bytes, at + 4 * i))
}

/// CRC-32 bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            crc >> 1 ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

/// The codes and row sizes of `FORMAT.md`, section 2.
const SECTIONS: [(&[u8; 4], usize); 37] = [
    (b"META", 1),
    (b"PART", 48),
    (b"PRIM", 16),
    (b"VERT", 16),
    (b"INFL", 8),
    (b"TRIS", 12),
    (b"MSET", 16),
    (b"MTGT", 16),
    (b"MFST", 4),
    (b"MDEL", 16),
    (b"NODE", 64),
    (b"BONE", 64),
    (b"CLIP", 16),
    (b"CHAN", 32),
    (b"KTIM", 4),
    (b"KVAL", 4),
    (b"SAMP", 8),
    (b"CBND", 44),
    (b"CACH", 32),
    (b"SEGM", 36),
    (b"TRAK", 32),
    (b"KEYF", 80),
    (b"KVRT", 24),
    (b"KWRD", 4),
    (b"CLUS", 64),
    (b"CBON", 32),
    (b"KDND", 8),
    (b"WDND", 136),
    (b"NMOV", 36),
    (b"KBOX", 48),
    (b"REFS", 4),
    (b"RBOX", 12),
    (b"PSPC", 32),
    (b"LEVR", 32),
    (b"CMOR", 16),
    (b"BENV", 144),
    (b"MENV", 8),
];

/// The rows of a section of the golden file with kd-trees, found through the table.
pub fn rows(code: &[u8; 4]) -> Vec<&'static [u8]> {
    rows_of(V1_3, code)
}

/// The rows of a section of a file.
pub fn rows_of<'a>(file: &'a [u8], code: &[u8; 4]) -> Vec<&'a [u8]> {
    let line = SECTIONS
        .iter()
        .position(|(known, _)| *known == code)
        .expect("a code of the format");
    let at = 128 + 40 * line;
    assert_eq!(&file[at..at + 4], code);
    let (offset, byte_len) = (u64_at(file, at + 16) as usize, u64_at(file, at + 24) as usize);
    let section = &file[offset..offset + byte_len];
    let rows: Vec<_> = section.chunks_exact(u32_at(file, at + 8) as usize).collect();
    assert_eq!(rows.len() as u64, u64_at(file, at + 32));
    rows
}

/// Asserts that each row of a section, decoded by `$bytes => $decoded`, equals the fixture's, decoded by field.
macro_rules! same {
    ($code:literal, $rows:expr, $bytes:ident => $decoded:expr, $row:ident => $fields:expr) => {
        let decoded: Vec<_> = $crate::bare_reader::rows($code).iter().map(|$bytes| $decoded).collect();
        let expected: Vec<_> = $rows.iter().map(|$row| $fields).collect();
        assert_eq!(decoded, expected);
    };
}

pub(crate) use same;

#[test]
fn header_and_table_are_as_the_text_says() {
    assert_eq!(V1_3[..10], [0x8B, 0x52, 0x50, 0x4F, 0x53, 0x45, 0x0D, 0x0A, 0x1A, 0x0A]);
    assert_eq!((u16_at(V1_3, 10), u16_at(V1_3, 12), u16_at(V1_3, 14)), (1, 3, 0));
    assert_eq!((u32_at(V1_3, 16), u64_at(V1_3, 24)), (128, V1_3.len() as u64));
    assert_eq!((u64_at(V1_3, 32), u64_at(V1_3, 40)), (0, 0));
    assert_eq!((u32_at(V1_3, 48), u32_at(V1_3, 52), u64_at(V1_3, 120)), (37, 0, 0));
    assert_eq!(
        (&V1_3[56..88], &V1_3[88..120]),
        (&model().hashes.source[..], &model().hashes.options[..])
    );
    let mut sealed = V1_3[..128 + 40 * 37].to_vec();
    sealed[20..24].fill(0);
    assert_eq!(u32_at(V1_3, 20), crc32(&sealed));

    let mut end = sealed.len();
    for (line, (code, row_size)) in SECTIONS.iter().enumerate() {
        let at = 128 + 40 * line;
        assert_eq!(&V1_3[at..at + 4], *code);
        assert_eq!(
            (u16_at(V1_3, at + 4), u16_at(V1_3, at + 6), u32_at(V1_3, at + 8)),
            (1, 0, *row_size as u32)
        );
        let (offset, byte_len) = (u64_at(V1_3, at + 16) as usize, u64_at(V1_3, at + 24) as usize);
        assert_eq!(offset, end.div_ceil(64) * 64);
        assert!(V1_3[end..offset].iter().all(|byte| *byte == 0));
        assert_eq!(u32_at(V1_3, at + 12), crc32(&V1_3[offset..offset + byte_len]));
        end = offset + byte_len;
    }
    assert_eq!(end, V1_3.len());
}

#[test]
fn rows_are_as_the_text_says() {
    let m = model();
    same!(b"PART", m.parts, b => u32s::<12>(b, 0), r => [
        r.source_node, r.source_mesh, r.source_skin, r.class, r.vertex_first, r.vertex_count, r.triangle_first,
        r.triangle_count, r.primitive_first, r.primitive_count, r.morph_set, r.cache,
    ]);
    same!(b"PRIM", m.primitives, b => u32s::<4>(b, 0), r => [
        r.source_primitive, r.triangle_first, r.triangle_count, r.reserved,
    ]);
    same!(b"VERT", m.vertices, b => (f32s::<3>(b, 0), u32_at(b, 12)), r => (r.position_rest, r.influence_first));
    same!(b"INFL", m.influences, b => (u32_at(b, 0), f32s::<1>(b, 4)), r => (r.bone, [r.weight]));
    same!(b"TRIS", m.triangles, b => u32s::<3>(b, 0), r => r.corners);
    same!(b"MSET", m.morph_sets, b => u32s::<4>(b, 0), r => [
        r.source_node, r.target_first, r.target_count, r.reserved,
    ]);
    same!(b"MTGT", m.morph_targets, b => (f32s::<1>(b, 0), f32s::<3>(b, 4)), r => ([r.default_weight], r.extent));
    same!(b"MFST", m.morph_first, b => u32_at(b, 0), r => *r);
    same!(b"MDEL", m.morph_deltas, b => (u32_at(b, 0), f32s::<3>(b, 4)), r => (r.target, r.delta));
    same!(b"NODE", m.nodes, b => (u32s::<4>(b, 0), f32s::<12>(b, 16)), r => (
        [r.parent, r.source_node, r.local_kind, r.reserved], r.local,
    ));
    same!(b"BONE", m.bones, b => (u32s::<4>(b, 0), f32s::<12>(b, 16)), r => (
        [r.node, r.source_skin, r.source_joint, r.reserved], r.inverse_bind,
    ));
    same!(b"CLIP", m.clips, b => (f32s::<2>(b, 0), u32s::<2>(b, 8)), r => (
        [r.start_seconds, r.end_seconds], [r.channel_first, r.channel_count],
    ));
    same!(b"CHAN", m.channels, b => u32s::<8>(b, 0), r => [
        r.target, r.path, r.interpolation, r.width, r.time_first, r.key_count, r.value_first, r.reserved,
    ]);
    same!(b"KTIM", m.key_times, b => f32s::<1>(b, 0), r => [*r]);
    same!(b"KVAL", m.key_values, b => f32s::<1>(b, 0), r => [*r]);
    same!(b"SAMP", m.samples, b => (u32_at(b, 0), f32s::<1>(b, 4)), r => (r.clip, [r.seconds]));
    same!(b"CBND", m.clip_bounds, b => (f32s::<3>(b, 0), f32s::<3>(b, 12), f32s::<4>(b, 24), u32_at(b, 40)), r => (
        r.bounds.min, r.bounds.max, [r.reach[0], r.reach[1], r.reach[2], r.rest_reach], r.known,
    ));
    same!(b"CACH", m.caches, b => (u32s::<5>(b, 0), f32s::<1>(b, 20), u32s::<2>(b, 24)), r => (
        [r.part, r.bone, r.key_count, r.segment_first, r.segment_count], [r.position_error], r.reserved,
    ));
    same!(b"SEGM", m.segments, b => u32s::<9>(b, 0), r => [
        r.key_first, r.key_count, r.track_first, r.track_count, r.cluster_first, r.cluster_count,
        r.key_vertex_first, r.word_first, r.words_per_key,
    ]);
    same!(b"TRAK", m.tracks, b => (u32_at(b, 0), f32s::<3>(b, 4), f32s::<1>(b, 16), u32s::<3>(b, 20)), r => (
        r.key_first, r.origin, [r.step], [r.box_first, r.box_interval, r.reserved],
    ));
    same!(b"KEYF", m.keys, b => (f32s::<12>(b, 0), f32s::<3>(b, 48), f32s::<3>(b, 60), u32s::<2>(b, 72)), r => (
        r.map, r.bounds.min, r.bounds.max, [r.flags, r.reserved],
    ));
    same!(b"KVRT", m.key_vertices, b => (u32s::<5>(b, 0).map(|x| x as i32), [b[20], b[21], b[22], b[23]]), r => (
        [r.base[0], r.base[1], r.base[2], r.track as i32, r.bit_first as i32],
        [r.widths[0], r.widths[1], r.widths[2], r.raw],
    ));
    same!(b"KWRD", m.key_words, b => u32_at(b, 0), r => *r);
    same!(b"CLUS", m.clusters, b => (u32s::<8>(b, 0), f32s::<3>(b, 32), f32s::<3>(b, 44), u32s::<2>(b, 56)), r => (
        [
            r.bone, r.node_first, r.node_count, r.reference_first, r.reference_count, r.cluster_bone_first,
            r.cluster_bone_count, r.triangle_count,
        ],
        r.bounds_local.min, r.bounds_local.max, [r.track, r.reserved],
    ));
    same!(b"CBON", m.cluster_bones, b => (u32_at(b, 0), f32s::<3>(b, 4), f32s::<3>(b, 16), u32_at(b, 28)), r => (
        r.bone, r.bounds.min, r.bounds.max, r.reserved,
    ));
    same!(b"REFS", m.references, b => u32_at(b, 0), r => *r);
    same!(b"RBOX", m.reference_boxes, b => (u16s(b, 0), u16s(b, 6)), r => (r.min, r.max));

    // The fixture's trees, by what they were made from: leaf, inner node on axis 0 at 0.5, and leaves.
    let words: Vec<[u32; 2]> = rows(b"KDND").iter().map(|bytes| u32s(bytes, 0)).collect();
    let inner = [1 << 2, 0.5f32.to_bits()];
    assert_eq!(
        words,
        [
            [2 << 2 | 3, 0],
            inner,
            [1 << 2 | 3, 0],
            [2 << 2 | 3, 1],
            [1 << 2 | 3, 0],
            [1 << 2 | 3, 0],
            [1 << 2 | 3, 0],
            [1 << 2 | 3, 0],
        ]
    );
}

/// Where the vertices of a cache are in its space, per segment and key.
pub fn positions_of_cache(cache: u32) -> Vec<Vec<Vec<[f32; 3]>>> {
    let cache = rows(b"CACH")[cache as usize];
    let part = rows(b"PART")[u32_at(cache, 0) as usize];
    let (first, count) = (u32_at(cache, 12) as usize, u32_at(cache, 16) as usize);
    let segments = &rows(b"SEGM")[first..first + count];
    let of_segment = |segment: &&[u8]| {
        let (key_count, vertex_count) = (u32_at(segment, 4), u32_at(part, 20));
        let vertices = &rows(b"KVRT")[u32_at(segment, 24) as usize..][..vertex_count as usize];
        (0..key_count)
            .map(|key| vertices.iter().map(|vertex| position(segment, vertex, key)).collect())
            .collect()
    };
    segments.iter().map(of_segment).collect()
}

/// Where the vertex of a row of KVRT is at a key of its segment.
fn position(segment: &[u8], vertex: &[u8], key: u32) -> [f32; 3] {
    let [word_first, words_per_key] = u32s::<2>(segment, 28);
    let words = &rows(b"KWRD")[(word_first + key * words_per_key) as usize..];
    let bit_first = u32_at(vertex, 16);
    let bit = |at: u32| u32_at(words[((bit_first + at) / 32) as usize], 0) >> ((bit_first + at) % 32) & 1;
    let number = |first: u32, width: u32| (0..width).map(|k| bit(first + k) << k).sum::<u32>();
    let track = rows(b"TRAK")[u32_at(vertex, 12) as usize];
    if vertex[23] == 1 {
        return [0, 1, 2].map(|axis| f32::from_bits(number(axis * 32, 32)));
    }
    let widths = [vertex[20], vertex[21], vertex[22]].map(u32::from);
    let starts = [0, widths[0], widths[0] + widths[1]];
    let (origin, [step]) = (f32s::<3>(track, 4), f32s::<1>(track, 16));
    let local: [f32; 3] = std::array::from_fn(|k| {
        let lattice = u32_at(vertex, 4 * k) as i32 + number(starts[k], widths[k]) as i32;
        origin[k] + step * lattice as f32
    });
    let map: [f32; 12] = f32s(rows(b"KEYF")[(u32_at(track, 0) + key) as usize], 0);
    [0, 1, 2].map(|k| map[k] * local[0] + map[3 + k] * local[1] + map[6 + k] * local[2] + map[9 + k])
}

#[test]
fn positions_of_caches_are_as_the_text_says() {
    assert_eq!(positions_of_cache(SPARK_CACHE), [[SPARK.to_vec()]]);
    let flag = FLAG.map(|key| key.to_vec());
    assert_eq!(positions_of_cache(FLAG_CACHE), [flag[..3].to_vec(), flag[2..].to_vec()]);
}

/// The stretch of a time of a row of CLIP.
fn stretch(clip: &[u8], seconds: f32) -> usize {
    let [start, end] = f32s(clip, 0);
    let mut rate = 32.0 / (end - start);
    if !rate.is_finite() {
        rate = 0.0;
    }
    let place = (seconds - start) * rate;
    if place.is_nan() || place < 0.0 {
        0
    } else if place >= 32.0 {
        31
    } else {
        place.trunc() as usize
    }
}

#[test]
fn stretches_are_as_the_text_says() {
    let model = model();
    let clips = rows(b"CLIP");
    assert_eq!(rows(b"CBND").len(), 32 * clips.len() + 1);
    for (number, clip) in clips.iter().enumerate() {
        let [start, end]: [f32; 2] = f32s(clip, 0);
        for part in -8..=136 {
            let border = start + (end - start) * part as f32 / 128.0;
            for seconds in [border.next_down(), border, border.next_up()] {
                let expected = ClipBoundsRow::row_at(&model.clips, Some(number), seconds);
                assert_eq!(
                    number * 32 + stretch(clip, seconds),
                    expected,
                    "clip {number} at {seconds}"
                );
            }
        }
    }
}

#[test]
fn metadata_is_as_the_text_says() {
    let bytes = rows(b"META").concat();
    let mut at = 1;
    let number = |at: &mut usize| {
        *at += 1;
        assert!(bytes[*at - 1] < 251, "the fixture's numbers are small");
        usize::from(bytes[*at - 1])
    };
    let string = |at: &mut usize| {
        let len = number(at);
        *at += len;
        String::from_utf8(bytes[*at - len..*at].to_vec()).expect("UTF-8")
    };
    let strings = |at: &mut usize| (0..number(at)).map(|_| string(at)).collect::<Vec<_>>();
    let m = model().meta;
    assert_eq!(bytes[0], 1);
    assert_eq!((string(&mut at), string(&mut at)), (m.generator, m.source_name));
    let options: Vec<_> = (0..number(&mut at))
        .map(|_| (string(&mut at), string(&mut at)))
        .collect();
    assert_eq!(options, m.options);
    for names in [m.part_names, m.bone_names, m.clip_names] {
        assert_eq!(strings(&mut at), names);
    }
    assert_eq!(
        [(); 3].map(|()| number(&mut at)),
        [1, 0, 2],
        "envelope bounds, kd-trees, two degenerate triangles"
    );
    assert_eq!(at, bytes.len());
}

#[test]
fn the_texts_list_of_sections_is_the_one_used_here() {
    let text = include_str!("../../FORMAT.md");
    for (line, (code, row_size)) in SECTIONS.iter().enumerate() {
        let expected = format!("| {line} | `{}` | {row_size} |", code.escape_ascii());
        assert!(text.contains(&expected), "{expected}");
    }
}
