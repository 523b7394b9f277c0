//! Decodes the boxes of wide nodes at keys as `FORMAT.md` describes them, in the manner of `bare_reader`.

use crate::{
    bare_boxes::{fuzzy_positions, lattice},
    bare_reader::{positions_of_cache, rows_of, u16_at, u32_at, u32s},
    fixture::FLAG_CACHE,
    golden::V1_3_WIDE,
};

/// Per axis, where its least and its greatest side are.
type Sides = [[f64; 2]; 3];

/// A place in use of a node that has boxes at keys.
struct KeyedPlace {
    /// Row of CLUS.
    cluster: usize,
    /// Row of SEGM.
    segment: usize,
    /// Counted from the tree's first.
    node: usize,
    /// Rows of TRIS below it.
    triangles: Vec<u32>,
    /// Keys from one of its boxes to the next.
    interval: u32,
    /// At its box keys, in local space.
    boxes: Vec<Sides>,
    /// A step of its coordinates in local space, per axis.
    parts: [f64; 3],
}

/// Every place in use of every node of the golden file that has boxes at keys.
fn keyed_places() -> Vec<KeyedPlace> {
    let [segments, tracks, clusters, nodes, boxes] =
        [b"SEGM", b"TRAK", b"CLUS", b"WDND", b"KBOX"].map(|code| rows_of(V1_3_WIDE, code));
    let mut next_row = 0;
    let mut out = Vec::new();
    for (segment, row) in segments.iter().enumerate() {
        let [first, count] = u32s::<2>(row, 16).map(|x| x as usize);
        for cluster in first..first + count {
            let track = tracks[u32_at(clusters[cluster], 56) as usize];
            let [box_first, interval] = u32s::<2>(track, 20);
            if u32_at(track, 0) == u32::MAX {
                assert_eq!([box_first, interval], [0; 2]);
                continue;
            }
            assert_eq!(box_first, next_row);
            assert_ne!(interval, 0, "every tree of the fixture has them");
            let box_keys = (u32_at(row, 4) - 1).div_ceil(interval) + 1;
            let [node_first, node_count] = u32s::<2>(clusters[cluster], 4);
            next_row += node_count * box_keys;
            let tree = &nodes[node_first as usize..][..node_count as usize];
            for (node, bytes) in (0..).zip(tree) {
                let row = |key: u32| boxes[(box_first + key * node_count + node) as usize];
                let own: Vec<&[u8]> = (0..box_keys).map(row).collect();
                for place in 0..8 {
                    let child = u32_at(bytes, 96 + 4 * place);
                    if child == u32::MAX {
                        assert!(own.iter().all(|row| (0..6).all(|side| row[8 * side + place] == 0)));
                        continue;
                    }
                    let mut triangles = Vec::new();
                    add_triangles(tree, child, &mut triangles);
                    out.push(KeyedPlace {
                        cluster,
                        segment,
                        node: node as usize,
                        triangles,
                        interval,
                        boxes: own
                            .iter()
                            .map(|row| sides(row, bytes, place, clusters[cluster]))
                            .collect(),
                        parts: [0, 1, 2].map(|k| part(bytes, place, k) * lattice(clusters[cluster], k)[1]),
                    });
                }
            }
        }
    }
    assert_eq!(next_row as usize, boxes.len());
    out
}

/// Least coordinate of a place of a row of WDND.
fn least(node: &[u8], place: usize, k: usize) -> f64 {
    f64::from(u16_at(node, 16 * k + 2 * place))
}

/// The 223rd part of a place of a row of WDND, in steps of the lattice.
fn part(node: &[u8], place: usize, k: usize) -> f64 {
    (f64::from(u16_at(node, 48 + 16 * k + 2 * place)) - least(node, place, k)) / 223.0
}

/// The box of a place by a row of KBOX, in local space.
fn sides(row: &[u8], node: &[u8], place: usize, cluster: &[u8]) -> Sides {
    [0, 1, 2].map(|k| {
        let [zero, step] = lattice(cluster, k);
        [0, 24].map(|corner| {
            let q = f64::from(row[corner + 8 * k + place]);
            zero + step * (least(node, place, k) + part(node, place, k) * (q - 16.0))
        })
    })
}

/// The triangles below a child.
fn add_triangles(tree: &[&[u8]], child: u32, out: &mut Vec<u32>) {
    if child >> 31 == 1 {
        out.push(child & 0x7FFF_FFFF);
        return;
    }
    let children = u32s::<8>(tree[child as usize], 96);
    for child in children.into_iter().filter(|child| *child != u32::MAX) {
        add_triangles(tree, child, out);
    }
}

#[test]
fn boxes_at_keys_are_where_the_text_says() {
    // Cluster, node and box key, then the box, to five digits.
    #[rustfmt::skip]
    let expected: [(usize, usize, usize, Sides); 9] = [
        (4, 0, 0, [[-0.00037, 1.00038], [-1.56979, 1.00038], [-0.35677, 0.35677]]),
        (4, 0, 1, [[-0.00037, 1.00038], [-2.21570, -1.21992], [-0.57218, 0.57218]]),
        (5, 0, 0, [[-0.00667, 1.01373], [-0.00037, 1.50694], [-1.00038, -0.74916]]),
        (5, 0, 1, [[-2.00040, 1.01373], [0.24188, 2.00040], [-1.00038, 1.00038]]),
        (5, 0, 2, [[-0.00667, 1.50039], [0.24188, 1.50694], [-0.00449, 1.00038]]),
        (6, 0, 0, [[-1.04036, 0.03588], [-0.03587, 1.54260], [-0.03587, 1.04036]]),
        (6, 0, 1, [[0.17937, 1.04036], [-0.25112, 1.54260], [-1.04036, 0.03588]]),
        (6, 1, 0, [[-1.00038, 0.00449], [-0.00699, 1.50039], [-0.00449, 1.00038]]),
        (6, 1, 1, [[0.24673, 1.00038], [-0.25037, 1.50039], [-1.00038, 0.00449]]),
    ];
    let found: Vec<_> = keyed_places()
        .iter()
        .flat_map(|place| {
            let boxes = place.boxes.iter().enumerate();
            boxes.map(|(key, sides)| (place.cluster, place.node, key, *sides))
        })
        .collect();
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((found.0, found.1, found.2), (expected.0, expected.1, expected.2));
        for (found, expected) in found.3.as_flattened().iter().zip(expected.3.as_flattened()) {
            assert!((found - expected).abs() < 0.6e-5, "{found} for {expected}");
        }
    }
}

/// The box of a place at a time in keys from the segment's first.
fn box_between(place: &KeyedPlace, time: f64) -> Sides {
    let before = (time / f64::from(place.interval)) as usize;
    let r = time / f64::from(place.interval) - before as f64;
    let [from, to] = [before, (before + 1).min(place.boxes.len() - 1)].map(|key| place.boxes[key]);
    [0, 1, 2].map(|k| [0, 1].map(|side| (1.0 - r) * from[k][side] + r * to[k][side]))
}

#[test]
fn boxes_between_keys_hold_what_is_below_at_every_time() {
    let (segments, tracks, clusters) = (
        rows_of(V1_3_WIDE, b"SEGM"),
        rows_of(V1_3_WIDE, b"TRAK"),
        rows_of(V1_3_WIDE, b"CLUS"),
    );
    let positions = positions_of_cache(FLAG_CACHE);
    for place in keyed_places() {
        let track = tracks[u32_at(clusters[place.cluster], 56) as usize];
        let positions = &positions[place.segment - 1];
        // How near each side comes to what is below.
        let mut gaps = [[f64::MAX; 2]; 3];
        for triangle in &place.triangles {
            for (time, fuzzy) in fuzzy_positions(*triangle, track, segments[place.segment], positions) {
                let sides = box_between(&place, time);
                for k in 0..3 {
                    let inside = [fuzzy[k] - sides[k][0], sides[k][1] - fuzzy[k]];
                    // What `f64` rounds in numbers of ten at most; a step of the coordinates is a million times as much.
                    assert!(
                        inside.iter().all(|gap| *gap >= -1e-13),
                        "cluster {} node {} at {time}: {fuzzy:?} on axis {k} of {sides:?}",
                        place.cluster,
                        place.node
                    );
                    for (gap, inside) in gaps[k].iter_mut().zip(inside) {
                        *gap = gap.min(inside);
                    }
                }
            }
        }
        // The fixture has rounded outwards.
        let loose = (0..3).any(|k| gaps[k].iter().any(|gap| *gap >= place.parts[k]));
        assert!(!loose, "cluster {} node {}: {gaps:?}", place.cluster, place.node);
    }
}
