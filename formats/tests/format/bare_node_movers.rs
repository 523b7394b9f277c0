//! Decodes the movers of wide nodes, and moves boxes by them, as `FORMAT.md` says, in the manner of `bare_reader`.

use crate::{
    bare_reader::{f32s, rows_of, u16_at, u32_at, u32s},
    golden::V1_3_WIDE,
};
use restpose_formats::{
    geom::Aabb,
    rows::{ClusterBoneRow, RestLattice},
};

/// A linear map, column by column, less the identity, and a translation.
type Motion = [[f64; 3]; 4];

/// Lattice over the rest positions of a cluster with these rows of CBON: where its zero is, and its step.
fn lattice(cluster_bones: &[&[u8]]) -> ([f32; 3], f32) {
    let corner = |at: usize, pick: fn(f32, f32) -> f32| {
        let corners = cluster_bones.iter().map(|row| f32s::<3>(row, at));
        corners
            .reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k])))
            .expect("a cluster bone")
    };
    let (least, greatest) = (corner(4, f32::min), corner(16, f32::max));
    let sides = [0, 1, 2].map(|k| f64::from(greatest[k]) - f64::from(least[k]));
    let exact = sides.into_iter().fold(0.0, f64::max) / 65533.0;
    let nearest = exact as f32;
    let step = if f64::from(nearest) < exact {
        f32::from_bits(nearest.to_bits() + 1)
    } else {
        nearest
    };
    (least, step)
}

/// A vertex of the golden file: where it rests, how far morphs take it at these weights, and the bones that move it.
struct Vertex {
    rest: [f64; 3],
    morph: [f64; 3],
    influences: Vec<(u32, f64)>,
}

fn vertex(at: u32, morph_weights: [f64; 2]) -> Vertex {
    let [vertices, influences, first, deltas] =
        [b"VERT", b"INFL", b"MFST", b"MDEL"].map(|code| rows_of(V1_3_WIDE, code));
    let at = at as usize;
    let range = u32_at(vertices[at], 12) as usize..u32_at(vertices[at + 1], 12) as usize;
    let mut morph = [0.0; 3];
    for delta in &deltas[u32_at(first[at], 0) as usize..u32_at(first[at + 1], 0) as usize] {
        for (k, x) in f32s::<3>(delta, 4).into_iter().enumerate() {
            morph[k] += morph_weights[u32_at(delta, 0) as usize] * f64::from(x);
        }
    }
    Vertex {
        rest: f32s::<3>(vertices[at], 0).map(f64::from),
        morph,
        influences: influences[range]
            .iter()
            .map(|row| (u32_at(row, 0), f64::from(f32s::<1>(row, 4)[0])))
            .collect(),
    }
}

/// A place of a node with movers.
struct Followed {
    min: [f64; 3],
    max: [f64; 3],
    step: f64,
    /// Weight and spread of each of the cluster's other bones; zero of those that have no row.
    weights: Vec<[f64; 2]>,
    /// The cluster's other bones.
    bones: Vec<u32>,
    /// Rows of VERT.
    vertices: Vec<u32>,
}

/// Every place in use of every node with movers of the golden file.
fn followed() -> Vec<Followed> {
    let [clusters, cluster_bones, nodes, movers] =
        [b"CLUS", b"CBON", b"WDND", b"NMOV"].map(|code| rows_of(V1_3_WIDE, code));
    let mut next_mover = 0;
    let mut out = Vec::new();
    for cluster in clusters {
        let [first, count] = u32s::<2>(cluster, 4).map(|x| x as usize);
        let [bone_first, bone_count] = u32s::<2>(cluster, 20).map(|x| x as usize);
        let listed = &cluster_bones[bone_first..bone_first + bone_count];
        let bones: Vec<u32> = listed.iter().map(|row| u32_at(row, 0)).collect();
        let bones: Vec<u32> = bones.into_iter().filter(|bone| *bone != u32_at(cluster, 0)).collect();
        let (zero, step) = lattice(listed);
        let tree = &nodes[first..first + count];
        for node in tree {
            let [mover_first, mover_count] = u32s::<2>(node, 128).map(|x| x as usize);
            assert_eq!(mover_first, next_mover);
            next_mover += mover_count;
            let rows = &movers[mover_first..next_mover];
            for place in (0..8).filter(|_| mover_count > 0) {
                let weight = |bone: usize| {
                    let row = rows.iter().find(|row| u32_at(row, 32) as usize == bone);
                    row.map_or([0; 2], |row| [0, 16].map(|at| u16_at(row, at + 2 * place)))
                };
                let weights: Vec<[u16; 2]> = (0..bones.len()).map(weight).collect();
                let child = u32_at(node, 96 + 4 * place);
                if child == u32::MAX {
                    assert!(weights.iter().all(|numbers| *numbers == [0; 2]));
                    continue;
                }
                let plane = |at: usize, k: usize| {
                    let coordinate = u16_at(node, at + 16 * k + 2 * place);
                    f64::from(zero[k]) + f64::from(coordinate) * f64::from(step)
                };
                let mut vertices = Vec::new();
                add_vertices(tree, child, &mut vertices);
                out.push(Followed {
                    min: [0, 1, 2].map(|k| plane(0, k)),
                    max: [0, 1, 2].map(|k| plane(48, k)),
                    step: f64::from(step),
                    weights: weights.iter().map(|numbers| numbers.map(f64::from)).collect(),
                    bones: bones.clone(),
                    vertices,
                });
            }
        }
    }
    assert_eq!(next_mover, movers.len());
    out
}

/// The vertices of all triangles below a child.
fn add_vertices(tree: &[&[u8]], child: u32, out: &mut Vec<u32>) {
    if child >> 31 == 1 {
        let triangle = rows_of(V1_3_WIDE, b"TRIS")[(child & 0x7FFF_FFFF) as usize];
        out.extend(u32s::<3>(triangle, 0));
        return;
    }
    let children = u32s::<8>(tree[child as usize], 96);
    for child in children.into_iter().filter(|child| *child != u32::MAX) {
        add_vertices(tree, child, out);
    }
}

#[test]
fn nodes_with_movers_hold_rest_positions_and_weights() {
    let places = followed();
    assert_eq!(places.len(), 3);
    for place in places {
        let vertices: Vec<Vertex> = place.vertices.iter().map(|at| vertex(*at, [0.0; 2])).collect();
        for k in 0..3 {
            let (low, high) = vertices.iter().fold((f64::MAX, f64::MIN), |(low, high), vertex| {
                (low.min(vertex.rest[k]), high.max(vertex.rest[k]))
            });
            assert!(place.min[k] <= low && high <= place.max[k], "axis {k}");
            // The fixture has rounded outwards and taken a step more.
            let loose = 3.0 * place.step;
            assert!(low - place.min[k] < loose && place.max[k] - high < loose, "axis {k}");
        }
        let own = |vertex: &Vertex, bone: u32| {
            let influence = vertex.influences.iter().find(|(listed, _)| *listed == bone);
            influence.map_or(0.0, |(_, weight)| *weight)
        };
        for (bone, [weight, spread]) in place.bones.iter().zip(&place.weights) {
            for vertex in &vertices {
                assert!((65536.0 * own(vertex, *bone) - weight).abs() <= *spread);
            }
        }
    }
}

/// The image of a point, less the point.
fn moved(motion: &Motion, p: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| motion[0][k] * p[0] + motion[1][k] * p[1] + motion[2][k] * p[2] + motion[3][k])
}

/// A place's box in a pose, least and greatest corner, by how its cluster's other bones move and how far morphs can.
fn posed(place: &Followed, motions: &[Motion], morphed: [f64; 3]) -> [[f64; 3]; 2] {
    let c = [0, 1, 2].map(|k| 0.5 * (place.min[k] + place.max[k]));
    let h = [0, 1, 2].map(|k| 0.5 * (place.max[k] - place.min[k]) + morphed[k]);
    let (mut center, mut half) = (c, h);
    for (motion, [weight, spread]) in motions.iter().zip(&place.weights) {
        let (weight, spread) = (weight / 65536.0, spread / 65536.0);
        let image = moved(motion, c);
        for k in 0..3 {
            center[k] += weight * image[k];
            let turned: f64 = (0..3).map(|j| motion[j][k].abs() * h[j]).sum();
            half[k] += spread * image[k].abs() + (weight + spread) * turned;
        }
    }
    [
        [0, 1, 2].map(|k| center[k] - half[k]),
        [0, 1, 2].map(|k| center[k] + half[k]),
    ]
}

#[test]
fn boxes_follow_the_bones_as_the_text_says() {
    let turn = |angle: f64, offset: [f64; 3]| {
        let (sin, cos) = angle.sin_cos();
        [[cos - 1.0, sin, 0.0], [-sin, cos - 1.0, 0.0], [0.0; 3], offset]
    };
    let motions: [Motion; 5] = [
        [[0.0; 3]; 4],
        [[0.0; 3], [0.0; 3], [0.0; 3], [3.0, -2.0, 1.0]],
        turn(1.0, [0.0; 3]),
        turn(-2.5, [-1.0, 0.5, 7.0]),
        [
            [9.0, 0.5, -1.0],
            [0.25, -3.0, 2.0],
            [-4.0, 1.0, 0.125],
            [0.0, 100.0, -5.0],
        ],
    ];
    let targets = rows_of(V1_3_WIDE, b"MTGT");
    for place in followed() {
        assert_eq!(place.bones.len(), 1, "one motion is enough");
        for motion in &motions {
            for morph_weights in [[0.0f64, 0.0], [1.0, 0.5], [-0.25, 2.0]] {
                let mut morphed = [0.0; 3];
                for (target, weight) in targets.iter().zip(morph_weights) {
                    for (k, x) in f32s::<3>(target, 4).into_iter().enumerate() {
                        morphed[k] += weight.abs() * f64::from(x);
                    }
                }
                let [min, max] = posed(&place, &[*motion], morphed);
                for at in &place.vertices {
                    let vertex = vertex(*at, morph_weights);
                    let m = [0, 1, 2].map(|k| vertex.rest[k] + vertex.morph[k]);
                    let mut fuzzy = m;
                    for (_, weight) in vertex.influences.iter().filter(|(bone, _)| *bone == place.bones[0]) {
                        for (k, x) in moved(motion, m).into_iter().enumerate() {
                            fuzzy[k] += weight * x;
                        }
                    }
                    for k in 0..3 {
                        // What `f64` rounds in numbers of a hundred at most; a step is a thousand times as much.
                        let (min, max) = (min[k] - 1e-12, max[k] + 1e-12);
                        assert!(
                            min <= fuzzy[k] && fuzzy[k] <= max,
                            "{fuzzy:?} on axis {k}: {min}..{max}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn the_lattice_of_rest_positions_has_the_zero_and_the_step_that_the_text_says() {
    let sides = [
        0.0, 1e-45, 1e-39, 3e-34, 3e-20, 1.0, 3.0, 10.0, 65533.0, 65535.0, 1e7, 3e38,
    ];
    for (side, min) in sides
        .iter()
        .flat_map(|side| [(*side, 0.0), (*side, -0.3 * side), (*side, 7.0)])
    {
        let row = |min: [f32; 3], max: [f32; 3]| ClusterBoneRow {
            bone: 0,
            bounds: Aabb { min, max },
            reserved: 0,
        };
        let listed = [
            row([min; 3], [min + 0.7 * side, min, min]),
            row([min + 0.1 * side, min, min], [min + 0.2 * side, min + side, min]),
        ];
        let bytes: Vec<&[u8]> = listed.iter().map(bytemuck::bytes_of).collect();
        let (zero, step) = lattice(&bytes);
        let expected = RestLattice::new(&listed);
        assert_eq!(
            (zero, step.to_bits()),
            (expected.origin, expected.step.to_bits()),
            "{listed:?}"
        );
        assert_eq!(step.is_normal(), expected.is_usable(), "{listed:?}");
    }
}
