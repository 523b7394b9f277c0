use super::row_count;
use crate::{
    BakeError,
    import::{Animation, Local},
    motion::{Classified, parents_first},
};
use restpose_formats::{
    Model,
    rows::{BoneRow, MotionClass, NONE, NodeRow, ROOT_BONE},
};

/// Columns of a 3 × 4 matrix.
pub(crate) type Columns = [[f64; 3]; 4];

const IDENTITY: Columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]];

/// Where the source's nodes and skins went.
pub(crate) struct Skeleton {
    /// Per source node: its node row, or `NONE`.
    pub node_rows: Vec<u32>,
    /// Per part: bone row of its first joint, or of its node, or the root bone.
    pub first_bone: Vec<u32>,
    pub bones_of_part: Vec<Vec<u32>>,
    /// Per source node: world from node without any clip.
    pub worlds: Vec<Columns>,
}

/// Adds bones for what moves and the nodes that these need.
pub(crate) fn add_skeleton(
    model: &mut Model,
    animation: &Animation,
    classes: &[Classified],
) -> Result<Skeleton, BakeError> {
    let order = parents_first(animation);
    let mut needed = vec![false; animation.nodes.len()];
    for (part, _) in animation
        .parts
        .iter()
        .zip(classes)
        .filter(|(_, class)| class.class != MotionClass::Static)
    {
        match part.skin {
            Some(skin) => animation.skins[skin]
                .joints
                .iter()
                .for_each(|joint| needed[*joint] = true),
            None => needed[part.node] = true,
        }
    }
    // Children stand behind their parents in `order`, so one pass backwards reaches every ancestor.
    for node in order.iter().rev().copied() {
        if let Some(parent) = animation.nodes[node].parent.filter(|_| needed[node]) {
            needed[parent] = true;
        }
    }

    let mut node_rows = vec![NONE; animation.nodes.len()];
    let mut worlds = vec![IDENTITY; animation.nodes.len()];
    for node in order {
        let source = &animation.nodes[node];
        let local = columns(&source.local);
        worlds[node] = source.parent.map_or(local, |parent| product(&worlds[parent], &local));
        if needed[node] {
            let parent = source.parent.map_or(NONE, |parent| node_rows[parent]);
            node_rows[node] = row_count("nodes", model.nodes.len())?;
            model
                .nodes
                .push(NodeRow::new(parent, row_count("nodes", node)?, source.local));
        }
    }

    let mut bones = Bones {
        skins: vec![None; animation.skins.len()],
        nodes: vec![None; animation.nodes.len()],
    };
    push_bone(model, "root", NONE, (NONE, NONE), identity_bind())?;
    let mut first_bone = Vec::with_capacity(classes.len());
    let mut bones_of_part = Vec::with_capacity(classes.len());
    for (part, class) in animation.parts.iter().zip(classes) {
        let (first, count) = match part.skin {
            _ if class.class == MotionClass::Static => (ROOT_BONE, 1),
            Some(skin) => bones.of_skin(model, animation, skin, &node_rows)?,
            None => (bones.of_node(model, animation, part.node, &node_rows)?, 1),
        };
        first_bone.push(first);
        bones_of_part.push((first..first + count).collect());
    }
    Ok(Skeleton {
        node_rows,
        first_bone,
        bones_of_part,
        worlds,
    })
}

/// Bones made so far: parts that share a skin or a node share its bones.
struct Bones {
    skins: Vec<Option<u32>>,
    nodes: Vec<Option<u32>>,
}

impl Bones {
    fn of_skin(
        &mut self,
        model: &mut Model,
        animation: &Animation,
        skin: usize,
        node_rows: &[u32],
    ) -> Result<(u32, u32), BakeError> {
        let source = &animation.skins[skin];
        let count = row_count("joints", source.joints.len())?;
        let first = match self.skins[skin] {
            Some(first) => first,
            None => {
                let first = row_count("bones", model.bones.len())?;
                for (joint, (node, inverse_bind)) in source.joints.iter().zip(&source.inverse_bind).enumerate() {
                    let numbers = (row_count("skins", skin)?, row_count("joints", joint)?);
                    push_bone(
                        model,
                        &name_of(animation, *node),
                        node_rows[*node],
                        numbers,
                        *inverse_bind,
                    )?;
                }
                *self.skins[skin].insert(first)
            }
        };
        Ok((first, count))
    }

    fn of_node(
        &mut self,
        model: &mut Model,
        animation: &Animation,
        node: usize,
        node_rows: &[u32],
    ) -> Result<u32, BakeError> {
        if let Some(bone) = self.nodes[node] {
            return Ok(bone);
        }
        let bone = push_bone(
            model,
            &name_of(animation, node),
            node_rows[node],
            (NONE, NONE),
            identity_bind(),
        )?;
        Ok(*self.nodes[node].insert(bone))
    }
}

/// A node's name, or its number in the source where it has none.
fn name_of(animation: &Animation, node: usize) -> String {
    let name = &animation.nodes[node].name;
    if name.is_empty() {
        format!("node {node}")
    } else {
        name.clone()
    }
}

fn identity_bind() -> [[f32; 3]; 4] {
    IDENTITY.map(|column| column.map(|x| x as f32))
}

fn push_bone(
    model: &mut Model,
    name: &str,
    node: u32,
    (source_skin, source_joint): (u32, u32),
    inverse_bind: [[f32; 3]; 4],
) -> Result<u32, BakeError> {
    let row = row_count("bones", model.bones.len())?;
    let inverse_bind = bytemuck::cast(inverse_bind);
    model.bones.push(BoneRow {
        node,
        source_skin,
        source_joint,
        reserved: 0,
        inverse_bind,
    });
    model.meta.bone_names.push(name.to_owned());
    Ok(row)
}

fn columns(local: &Local) -> Columns {
    match *local {
        Local::Matrix(columns) => columns.map(|column| column.map(f64::from)),
        Local::Trs {
            translation,
            rotation,
            scale,
        } => {
            let rotation = glam::DQuat::from_array(rotation.map(f64::from)).normalize();
            let map = glam::DAffine3::from_scale_rotation_translation(
                scale.map(f64::from).into(),
                rotation,
                translation.map(f64::from).into(),
            );
            map.to_cols_array_2d()
        }
    }
}

/// `a` after `b`.
pub(crate) fn product(a: &Columns, b: &Columns) -> Columns {
    (glam::DAffine3::from_cols_array_2d(a) * glam::DAffine3::from_cols_array_2d(b)).to_cols_array_2d()
}
