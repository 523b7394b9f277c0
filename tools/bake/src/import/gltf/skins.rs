use super::{
    accessor::{Accessors, Numbers},
    document::Document,
    schema, transform,
};
use crate::import::{Fault, Skin, fault_list::FaultList};
use std::collections::BTreeSet;

const IDENTITY: [[f32; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]];

/// Reads all skins.
pub(super) fn read(document: &Document, accessors: &Accessors, faults: &mut FaultList) -> Vec<Skin> {
    let skins = document.skins.iter().enumerate();
    skins
        .map(|(number, row)| {
            let path = format!("/skins/{number}");
            check_references(document, row, &path, faults);
            let inverse_bind = match row.inverse_bind_matrices {
                Some(index) => {
                    let at = format!("{path}/inverseBindMatrices");
                    let matrices = inverse_bind(accessors, index, row.joints.len(), &at, faults);
                    faults.keep(matrices).unwrap_or_default()
                }
                None => vec![IDENTITY; row.joints.len()],
            };
            Skin {
                name: row.name.clone().unwrap_or_default(),
                joints: row.joints.iter().map(|joint| joint.0).collect(),
                inverse_bind,
            }
        })
        .collect()
}

/// Per mesh, the number of joints that every skin over it has; nothing for a mesh without skin.
pub(super) fn joint_counts(document: &Document) -> Vec<Option<usize>> {
    let mut counts: Vec<Option<usize>> = vec![None; document.meshes.len()];
    for node in &document.nodes {
        let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else {
            continue;
        };
        let (Some(count), Some(skin)) = (counts.get_mut(mesh.0), document.skins.get(skin.0)) else {
            continue;
        };
        *count = Some(count.map_or(skin.joints.len(), |least| least.min(skin.joints.len())));
    }
    counts
}

fn check_references(document: &Document, row: &schema::Skin, path: &str, faults: &mut FaultList) {
    let count = document.nodes.len();
    let missing = |node: schema::Whole| format!("node {} does not exist; the file has {count}", node.0);
    if row.joints.is_empty() {
        faults.error(format!("{path}/joints"), "is empty; expected at least one joint");
    }
    let mut seen = BTreeSet::new();
    for (place, joint) in row.joints.iter().enumerate() {
        if joint.0 >= count {
            faults.error(format!("{path}/joints/{place}"), missing(*joint));
        } else if !seen.insert(joint.0) {
            let message = format!("node {} is listed before; it is kept as a joint of its own", joint.0);
            faults.warn(format!("{path}/joints/{place}"), message);
        }
    }
    if let Some(skeleton) = row.skeleton.filter(|skeleton| skeleton.0 >= count) {
        faults.error(format!("{path}/skeleton"), missing(skeleton));
    }
}

fn inverse_bind(
    accessors: &Accessors,
    index: schema::Whole,
    joint_count: usize,
    at: &str,
    faults: &mut FaultList,
) -> Result<Vec<[[f32; 3]; 4]>, Fault> {
    let matrices: Vec<[f32; 16]> = accessors.floats(index, Numbers::Float, at)?;
    if matrices.len() < joint_count {
        let found = matrices.len();
        return Err(Fault::error(
            at,
            format!("{found} matrices for {joint_count} joints; expected one per joint"),
        ));
    }
    let mut inexact = None;
    let mut out = Vec::with_capacity(joint_count);
    for (joint, matrix) in matrices.iter().take(joint_count).enumerate() {
        let (columns, exact) = transform::affine(&matrix.map(f64::from))
            .map_err(|message| Fault::error(at, format!("joint {joint}: {message}")))?;
        if !exact {
            inexact = inexact.or(Some(joint));
        }
        out.push(columns.map(|column| column.map(|entry| entry as f32)));
    }
    if let Some(joint) = inexact {
        faults.warn(
            at,
            format!("the bottom row of the matrix of joint {joint} is not exactly 0, 0, 0, 1; it is taken to be"),
        );
    }
    Ok(out)
}
