//! That the contract's tests can fail: one ulp less box or margin than the proof asks for is seen.
//!
//! All numbers are dyadic and every bound is attained, so an intact file has no slack that would hide a fault.

mod following;
mod tight_file;

use restpose_bake::verify::Oracle;
use restpose_formats::{FormatError, Model, SectionKind, TreeKind, rows::LeverRow};
use restpose_runtime::{Asset, Posing, Ray, Scene};
use restpose_tests::escapes::Escaped;
use tight_file::{ENDS, Range, STILL, Stretched, baked, opened, split_at, tight};

/// Breaks a file.
type Sabotage = fn(&mut Model);

fn escaped(model: &Model, poses: &[Stretched]) -> Vec<Escaped> {
    let found = poses.iter().flat_map(|pose| pose.escapes(model, |excess| excess));
    let mut out: Vec<Escaped> = found.map(|escape| escape.from).collect();
    out.sort_unstable();
    out.dedup();
    out
}

#[test]
fn a_face_or_plane_one_ulp_inwards_is_seen() {
    for (range, tree) in files() {
        let intact = tight(range, tree);
        assert_eq!(escaped(&intact, &ENDS), []);

        let of_clusters: [(&str, Sabotage, Escaped); 4] = [
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
        ];
        let of_kd_trees: [(&str, Sabotage, Escaped); 4] = [
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
        // A node's box inside of its child's is refused when the file is read.
        let of_wide_trees: [(&str, Sabotage, Escaped); 2] = [
            (
                "box max",
                |model| model.wide_nodes[0].max[0][0] -= 1,
                Escaped::ReferenceBox,
            ),
            (
                "box min",
                |model| model.wide_nodes[1].min[0][0] += 1,
                Escaped::ReferenceBox,
            ),
        ];
        let of_trees = match tree {
            TreeKind::Kd => &of_kd_trees[..],
            TreeKind::Wide => &of_wide_trees[..],
        };
        for (name, sabotage, expected) in of_clusters.iter().chain(of_trees) {
            let mut model = intact.clone();
            sabotage(&mut model);
            let found = escaped(&model, &ENDS);
            assert!(found.contains(expected), "{range:?}, {tree:?}, {name}: {found:?}");
        }
    }
}

/// Both ends of the gap between the triangles are right places for a plane.
#[test]
fn a_plane_may_stand_anywhere_in_a_gap() {
    let mut model = tight(Range::Line, TreeKind::Kd);
    model.kd_nodes[0] = split_at(4.0);
    assert_eq!(escaped(&model, &ENDS), []);
}

/// Both ways to write the range, with both kinds of trees.
fn files() -> impl Iterator<Item = (Range, TreeKind)> {
    [Range::Line, Range::Reach]
        .into_iter()
        .flat_map(|range| TreeKind::ALL.map(|tree| (range, tree)))
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
    for (range, tree) in files() {
        let model = tight(range, tree);
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
    let sabotages: [(&str, Range, Sabotage, Stretched); 6] = [
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
        let mut model = tight(range, TreeKind::Wide);
        assert_eq!(escaped(&model, &[pose]), [], "{name}");
        sabotage(&mut model);
        let found = escaped(&model, &[pose]);
        assert!(found.contains(&Escaped::Bounds), "{name}: {found:?}");
    }
}

/// Levers are not the baker's word alone: a file with one that is too short is refused.
#[test]
fn a_lever_one_ulp_shorter_is_refused() {
    let sabotages: [(SectionKind, &str, Sabotage); 4] = [
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
        let mut model = tight(Range::Line, TreeKind::Wide);
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
    for tree in TreeKind::ALL {
        let intact = baked(tree);
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
}

/// Without the excess hits are lost, and comparing with brute force says so.
#[test]
fn a_margin_left_out_loses_hits_that_brute_force_finds() {
    TreeKind::ALL.into_iter().for_each(assert_hits_are_lost);
}

fn assert_hits_are_lost(tree: TreeKind) {
    let intact = tight(Range::Reach, tree);
    let mut blind = intact.clone();
    blind.bone_envelopes[0].reach = [1e6; 12];
    let pose = Stretched { shift: 100.0, ..STILL };
    let lost = [&intact, &blind].map(|model| {
        let asset = opened(model);
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        scene
            .set_palette(instance, &pose.palette(model), &[pose.morph])
            .unwrap();
        let frame = scene.commit();
        frame.prepare();
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
