use restpose_formats::{
    ModelView,
    rows::{CacheRow, SegmentRow},
};
use serde::Serialize;

/// What a file holds of a vertex cache.
#[derive(Serialize)]
pub struct CacheContents {
    /// Name of the part that it moves.
    pub part: String,
    /// Key frames.
    pub keys: u32,
    /// Bound of the distance of a stored position from the source's at any key, scene units; 0 is exact.
    pub position_error: f32,
    /// Bytes of the stored positions.
    pub position_bytes: u64,
    /// The same per vertex and key; raw positions take 12.
    pub bytes_per_vertex_key: f64,
    pub segments: Vec<SegmentContents>,
}

/// A time segment of a vertex cache.
#[derive(Serialize)]
pub struct SegmentContents {
    pub key_first: u32,
    pub key_last: u32,
    pub tracks: u32,
    pub clusters: u32,
}

impl CacheContents {
    /// All caches of a file, in its order.
    pub fn all(model: &ModelView<'_>) -> Vec<Self> {
        model.caches.iter().map(|cache| Self::new(model, cache)).collect()
    }

    fn new(model: &ModelView<'_>, cache: &CacheRow) -> Self {
        let part = model.parts.get(cache.part as usize);
        let vertices = part.map_or(0, |part| part.vertex_count);
        let name = model.meta.part_names.get(cache.part as usize);
        let segments = rows(model.segments, cache.segment_first, cache.segment_count);
        let position_bytes: u64 = segments
            .iter()
            .map(|segment| position_bytes(model, segment, vertices))
            .sum();
        let positions = f64::from(vertices) * f64::from(cache.key_count);
        Self {
            part: name.cloned().unwrap_or_default(),
            keys: cache.key_count,
            position_error: cache.position_error,
            position_bytes,
            // A part has vertices and a cache has keys; 0 would not be a number in JSON.
            bytes_per_vertex_key: position_bytes as f64 / positions.max(1.0),
            segments: segments.iter().map(segment_contents).collect(),
        }
    }

    /// Tracks of all segments.
    pub fn tracks(&self) -> u32 {
        self.segments.iter().map(|segment| segment.tracks).sum()
    }
}

fn segment_contents(segment: &SegmentRow) -> SegmentContents {
    SegmentContents {
        key_first: segment.key_first,
        key_last: segment.key_first + segment.key_count.saturating_sub(1),
        tracks: segment.track_count,
        clusters: segment.cluster_count,
    }
}

/// Bytes of the rows that say where the vertices' numbers are, and of these numbers.
fn position_bytes(model: &ModelView<'_>, segment: &SegmentRow, vertices: u32) -> u64 {
    let rows = rows(model.key_vertices, segment.key_vertex_first, vertices);
    let words = u64::from(segment.words_per_key) * u64::from(segment.key_count);
    size_of_val(rows) as u64 + size_of::<u32>() as u64 * words
}

fn rows<T>(section: &[T], first: u32, count: u32) -> &[T] {
    section
        .get(first as usize..first.saturating_add(count) as usize)
        .unwrap_or_default()
}
