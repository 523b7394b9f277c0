use super::{accessor::Accessors, document::Document, forest, schema, transform};
use crate::import::{Fault, Local, Node, fault_list::FaultList, magnitude::flaw};

/// A rotation's length may differ from one by this much without a warning: half a step of an 8-bit normalised integer,
/// 0.5 / 127, in each of four components.
const UNIT_LENGTH_TOLERANCE: f64 = 0.008;

/// Reads all nodes; their morph weights are added once the meshes are known.
pub(super) fn read(document: &Document, faults: &mut FaultList) -> Vec<Node> {
    let parents = forest::parents(&document.nodes, faults);
    let animated = animated_nodes(document);
    let rows = document.nodes.iter().zip(parents).zip(animated).enumerate();
    rows.map(|(number, ((node, parent), animated))| {
        check_references(document, number, node, faults);
        let local = local(number, node, animated, faults);
        Node {
            name: node.name.clone().unwrap_or_default(),
            parent,
            local,
            weights: Vec::new(),
        }
    })
    .collect()
}

/// Nodes whose translation, rotation or scale some channel moves.
fn animated_nodes(document: &Document) -> Vec<bool> {
    let mut animated = vec![false; document.nodes.len()];
    for channel in document.animations.iter().flat_map(|animation| &animation.channels) {
        let moves = matches!(channel.target.path.as_str(), "translation" | "rotation" | "scale");
        if let Some(node) = channel
            .target
            .node
            .and_then(|node| animated.get_mut(node.0))
            .filter(|_| moves)
        {
            *node = true;
        }
    }
    animated
}

fn check_references(document: &Document, number: usize, node: &schema::Node, faults: &mut FaultList) {
    for (key, index, count) in [
        ("mesh", node.mesh, document.meshes.len()),
        ("skin", node.skin, document.skins.len()),
    ] {
        if let Some(index) = index.filter(|index| index.0 >= count) {
            let message = format!("{key} {} does not exist; the file has {count}", index.0);
            faults.error(format!("/nodes/{number}/{key}"), message);
        }
    }
    if node.extensions.contains_key("EXT_mesh_gpu_instancing") && node.mesh.is_some() {
        faults.warn(
            format!("/nodes/{number}/extensions/EXT_mesh_gpu_instancing"),
            "not supported: the mesh is shown once, at the node itself; export the instances as nodes",
        );
    }
}

fn local(number: usize, node: &schema::Node, animated: bool, faults: &mut FaultList) -> Local {
    let at = |key: &str| format!("/nodes/{number}/{key}");
    let mut check = |key: &str, values: &[f64]| {
        for (place, flaw) in values
            .iter()
            .enumerate()
            .filter_map(|(place, value)| Some((place, flaw(*value)?)))
        {
            faults.error(format!("{}/{place}", at(key)), flaw);
        }
    };
    let translation = node.translation.unwrap_or([0.0; 3]);
    let rotation = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = node.scale.unwrap_or([1.0; 3]);
    check("translation", &translation);
    check("rotation", &rotation);
    check("scale", &scale);
    if let Some(matrix) = &node.matrix {
        check("matrix", &matrix[..]);
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            faults.warn(
                at("matrix"),
                "the node also has translation, rotation or scale, which are ignored",
            );
        }
        let local = matrix_local(matrix, animated, &at("matrix"), faults);
        return faults.keep(local).unwrap_or(Local::Matrix([[0.0; 3]; 4]));
    }
    let rotation = transform::normalized(rotation).unwrap_or_else(|| {
        faults.error(
            at("rotation"),
            format!("is {rotation:?}, which is no rotation; expected a quaternion of length one"),
        );
        rotation
    });
    if let Some(given) = node.rotation {
        warn_unless_unit(given, &at("rotation"), faults);
    }
    Local::Trs {
        translation: narrow(translation),
        rotation: narrow(rotation),
        scale: narrow(scale),
    }
}

fn matrix_local(matrix: &[f64; 16], animated: bool, at: &str, faults: &mut FaultList) -> Result<Local, Fault> {
    let (columns, exact) = transform::affine(matrix).map_err(|message| Fault::error(at, message))?;
    if !exact {
        faults.warn(at, "the bottom row is not exactly 0, 0, 0, 1; it is taken to be");
    }
    if !animated {
        return Ok(Local::Matrix(columns.map(narrow)));
    }
    let (rotation, scale) = transform::rotation_and_scale(&columns).map_err(|reason| {
        let message = format!("{reason}, but the node is animated; give it translation, rotation and scale instead");
        Fault::error(at, message)
    })?;
    faults.warn(
        at,
        "an animated node should have no matrix; it was taken apart into translation, rotation and scale",
    );
    Ok(Local::Trs {
        translation: narrow(columns[3]),
        rotation: narrow(rotation),
        scale: narrow(scale),
    })
}

/// Says so when a rotation is far from unit length; whoever uses it normalises it.
pub(super) fn warn_unless_unit(rotation: [f64; 4], at: &str, faults: &mut FaultList) {
    let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    if (length - 1.0).abs() > UNIT_LENGTH_TOLERANCE {
        faults.warn(at, format!("is a quaternion of length {length}; it is normalised"));
    }
}

/// Gives every node its morph weights: its own, else its mesh's, else zeros, one per target of its mesh.
pub(super) fn set_weights(
    document: &Document,
    accessors: &Accessors,
    target_counts: &[usize],
    nodes: &mut [Node],
    faults: &mut FaultList,
) {
    for (number, mesh) in document.meshes.iter().enumerate() {
        check_weights(
            &mesh.weights,
            target_counts.get(number),
            &format!("/meshes/{number}/weights"),
            faults,
        );
    }
    for (number, (row, node)) in document.nodes.iter().zip(nodes).enumerate() {
        let count = row.mesh.and_then(|mesh| target_counts.get(mesh.0));
        check_weights(&row.weights, count, &format!("/nodes/{number}/weights"), faults);
        let mesh_weights = || document.meshes.get(row.mesh?.0)?.weights.as_ref();
        let weights = row.weights.as_ref().or_else(mesh_weights);
        node.weights = weights.map_or_else(Vec::new, |weights| weights.iter().map(|w| *w as f32).collect());
        let count = count.copied().unwrap_or(0);
        let affordable = accessors.charge(count, size_of::<f32>(), &format!("/nodes/{number}/mesh"));
        if faults.keep(affordable).is_some() {
            node.weights.resize(count, 0.0);
        }
    }
}

fn check_weights(weights: &Option<Vec<f64>>, count: Option<&usize>, at: &str, faults: &mut FaultList) {
    let Some(weights) = weights else { return };
    let count = count.copied().unwrap_or(0);
    if weights.len() != count {
        let message = format!(
            "{} weights for {count} morph targets; missing ones are zero, others ignored",
            weights.len()
        );
        faults.warn(at, message);
    }
    for (place, flaw) in weights
        .iter()
        .enumerate()
        .filter_map(|(place, weight)| Some((place, flaw(*weight)?)))
    {
        faults.error(format!("{at}/{place}"), flaw);
    }
}

fn narrow<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|value| value as f32)
}
