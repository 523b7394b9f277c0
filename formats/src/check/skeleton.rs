use super::{
    numbers::{finite, index, reserved},
    row,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    geom::Affine,
    rows::{BoneRow, NONE, NodeRow, ROOT_BONE},
};

/// Nodes are a forest with parents first; bone 0, and no other, is the root bone.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    for (at, node) in view.nodes.iter().enumerate() {
        check_node(at, node)?;
    }
    if view.bones.is_empty() {
        return Err(FormatError::RowCount {
            section: SectionKind::Bones,
            expected: 1,
            found: 0,
        });
    }
    for (at, bone) in view.bones.iter().enumerate() {
        check_bone(at, bone, view.nodes.len())?;
    }
    Ok(())
}

fn check_node(at: usize, node: &NodeRow) -> Result<(), FormatError> {
    let section = SectionKind::Nodes;
    reserved(section, at, "reserved", &[node.reserved])?;
    if node.parent != NONE && node.parent as usize >= at {
        return Err(row(section, at, RowFault::ParentNotBefore { found: node.parent }));
    }
    finite(section, at, "local", &node.local)?;
    match node.local_kind {
        NodeRow::TRS => {
            let unused = [node.local[10].to_bits(), node.local[11].to_bits()];
            reserved(section, at, "local[10..12]", &unused)
        }
        NodeRow::MATRIX => Ok(()),
        found => {
            let limit = NodeRow::MATRIX + 1;
            Err(row(
                section,
                at,
                RowFault::UnknownNumber {
                    field: "local_kind",
                    found,
                    limit,
                },
            ))
        }
    }
}

fn check_bone(at: usize, bone: &BoneRow, node_count: usize) -> Result<(), FormatError> {
    let section = SectionKind::Bones;
    reserved(section, at, "reserved", &[bone.reserved])?;
    finite(section, at, "inverse_bind", &bone.inverse_bind)?;
    if at == ROOT_BONE as usize {
        let identity: [f32; 12] = bytemuck::cast(Affine::IDENTITY.columns);
        return if bone.node == NONE && bone.inverse_bind == identity {
            Ok(())
        } else {
            Err(row(section, at, RowFault::NotRootBone))
        };
    }
    if bone.node == NONE {
        return Err(row(section, at, RowFault::SecondRootBone));
    }
    index(section, at, "node", bone.node, node_count)?;
    Ok(())
}
