//! The reference against bytes written out by hand.

use super::{CacheReference, Obj};

const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn pc2(points: i32, start: f32, rate: f32, samples: i32, numbers: &[f32]) -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    bytes.extend(1i32.to_le_bytes());
    bytes.extend(points.to_le_bytes());
    bytes.extend(start.to_le_bytes());
    bytes.extend(rate.to_le_bytes());
    bytes.extend(samples.to_le_bytes());
    bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// A triangle that is 1, then 3 times its size.
const GROWTH: [f32; 18] = [
    0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 3.0, 0.0,
];

fn corners(text: &str) -> Vec<Vec<usize>> {
    let faces = Obj::parse(text.as_bytes()).faces;
    faces.into_iter().map(|face| face.corners).collect()
}

#[test]
fn faces_of_every_spelling() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    for (spelling, expected) in [
        ("f 1 2 3", vec![0, 1, 2]),
        ("f 1/7 2/8 3/9", vec![0, 1, 2]),
        ("f 1//7 2//8 3//9", vec![0, 1, 2]),
        ("f 1/1/7 2/1/8 3/1/9 4/1/9", vec![0, 1, 2, 3]),
        ("f -4 -3 -1", vec![0, 1, 3]),
        ("  f\t1  2 \\\n 3 # a comment", vec![0, 1, 2]),
        ("f 1 2 3\r", vec![0, 1, 2]),
    ] {
        assert_eq!(corners(&format!("{text}{spelling}\n")), [expected], "{spelling}");
    }
}

#[test]
fn negative_numbers_count_from_the_vertices_so_far() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -3 -2 -1\n";
    assert_eq!(corners(text), [[0, 1, 2], [1, 2, 3]]);
}

#[test]
fn polygons_become_fans_and_know_their_group() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 3 4 5\no big pen\n\
                f 1 2 3 4 5\ng a b\nf 1 2 3\no ball\nf 1 2 4\ng\nf 2 3 4\n";
    let obj = Obj::parse(text.as_bytes());
    let fan: Vec<[usize; 3]> = obj.faces[1].triangles().collect();
    assert_eq!(fan, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    let names: Vec<Option<&str>> = obj.faces.iter().map(|face| face.group.as_deref()).collect();
    assert_eq!(
        names,
        [None, Some("big pen"), Some("a b"), Some("ball"), Some("default")]
    );
}

#[test]
fn vertices_may_carry_more_than_a_place() {
    let obj = Obj::parse(b"v 1.5 -2e3 .25 1.0\nv 1 2 3 0.1 0.2 0.3\nvn 9 9 9\nvt 9 9\n");
    assert_eq!(obj.positions, [[1.5, -2000.0, 0.25], [1.0, 2.0, 3.0]]);
}

#[test]
#[should_panic(expected = "vertex 4 is not in the file")]
fn a_face_beyond_the_vertices_is_refused() {
    corners("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
}

#[test]
fn pc2_frames_lie_at_start_plus_sample_times_rate() {
    let reference = CacheReference::from_bytes(TRIANGLE, &pc2(3, 12.0, 0.5, 2, &GROWTH), None);
    assert_eq!(reference.frame_seconds(), [0.5, 12.5 / 24.0]);
    assert_eq!(reference.frame(1), [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
    let faster = CacheReference::from_bytes(TRIANGLE, &pc2(3, 12.0, 0.5, 2, &GROWTH), Some(25.0));
    assert_eq!(faster.frame_seconds(), [12.0 / 25.0, 0.5]);
}

#[test]
fn positions_are_linear_between_frames_and_stay_at_the_ends() {
    let reference = CacheReference::from_bytes(TRIANGLE, &pc2(3, 24.0, 24.0, 2, &GROWTH), None);
    for (seconds, width) in [(0.0, 1.0), (1.0, 1.0), (1.25, 1.5), (1.5, 2.0), (2.0, 3.0), (9.0, 3.0)] {
        assert_eq!(reference.positions(seconds)[1], [width, 0.0, 0.0], "{seconds} s");
    }
}

#[test]
fn mdd_is_big_endian_and_states_its_times() {
    let mut bytes = vec![0, 0, 0, 2, 0, 0, 0, 3];
    for number in [0.25f32, 1.25].iter().chain(&GROWTH) {
        bytes.extend(number.to_be_bytes());
    }
    let reference = CacheReference::from_bytes(TRIANGLE, &bytes, None);
    assert_eq!(reference.frame_seconds(), [0.25, 1.25]);
    assert_eq!(reference.positions(0.75)[2], [0.0, 2.0, 0.0]);
    let faster = CacheReference::from_bytes(TRIANGLE, &bytes, Some(50.0));
    assert_eq!(faster.frame_seconds(), [0.0, 0.02]);
}

#[test]
fn a_row_of_objs_is_a_cache() {
    let second = b"v 0 0 0\nv 3 0 0\nv 0 3 0\nf 1 2 3\n";
    let reference = CacheReference::from_obj_row(&[TRIANGLE, second], Some(2.0));
    assert_eq!(reference.frame_seconds(), [0.0, 0.5]);
    assert_eq!(reference.positions(0.25)[1], [2.0, 0.0, 0.0]);
    assert_eq!(reference.obj().positions[1], [1.0, 0.0, 0.0]);
}

#[test]
fn caches_that_do_not_fit_are_refused() {
    for (cache, message) in [
        (pc2(2, 0.0, 1.0, 3, &GROWTH), "points of frame 0"),
        (pc2(3, 0.0, 1.0, 3, &GROWTH), "bytes of 3 frames"),
        (pc2(3, 0.0, -1.0, 2, &GROWTH), "times do not increase"),
        (pc2(-3, 0.0, 1.0, 2, &GROWTH), "a count below zero"),
    ] {
        let outcome = std::panic::catch_unwind(|| CacheReference::from_bytes(TRIANGLE, &cache, None));
        let panic = outcome.expect_err(message);
        let text = panic.downcast_ref::<String>().expect("a message");
        assert!(text.contains(message), "{text}");
    }
}
