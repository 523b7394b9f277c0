use super::{
    row,
    segments::{self, Segment},
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{KeyBoxRow, NONE, WideChild, WideNodeRow},
};

/// The boxes at keys fill their section, cluster by cluster; each has a point, or is zero in an empty place. Segments, tracks,
/// clusters and trees have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let mut ranges = Tiling::new(SectionKind::KeyBoxes, view.key_boxes.len());
    for segment in segments::all(view) {
        for at in segment.clusters() {
            check_cluster(view, &segment, at, &mut ranges)?;
        }
    }
    ranges.finish()
}

fn check_cluster(
    view: &ModelView<'_>,
    segment: &Segment<'_>,
    at: usize,
    ranges: &mut Tiling,
) -> Result<(), FormatError> {
    let cluster = &view.clusters[at];
    let at = cluster.track as usize;
    let track = &view.tracks[at];
    if track.key_first == NONE {
        return Ok(());
    }
    let count = track.key_box_count(cluster, segment.row.key_count);
    let rows = ranges.take(SectionKind::Tracks, at, "box_first", track.box_first, count)?;
    if track.box_interval == 0 {
        return Ok(());
    }
    // Beside kd-trees there are no such rows, so these are a wide tree's nodes.
    let nodes = &view.wide_nodes[cluster.node_first as usize..][..cluster.node_count as usize];
    let empty: Vec<[u8; 8]> = nodes.iter().map(empty_places).collect();
    for (at, empty) in rows.zip(empty.iter().cycle()) {
        let listed = &view.key_boxes[at];
        // A file may have more of these rows than of all others, so which place is wrong is asked only of a row that is.
        if !is_right(listed, *empty) {
            check_row(listed, *empty).map_err(|fault| row(SectionKind::KeyBoxes, at, fault))?;
        }
    }
    Ok(())
}

/// All bits of the empty places of a node, none of the others.
fn empty_places(node: &WideNodeRow) -> [u8; 8] {
    node.children.map(|child| match child {
        WideChild::EMPTY => u8::MAX,
        _ => 0,
    })
}

/// Not zero where a box is wrong along an axis: where `min` is above `max`, or either is not zero in an empty place, where
/// `empty` has all of its bits.
fn wrong(min: u8, max: u8, empty: u8) -> u8 {
    // A `min` that is not above `max` is zero where `max` is.
    min.saturating_sub(max) | max & empty
}

/// Whether no place of a row is wrong. Without branches, and with plain indices: so the compiler looks at all places of an axis
/// together, which is five times as fast as one by one.
fn is_right(boxes: &KeyBoxRow, empty: [u8; 8]) -> bool {
    let mut found = [0; 8];
    for k in 0..3 {
        for place in 0..8 {
            found[place] |= wrong(boxes.min[k][place], boxes.max[k][place], empty[place]);
        }
    }
    found == [0; 8]
}

/// No place of a row is wrong.
fn check_row(boxes: &KeyBoxRow, empty: [u8; 8]) -> Result<(), RowFault> {
    for (axis, (min, max)) in boxes.min.iter().zip(&boxes.max).enumerate() {
        for place in 0..8 {
            let (min, max) = (min[place], max[place]);
            if wrong(min, max, empty[place]) != 0 {
                let expected = match empty[place] {
                    0 => "`min` at most `max`",
                    _ => "zero in an empty place",
                };
                return Err(RowFault::KeyBox {
                    place,
                    axis,
                    min,
                    max,
                    expected,
                });
            }
        }
    }
    Ok(())
}
