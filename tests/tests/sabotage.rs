//! That the contract's tests can fail: one ulp less box or margin than the proof asks for is seen.
//!
//! All numbers are dyadic and every bound is attained, so an intact file has no slack that would hide a fault.

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::{Channel, ChannelTarget, Influence, Local},
    verify::Oracle,
};
use restpose_formats::{
    Bounds, FormatError, Model, SectionKind,
    geom::Aabb,
    rows::{BoneEnvelopeRow, Interpolation, KdNode, KdNodeRow, LeverRow, MorphEnvelopeRow, ReferenceBoxRow},
};
use restpose_runtime::{Affine, Asset, Ray, Scene};
use restpose_tests::{
    Recipe,
    escapes::{Escape, Escaped, escapes},
    random_animation,
};
use std::sync::Arc;

/// Two right triangles side by side in z = 0, x from 1 to 2 and from 4 to 5, y from 0 to 1. Two bones at the origin carry
/// every vertex by half, the second of which moves by one along x; a morph target moves all by one along x.
fn baked() -> Model {
    let recipe = Recipe {
        seed: 1,
        vertices: 6,
        joints: 2,
        scale: 1.0,
        offset: 0.0,
        wild_scales: false,
        morph_targets: 1,
    };
    let mut animation = random_animation(&recipe);
    let still = |node: &mut restpose_bake::import::Node| {
        node.parent = None;
        node.local = Local::Trs {
            translation: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: [1.0; 3],
        };
    };
    animation.nodes.iter_mut().for_each(still);
    let linear = |node: usize, target: ChannelTarget, values: &[f32]| Channel {
        node,
        target,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: values.to_vec(),
    };
    animation.clips[0].channels = vec![
        linear(0, ChannelTarget::Weights, &[0.0, 1.0]),
        linear(2, ChannelTarget::Translation, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
    ];
    let primitive = &mut animation.meshes[0].primitives[0];
    let corners = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    primitive.positions = [corners(1.0), corners(4.0)].concat();
    primitive.triangles = vec![[0, 1, 2], [3, 4, 5]];
    primitive.morph_targets = vec![vec![[1.0, 0.0, 0.0]; 6]];
    let half = |joint| Influence { joint, weight: 0.5 };
    primitive.influences = vec![vec![half(0), half(1)]; 6];
    let settings = BakeSettings {
        bounds: Bounds::Envelope,
        sample_step_seconds: 1.0,
        ..BakeSettings::default()
    };
    let model = bake(&animation, &settings, &NoProgress).unwrap().model;
    assert_eq!((model.clusters.len(), model.cluster_bones.len()), (1, 2));
    model
}

/// How the range [0, 1] of the bone's shift along x is written.
#[derive(Clone, Copy, Debug)]
enum Range {
    Line,
    Reach,
}

/// The file with every bound as small as it may be: fuzzy positions are p + μ + d/2 along x, μ the morph weight and d the
/// shift, both in [0, 1].
fn tight(range: Range) -> Model {
    let mut model = baked();
    let own = model.clusters[0].bone;
    for (lever, bone) in model.levers.iter_mut().zip(&model.cluster_bones) {
        if bone.bone != own {
            *lever = LeverRow {
                pivot: [0.0; 3],
                lever: [2.5, 0.5, 0.0],
                weight: 0.5,
                reserved: 0,
            };
        }
    }
    let mut half = [0.0; 12];
    half[9] = 0.5;
    let (direction, reach) = match range {
        Range::Line => (half, [0.0; 12]),
        Range::Reach => ([0.0; 12], half),
    };
    let center = half;
    model.bone_envelopes = vec![BoneEnvelopeRow {
        center,
        direction,
        reach,
    }];
    model.morph_envelopes = vec![MorphEnvelopeRow { min: 0.0, max: 1.0 }];
    model.pose_spaces[0].envelope_count = 1;

    let boxes = [(1.0, 3.5), (4.0, 6.5)].map(|(min, max)| Aabb {
        min: [min, 0.0, 0.0],
        max: [max, 1.0, 0.0],
    });
    let bounds = boxes[0].union(boxes[1]);
    let cluster = &mut model.clusters[0];
    cluster.bounds_local = bounds;
    (cluster.node_count, cluster.reference_count) = (3, 2);
    let leaf = |first| KdNodeRow::pack(KdNode::Leaf { first, count: 1 });
    model.kd_nodes = vec![split_at(3.5), leaf(0), leaf(1)];
    model.references = vec![0, 1];
    model.reference_boxes = boxes
        .iter()
        .map(|fuzzy| ReferenceBoxRow::around(fuzzy, &bounds))
        .collect();
    model
}

fn split_at(split: f32) -> KdNodeRow {
    KdNodeRow::pack(KdNode::Inner {
        axis: 0,
        split,
        left: 1,
    })
}

fn opened(model: &Model) -> Arc<Asset> {
    let bytes = restpose_formats::write(model).unwrap_or_else(|error| panic!("{error}"));
    Arc::new(Asset::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}")))
}

/// A pose of [`tight`]: the other bone stretches space by `stretch` along x and then shifts it by `shift`, the cluster's own
/// bone shifts it by `own`.
#[derive(Clone, Copy, Debug)]
struct Stretched {
    own: f32,
    shift: f32,
    stretch: f32,
    morph: f32,
}

const STILL: Stretched = Stretched {
    own: 0.0,
    shift: 0.0,
    stretch: 1.0,
    morph: 0.0,
};

/// Where the pose space ends: fuzzy positions reach the faces of all boxes.
const ENDS: [Stretched; 2] = [
    STILL,
    Stretched {
        shift: 1.0,
        morph: 1.0,
        ..STILL
    },
];

impl Stretched {
    fn palette(&self, model: &Model) -> Vec<Affine> {
        let own = model.clusters[0].bone as usize;
        let mut palette = vec![Affine::IDENTITY; model.bones.len()];
        for bone in model.cluster_bones.iter().map(|row| row.bone as usize) {
            palette[bone].columns[3][0] = if bone == own { self.own } else { self.shift };
            palette[bone].columns[0][0] = if bone == own { 1.0 } else { self.stretch };
        }
        palette
    }

    /// What the runtime finds for the only cluster.
    fn excess(&self, model: &Model) -> [f64; 3] {
        let mut scene = Scene::new();
        let instance = scene.add(&opened(model));
        scene
            .set_palette(instance, &self.palette(model), &[self.morph])
            .unwrap();
        let clusters: Vec<_> = scene.commit().clusters().collect();
        assert_eq!(clusters.len(), 1);
        clusters[0].excess
    }

    /// What escapes where boxes are widened by what `change` makes of the excess that the runtime finds.
    fn escapes(&self, model: &Model, change: impl Fn(f64) -> f64) -> Vec<Escape> {
        let excess = self.excess(model).map(change);
        escapes(&model.view(), &self.palette(model), &[self.morph], [(0, excess)])
    }
}

fn escaped(model: &Model, poses: &[Stretched]) -> Vec<Escaped> {
    let found = poses.iter().flat_map(|pose| pose.escapes(model, |excess| excess));
    let mut out: Vec<Escaped> = found.map(|escape| escape.from).collect();
    out.sort_unstable();
    out.dedup();
    out
}

#[test]
fn a_face_or_plane_one_ulp_inwards_is_seen() {
    for range in [Range::Line, Range::Reach] {
        let intact = tight(range);
        assert_eq!(escaped(&intact, &ENDS), []);

        let sabotages: [(&str, fn(&mut Model), Escaped); 8] = [
            (
                "bounds max",
                |model| inwards(&mut model.clusters[0].bounds_local.max[0]),
                Escaped::Bounds,
            ),
            (
                "bounds max y",
                |model| inwards(&mut model.clusters[0].bounds_local.max[1]),
                Escaped::Bounds,
            ),
            (
                "bounds min",
                |model| outwards(&mut model.clusters[0].bounds_local.min[0]),
                Escaped::Bounds,
            ),
            // Coordinate 0 of the lattice is the bounds' least end.
            (
                "lattice min",
                |model| outwards(&mut model.clusters[0].bounds_local.min[0]),
                Escaped::ReferenceBox,
            ),
            (
                "box max",
                |model| model.reference_boxes[0].max[0] -= 1,
                Escaped::ReferenceBox,
            ),
            (
                "box min",
                |model| model.reference_boxes[1].min[0] += 1,
                Escaped::ReferenceBox,
            ),
            (
                "plane below",
                |model| model.kd_nodes[0] = split_at(3.5f32.next_down()),
                Escaped::Tree,
            ),
            (
                "plane above",
                |model| model.kd_nodes[0] = split_at(4f32.next_up()),
                Escaped::Tree,
            ),
        ];
        for (name, sabotage, expected) in sabotages {
            let mut model = intact.clone();
            sabotage(&mut model);
            let found = escaped(&model, &ENDS);
            assert!(found.contains(&expected), "{range:?}, {name}: {found:?}");
        }
        // Both ends of the gap between the triangles are right places for the plane.
        let mut model = intact;
        model.kd_nodes[0] = split_at(4.0);
        assert_eq!(escaped(&model, &ENDS), []);
    }
}

fn inwards(x: &mut f32) {
    *x = x.next_down();
}

fn outwards(x: &mut f32) {
    *x = x.next_up();
}

/// Poses outside by every kind of number, where the bound of the excess is attained.
#[test]
fn a_margin_one_ulp_smaller_is_seen() {
    let [low, high] = ENDS;
    let outside = [
        (0.5, Stretched { shift: 2.0, ..high }),
        (0.5, Stretched { shift: -1.0, ..low }),
        // The lever, and half of the morph.
        (3.0, Stretched { stretch: 2.0, ..high }),
        (1.0, Stretched { morph: 2.0, ..high }),
        (1.0, Stretched { morph: -1.0, ..low }),
    ];
    for range in [Range::Line, Range::Reach] {
        let model = tight(range);
        for (length, pose) in outside {
            // What rounding adds is below 1e-12 of it, and an ulp of `f32` above 1e-8.
            let found = pose.excess(&model)[0];
            assert!(
                (length..length * (1.0 + 1e-12)).contains(&found),
                "{range:?}, {pose:?}: {found}"
            );
            assert_eq!(pose.escapes(&model, |excess| excess), [], "{range:?}, {pose:?}");
            let found = pose.escapes(&model, |excess| f64::from((excess as f32).next_down()));
            let bounds = found.iter().any(|escape| escape.from == Escaped::Bounds);
            assert!(bounds, "{range:?}, {pose:?}: {found:?}");
        }
    }
}

/// An envelope that claims one ulp more than the boxes hold.
#[test]
fn a_pose_space_one_ulp_larger_than_its_boxes_is_seen() {
    let above_one = f32::next_up(1.0);
    // The shift is 1 + 2⁻²⁴, half an ulp beyond: the difference of two numbers that are exact.
    let shifted = Stretched {
        own: -2f32.powi(-24),
        ..ENDS[1]
    };
    let morphed = Stretched {
        morph: above_one,
        ..ENDS[1]
    };
    let below = Stretched {
        own: 2f32.powi(-24),
        ..ENDS[0]
    };
    let sabotages: [(&str, Range, fn(&mut Model), Stretched); 6] = [
        (
            "reach",
            Range::Reach,
            |model| outwards(&mut model.bone_envelopes[0].reach[9]),
            shifted,
        ),
        (
            "reach down",
            Range::Reach,
            |model| outwards(&mut model.bone_envelopes[0].reach[9]),
            below,
        ),
        (
            "center",
            Range::Reach,
            |model| outwards(&mut model.bone_envelopes[0].center[9]),
            shifted,
        ),
        (
            "direction",
            Range::Line,
            |model| outwards(&mut model.bone_envelopes[0].direction[9]),
            shifted,
        ),
        (
            "direction down",
            Range::Line,
            |model| outwards(&mut model.bone_envelopes[0].direction[9]),
            below,
        ),
        (
            "morph weights",
            Range::Line,
            |model| outwards(&mut model.morph_envelopes[0].max),
            morphed,
        ),
    ];
    for (name, range, sabotage, pose) in sabotages {
        let mut model = tight(range);
        assert_eq!(escaped(&model, &[pose]), [], "{name}");
        sabotage(&mut model);
        let found = escaped(&model, &[pose]);
        assert!(found.contains(&Escaped::Bounds), "{name}: {found:?}");
    }
}

/// Levers are not the baker's word alone: a file with one that is too short is refused.
#[test]
fn a_lever_one_ulp_shorter_is_refused() {
    let sabotages: [(SectionKind, &str, fn(&mut Model)); 4] = [
        (SectionKind::Levers, "lever[0]", |model| {
            inwards(&mut other_lever(model).lever[0])
        }),
        (SectionKind::Levers, "lever[0]", |model| {
            other_lever(model).pivot[0] = -f32::EPSILON
        }),
        (SectionKind::Levers, "weight", |model| {
            inwards(&mut other_lever(model).weight)
        }),
        (SectionKind::ClusterMorphs, "extent", |model| {
            inwards(&mut model.cluster_morphs[0].extent[0])
        }),
    ];
    for (expected, name, sabotage) in sabotages {
        let mut model = tight(Range::Line);
        sabotage(&mut model);
        let found = restpose_formats::write(&model).map(|bytes| Asset::from_bytes(&bytes).map(|_| ()));
        let error = match found {
            Ok(Ok(())) => panic!("{name}: not refused"),
            Ok(Err(error)) | Err(error) => error,
        };
        match error {
            FormatError::Row { section, .. } => assert_eq!(section, expected, "{error}"),
            _ => panic!("{name}: {error}"),
        }
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
}

/// The lever of the bone that moves against the cluster.
fn other_lever(model: &mut Model) -> &mut LeverRow {
    let own = model.clusters[0].bone;
    let place = model.cluster_bones.iter().position(|row| row.bone != own).unwrap();
    &mut model.levers[place]
}

/// Faces of what the baker itself wrote, moved inwards: a few ulps are all that they have.
#[test]
fn the_bakers_own_boxes_have_few_ulps_to_spare() {
    let intact = baked();
    assert_eq!(escaped(&intact, &ENDS), []);
    let mut model = intact;
    let mut spare = 0;
    while escaped(&model, &ENDS).is_empty() {
        inwards(&mut model.clusters[0].bounds_local.max[0]);
        spare += 1;
    }
    // One for each of: rounding the box outwards, the line made longer by 2⁻²⁰, and the reach that rounding needs.
    assert!(spare <= 4, "{spare}");
}

/// Without the excess hits are lost, and comparing with brute force says so.
#[test]
fn a_margin_left_out_loses_hits_that_brute_force_finds() {
    let intact = tight(Range::Reach);
    let mut blind = intact.clone();
    blind.bone_envelopes[0].reach = [1e6; 12];
    let pose = Stretched { shift: 100.0, ..STILL };
    let lost = [&intact, &blind].map(|model| {
        let asset = opened(model);
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene
            .set_palette(instance, &pose.palette(model), &[pose.morph])
            .unwrap();
        let frame = scene.commit();
        assert_eq!(frame.stats().clusters_outside, u32::from(std::ptr::eq(model, &intact)));
        let oracle = Oracle::new(&frame, &[instance]);
        let rays = (0..100).map(|step| Ray::new([51.0 + 0.005 * step as f32, 0.25, -1.0], [0.0, 0.0, 1.0]));
        let (mut hits, mut lost) = (0, 0);
        for ray in rays {
            let expected = oracle.closest_hit(&ray);
            hits += u32::from(expected.is_some());
            lost += u32::from(frame.closest_hit(&ray) != expected);
        }
        assert_eq!(hits, 100);
        lost
    });
    assert_eq!(lost, [0, 100]);
}
