//! A file of dyadic numbers in which every bound is attained, and poses that attain them.

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::{Channel, ChannelTarget, Influence, Local, Node},
};
use restpose_formats::{
    Bounds, Model, TreeKind,
    geom::Aabb,
    rows::{
        BoneEnvelopeRow, Interpolation, KdNode, KdNodeRow, LeverRow, MOVER_WEIGHTS, MorphEnvelopeRow, NodeMoverRow,
        ReferenceBoxRow, WideChild, WideNodeRow,
    },
};
use restpose_runtime::{Affine, Asset, Posing, Scene};
use restpose_tests::{
    Recipe,
    escapes::{Escape, escapes},
    random_animation,
};
use std::sync::Arc;

/// Two right triangles side by side in z = 0, x from 1 to 2 and from 4 to 5, y from 0 to 1. Two bones at the origin carry
/// every vertex by half, the second of which moves by one along x; a morph target moves all by one along x.
pub fn baked(tree: TreeKind) -> Model {
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
    let still = |node: &mut Node| {
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
        tree,
        ..BakeSettings::default()
    };
    let model = bake(&animation, &settings, &NoProgress).unwrap().model;
    assert_eq!((model.clusters.len(), model.cluster_bones.len()), (1, 2));
    model
}

/// How the range [0, 1] of the bone's shift along x is written.
#[derive(Clone, Copy, Debug)]
pub enum Range {
    Line,
    Reach,
}

/// The file with every bound as small as it may be: fuzzy positions are p + μ + d/2 along x, μ the morph weight and d the
/// shift, both in [0, 1].
pub fn tight(range: Range, tree: TreeKind) -> Model {
    let mut model = baked(tree);
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
    cluster.reference_count = 2;
    model.references = vec![0, 1];
    let boxes = boxes.map(|fuzzy| ReferenceBoxRow::around(&fuzzy, &bounds));
    match tree {
        TreeKind::Kd => {
            cluster.node_count = 3;
            let leaf = |first| KdNodeRow::pack(KdNode::Leaf { first, count: 1 });
            model.kd_nodes = vec![split_at(3.5), leaf(0), leaf(1)];
            model.reference_boxes = boxes.to_vec();
        }
        TreeKind::Wide => {
            cluster.node_count = 2;
            let mut nodes = [WideNodeRow::EMPTY; 2];
            place(&mut nodes[0], 0, WideChild::Leaf(0), &boxes[0]);
            place(&mut nodes[0], 1, WideChild::Node(1), &boxes[1]);
            place(&mut nodes[1], 0, WideChild::Leaf(1), &boxes[1]);
            model.wide_nodes = nodes.to_vec();
            model.node_movers.clear();
        }
    }
    model
}

/// The file of [`tight`] with nodes whose boxes follow the pose, every promise as small as it may be.
///
/// The second triangle's corner at x = 5 follows the second bone by three quarters, its others by a quarter, so that where
/// that bone shifts it upwards, it reaches both faces of its box. The cluster's bones claim more of x than their vertices
/// have: this makes the lattice's step 2⁻¹³, and all rest positions are on it.
pub fn following() -> Model {
    let mut model = tight(Range::Reach, TreeKind::Wide);
    let own = model.clusters[0].bone;
    for vertex in 0..model.vertices.len() - 1 {
        let x = model.vertices[vertex].position_rest[0];
        let share = match x {
            5.0 => 0.75,
            4.0 => 0.25,
            _ => 0.5,
        };
        let [begin, end] = [vertex, vertex + 1].map(|row| model.vertices[row].influence_first as usize);
        for influence in &mut model.influences[begin..end] {
            influence.weight = if influence.bone == own { 1.0 - share } else { share };
        }
    }
    for lever in model.levers.iter_mut().filter(|lever| lever.weight > 0.0) {
        (lever.lever[0], lever.weight) = (3.75, 0.75);
    }
    for row in &mut model.cluster_bones {
        row.bounds = Aabb {
            min: [1.0, 0.0, 0.0],
            max: [1.0 + 65533.0 / STEPS, 1.0, 0.0],
        };
    }
    model.clusters[0].bounds_local.max[0] = 6.75;
    let [root, inner] = &mut model.wide_nodes[..] else {
        panic!("two nodes");
    };
    let rest = |x: f32| ReferenceBoxRow {
        min: [(x - 1.0) * STEPS, 0.0, 0.0].map(|steps| steps as u16),
        max: [x * STEPS, STEPS, 0.0].map(|steps| steps as u16),
    };
    place(root, 0, WideChild::Leaf(0), &rest(1.0));
    place(root, 1, WideChild::Node(1), &rest(4.0));
    place(inner, 0, WideChild::Leaf(1), &rest(4.0));
    (root.mover_first, root.mover_count) = (0, 1);
    (inner.mover_first, inner.mover_count) = (1, 1);
    let mut rows = [NodeMoverRow::default(); 2];
    let half = (0.5 * MOVER_WEIGHTS) as u16;
    (rows[0].weight[0], rows[0].spread[0]) = (half, 0);
    (rows[0].weight[1], rows[0].spread[1]) = (half, half / 2);
    (rows[1].weight[0], rows[1].spread[0]) = (half, half / 2);
    model.node_movers = rows.to_vec();
    model
}

/// Steps of the lattice of [`following`] in a length of one.
const STEPS: f32 = 8192.0;

fn place(node: &mut WideNodeRow, place: usize, child: WideChild, bounds: &ReferenceBoxRow) {
    node.children[place] = child.pack();
    for k in 0..3 {
        (node.min[k][place], node.max[k][place]) = (bounds.min[k], bounds.max[k]);
    }
}

pub fn split_at(split: f32) -> KdNodeRow {
    KdNodeRow::pack(KdNode::Inner {
        axis: 0,
        split,
        left: 1,
    })
}

pub fn opened(model: &Model) -> Arc<Asset> {
    let bytes = restpose_formats::write(model).unwrap_or_else(|error| panic!("{error}"));
    Arc::new(Asset::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}")))
}

/// A pose of [`tight`]: the other bone stretches space by `stretch` along x and then shifts it by `shift`, the cluster's own
/// bone shifts it by `own`.
#[derive(Clone, Copy, Debug)]
pub struct Stretched {
    pub own: f32,
    pub shift: f32,
    pub stretch: f32,
    pub morph: f32,
}

pub const STILL: Stretched = Stretched {
    own: 0.0,
    shift: 0.0,
    stretch: 1.0,
    morph: 0.0,
};

/// Where the pose space ends: fuzzy positions reach the faces of all boxes.
pub const ENDS: [Stretched; 2] = [
    STILL,
    Stretched {
        shift: 1.0,
        morph: 1.0,
        ..STILL
    },
];

impl Stretched {
    pub fn palette(&self, model: &Model) -> Vec<Affine> {
        let own = model.clusters[0].bone as usize;
        let mut palette = vec![Affine::IDENTITY; model.bones.len()];
        for bone in model.cluster_bones.iter().map(|row| row.bone as usize) {
            palette[bone].columns[3][0] = if bone == own { self.own } else { self.shift };
            palette[bone].columns[0][0] = if bone == own { 1.0 } else { self.stretch };
        }
        palette
    }

    /// What the runtime finds for the only cluster.
    pub fn excess(&self, model: &Model) -> [f64; 3] {
        let mut scene = Scene::new();
        let instance = scene.add(&opened(model));
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        scene
            .set_palette(instance, &self.palette(model), &[self.morph])
            .unwrap();
        let clusters: Vec<_> = scene.commit().clusters().collect();
        assert_eq!(clusters.len(), 1);
        clusters[0].excess
    }

    /// What escapes where boxes are widened by what `change` makes of the excess that the runtime finds.
    pub fn escapes(&self, model: &Model, change: impl Fn(f64) -> f64) -> Vec<Escape> {
        let excess = self.excess(model).map(change);
        escapes(&model.view(), &self.palette(model), &[self.morph], [(0, excess)])
    }
}
