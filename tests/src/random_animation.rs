use fastrand::Rng;
use restpose_bake::import::{
    Animation, Channel, ChannelTarget, Clip, Influence, Local, Mesh, Node, Part, Primitive, Skin,
};
use restpose_formats::rows::Interpolation;

/// What a random animation is made of.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// Seed.
    pub seed: u64,
    /// Vertices, at least three; as many triangles are drawn among them.
    pub vertices: usize,
    /// Joints of the skin.
    pub joints: usize,
    /// Unit of every length.
    pub scale: f32,
    /// Where the model is, in units of `scale`.
    pub offset: f32,
    /// Whether bones are also scaled unevenly, mirrored, flattened and scaled to nothing.
    pub wild_scales: bool,
    /// Morph targets.
    pub morph_targets: usize,
}

/// A triangle soup under a random skeleton, with a clip that moves everything. No mesh anyone would draw, but each
/// thing that can go wrong in decomposition and traversal happens in it: triangles across unrelated bones, slivers,
/// points, mirrored and vanishing bones.
#[must_use]
pub fn random_animation(recipe: &Recipe) -> Animation {
    let mut random = Rng::with_seed(recipe.seed);
    let mut signed = |magnitude: f32| (random.f32() * 2.0 - 1.0) * magnitude;
    let unit = recipe.scale;
    let mut point = |spread: f32| -> [f32; 3] { std::array::from_fn(|_| signed(spread) * unit) };

    let positions: Vec<[f32; 3]> = (0..recipe.vertices)
        .map(|_| point(1.0).map(|x| x + recipe.offset * unit))
        .collect();
    let morph_targets: Vec<Vec<[f32; 3]>> = (0..recipe.morph_targets)
        .map(|_| (0..recipe.vertices).map(|_| point(0.3)).collect())
        .collect();
    let translations: Vec<[f32; 3]> = (0..recipe.joints * 3).map(|_| point(0.4)).collect();

    let corner = |random: &mut Rng| random.u32(..recipe.vertices as u32);
    let mut triangles: Vec<[u32; 3]> = (0..recipe.vertices)
        .map(|_| std::array::from_fn(|_| corner(&mut random)))
        .collect();
    // Chance may draw a corner twice; one triangle is sure to have an area.
    triangles[0] = [0, 1, 2];
    let influences = (0..recipe.vertices)
        .map(|_| random_influences(&mut random, recipe.joints))
        .collect();

    let rotation = |random: &mut Rng| -> [f32; 4] {
        let q: [f32; 4] = std::array::from_fn(|_| random.f32() * 2.0 - 1.0);
        let length = q.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-3);
        q.map(|x| x / length)
    };
    let mut nodes = vec![Node {
        name: "mesh".to_owned(),
        parent: None,
        local: trs([0.0; 3]),
        weights: vec![0.0; recipe.morph_targets],
    }];
    let mut channels = Vec::new();
    for joint in 0..recipe.joints {
        let parent = (joint > 0).then(|| 1 + random.usize(..joint));
        nodes.push(Node {
            name: format!("joint {joint}"),
            parent,
            local: trs(translations[joint]),
            weights: Vec::new(),
        });
        let times = vec![0.0, 0.25, 0.5];
        channels.push(Channel {
            node: 1 + joint,
            target: ChannelTarget::Rotation,
            interpolation: if joint % 2 == 0 {
                Interpolation::Linear
            } else {
                Interpolation::CubicSpline
            },
            values: {
                let keys = if joint % 2 == 0 { 3 } else { 9 };
                (0..keys).flat_map(|_| rotation(&mut random)).collect()
            },
            times: times.clone(),
        });
        if recipe.wild_scales {
            let kinds = [1.0, -1.0, 0.0, 1e-3, 40.0, 1e-9];
            let values = (0..9).map(|_| kinds[random.usize(..kinds.len())]).collect();
            let target = ChannelTarget::Scale;
            channels.push(Channel {
                node: 1 + joint,
                target,
                interpolation: Interpolation::Step,
                times,
                values,
            });
        }
    }
    if recipe.morph_targets > 0 {
        let values = (0..3 * recipe.morph_targets)
            .map(|_| random.f32() * 3.0 - 1.0)
            .collect();
        let (target, interpolation) = (ChannelTarget::Weights, Interpolation::Linear);
        channels.push(Channel {
            node: 0,
            target,
            interpolation,
            times: vec![0.0, 0.25, 0.5],
            values,
        });
    }

    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
    let primitive = Primitive {
        source_primitive: 0,
        positions,
        triangles,
        influences,
        morph_targets,
        points: Vec::new(),
    };
    Animation {
        source_name: format!("random {}", recipe.seed),
        source_hash: [0; 32],
        nodes,
        meshes: vec![Mesh {
            name: "soup".to_owned(),
            primitives: vec![primitive],
            morph_target_count: recipe.morph_targets,
        }],
        skins: vec![Skin {
            name: "skin".to_owned(),
            joints: (1..=recipe.joints).collect(),
            inverse_bind: vec![identity; recipe.joints],
        }],
        clips: vec![Clip {
            name: "clip".to_owned(),
            channels,
        }],
        parts: vec![Part {
            name: "soup".to_owned(),
            node: 0,
            mesh: 0,
            skin: Some(0),
            cache: None,
        }],
        ..Animation::default()
    }
}

fn random_influences(random: &mut Rng, joints: usize) -> Vec<Influence> {
    let mut order: Vec<usize> = (0..joints).collect();
    random.shuffle(&mut order);
    let count = random.usize(1..=joints.min(4));
    order[..count]
        .iter()
        .map(|joint| Influence {
            joint: *joint,
            weight: random.f32() + 1e-3,
        })
        .collect()
}

fn trs(translation: [f32; 3]) -> Local {
    Local::Trs {
        translation,
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    }
}
