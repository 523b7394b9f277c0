use super::*;
use crate::cluster_frame::Map64;
use bytemuck::Zeroable;
use fastrand::Rng;
use restpose_formats::{
    Model,
    rows::{CacheRow, InfluenceRow, KeyRow, KeyVertexRow, MorphDeltaRow, PartRow, SegmentRow, TrackRow, VertexRow},
};

/// Ordinary numbers, zeros of both signs, and what overflows or underflows.
fn number(random: &mut Rng) -> f32 {
    match random.u32(..40) {
        0 => 0.0,
        1 => -0.0,
        2 => 3e38,
        3 => f32::from_bits(random.u32(..9)),
        _ => (random.f32() - 0.5) * 100.0,
    }
}

fn map(random: &mut Rng) -> Affine {
    Affine {
        columns: std::array::from_fn(|_| std::array::from_fn(|_| number(random))),
    }
}

/// Bits; of NaN only that it is one.
fn bits(p: [f32; 3]) -> [u32; 3] {
    p.map(|x| if x.is_nan() { u32::MAX } else { x.to_bits() })
}

/// The vertex function as its documentation has it, coordinate by coordinate.
fn skinned(model: &ModelView, palette: &[Affine], morph_weights: &[f32], vertex: usize) -> [f32; 3] {
    let mut p = model.vertices[vertex].position_rest;
    for delta in model.morph_deltas_of(vertex) {
        for k in 0..3 {
            p[k] += morph_weights[delta.target as usize] * delta.delta[k];
        }
    }
    match model.influences_of(vertex) {
        [only] => palette[only.bone as usize].transform_point(p),
        influences => influences.iter().fold([0.0; 3], |sum, influence| {
            let moved = palette[influence.bone as usize].transform_point(p);
            std::array::from_fn(|k| sum[k] + influence.weight * moved[k])
        }),
    }
}

/// The same of a vertex with a cache.
fn cached(model: &ModelView, cache: &CacheState, vertex: u32) -> [f32; 3] {
    let row = &model.key_vertices[(vertex - 2 + 1) as usize];
    let maps = cache.track(row.track).maps();
    let keys = cache.time().unwrap().keys;
    let stored = |place: usize| row.stored(model.segments[0].key_words(model.key_words, keys[place]));
    let [a, b] = [0, 1].map(|place| maps[place].transform_point(stored(place)));
    std::array::from_fn(|k| a[k] + b[k])
}

fn skinned_model(random: &mut Rng, vertices: usize) -> Model {
    let mut model = Model::default();
    let with_morphs = random.bool();
    for _ in 0..vertices {
        model.vertices.push(VertexRow {
            position_rest: std::array::from_fn(|_| number(random)),
            influence_first: model.influences.len() as u32,
        });
        for _ in 0..random.usize(1..7) {
            let (bone, weight) = (random.u32(..5), random.f32());
            model.influences.push(InfluenceRow { bone, weight });
        }
        if with_morphs {
            model.morph_first.push(model.morph_deltas.len() as u32);
            for _ in 0..random.usize(..3) {
                let delta = std::array::from_fn(|_| number(random));
                model.morph_deltas.push(MorphDeltaRow {
                    target: random.u32(..3),
                    delta,
                });
            }
        }
    }
    model.vertices.push(VertexRow {
        position_rest: [0.0; 3],
        influence_first: model.influences.len() as u32,
    });
    if with_morphs {
        model.morph_first.push(model.morph_deltas.len() as u32);
    }
    model
}

#[test]
fn skinned_vertices_have_the_bits_of_the_vertex_function() {
    let mut random = Rng::with_seed(21);
    for round in 0..200 {
        let vertices = if round == 0 { 3 * TASK + 17 } else { random.usize(1..60) };
        let model = skinned_model(&mut random, vertices);
        let model = model.view();
        let mut palette: Vec<Affine> = (0..5).map(|_| map(&mut random)).collect();
        if round % 8 == 7 {
            // Everything ends in a zero, whose sign depends on where sums begin.
            palette.fill(Affine {
                columns: [[-0.0; 3]; 4],
            });
        }
        let morph_weights: Vec<f32> = (0..3).map(|_| random.f32() - 0.5).collect();
        let first = random.usize(..vertices);
        for level in [SimdLevel::Portable, SimdLevel::detect()] {
            let mut out = vec![[0.0; 3]; vertices - first];
            pose_vertices(level, &model, &palette, &morph_weights, first, &mut out);
            for (row, found) in (first as u32..).zip(out) {
                let expected = skinned(&model, &palette, &morph_weights, row as usize);
                assert_eq!(bits(found), bits(expected), "{level:?}, vertex {row} of {vertices}");
            }
        }
    }
}

/// A part with one cache of four keys, some of its vertices stored raw.
fn cached_model(random: &mut Rng, vertices: u32) -> Model {
    let mut model = Model::default();
    let mut part = PartRow::zeroed();
    part.vertex_first = 2;
    let keys = 4;
    let mut cache = CacheRow::zeroed();
    (cache.key_count, cache.segment_count) = (keys, 1);
    let mut segment = SegmentRow::zeroed();
    (segment.key_count, segment.track_count, segment.key_vertex_first) = (keys, 2, 1);
    for track in 0..2 {
        model.tracks.push(TrackRow {
            key_first: keys * track,
            origin: std::array::from_fn(|_| number(random)),
            step: random.f32(),
            ..TrackRow::zeroed()
        });
        for _ in 0..keys {
            let mut key = KeyRow::zeroed();
            key.map = std::array::from_fn(|_| number(random));
            model.keys.push(key);
        }
    }
    model.key_vertices.push(KeyVertexRow::zeroed());
    let mut bits = 0;
    for _ in 0..vertices {
        let mut row = KeyVertexRow::zeroed();
        row.raw = u8::from(random.u32(..4) == 0);
        row.track = random.u32(..2);
        row.bit_first = bits;
        if row.raw == 0 {
            row.base = std::array::from_fn(|_| random.i32(-1000..1000));
            row.widths = std::array::from_fn(|_| random.u8(..=KeyVertexRow::MAX_WIDTH));
        }
        bits += row.record_bits();
        model.key_vertices.push(row);
    }
    segment.words_per_key = bits.div_ceil(32);
    // Raw positions are any bits, too: of NaN only that it is one is compared.
    let words = (0..keys * segment.words_per_key).map(|_| random.u32(..));
    model.key_words = words.chain([0; KeyVertexRow::CLOSING_WORDS]).collect();
    (model.parts, model.caches, model.segments) = (vec![part], vec![cache], vec![segment]);
    model
}

#[test]
fn cached_vertices_have_the_bits_of_their_function() {
    let mut random = Rng::with_seed(22);
    for round in 0..200 {
        let vertices = if round == 0 {
            TASK as u32 + 17
        } else {
            random.u32(1..60)
        };
        let model = cached_model(&mut random, vertices);
        let model = model.view();
        let mut cache = CacheState::default();
        let mut out = [[0.0; 3]; 2];
        pose_cached_vertices(SimdLevel::detect(), &model, &cache, 2, &mut out);
        assert!(out.as_flattened().iter().all(|x| x.is_nan()), "it stands nowhere yet");
        let world = [Map64::new(&map(&mut random)), Map64::new(&Affine::IDENTITY)];
        cache.update(&model, &model.caches[0], random.f64() * 3.0, &world);
        for level in [SimdLevel::Portable, SimdLevel::detect()] {
            let first = random.u32(..vertices) + 2;
            let mut out = vec![[0.0; 3]; (vertices + 2 - first) as usize];
            pose_cached_vertices(level, &model, &cache, first as usize, &mut out);
            for (row, found) in (first..).zip(out) {
                assert_eq!(
                    bits(found),
                    bits(cached(&model, &cache, row)),
                    "{level:?}, vertex {row}"
                );
            }
        }
    }
}
