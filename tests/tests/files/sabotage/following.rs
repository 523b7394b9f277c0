//! Nodes whose boxes follow the pose: a promise that is one step too small is seen, in the file alone and in poses.

use super::{
    Sabotage, escaped,
    tight_file::{ENDS, STILL, Stretched, following, opened},
};
use restpose_bake::{BakeSettings, verify::Oracle};
use restpose_formats::{
    Bounds, Model,
    rows::{NodeMoverRow, WideNodeRow},
};
use restpose_runtime::{Affine, Posing, Ray, Scene};
use restpose_tests::{
    Landmarks, Recipe, baked_with,
    escapes::{Escaped, escapes},
    followed_nodes::{Untruth, contradictions},
    following_twin, random_animation,
};

/// Within the pose space and far outside: the boxes are attained in all of them.
fn poses() -> [Stretched; 4] {
    let far = Stretched { shift: 100.0, ..STILL };
    [ENDS[0], ENDS[1], far, Stretched { stretch: 8.0, ..far }]
}

fn untruths(model: &Model) -> Vec<Untruth> {
    let mut out: Vec<Untruth> = contradictions(&model.view())
        .iter()
        .map(|found| found.untruth)
        .collect();
    out.sort_unstable();
    out.dedup();
    out
}

#[test]
fn a_promise_one_step_smaller_is_seen() {
    let intact = following();
    assert_eq!(untruths(&intact), []);
    assert_eq!(escaped(&intact, &poses()), []);
    let sabotages: [(&str, Sabotage, Untruth, Escaped); 11] = [
        (
            "rest max of a leaf",
            |model| model.wide_nodes[1].max[0][0] -= 1,
            Untruth::RestBox,
            Escaped::ReferenceBox,
        ),
        (
            "rest max along y",
            |model| model.wide_nodes[0].max[1][0] -= 1,
            Untruth::RestBox,
            Escaped::ReferenceBox,
        ),
        (
            "rest min of a leaf",
            |model| model.wide_nodes[0].min[0][0] += 1,
            Untruth::RestBox,
            Escaped::ReferenceBox,
        ),
        (
            "rest boxes of a node and its child",
            |model| {
                model.wide_nodes[0].max[0][1] -= 1;
                model.wide_nodes[1].max[0][0] -= 1;
            },
            Untruth::RestBox,
            Escaped::Tree,
        ),
        (
            "spread of a leaf",
            |model| model.node_movers[1].spread[0] -= 1,
            Untruth::Weight,
            Escaped::ReferenceBox,
        ),
        (
            "spread of a node",
            |model| model.node_movers[0].spread[1] -= 1,
            Untruth::Weight,
            Escaped::Tree,
        ),
        (
            "weight above",
            |model| model.node_movers[1].weight[0] += 1,
            Untruth::Weight,
            Escaped::ReferenceBox,
        ),
        (
            "weight below",
            |model| model.node_movers[1].weight[0] -= 1,
            Untruth::Weight,
            Escaped::ReferenceBox,
        ),
        (
            "weight without spread",
            |model| model.node_movers[0].weight[0] += 1,
            Untruth::Weight,
            Escaped::ReferenceBox,
        ),
        (
            "weight of a node",
            |model| model.node_movers[0].weight[1] -= 1,
            Untruth::Weight,
            Escaped::Tree,
        ),
        (
            "lattice",
            |model| {
                for row in &mut model.cluster_bones {
                    row.bounds.max[0] = row.bounds.max[0].next_down();
                }
            },
            Untruth::RestBox,
            Escaped::ReferenceBox,
        ),
    ];
    for (name, sabotage, untruth, escape) in sabotages {
        let mut model = intact.clone();
        sabotage(&mut model);
        assert_eq!(untruths(&model), [untruth], "{name}");
        let found = escaped(&model, &poses());
        assert!(found.contains(&escape), "{name}: {found:?}");
    }
}

/// Every row in turn that says of any place that it is moved.
#[test]
fn a_mover_left_out_is_seen() {
    let recipe = Recipe {
        seed: 3,
        vertices: 40,
        joints: 6,
        scale: 1.0,
        offset: 0.0,
        wild_scales: false,
        morph_targets: 1,
    };
    let settings = BakeSettings {
        bounds: Bounds::Envelope,
        ..BakeSettings::default()
    };
    let asset = following_twin(&baked_with(&random_animation(&recipe), &settings));
    let view = asset.model();
    assert_eq!(contradictions(view), []);
    let mut left_out = 0;
    for (cluster, row) in (0u32..).zip(view.clusters) {
        let bones = &view.cluster_bones[row.cluster_bone_first as usize..][..row.cluster_bone_count as usize];
        let others: Vec<u32> = bones
            .iter()
            .map(|row| row.bone)
            .filter(|bone| *bone != row.bone)
            .collect();
        for node in row.node_first as usize..(row.node_first + row.node_count) as usize {
            let rows = view.wide_nodes[node].movers(view.node_movers).iter();
            for mover in rows.filter(|row| row.weight.iter().chain(&row.spread).any(|parts| *parts > 0)) {
                let (nodes, movers) = without(view.wide_nodes, view.node_movers, node, mover.mover);
                if nodes[node].mover_count == 0 {
                    // Its boxes are others then, on another lattice.
                    continue;
                }
                let mut model = view.clone();
                (model.wide_nodes, model.node_movers) = (&nodes, &movers);
                let found = contradictions(&model);
                let seen = found
                    .iter()
                    .any(|found| found.cluster == cluster && found.untruth == Untruth::Mover);
                assert!(seen, "node {node}, mover {}: {found:?}", mover.mover);

                // Where this bone alone moves, far, nothing holds its vertices in boxes that do not follow it; all others
                // are widened to hold them.
                let mut palette = vec![Affine::IDENTITY; view.bones.len()];
                palette[others[mover.mover as usize] as usize].columns[3] = [1e6; 3];
                let excess = [(cluster, [1e7; 3])];
                let weights = vec![0.0; view.morph_targets.len()];
                assert_eq!(escapes(view, &palette, &weights, excess), []);
                let found = escapes(&model, &palette, &weights, excess);
                assert!(!found.is_empty(), "node {node}, mover {}", mover.mover);
                left_out += 1;
            }
        }
    }
    assert!(left_out > 10, "{left_out}");
}

/// The nodes and movers of a file without one row.
fn without(
    nodes: &[WideNodeRow],
    movers: &[NodeMoverRow],
    node: usize,
    mover: u32,
) -> (Vec<WideNodeRow>, Vec<NodeMoverRow>) {
    let (mut nodes, mut movers) = (nodes.to_vec(), movers.to_vec());
    let rows = nodes[node].mover_first as usize..(nodes[node].mover_first + nodes[node].mover_count) as usize;
    let row = rows.clone().find(|row| movers[*row].mover == mover).expect("its row");
    movers.remove(row);
    nodes[node].mover_count -= 1;
    for other in &mut nodes {
        other.mover_first -= u32::from(other.mover_first as usize > row);
    }
    (nodes, movers)
}

/// Comparing with brute force says so, too.
#[test]
fn a_node_that_follows_the_wrong_way_loses_hits() {
    let mut intact = following();
    // A pose space that has the pose, or the tree would be refitted.
    intact.bone_envelopes[0].reach = [1e6; 12];
    intact.clusters[0].bounds_local.max[0] = 100.0;
    let mut wrong = intact.clone();
    // A percent less.
    wrong.node_movers[1].weight[0] -= 655;
    let pose = Stretched { shift: 100.0, ..STILL };
    let lost = [&intact, &wrong].map(|model| {
        let mut scene = Scene::new();
        let instance = scene.add(&opened(model));
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        scene
            .set_palette(instance, &pose.palette(model), &[pose.morph])
            .unwrap();
        let frame = scene.commit();
        let oracle = Oracle::new(&frame, &[instance]);
        // Into the triangle's far corner, at 5 + 75.
        let rays = (1..100).map(|step| Ray::new([79.99 - 0.005 * step as f32, 1e-5 - 0.01, -1.0], [0.01, 0.01, 1.0]));
        let (mut hits, mut lost) = (0, 0);
        for ray in rays {
            let expected = oracle.closest_hit(&ray);
            hits += u32::from(expected.is_some());
            lost += u32::from(frame.closest_hit(&ray) != expected);
        }
        assert_eq!(hits, 99);
        lost
    });
    assert_eq!(lost[0], 0);
    assert!(lost[1] > 50, "{lost:?}");
}

/// Rays are aimed at the faces of these boxes where the pose has them.
#[test]
fn landmarks_are_on_faces_that_vertices_touch() {
    let model = following();
    let pose = Stretched { shift: 100.0, ..STILL };
    let (asset, palette) = (opened(&model), pose.palette(&model));
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    scene.set_posing(instance, Posing::Recomputed).unwrap();
    scene.set_palette(instance, &palette, &[pose.morph]).unwrap();
    let frame = scene.commit();
    let mut marks = Landmarks::default();
    marks.add(&frame, instance, &asset, (&palette, &[pose.morph]), Affine::IDENTITY);
    let along_x = |planes: &[(usize, f32)]| -> Vec<f32> {
        let planes = planes.iter().filter(|(axis, _)| *axis == 0);
        planes.map(|(_, plane)| *plane).collect()
    };
    // x + 50, and x + 25 or x + 75.
    assert_eq!(along_x(&marks.local[0].sides), [51.0, 52.0, 29.0, 80.0]);
    assert_eq!(along_x(&marks.local[0].splits), [29.0, 80.0]);
}
