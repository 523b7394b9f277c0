//! Vertex caches: where one stands in this frame, and what its tracks are there.
//!
//! A cached vertex is `A·q + B·q'`: q and q' are its stored numbers at the keys around the frame, A and B the maps of its
//! track there, with the weights of both keys, the lattice, the bone and the instance transform multiplied in.

use crate::{
    Aabb, Affine, Asset,
    cluster_frame::{Map64, PosedMap, world_box},
    simd::{Doubles, Lanes, Portable, prefetch},
    vertex::{moved, transform},
    wide::KeyBoxes,
};
use restpose_formats::{
    ModelView,
    geom::round::{f32_above, f32_below},
    rows::{CacheRow, ClusterRow, NONE, PartRow, SegmentRow, TrackRow},
};

/// Frames between keys are told apart down to this fraction, 2⁻²⁴, so that both weights are `f32` and sum to one.
const WEIGHT_STEPS: f64 = (1u32 << 24) as f64;

/// Where a cache stands: between which keys, in which segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CacheTime {
    /// Segment row.
    pub segment: u32,
    /// The key before and the key after, counted from the segment's first.
    pub keys: [u32; 2],
    /// Weight of the key after, a multiple of 2⁻²⁴.
    pub weight: f32,
}

impl CacheTime {
    /// `frame` counts keys from 0 and is finite; beyond the ends it stands for the first or last key.
    pub(crate) fn new(model: &ModelView, cache: &CacheRow, frame: f64) -> Self {
        let segments = &model.segments[cache.segment_first as usize..][..cache.segment_count as usize];
        let frame = frame.clamp(0.0, f64::from(cache.key_count - 1));
        let place = segments
            .partition_point(|segment| f64::from(segment.key_first) <= frame)
            .saturating_sub(1);
        let segment = &segments[place];
        let in_segment = frame - f64::from(segment.key_first);
        let last = segment.key_count - 1;
        let before = (in_segment as u32).min(last.saturating_sub(1));
        let weight = ((in_segment - f64::from(before)) * WEIGHT_STEPS).round() / WEIGHT_STEPS;
        Self {
            segment: cache.segment_first + place as u32,
            keys: [before, (before + 1).min(last)],
            weight: weight as f32,
        }
    }
}

/// A track in this frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedTrack {
    /// World space from the stored numbers of the key before and of the key after.
    maps: [PosedMap; 2],
    /// The cluster frame that the track gives: world from local space.
    pub frame: PosedMap,
}

impl PosedTrack {
    /// `world` is world space from the cache's space: the instance transform and the bone's map.
    fn new(world: &[Map64; 2], track: &TrackRow, model: &ModelView, time: &CacheTime) -> Self {
        let key = |place: usize| match track.key_first {
            NONE => Affine::IDENTITY,
            first => model.keys[(first + time.keys[place]) as usize].map(),
        };
        let maps = [Map64::new(&key(0)), Map64::new(&key(1))];
        let after = f64::from(time.weight);
        let weights = [1.0 - after, after];
        let lattice = Map64::lattice(track.origin, track.step);
        let stored = |place: usize| {
            PosedMap::weighted(
                Portable,
                weights[place],
                &[&world[0], &world[1], &maps[place], &lattice],
            )
        };
        Self {
            maps: [stored(0), stored(1)],
            frame: PosedMap::product(Portable, &[&world[0], &world[1], &Map64::blend(weights, &maps)]),
        }
    }

    /// World space from the stored numbers of the key before and of the key after.
    #[cfg(test)]
    pub(crate) fn maps(&self) -> [&Affine; 2] {
        self.maps.each_ref().map(|map| &map.map)
    }

    /// Bounds, per world axis, the magnitudes that enter a vertex whose stored numbers are at most `extent`.
    #[inline(always)]
    fn reach<S: Lanes>(&self, simd: S, extent: [f64; 3]) -> Doubles<S> {
        let [a, b] = &self.maps;
        a.reach(simd, extent) + b.reach(simd, extent)
    }
}

/// A cache of an instance in this frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct CacheState {
    time: Option<CacheTime>,
    /// Key-vertex row minus vertex row, for the cache's vertices; wraps.
    key_vertex_shift: u32,
    /// Where the words of the key before and of the key after begin.
    words: [usize; 2],
    track_first: u32,
    tracks: Vec<PosedTrack>,
}

impl CacheState {
    /// Poses the tracks of the segment that holds `frame`. `world` as in [`PosedTrack`].
    pub(crate) fn update(&mut self, model: &ModelView, cache: &CacheRow, frame: f64, world: &[Map64; 2]) {
        let time = CacheTime::new(model, cache, frame);
        let segment: &SegmentRow = &model.segments[time.segment as usize];
        let part: &PartRow = &model.parts[cache.part as usize];
        self.time = Some(time);
        self.key_vertex_shift = segment.key_vertex_first.wrapping_sub(part.vertex_first);
        self.words = time.keys.map(|key| segment.first_word(key));
        self.track_first = segment.track_first;
        self.tracks.clear();
        let tracks = &model.tracks[segment.track_first as usize..][..segment.track_count as usize];
        self.tracks
            .extend(tracks.iter().map(|track| PosedTrack::new(world, track, model, &time)));
    }

    /// Where the cache stands; set by the first update.
    pub(crate) fn time(&self) -> Option<CacheTime> {
        self.time
    }

    /// A track row of the present segment.
    pub(crate) fn track(&self, row: u32) -> &PosedTrack {
        &self.tracks[(row - self.track_first) as usize]
    }

    /// Whether it stands in a cut interval of the track, where its cluster's tree holds nothing. The track has keys.
    pub(crate) fn is_cut(&self, model: &ModelView, track: u32) -> bool {
        self.time.is_none_or(|time| {
            let before = model.tracks[track as usize].key_first + time.keys[0];
            model.keys[before as usize].is_cut() && time.weight > 0.0
        })
    }

    /// Boxes at keys of the nodes of a cluster with a track, where they have any.
    #[inline]
    pub(crate) fn key_boxes<'a>(&self, model: &ModelView<'a>, cluster: &ClusterRow) -> Option<KeyBoxes<'a>> {
        let track = &model.tracks[cluster.track as usize];
        let time = self.time.filter(|_| track.box_interval != 0)?;
        let segment_keys = model.segments[time.segment as usize].key_count;
        let count = track.key_box_count(cluster, segment_keys) as usize;
        let key_count = track.box_key_count(segment_keys);
        let before = time.keys[0] / track.box_interval;
        let passed = (time.keys[0] % track.box_interval) as f32 + time.weight;
        Some(KeyBoxes {
            rows: &model.key_boxes[track.box_first as usize..][..count],
            node_count: cluster.node_count,
            keys: [before, (before + 1).min(key_count - 1)],
            weight: passed / track.box_interval as f32,
        })
    }

    /// The greatest magnitudes, per world axis, that enter the posed vertices of a cluster.
    #[inline(always)]
    pub(crate) fn reach<S: Lanes>(&self, simd: S, model: &ModelView, cluster: &ClusterRow) -> Doubles<S> {
        let mut reach = Doubles::splat(simd, 0.0);
        for (track, extent) in moved(model, cluster) {
            reach = self.track(track).reach(simd, extent).max(reach);
        }
        reach
    }

    /// World box of a cluster that has a track with keys, by the boxes of its vertices at the keys, between which these
    /// move on straight lines. `bone` carries the cache.
    pub(crate) fn cluster_bounds(&self, asset: &Asset, cluster: &ClusterRow, bone: &PosedMap) -> Aabb {
        let model = asset.model();
        let Some(time) = self.time else {
            return Aabb::EMPTY;
        };
        let first = model.tracks[cluster.track as usize].key_first;
        let [a, b] = time.keys.map(|key| &model.keys[(first + key) as usize]);
        let after = f64::from(time.weight);
        let mix = |a: f32, b: f32| (1.0 - after) * f64::from(a) + after * f64::from(b);
        let bounds = Aabb {
            min: std::array::from_fn(|k| f32_below(mix(a.bounds.min[k], b.bounds.min[k]))),
            max: std::array::from_fn(|k| f32_above(mix(a.bounds.max[k], b.bounds.max[k]))),
        };
        let error = self.reach(Portable, model, cluster) * asset.cache_vertex_error();
        world_box(Portable, &bounds, bone, error)
    }

    /// Poses a vertex of the cache's part, by vertex row: each map's image rounded as [`Affine::transform_point`] says,
    /// then one sum per component, in `f32` without contraction. The fourth lane means nothing; NaN before the first update.
    #[inline(always)]
    pub(crate) fn pose_vertex<S: Lanes>(&self, simd: S, model: &ModelView, vertex: u32) -> S::F4 {
        if self.time.is_none() {
            return simd.splat4(f32::NAN);
        }
        let row = &model.key_vertices[vertex.wrapping_add(self.key_vertex_shift) as usize];
        let [a, b] = &self.track(row.track).maps;
        let [p, q] = [
            row.stored(&model.key_words[self.words[0]..]),
            row.stored(&model.key_words[self.words[1]..]),
        ];
        let a = transform(simd, &a.map, [simd.splat4(p[0]), simd.splat4(p[1]), simd.splat4(p[2])]);
        let b = transform(simd, &b.map, [simd.splat4(q[0]), simd.splat4(q[1]), simd.splat4(q[2])]);
        simd.add4(a, b)
    }

    /// Asks for what [`CacheState::pose_vertex`] reads first.
    #[inline]
    pub(crate) fn prefetch_row(&self, model: &ModelView, vertex: u32) {
        let row = vertex.wrapping_add(self.key_vertex_shift) as usize;
        prefetch(std::slice::from_ref(&model.key_vertices[row]));
    }

    /// Asks for what it reads next, where the first is near.
    #[inline]
    pub(crate) fn prefetch_stored(&self, model: &ModelView, vertex: u32) {
        let word = model.key_vertices[vertex.wrapping_add(self.key_vertex_shift) as usize].word();
        for first in self.words {
            prefetch(&model.key_words[first + word..][..4]);
        }
    }
}

/// `f32` roundings of [`CacheState::pose_vertex`]: product and sums with a map are four, the last sum is one.
pub(crate) const CACHE_ROUNDINGS: u32 = 5;
