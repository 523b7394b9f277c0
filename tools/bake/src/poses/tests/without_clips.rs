use crate::{
    BakeSettings, Baked, MotionClass, NoProgress, PoseSpace, bake,
    import::{Animation, Influence, Local, Mesh, Node, Part, Primitive, Skin},
};

fn node(name: &str, parent: Option<usize>, height: f32) -> Node {
    Node {
        name: name.to_owned(),
        parent,
        local: Local::Trs {
            translation: [0.0, height, 0.0],
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: [1.0; 3],
        },
        weights: Vec::new(),
    }
}

fn triangle(influences: Vec<Vec<Influence>>) -> Mesh {
    let primitive = Primitive {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        influences,
        ..Primitive::default()
    };
    Mesh {
        primitives: vec![primitive],
        ..Mesh::default()
    }
}

/// A triangle over two joints, a hat on the upper one, a stone beside them; no clips.
fn baked(pose_space: PoseSpace) -> Baked {
    let half = |joint| Influence { joint, weight: 0.5 };
    let unbound = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
    let part = |name: &str, node, mesh, skin| Part {
        name: name.to_owned(),
        node,
        mesh,
        skin,
        cache: None,
    };
    let animation = Animation {
        nodes: vec![
            node("hip", None, 1.0),
            node("head", Some(0), 1.0),
            node("hat", Some(1), 0.5),
            node("stone", None, 0.0),
        ],
        meshes: vec![triangle(vec![vec![half(0), half(1)]; 3]), triangle(Vec::new())],
        skins: vec![Skin {
            joints: vec![0, 1],
            inverse_bind: vec![unbound; 2],
            ..Skin::default()
        }],
        parts: vec![
            part("body", 3, 0, Some(0)),
            part("hat", 2, 1, None),
            part("stone", 3, 1, None),
        ],
        ..Animation::default()
    };
    let settings = BakeSettings {
        pose_space,
        ..BakeSettings::default()
    };
    bake(&animation, &settings, &NoProgress).expect("a sound scene")
}

#[test]
fn what_hangs_on_a_turned_joint_follows_it() {
    for (space, hat, random) in [
        (PoseSpace::Clips, MotionClass::Static, 0),
        (PoseSpace::Limits(Default::default()), MotionClass::Rigid, 245),
        (PoseSpace::Arbitrary, MotionClass::Rigid, 1000),
    ] {
        let report = baked(space.clone()).report;
        let classes: Vec<_> = report.parts.iter().map(|part| part.class).collect();
        assert_eq!(classes, [MotionClass::Skinned, hat, MotionClass::Static], "{space:?}");
        assert_eq!((report.samples, report.random_poses), (1 + random, random), "{space:?}");
    }
}

#[test]
fn random_poses_widen_the_boxes_but_are_no_samples_of_the_file() {
    let [still, limits, arbitrary] = [
        PoseSpace::Clips,
        PoseSpace::Limits(Default::default()),
        PoseSpace::Arbitrary,
    ]
    .map(baked);
    let area = |baked: &Baked| baked.report.parts[0].fuzzy_box_area;
    assert!(area(&still) < area(&limits) && area(&limits) < area(&arbitrary));
    assert_eq!(arbitrary.model.samples, still.model.samples);
}
