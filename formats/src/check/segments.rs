use super::{numbers::reserved, row, tiling::Tiling};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{CacheRow, KeyVertexRow, NONE, PartRow, SegmentRow},
};
use std::ops::Range;

/// A segment with what it belongs to.
#[derive(Clone, Copy)]
pub(super) struct Segment<'a> {
    pub(super) at: usize,
    pub(super) row: &'a SegmentRow,
    pub(super) cache: &'a CacheRow,
    pub(super) part: &'a PartRow,
}

impl Segment<'_> {
    pub(super) fn tracks(&self) -> Range<usize> {
        range(self.row.track_first, self.row.track_count)
    }

    pub(super) fn clusters(&self) -> Range<usize> {
        range(self.row.cluster_first, self.row.cluster_count)
    }

    /// The key-vertex rows of the part's vertices.
    pub(super) fn key_vertices(&self) -> Range<usize> {
        range(self.row.key_vertex_first, self.part.vertex_count)
    }

    /// The words of each key, and all that follow them. Segments have been checked.
    pub(super) fn keys<'b>(&self, view: &ModelView<'b>) -> impl Iterator<Item = &'b [u32]> {
        let (segment, words) = (self.row, view.key_words);
        (0..segment.key_count).map(move |key| segment.key_words(words, key))
    }

    /// The key-vertex row of a vertex of the part.
    pub(super) fn key_vertex(&self, vertex: usize) -> usize {
        self.row.key_vertex_first as usize + (vertex - self.part.vertex_first as usize)
    }
}

fn range(first: u32, count: u32) -> Range<usize> {
    first as usize..first as usize + count as usize
}

/// The segments of a cache. Caches have been checked.
pub(super) fn of_cache<'a>(view: &ModelView<'a>, cache: &'a CacheRow) -> impl Iterator<Item = Segment<'a>> {
    let part = &view.parts[cache.part as usize];
    let segments = view.segments;
    range(cache.segment_first, cache.segment_count).map(move |at| Segment {
        at,
        row: &segments[at],
        cache,
        part,
    })
}

/// All segments, in row order. Caches have been checked.
pub(super) fn all<'a>(view: &ModelView<'a>) -> impl Iterator<Item = Segment<'a>> {
    view.caches.iter().flat_map(|cache| of_cache(view, cache))
}

/// How many clusters stand before the first one that has a track.
pub(super) fn clusters_without_track(view: &ModelView<'_>) -> usize {
    let first = view.clusters.iter().position(|cluster| cluster.track != NONE);
    first.unwrap_or(view.clusters.len())
}

/// Segments tile the tracks, the key vertices, the key words but for those that close their section, and the clusters from
/// the first with a track on. Caches have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::Segments;
    let first = clusters_without_track(view);
    let mut tracks = Tiling::new(SectionKind::Tracks, view.tracks.len());
    let mut clusters = Tiling::starting_at(SectionKind::Clusters, view.clusters.len(), first);
    let mut vertices = Tiling::new(SectionKind::KeyVertices, view.key_vertices.len());
    let closing = if view.caches.is_empty() {
        0
    } else {
        KeyVertexRow::CLOSING_WORDS
    };
    let mut words = Tiling::with_closing_rows(SectionKind::KeyWords, view.key_words.len(), closing);
    for Segment {
        at, row: segment, part, ..
    } in all(view)
    {
        if segment.track_count == 0 {
            return Err(row(section, at, RowFault::EmptyRange { field: "track_count" }));
        }
        tracks.take(section, at, "track_first", segment.track_first, segment.track_count)?;
        clusters.take(
            section,
            at,
            "cluster_first",
            segment.cluster_first,
            segment.cluster_count,
        )?;
        vertices.take(
            section,
            at,
            "key_vertex_first",
            segment.key_vertex_first,
            part.vertex_count,
        )?;
        let count = u64::from(segment.words_per_key) * u64::from(segment.key_count);
        words.take(section, at, "word_first", segment.word_first, count)?;
    }
    tracks.finish()?;
    clusters.finish()?;
    vertices.finish()?;
    words.finish()?;
    let first = view.key_words.len() - closing;
    for (at, word) in view.key_words.iter().enumerate().skip(first) {
        reserved(SectionKind::KeyWords, at, "closing word", &[*word])?;
    }
    Ok(())
}
