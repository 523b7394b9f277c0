//! Decodes the boxes of single triangles as `FORMAT.md` describes them, in the manner of `bare_reader`.

use crate::{
    bare_reader::{f32s, positions_of_cache, rows, u16s, u32_at, u32s},
    fixture::FLAG_CACHE,
};
use restpose_formats::{geom::Aabb, rows::box_steps};

/// The lattice over a cluster's bounds on an axis: where its zero is, and its step.
pub fn lattice(cluster: &[u8], k: usize) -> [f64; 2] {
    let [min, max] = [32, 44].map(|at| f64::from(f32s::<3>(cluster, at)[k]));
    let exact = (max - min) / 65535.0 * (1.0 + 2.0f64.powi(-40));
    let nearest = exact as f32;
    let step = if f64::from(nearest) < exact {
        f32::from_bits(nearest.to_bits() + 1)
    } else {
        nearest
    };
    [min, f64::from(step)]
}

/// The planes of a row of RBOX over a cluster's bounds: least and greatest corner.
pub fn planes(reference_box: &[u8], cluster: &[u8]) -> [[f64; 3]; 2] {
    [0, 6].map(|at| {
        let coordinates = u16s(reference_box, at);
        [0, 1, 2].map(|k| {
            let [zero, step] = lattice(cluster, k);
            zero + f64::from(coordinates[k]) * step
        })
    })
}

/// The fuzzy positions of a triangle of the flag, whose cluster has the track, in every uncut interval of the segment and at
/// every key, each with its time in keys. `positions` are those of the flag's vertices at the segment's keys. What is read
/// here is the same in both golden files.
pub fn fuzzy_positions(
    triangle: u32,
    track: &[u8],
    segment: &[u8],
    positions: &[Vec<[f32; 3]>],
) -> Vec<(f64, [f64; 3])> {
    let triangle = rows(b"TRIS")[triangle as usize];
    let part = rows(b"PART")[u32_at(rows(b"CACH")[FLAG_CACHE as usize], 0) as usize];
    let corners = u32s::<3>(triangle, 0).map(|corner| (corner - u32_at(part, 16)) as usize);
    let key_first = u32_at(track, 0);
    let keys: Vec<&[u8]> = (0..u32_at(segment, 4))
        .map(|key| rows(b"KEYF")[(key_first + key) as usize])
        .collect();
    let mut out = Vec::new();
    for (k, key) in keys.iter().enumerate() {
        let is_cut = k + 1 == keys.len() || u32_at(key, 72) == 1;
        let (next, steps) = if is_cut { (k, 0) } else { (k + 1, 16) };
        for s in (0..=steps).map(|s| f64::from(s) / 16.0) {
            let mix = |a: f32, b: f32| (1.0 - s) * f64::from(a) + s * f64::from(b);
            let [map, next_map] = [k, next].map(|key| f32s::<12>(keys[key], 0));
            for corner in corners {
                let [from, onto] = [k, next].map(|key| positions[key][corner]);
                // The fixture's maps scale and move, no more.
                let fuzzy = [0, 1, 2].map(|axis| {
                    let moved = mix(from[axis], onto[axis]) - mix(map[9 + axis], next_map[9 + axis]);
                    moved / mix(map[4 * axis], next_map[4 * axis])
                });
                out.push((k as f64 + s, fuzzy));
            }
        }
    }
    out
}

#[test]
fn boxes_of_triangles_are_as_the_text_says() {
    let (clusters, boxes) = (rows(b"CLUS"), rows(b"RBOX"));
    let positions = positions_of_cache(FLAG_CACHE);
    // Clusters on tracks with keys: both of the first segment, one of the second.
    for (row, segment) in [(4, 1), (5, 1), (6, 2)] {
        let cluster = clusters[row];
        let [min, max] = planes(boxes[u32_at(cluster, 12) as usize], cluster);
        let triangle = u32_at(rows(b"REFS")[u32_at(cluster, 12) as usize], 0);
        let track = rows(b"TRAK")[u32_at(cluster, 56) as usize];
        let fuzzy = fuzzy_positions(triangle, track, rows(b"SEGM")[segment], &positions[segment - 1]);
        for k in 0..3 {
            let (low, high) = fuzzy.iter().fold((f64::MAX, f64::MIN), |(low, high), (_, p)| {
                (low.min(p[k]), high.max(p[k]))
            });
            assert!(min[k] <= low && high <= max[k], "cluster {row}, axis {k}");
            // The fixture has rounded outwards and taken a step more.
            let loose = 3.0 * 16.0 / 65535.0;
            assert!(low - min[k] < loose && max[k] - high < loose, "cluster {row}, axis {k}");
        }
    }
    for row in [3, 7] {
        assert_eq!(
            boxes[u32_at(clusters[row], 12) as usize],
            [0; 12],
            "cluster {row} moves freely"
        );
    }
}

#[test]
fn the_lattice_of_boxes_has_the_steps_that_the_text_says() {
    let sides = [0.0, 1e-45, 1e-39, 3e-20, 1.0, 3.0, 10.0, 16.0, 65535.0, 1e7, 3e38];
    for (side, min) in sides
        .iter()
        .flat_map(|side| [(*side, 0.0), (*side, -0.3 * side), (*side, 7.0)])
    {
        let bounds = Aabb {
            min: [min; 3],
            max: [min, min + side, min + 0.7 * side],
        };
        let mut cluster = vec![0; 64];
        cluster[32..56].copy_from_slice(bytemuck::bytes_of(&bounds));
        let last = planes(&[255; 12], &cluster)[1];
        let steps = box_steps(&bounds);
        for k in 0..3 {
            assert_eq!(
                last[k],
                f64::from(bounds.min[k]) + 65535.0 * f64::from(steps[k]),
                "{bounds:?}"
            );
            assert!(last[k] >= f64::from(bounds.max[k]), "{bounds:?}");
        }
    }
}
