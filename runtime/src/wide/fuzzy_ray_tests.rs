//! Boxes that follow the pose, against fuzzy positions in `f64` with bounds of their own.

use super::fuzzy_ray::FuzzyBoxes;
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Affine,
    cluster_frame::invert_frame,
    mover_maps::MoverMaps,
    relative_motions::RelativeMotions,
    simd::{Lanes, Portable},
};
use fastrand::Rng;
use restpose_formats::rows::{ClusterBoneRow, MAX_MOVERS, MOVER_WEIGHTS, NodeMoverRow, RestLattice, WideNodeRow};

/// A rest position, by how much it is morphed, and the parts of 2²⁴ by which bones move it: by mover, then the rest of one.
struct Vertex {
    rest: [f32; 3],
    morphed: [f64; 3],
    weights: [u32; MAX_MOVERS],
}

const WHOLE: u32 = 1 << 24;

/// Of the lattice, in sizes.
const STEP: f32 = 1.0 / 16_384.0;

impl Vertex {
    fn own_weight(&self) -> u32 {
        WHOLE - self.weights.iter().sum::<u32>()
    }
}

/// A cluster in a pose, with one node.
struct Posed {
    /// Of eight places, the last ones without any.
    places: [Vec<Vertex>; 8],
    lattice: RestLattice,
    /// Row in the palette of the cluster's own bone; those of the others, in their order.
    own: u32,
    others: Vec<u32>,
    palette: Vec<Affine>,
    inverse: [[f64; 3]; 3],
    maps: MoverMaps,
    error: [f64; 3],
    node: WideNodeRow,
    movers: Vec<NodeMoverRow>,
}

fn signed(random: &mut Rng) -> f32 {
    random.f32() * 2.0 - 1.0
}

fn random_weights(random: &mut Rng, movers: usize) -> [u32; MAX_MOVERS] {
    let mut weights = [0; MAX_MOVERS];
    let mut left = WHOLE;
    for _ in 0..random.usize(..5) {
        let part = match random.u32(..5) {
            0 => left,
            1 => left.min(1),
            2 => left.min(random.u32(..1 << 9)),
            _ => random.u32(..=left),
        };
        weights[random.usize(..movers)] += part;
        left -= part;
    }
    weights
}

/// Near rest, or anything from a ragdoll to a flat map.
fn random_map(random: &mut Rng, size: f32, near_rest: bool) -> Affine {
    let (off, far) = if near_rest {
        (
            [0.0, 1e-7, 1e-4, 0.02, 1.0][random.usize(..5)],
            size * [0.0, 0.01, 0.3, 3.0][random.usize(..4)],
        )
    } else {
        (1.0, size * [0.0, 1.0, 100.0, 1e4][random.usize(..4)])
    };
    let scale = if near_rest {
        1.0
    } else {
        [1.0, -1.0, 40.0, 1e-3, 0.0][random.usize(..5)]
    };
    let mut columns: [[f32; 3]; 4] = std::array::from_fn(|column| {
        std::array::from_fn(|row| {
            let still = if near_rest && column == row { 1.0 } else { 0.0 };
            still + off * scale * signed(random)
        })
    });
    columns[3] = std::array::from_fn(|_| signed(random) * far);
    Affine { columns }
}

/// Of condition numbers up to the limit.
fn random_own(random: &mut Rng, size: f32) -> (Affine, [[f64; 3]; 3]) {
    loop {
        let near_rest = random.bool();
        let mut map = random_map(random, size, near_rest);
        let flat = [1.0, 1.0, 0.01, 1e-3, 1e-4][random.usize(..5)];
        map.columns[random.usize(..3)].iter_mut().for_each(|x| *x *= flat);
        if let Some(inverse) = invert_frame(&map) {
            return (map, inverse);
        }
    }
}

impl Posed {
    fn random(seed: u64) -> Self {
        let random = &mut Rng::with_seed(seed);
        let size = 2f32.powi(random.i32(-20..20));
        let offset = size * [0.0, -2.0, 1.0, 100.0, 500.0][random.usize(..5)];
        let (own_map, inverse) = random_own(random, size);
        let bones = random.u32(2..=11);
        let own = random.u32(..bones);
        let others: Vec<u32> = (0..bones).filter(|bone| *bone != own).collect();
        let with_own = random.u32(..4) > 0;
        let near_rest = random.u32(..4) > 0;
        let palette: Vec<Affine> = (0..bones)
            .map(|bone| match (bone == own, random_map(random, size, near_rest)) {
                (true, _) => own_map,
                (false, map) if with_own => own_map * map,
                (false, map) => map,
            })
            .collect();

        let morphs = f64::from(size) * [0.0, 0.0, 0.3, 10.0, 1e3][random.usize(..5)];
        let morph_extent: [f64; 3] = std::array::from_fn(|_| morphs * random.f64());
        let movers = others.len().min(MAX_MOVERS);
        let used = random.usize(1..=8);
        let spread = [1e-3, 1.0][random.usize(..2)];
        let on_lattice = random.bool();
        let position = |random: &mut Rng, center: f32| {
            let share = (0.5 + 0.5 * (center + signed(random) * spread)).clamp(0.0, 1.0);
            let steps = share * 65_533.0;
            let steps = if on_lattice { steps.round() } else { steps };
            offset + steps * size * STEP
        };
        let places: [Vec<Vertex>; 8] = std::array::from_fn(|place| {
            let center: [f32; 3] = std::array::from_fn(|_| signed(random));
            let alike = random.bool().then(|| random_weights(random, movers));
            let vertices = (0..random.usize(1..7)).map(|_| Vertex {
                rest: center.map(|x| position(random, x)),
                // At the ends, where the bound is attained.
                morphed: morph_extent.map(|x| if random.bool() { x } else { -x }),
                weights: alike.unwrap_or_else(|| random_weights(random, movers)),
            });
            vertices.take(if place < used { usize::MAX } else { 0 }).collect()
        });

        let rest = |place: &Vec<Vertex>| Aabb::around(place.iter().map(|vertex| vertex.rest));
        // Such that the step is a power of two.
        let whole = Aabb {
            min: [offset; 3],
            max: [offset + 65_533.0 * size * STEP; 3],
        };
        let cluster_bones: Vec<ClusterBoneRow> = (0..bones)
            .map(|bone| ClusterBoneRow {
                bone,
                bounds: whole,
                reserved: 0,
            })
            .collect();
        let lattice = RestLattice::new(&cluster_bones);
        assert_eq!(
            (lattice.origin, lattice.step),
            ([offset; 3], size * STEP),
            "seed {seed}"
        );
        let mut node = WideNodeRow::EMPTY;
        node.mover_count = movers as u32;
        let mut rows: Vec<NodeMoverRow> = (0..movers as u32)
            .map(|mover| NodeMoverRow {
                mover,
                ..NodeMoverRow::default()
            })
            .collect();
        for (at, place) in places.iter().enumerate().take(used) {
            let rest = rest(place);
            // Of positions on the lattice without a step to spare.
            let steps = |corner: [f32; 3]| corner.map(|x| ((x - offset) / lattice.step) as u16);
            let [min, max] = if on_lattice {
                [steps(rest.min), steps(rest.max)]
            } else {
                lattice.around(&rest)
            };
            for k in 0..3 {
                (node.min[k][at], node.max[k][at]) = (min[k], max[k]);
            }
            for row in &mut rows {
                let weights = place.iter().map(|vertex| vertex.weights[row.mover as usize]);
                let (least, greatest) = weights.fold((WHOLE, 0), |(a, b), weight| (a.min(weight), b.max(weight)));
                let unit = WHOLE / MOVER_WEIGHTS as u32;
                let middle = (least.midpoint(greatest) / unit).min(u32::from(u16::MAX));
                let off = (middle * unit).abs_diff(least).max((middle * unit).abs_diff(greatest));
                (row.weight[at], row.spread[at]) = (middle as u16, off.div_ceil(unit) as u16);
            }
        }
        let mut relative = RelativeMotions::default();
        relative.update(Portable, &cluster_bones, own, &inverse, &palette);
        let (maps, error) = MoverMaps::new(Portable, &lattice, &relative, morph_extent);
        Self {
            places,
            lattice,
            own,
            others,
            palette,
            inverse,
            maps,
            error,
            node,
            movers: rows,
        }
    }

    /// Per axis, of the eight places.
    fn planes<S: Lanes>(&self, simd: S) -> [[[f32; 8]; 2]; 3] {
        let boxes = FuzzyBoxes {
            keys: None,
            motions: &self.maps,
            movers: &self.movers,
        };
        boxes.planes(simd, &self.node, 0).map(|sides| {
            sides.map(|lanes| {
                let mut out = [0.0; 8];
                simd.store8(lanes, &mut out);
                out
            })
        })
    }

    /// The fuzzy position, and how far it may be from the exact one per axis.
    ///
    /// With the posed vertex v it is the q of `X·q = v − t`. For any q′ and L, q − q′ = X⁻¹·(v − t − X·q′), and X⁻¹ is within
    /// half of L where L is its inverse but for rounding.
    fn fuzzy_position(&self, vertex: &Vertex) -> ([f64; 3], [f64; 3]) {
        // More than all roundings here, relative to what enters them.
        const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;
        let morphed: [f64; 3] = std::array::from_fn(|k| f64::from(vertex.rest[k]) + vertex.morphed[k]);
        let own = columns(&self.palette[self.own as usize]);
        let (mut from_origin, mut magnitude) = (own[3].map(|x| -x), own[3].map(f64::abs));
        let others = vertex.weights.iter().zip(&self.others);
        for (weight, bone) in others.chain([(&vertex.own_weight(), &self.own)]) {
            let (weight, x) = (
                f64::from(*weight) / f64::from(WHOLE),
                columns(&self.palette[*bone as usize]),
            );
            for k in 0..3 {
                for (entry, along) in [
                    (x[0][k], morphed[0]),
                    (x[1][k], morphed[1]),
                    (x[2][k], morphed[2]),
                    (x[3][k], 1.0),
                ] {
                    from_origin[k] += weight * entry * along;
                    magnitude[k] += weight * (entry * along).abs();
                }
            }
        }
        let turned = |v: &[f64; 3], k: usize| (0..3).map(|j| self.inverse[k][j] * v[j]).sum::<f64>();
        let position: [f64; 3] = std::array::from_fn(|k| turned(&from_origin, k));
        let left: [f64; 3] = std::array::from_fn(|k| {
            let images: [f64; 3] = std::array::from_fn(|j| own[j][k] * position[j]);
            let rounding = ROUNDING * (magnitude[k] + images.iter().map(|x| x.abs()).sum::<f64>());
            (from_origin[k] - images.iter().sum::<f64>()).abs() + rounding
        });
        let bound = |k: usize| 2.0 * (0..3).map(|j| self.inverse[k][j].abs() * left[j]).sum::<f64>();
        (position, [bound(0), bound(1), bound(2)])
    }
}

fn columns(map: &Affine) -> [[f64; 3]; 4] {
    map.columns.map(|column| column.map(f64::from))
}

/// Along one axis.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Vertices in boxes that are relied upon.
    compared: usize,
    /// Of boxes that are not, vertices.
    left_out: usize,
    /// Vertices that are certainly outside of the box without its error.
    outside: usize,
    /// The part of the error that is needed, at most.
    needed: f64,
}

#[test]
fn boxes_that_follow_contain_fuzzy_positions() {
    let mut found = Found::default();
    for seed in 0..20_000 {
        let posed = Posed::random(seed);
        let planes = posed.planes(Portable);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = Avx2::new() {
            let bits = |planes: [[[f32; 8]; 2]; 3]| planes.map(|sides| sides.map(|lanes| lanes.map(f32::to_bits)));
            assert_eq!(bits(posed.planes(simd)), bits(planes), "seed {seed}");
        }
        for (place, vertex) in (0..8).flat_map(|place| posed.places[place].iter().map(move |vertex| (place, vertex))) {
            let (position, bound) = posed.fuzzy_position(vertex);
            for k in 0..3 {
                let error = posed.error[k];
                if !error.is_finite() {
                    found.left_out += 1;
                    continue;
                }
                found.compared += 1;
                let (origin, step) = (f64::from(posed.lattice.origin[k]), f64::from(posed.lattice.step));
                let plane = |steps: f32| origin + f64::from(steps) * step;
                let [min, max] = [planes[k][0][place], planes[k][1][place]].map(plane);
                let off = (position[k] - max).max(min - position[k]) - bound[k];
                assert!(
                    off <= error,
                    "seed {seed}, place {place}, axis {k}: {off:e} outside, error {error:e}, {:?}",
                    vertex.rest
                );
                found.outside += usize::from(off > 0.0);
                found.needed = found.needed.max(off / error);
            }
        }
    }
    assert!(found.compared > 400_000 && found.left_out > 100_000, "{found:?}");
    // Else the error is idle, or not what is looked at.
    assert!(found.outside > 1_000 && found.needed > 0.01, "{found:?}");
}
