use fastrand::Rng;
use restpose_bake::import::{
    Animation, Channel, ChannelTarget, Clip, Influence, Local, Mesh, Node, Part, Primitive, Skin,
};
use restpose_formats::rows::Interpolation;
use restpose_samples::surface::Surface;

/// A mesh and the joints that bend it.
#[derive(Clone, Copy, Debug)]
pub struct MeshRecipe<'a> {
    /// Its mesh, about one unit large.
    pub surface: &'a Surface,
    /// Joints of a chain along y, each carried by the one before. Without any the part stands still.
    pub joints: usize,
    /// Whether each vertex follows the joint below it alone.
    pub stiff: bool,
    /// Unit of every length.
    pub scale: f64,
    /// Where the mesh and its joints rest, in units of `scale`.
    pub rest_offset: [f64; 3],
    /// Where the root joint carries them from there, in units of `scale`.
    pub carried: [f64; 3],
}

impl<'a> MeshRecipe<'a> {
    /// The mesh under so many joints, at the origin and of its own size.
    #[must_use]
    pub fn new(surface: &'a Surface, joints: usize) -> Self {
        Self {
            surface,
            joints,
            stiff: false,
            scale: 1.0,
            rest_offset: [0.0; 3],
            carried: [0.0; 3],
        }
    }
}

/// Key times of every joint's rotation, seconds.
const TIMES: [f32; 3] = [0.0, 0.5, 1.0];

/// Greatest half-angle tangent of a joint's turn: 40 degrees, at which a tube with joints bends into a hook and stays
/// closed.
const TURN: f32 = 0.36;

/// The mesh as an animation with one clip. Vertices are shared as in the surface, so what is closed stays closed in
/// every pose.
#[must_use]
pub fn jointed_mesh(recipe: &MeshRecipe) -> Animation {
    let place =
        |p: [f64; 3]| -> [f32; 3] { std::array::from_fn(|k| ((p[k] + recipe.rest_offset[k]) * recipe.scale) as f32) };
    let points: Vec<[f64; 3]> = recipe.surface.positions.iter().map(|p| p.to_array()).collect();
    let low = points.iter().fold(f64::INFINITY, |low, p| low.min(p[1]));
    let high = points.iter().fold(f64::NEG_INFINITY, |high, p| high.max(p[1]));
    let spacing = (high - low) / recipe.joints.max(1) as f64;
    let influences = if recipe.joints == 0 {
        Vec::new()
    } else {
        let along = |p: &[f64; 3]| if spacing > 0.0 { (p[1] - low) / spacing } else { 0.0 };
        points.iter().map(|p| influences(along(p), recipe)).collect()
    };

    let carried = recipe.carried.map(|x| (x * recipe.scale) as f32);
    let mut animation = Animation {
        source_name: "jointed mesh".to_owned(),
        nodes: vec![node("mesh", None, carried)],
        meshes: vec![Mesh {
            name: "mesh".to_owned(),
            primitives: vec![Primitive {
                positions: points.iter().map(|p| place(*p)).collect(),
                triangles: recipe.surface.triangles.clone(),
                influences,
                ..Primitive::default()
            }],
            morph_target_count: 0,
        }],
        parts: vec![Part {
            name: "mesh".to_owned(),
            node: 0,
            mesh: 0,
            skin: (recipe.joints > 0).then_some(0),
            cache: None,
        }],
        ..Animation::default()
    };
    if recipe.joints > 0 {
        add_chain(&mut animation, recipe, [low, spacing], carried, place);
    }
    animation
}

/// The joints, whose rest poses are their places in the mesh, and a clip that turns them.
fn add_chain(
    animation: &mut Animation,
    recipe: &MeshRecipe,
    [low, spacing]: [f64; 2],
    carried: [f32; 3],
    place: impl Fn([f64; 3]) -> [f32; 3],
) {
    let mut random = Rng::with_seed(recipe.joints as u64);
    let mut skin = Skin {
        name: "chain".to_owned(),
        joints: Vec::new(),
        inverse_bind: Vec::new(),
    };
    let mut clip = Clip {
        name: "bend".to_owned(),
        channels: Vec::new(),
    };
    animation.nodes.push(node("root", None, carried));
    for joint in 0..recipe.joints {
        let at = place([0.0, low + joint as f64 * spacing, 0.0]);
        let step = [0.0, (spacing * recipe.scale) as f32, 0.0];
        let number = animation.nodes.len();
        let local = if joint == 0 { at } else { step };
        animation
            .nodes
            .push(node(&format!("joint {joint}"), Some(number - 1), local));
        skin.joints.push(number);
        skin.inverse_bind
            .push([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], at.map(|x| -x)]);
        let values = TIMES.iter().flat_map(|_| {
            let turn: [f32; 3] = std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * TURN);
            let length = turn.iter().fold(1.0, |sum, x| sum + x * x).sqrt();
            [turn[0] / length, turn[1] / length, turn[2] / length, 1.0 / length]
        });
        clip.channels.push(Channel {
            node: number,
            target: ChannelTarget::Rotation,
            interpolation: Interpolation::Linear,
            times: TIMES.to_vec(),
            values: values.collect(),
        });
    }
    animation.skins.push(skin);
    animation.clips.push(clip);
}

/// The two joints beside a place along the chain, or only the lower one.
fn influences(along: f64, recipe: &MeshRecipe) -> Vec<Influence> {
    let last = recipe.joints - 1;
    let lower = (along as usize).min(last);
    let upper = (lower + 1).min(last);
    let share = (along - lower as f64).clamp(0.0, 1.0) as f32;
    let one = |joint| vec![Influence { joint, weight: 1.0 }];
    if recipe.stiff || lower == upper || share == 0.0 {
        one(lower)
    } else {
        vec![
            Influence {
                joint: lower,
                weight: 1.0 - share,
            },
            Influence {
                joint: upper,
                weight: share,
            },
        ]
    }
}

fn node(name: &str, parent: Option<usize>, translation: [f32; 3]) -> Node {
    Node {
        name: name.to_owned(),
        parent,
        local: Local::Trs {
            translation,
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: [1.0; 3],
        },
        weights: Vec::new(),
    }
}
