//! Whatever is changed in an OBJ file or a vertex cache, an import ends with errors or keeps its guarantee.

use crate::{
    cache_builder::{TRIANGLE, clean, frames, mdd, pc2},
    guarantee::check,
};
use restpose_bake::import::{FrameRange, ImportSettings, import_obj_bytes};

/// Most of what is read: both kinds of group, polygons, every form of corner, a continued line.
const MESH: &str = "# x\no a b\nv 0 0 0\nv 1.5 0 -2e3 1\r\nv 0 1 0\nv \\\n 0 0 1\nvt 0 0\ng c\nf 1 2 3\nf 1/1 2/1 3/1 4/1\n\
    g\nf -1 -2//3 -3/1/1\nsurf 0\nf 1 2\n";

const BYTES: [u8; 24] = [
    0, 1, 9, 10, 13, b' ', b'#', b'-', b'.', b'/', b'0', b'1', b'9', b'\\', b'e', b'f', b'g', b'n', b'o', b'v', 0x7F,
    0x80, 0xC3, 0xFF,
];

fn settings() -> [ImportSettings; 3] {
    let frames = FrameRange {
        first: 1,
        last: Some(2),
        step: 1,
    };
    [
        ImportSettings::default(),
        ImportSettings {
            frame_rate: Some(30.0),
            frames,
        },
        ImportSettings {
            frame_rate: Some(f64::MAX),
            frames,
        },
    ]
}

/// Imports the mesh alone and with a cache.
fn check_mesh(mesh: &[u8], what: &str) {
    let cache = pc2(0.0, 1.0, &frames(2, 4));
    check(
        import_obj_bytes(("m.obj", mesh), None, &ImportSettings::default()),
        what,
    );
    check(
        import_obj_bytes(("m.obj", mesh), Some(("m.pc2", &cache)), &ImportSettings::default()),
        what,
    );
}

#[test]
fn every_byte_of_an_obj_file_replaced_removed_or_doubled() {
    for place in 0..MESH.len() {
        for byte in BYTES {
            let mut mesh = MESH.as_bytes().to_vec();
            mesh[place] = byte;
            check_mesh(&mesh, &format!("byte {place} = {byte}"));
            mesh[place] = MESH.as_bytes()[place];
            mesh.insert(place, byte);
            check_mesh(&mesh, &format!("byte {byte} before {place}"));
        }
        let mut mesh = MESH.as_bytes().to_vec();
        mesh.remove(place);
        check_mesh(&mesh, &format!("without byte {place}"));
        check_mesh(&MESH.as_bytes()[..place], &format!("cut at {place}"));
    }
}

#[test]
fn every_word_of_an_obj_file_replaced() {
    let words: Vec<&str> = MESH.split(' ').collect();
    let others = [
        "",
        "\n",
        "0",
        "-1",
        "5",
        "4294967296",
        "-9223372036854775808",
        "1e31",
        "nan",
        "inf",
        "1e-50",
        "f",
        "v",
        "g",
        "o",
        "\\",
        "#",
        "1//",
        "//",
        "1/2/3/-4",
        "surf",
        "\u{FEFF}",
    ];
    for place in 0..words.len() {
        for other in others {
            let mut words = words.clone();
            words[place] = other;
            check_mesh(words.join(" ").as_bytes(), &format!("word {place} = {other:?}"));
        }
    }
}

#[test]
fn every_byte_of_a_cache_replaced() {
    let caches = [
        ("m.pc2", pc2(0.0, 1.0, &frames(3, 3))),
        ("m.mdd", mdd(&[0.0, 1.0, 2.0], &frames(3, 3))),
    ];
    for (name, cache) in &caches {
        let import = |cache: &[u8], settings: &_| {
            import_obj_bytes(("m.obj", TRIANGLE.as_bytes()), Some((name, cache)), settings)
        };
        clean(import(cache, &ImportSettings::default()));
        for settings in settings() {
            for place in 0..cache.len() {
                for byte in [0, 1, 0x3F, 0x7F, 0x80, 0xFF] {
                    let mut cache = cache.clone();
                    cache[place] = byte;
                    check(import(&cache, &settings), &format!("{name} byte {place} = {byte}"));
                }
                check(import(&cache[..place], &settings), &format!("{name} cut at {place}"));
                check(import(&cache[place..], &settings), &format!("{name} from {place}"));
            }
        }
    }
}

#[test]
fn every_pair_of_header_words_of_a_cache_replaced() {
    let words = [
        0,
        1,
        2,
        3,
        4,
        -1,
        32,
        1 << 24,
        i32::MAX,
        i32::MIN,
        0x7FC0_0000,
        0x3F80_0000,
    ];
    for (name, cache, header) in [
        ("m.pc2", pc2(0.0, 1.0, &frames(3, 3)), 12..32),
        ("m.mdd", mdd(&[0.0, 1.0, 2.0], &frames(3, 3)), 0..20),
    ] {
        for first in header.clone().step_by(4) {
            for second in header.clone().step_by(4) {
                for (a, b) in words.iter().flat_map(|a| words.iter().map(move |b| (*a, *b))) {
                    let mut cache = cache.clone();
                    for (place, word) in [(first, a), (second, b)] {
                        let bytes = if name == "m.pc2" {
                            word.to_le_bytes()
                        } else {
                            i32::to_be_bytes(word)
                        };
                        cache[place..place + 4].copy_from_slice(&bytes);
                    }
                    let result = import_obj_bytes(
                        ("m.obj", TRIANGLE.as_bytes()),
                        Some((name, &cache)),
                        &ImportSettings::default(),
                    );
                    check(result, &format!("{name} {first} = {a}, {second} = {b}"));
                }
            }
        }
    }
}
