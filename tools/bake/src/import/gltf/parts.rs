use super::{accessor::Accessors, document::Document};
use crate::import::{Mesh, Node, Part, fault_list::FaultList};

/// Every mesh that the scene shows, in the order of the nodes.
pub(super) fn read(
    document: &Document,
    accessors: &Accessors,
    nodes: &[Node],
    meshes: &[Mesh],
    faults: &mut FaultList,
) -> Vec<Part> {
    let shown = shown_nodes(document, nodes, faults);
    let skinnable: Vec<Skinnable> = meshes.iter().map(skinnable).collect();
    let mut out = Vec::new();
    for (number, (row, node)) in document.nodes.iter().zip(nodes).enumerate() {
        let Some(mesh_number) = row.mesh.filter(|_| shown.get(number) == Some(&true)) else {
            continue;
        };
        let Some(mesh) = meshes.get(mesh_number.0) else {
            continue;
        };
        if mesh.primitives.is_empty() {
            if !faults.has_errors() {
                let message = format!("mesh {} has no triangles; it is not shown", mesh_number.0);
                faults.warn(format!("/nodes/{number}/mesh"), message);
            }
            continue;
        }
        let name = [&node.name, &mesh.name].into_iter().find(|name| !name.is_empty());
        // Many nodes may share one mesh with a very long name.
        let name_length = name.map_or(0, String::len);
        if faults
            .keep(accessors.charge(name_length, 1, &format!("/nodes/{number}/mesh")))
            .is_none()
        {
            break;
        }
        let follows = |_: &usize| follows_skin(number, skinnable.get(mesh_number.0), faults);
        out.push(Part {
            skin: row.skin.map(|skin| skin.0).filter(follows),
            name: name.cloned().unwrap_or_else(|| format!("node {number}")),
            node: number,
            mesh: mesh_number.0,
            cache: None,
        });
    }
    warn_about_unused_joints(document, faults);
    // With errors, the triangles may be missing only because they could not be read.
    if out.is_empty() && !faults.has_errors() {
        faults.error("", "the scene shows no triangles; expected at least one");
    }
    out
}

/// Which primitives of a mesh can follow a skin.
enum Skinnable {
    All,
    Not,
    /// Only some; the first that cannot.
    Except(usize),
}

fn skinnable(mesh: &Mesh) -> Skinnable {
    let mut without = mesh
        .primitives
        .iter()
        .filter(|primitive| primitive.influences.is_empty());
    match without.next() {
        None => Skinnable::All,
        Some(_) if without.count() + 1 == mesh.primitives.len() => Skinnable::Not,
        Some(first) => Skinnable::Except(first.source_primitive),
    }
}

/// True when the node's mesh follows the node's skin.
fn follows_skin(node: usize, skinnable: Option<&Skinnable>, faults: &mut FaultList) -> bool {
    let at = || format!("/nodes/{node}/skin");
    match skinnable {
        Some(Skinnable::All) => return true,
        Some(Skinnable::Except(primitive)) => {
            let message = format!(
                "primitive {primitive} of the mesh has no JOINTS_0 and WEIGHTS_0, others have; expected all or none \
                 under a skin"
            );
            faults.error(at(), message);
        }
        Some(Skinnable::Not) | None => {
            let message =
                "the mesh has no JOINTS_0 and WEIGHTS_0; the skin is ignored and the node's transform moves it";
            faults.warn(at(), message);
        }
    }
    false
}

fn warn_about_unused_joints(document: &Document, faults: &mut FaultList) {
    let mut skinned = vec![false; document.meshes.len()];
    for node in document.nodes.iter().filter(|node| node.skin.is_some()) {
        if let Some(mesh) = node.mesh.and_then(|mesh| skinned.get_mut(mesh.0)) {
            *mesh = true;
        }
    }
    for (number, (mesh, _)) in document
        .meshes
        .iter()
        .zip(skinned)
        .enumerate()
        .filter(|(_, (_, skinned))| !skinned)
    {
        for (place, primitive) in mesh.primitives.iter().enumerate() {
            if primitive.attributes.contains_key("JOINTS_0") {
                let at = format!("/meshes/{number}/primitives/{place}/attributes/JOINTS_0");
                faults.warn(at, "no node puts the mesh under a skin; the joints are ignored");
            }
        }
    }
}

/// Nodes under the roots of the default scene; else of the first; else, without scenes, all.
fn shown_nodes(document: &Document, nodes: &[Node], faults: &mut FaultList) -> Vec<bool> {
    let count = document.nodes.len();
    let number = document.scene.map_or(0, |scene| scene.0);
    let Some(scene) = document.scenes.get(number) else {
        if document.scene.is_some() {
            let message = format!("scene {number} does not exist; the file has {}", document.scenes.len());
            faults.error("/scene", message);
        }
        return vec![true; count];
    };
    let mut shown = vec![false; count];
    let mut open: Vec<usize> = Vec::new();
    for (place, root) in scene.nodes.iter().enumerate() {
        let at = || format!("/scenes/{number}/nodes/{place}");
        match nodes.get(root.0) {
            None => faults.error(at(), format!("node {} does not exist; the file has {count}", root.0)),
            Some(node) => {
                if let Some(parent) = node.parent {
                    let message = format!(
                        "node {} is no root; it keeps the transforms of its parent {parent}",
                        root.0
                    );
                    faults.warn(at(), message);
                }
                open.push(root.0);
            }
        }
    }
    while let Some(number) = open.pop() {
        match shown.get_mut(number) {
            Some(shown) if !*shown => *shown = true,
            _ => continue,
        }
        open.extend(
            document
                .nodes
                .get(number)
                .into_iter()
                .flat_map(|node| &node.children)
                .map(|child| child.0),
        );
    }
    shown
}
