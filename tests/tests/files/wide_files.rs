//! Wide trees of a baked file: the boxes of the kd-trees, or the smallest around rest positions where they follow the pose,
//! and the same bytes on any number of threads.

use restpose_bake::{
    BakeSettings, DecomposeSettings, NoProgress, bake,
    import::{Animation, FrameRange, ImportSettings, import, import_files},
    subdivide::subdivide,
};
use restpose_formats::{
    Model, TreeKind,
    geom::Aabb,
    rows::{ClusterRow, ReferenceBoxRow, RestLattice, WideChild},
};
use restpose_tests::source_scenes;
use std::{collections::BTreeMap, ops::Range, path::Path};

fn range(first: u32, count: u32) -> Range<usize> {
    first as usize..(first + count) as usize
}

/// The box of a single triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Own {
    Fuzzy(ReferenceBoxRow),
    /// In rest space, of a node whose boxes follow the pose.
    Rest(ReferenceBoxRow),
}

/// By triangle row.
fn boxes(model: &Model, cluster: &ClusterRow) -> BTreeMap<u32, Own> {
    let nodes = range(cluster.node_first, cluster.node_count);
    match model.meta.tree {
        TreeKind::Kd => {
            let references = range(cluster.reference_first, cluster.reference_count);
            let boxes = &model.reference_boxes[references.clone()];
            model.references[references]
                .iter()
                .copied()
                .zip(boxes.iter().copied().map(Own::Fuzzy))
                .collect()
        }
        TreeKind::Wide => {
            let mut out = BTreeMap::new();
            for node in &model.wide_nodes[nodes] {
                for (place, child) in node.children().enumerate() {
                    if let WideChild::Leaf(triangle) = child {
                        let [min, max] = [&node.min, &node.max].map(|corner| [0, 1, 2].map(|k| corner[k][place]));
                        let own = ReferenceBoxRow { min, max };
                        let own = if node.mover_count == 0 {
                            Own::Fuzzy(own)
                        } else {
                            Own::Rest(own)
                        };
                        out.insert(triangle, own);
                    }
                }
            }
            out
        }
    }
}

/// The place of a box has less than a step to spare on each side.
fn assert_smallest(name: &str, model: &Model, cluster: &ClusterRow, triangle: u32, own: &ReferenceBoxRow) {
    let lattice = RestLattice::new(&model.cluster_bones[range(cluster.cluster_bone_first, cluster.cluster_bone_count)]);
    let corners = model.triangles[triangle as usize].corners;
    let rest = Aabb::around(corners.map(|corner| model.vertices[corner as usize].position_rest));
    for k in 0..3 {
        let steps = |x: f32| (f64::from(x) - f64::from(lattice.origin[k])) / f64::from(lattice.step);
        let spare = [
            steps(rest.min[k]) - f64::from(own.min[k]),
            f64::from(own.max[k]) - steps(rest.max[k]),
        ];
        for spare in spare {
            // Another step where rounding in `f64` might matter; here it matters a thousandth of that.
            assert!(
                spare > -1e-9 && spare < 1.0 + 1e-6,
                "{name}, triangle {triangle}: {spare}"
            );
        }
    }
}

/// All scenes with bones, subdivided so that there is more than one task of triangles, and some frames of two vertex caches:
/// a goose that moves in one piece, and a vase that bursts.
fn animations() -> Vec<(String, Animation)> {
    let mut out = Vec::new();
    for path in source_scenes() {
        let animation = import(&path).expect("a scene").animation;
        out.push((path.display().to_string(), subdivide(&animation, 1)));
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    for (name, step) in [("goose", 8), ("shatter", 6)] {
        let inputs = ["obj", "pc2"].map(|extension| folder.join(format!("{name}.{extension}")));
        let frames = FrameRange {
            step,
            ..FrameRange::default()
        };
        let settings = ImportSettings {
            frames,
            ..ImportSettings::default()
        };
        let imported = import_files(&inputs, &settings).expect("a bundled scene");
        out.push((name.to_owned(), imported.animation));
    }
    out
}

fn settings(tree: TreeKind) -> BakeSettings {
    BakeSettings {
        tree,
        // What trees cost decides neither on the clusters nor on free motion.
        rays_per_frame: 0.0,
        motion: DecomposeSettings {
            max_clusters: 1,
            ..DecomposeSettings::default()
        },
        ..BakeSettings::default()
    }
}

#[test]
fn wide_trees_have_the_boxes_of_kd_trees() {
    let (mut with_track, mut following) = (0, 0);
    for (name, animation) in animations() {
        let [kd, wide] = [TreeKind::Kd, TreeKind::Wide]
            .map(|tree| bake(&animation, &settings(tree), &NoProgress).expect("a scene").model);
        restpose_formats::write(&wide).expect("a valid file");
        assert_eq!(kd.clusters.len(), wide.clusters.len());
        assert!(wide.kd_nodes.is_empty() && wide.reference_boxes.is_empty() && !wide.wide_nodes.is_empty());
        for (kd_row, row) in kd.clusters.iter().zip(&wide.clusters) {
            assert_eq!(kd_row.bounds_local, row.bounds_local);
            assert_eq!(row.reference_count, row.triangle_count);
            if row.node_count > 0 {
                let (expected, found) = (boxes(&kd, kd_row), boxes(&wide, row));
                assert!(expected.keys().eq(found.keys()), "{name}");
                for (triangle, own) in found {
                    match own {
                        Own::Fuzzy(_) => assert_eq!(own, expected[&triangle], "{name}, triangle {triangle}"),
                        Own::Rest(rest) => {
                            assert_smallest(&name, &wide, row, triangle, &rest);
                            following += 1;
                        }
                    }
                }
                with_track += u32::from(row.track != u32::MAX);
            }
        }
    }
    assert!(with_track > 0 && following > 100, "{with_track}, {following}");
}

#[test]
fn wide_files_are_the_same_bytes_on_one_and_two_threads() {
    for (name, animation) in animations() {
        let settings = BakeSettings {
            tree: TreeKind::Wide,
            segments: 2,
            ..BakeSettings::default()
        };
        let bytes = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads");
            let baked = pool.install(|| bake(&animation, &settings, &NoProgress));
            restpose_formats::write(&baked.expect("a scene").model).expect("a valid file")
        };
        assert!(bytes(1) == bytes(2), "{name}");
    }
}
