//! Decodes the wide trees of the golden file as `FORMAT.md` describes them, in the manner of `bare_reader`.

use crate::{
    bare_reader::{rows, rows_of, u32_at, u32s},
    golden::V1_3_WIDE,
};

/// The six coordinates of a place of a row of WDND, as a row of RBOX has them.
fn box_of(node: &[u8], place: usize) -> Vec<u8> {
    (0..6)
        .flat_map(|corner| node[16 * corner + 2 * place..][..2].to_vec())
        .collect()
}

/// Triangle of each leaf below a node, and its box where that does not follow the pose. Asserts that boxes lie in `around`,
/// which is of a node of the kind that `follows` says, or of the whole lattice.
fn leaves(nodes: &[&[u8]], at: usize, follows: bool, around: &[u8], out: &mut Vec<(u32, Option<Vec<u8>>)>) {
    let coordinate = |bytes: &[u8], k: usize| u16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]);
    let children = u32s::<8>(nodes[at], 96);
    let own_follows = u32_at(nodes[at], 132) > 0;
    let whole = whole_lattice();
    let around = if own_follows == follows { around } else { &whole };
    let used = children.iter().take_while(|child| **child != u32::MAX).count();
    assert!(used > 0);
    for (place, child) in children.iter().enumerate() {
        let own = box_of(nodes[at], place);
        if place >= used {
            assert_eq!((*child, own), (u32::MAX, vec![255; 12]));
            continue;
        }
        for k in 0..3 {
            assert!(coordinate(around, k) <= coordinate(&own, k));
            assert!(coordinate(&own, k) <= coordinate(&own, k + 3));
            assert!(coordinate(&own, k + 3) <= coordinate(around, k + 3));
        }
        if child >> 31 == 1 {
            out.push((child & 0x7FFF_FFFF, (!own_follows).then_some(own)));
        } else {
            assert!(*child as usize > at);
            leaves(nodes, *child as usize, own_follows, &own, out);
        }
    }
}

fn whole_lattice() -> Vec<u8> {
    [[0; 6], [255; 6]].concat()
}

#[test]
fn wide_trees_have_the_boxes_of_the_kd_trees() {
    let [nodes, clusters, references] = [b"WDND", b"CLUS", b"REFS"].map(|code| rows_of(V1_3_WIDE, code));
    let (mut node_count, mut still) = (0, 0);
    for (cluster, kd_cluster) in clusters.iter().zip(rows(b"CLUS")) {
        let [first, count, reference_first, reference_count] = u32s::<4>(cluster, 4).map(|x| x as usize);
        assert_eq!(first, node_count);
        node_count += count;
        let [_, _, kd_first, kd_count] = u32s::<4>(kd_cluster, 4).map(|x| x as usize);
        let mut expected: Vec<(u32, Vec<u8>)> = (kd_first..kd_first + kd_count)
            .map(|at| (u32_at(rows(b"REFS")[at], 0), rows(b"RBOX")[at].to_vec()))
            .collect();
        expected.sort();
        expected.dedup();
        let mut listed: Vec<u32> = (reference_first..reference_first + reference_count)
            .map(|at| u32_at(references[at], 0))
            .collect();
        if count > 0 {
            let in_rows = nodes[first..first + count].iter().flat_map(|node| u32s::<8>(node, 96));
            let in_rows: Vec<u32> = in_rows.filter(|child| child >> 31 == 1 && *child != u32::MAX).collect();
            assert_eq!(
                in_rows.iter().map(|child| child & 0x7FFF_FFFF).collect::<Vec<_>>(),
                listed
            );
            let mut found = Vec::new();
            leaves(&nodes[first..first + count], 0, false, &whole_lattice(), &mut found);
            found.sort();
            assert_eq!(found.len(), expected.len());
            for ((triangle, own), (expected, fuzzy)) in found.iter().zip(&expected) {
                assert_eq!(triangle, expected);
                assert!(own.as_ref().is_none_or(|own| own == fuzzy));
                still += usize::from(own.is_some());
            }
        }
        listed.sort_unstable();
        assert_eq!(
            listed,
            expected.iter().map(|(triangle, _)| *triangle).collect::<Vec<_>>()
        );
    }
    assert_eq!(node_count, nodes.len());
    assert_eq!(still, 6, "of eight leaves, two follow the pose");
    assert_eq!(
        (rows_of(V1_3_WIDE, b"KDND").len(), rows_of(V1_3_WIDE, b"RBOX").len()),
        (0, 0)
    );
}

#[test]
fn metadata_tells_the_kind_of_trees() {
    // Bounds, kind of trees and the number of degenerate triangles are the last three bytes.
    let tail = |rows: Vec<&[u8]>| rows[rows.len() - 3..].concat();
    assert_eq!(tail(rows(b"META")), [1, 0, 2]);
    assert_eq!(tail(rows_of(V1_3_WIDE, b"META")), [1, 1, 2]);
}
