//! An independent evaluation of glTF sources in f64: where every vertex is at a given time.
//!
//! Source: Khronos, *glTF 2.0 Specification* (2021) and its extension `KHR_mesh_quantization`. Written from those
//! texts alone; it shares no code with the baker or the runtime, for it is what their vertices are measured against.
//! Section numbers below are the specification's.
//!
//! It is test code: a file that it cannot read makes it panic and say why.

mod document;
#[cfg(test)]
mod tests;

use document::Document;
use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3, Vector4};
use std::path::Path;

/// A decoded glTF source that can be evaluated at any time.
#[derive(Clone, Debug)]
pub struct Reference {
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    skins: Vec<Skin>,
    clips: Vec<Vec<Channel>>,
    parts: Vec<ReferencePart>,
}

/// A node with a mesh, by the source's numbering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReferencePart {
    /// Node.
    pub node: usize,
    /// Mesh of that node.
    pub mesh: usize,
    /// Skin of that node.
    pub skin: Option<usize>,
}

#[derive(Clone, Debug)]
struct Node {
    parent: Option<usize>,
    /// In place of the other three.
    matrix: Option<Matrix4<f64>>,
    translation: Vec<f64>,
    rotation: Vec<f64>,
    scale: Vec<f64>,
    /// Morph weights, the node's else its mesh's else zeros.
    weights: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Clone, Debug)]
struct Primitive {
    positions: Vec<Vector3<f64>>,
    /// `[target][vertex]`.
    targets: Vec<Vec<Vector3<f64>>>,
    /// `[vertex]`, of every set: number of the joint in the skin, weight as stored.
    influences: Vec<Vec<(usize, f64)>>,
    triangles: Vec<[usize; 3]>,
}

#[derive(Clone, Debug)]
struct Skin {
    joints: Vec<usize>,
    inverse_bind: Vec<Matrix4<f64>>,
}

#[derive(Clone, Debug)]
struct Channel {
    node: usize,
    property: Property,
    interpolation: Interpolation,
    times: Vec<f64>,
    /// Numbers per value.
    width: usize,
    values: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

impl Reference {
    /// Reads a `.glb` or `.gltf` and the buffers that it refers to.
    ///
    /// # Panics
    /// When a file cannot be read or breaks the specification.
    pub fn load(path: &Path) -> Reference {
        Document::read(path).decode()
    }

    /// The nodes with a mesh that the default scene reaches, in ascending order of node.
    pub fn parts(&self) -> &[ReferencePart] {
        &self.parts
    }

    /// Number of clips (the source's animations).
    pub fn clip_count(&self) -> usize {
        self.clips.len()
    }

    /// Seconds of a clip's first and last key over all its channels; (0, 0) where it has none.
    pub fn clip_time_range(&self, clip: usize) -> (f64, f64) {
        let times = || {
            self.clips[clip]
                .iter()
                .flat_map(|channel| channel.times.iter().copied())
        };
        let range = times().reduce(f64::min).zip(times().reduce(f64::max));
        range.unwrap_or((0.0, 0.0))
    }

    /// Corners of each triangle as the primitive's own vertex numbers.
    ///
    /// Shapes: `[primitive][triangle]`, primitives by the source's numbering; points and lines have no triangles.
    /// Source: §3.7.2.1.
    pub fn triangles(&self, part: usize) -> Vec<Vec<[usize; 3]>> {
        let primitives = self.meshes[self.parts[part].mesh].primitives.iter();
        primitives.map(|primitive| primitive.triangles.clone()).collect()
    }

    /// Positions of a part's vertices at a time of a clip, or as the nodes stand without any clip.
    ///
    /// Shapes: `[primitive][vertex]`, both by the source's numbering.
    /// Space: the scene's, scene units, f64.
    /// Morph targets are applied first, then the skin with its weights renormalised to sum to one; a skinned node's own
    /// transform is ignored. Each channel holds its first value before its first key and its last after its last.
    ///
    /// # Panics
    /// When a vertex of a skinned part has no weight, or a joint that its skin lacks.
    pub fn positions(&self, part: usize, clip: Option<usize>, seconds: f64) -> Vec<Vec<[f64; 3]>> {
        let ReferencePart { node, mesh, skin } = self.parts[part];
        let nodes = self.posed_nodes(clip, seconds);
        let joints: Option<Vec<Matrix4<f64>>> = skin.map(|skin| {
            let Skin { joints, inverse_bind } = &self.skins[skin];
            let pairs = joints.iter().zip(inverse_bind);
            pairs.map(|(&joint, inverse)| world(&nodes, joint) * inverse).collect()
        });
        let own = world(&nodes, node);
        let place = |primitive: &Primitive, vertex: usize| -> [f64; 3] {
            let position = primitive.morphed(vertex, &nodes[node].weights);
            let world = match &joints {
                Some(joints) => blend(joints, &primitive.influences, vertex),
                None => own,
            };
            (world * position.push(1.0)).xyz().into()
        };
        let primitives = self.meshes[mesh].primitives.iter();
        primitives
            .map(|primitive| {
                (0..primitive.positions.len())
                    .map(|vertex| place(primitive, vertex))
                    .collect()
            })
            .collect()
    }

    /// The nodes with a clip's values in place of their own.
    fn posed_nodes(&self, clip: Option<usize>, seconds: f64) -> Vec<Node> {
        let mut nodes = self.nodes.clone();
        for channel in clip.into_iter().flat_map(|clip| &self.clips[clip]) {
            let node = &mut nodes[channel.node];
            let value = channel.at(seconds);
            match channel.property {
                Property::Translation => node.translation = value,
                Property::Rotation => node.rotation = value,
                Property::Scale => node.scale = value,
                Property::Weights => node.weights = value,
            }
        }
        nodes
    }
}

impl Node {
    /// Parent from node: T · R · S (§3.5.3).
    fn local(&self) -> Matrix4<f64> {
        if let Some(matrix) = self.matrix {
            return matrix;
        }
        let turn = unit(&self.rotation).to_homogeneous();
        let place = Matrix4::new_translation(&Vector3::from_row_slice(&self.translation));
        place * turn * Matrix4::new_nonuniform_scaling(&Vector3::from_row_slice(&self.scale))
    }
}

/// A quaternion in the file's order x, y, z, w, made unit: stored ones are so only to their precision.
fn unit(xyzw: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(xyzw[3], xyzw[0], xyzw[1], xyzw[2]))
}

/// Scene from node.
fn world(nodes: &[Node], node: usize) -> Matrix4<f64> {
    let (mut whole, mut up, mut steps) = (nodes[node].local(), nodes[node].parent, 0);
    while let Some(parent) = up {
        whole = nodes[parent].local() * whole;
        up = nodes[parent].parent;
        steps += 1;
        assert!(steps <= nodes.len(), "node {node} is its own ancestor");
    }
    whole
}

/// The mean of a vertex's joint matrices by its weights (§3.7.3.3).
fn blend(joints: &[Matrix4<f64>], influences: &[Vec<(usize, f64)>], vertex: usize) -> Matrix4<f64> {
    let row = influences
        .get(vertex)
        .expect("a skinned primitive has joints and weights");
    let whole: f64 = row.iter().map(|&(_, weight)| weight).sum();
    assert!(whole > 0.0, "the weights of vertex {vertex} sum to {whole}");
    let weighted = row.iter().filter(|&&(_, weight)| weight != 0.0);
    weighted.fold(Matrix4::zeros(), |sum, &(joint, weight)| {
        let matrix = joints.get(joint);
        sum + matrix.unwrap_or_else(|| panic!("vertex {vertex} names joint {joint}")) * (weight / whole)
    })
}

impl Primitive {
    /// A vertex after its morph targets (§3.7.2.2).
    fn morphed(&self, vertex: usize, weights: &[f64]) -> Vector3<f64> {
        let moves = self.targets.iter().zip(weights);
        moves.fold(self.positions[vertex], |sum, (target, &weight)| {
            sum + target[vertex] * weight
        })
    }
}

impl Channel {
    /// The value at a time (§3.11 and appendix C).
    fn at(&self, seconds: f64) -> Vec<f64> {
        let last = self.times.len() - 1;
        if seconds <= self.times[0] {
            return self.value(0);
        }
        if seconds >= self.times[last] {
            return self.value(last);
        }
        // The key at or before the time: there is one, and one after it.
        let key = self.times.iter().rposition(|&time| time <= seconds).unwrap_or(0);
        let length = self.times[key + 1] - self.times[key];
        let along = (seconds - self.times[key]) / length;
        match self.interpolation {
            Interpolation::Step => self.value(key),
            Interpolation::Linear if self.property == Property::Rotation => {
                slerp(&self.value(key), &self.value(key + 1), along)
            }
            Interpolation::Linear => {
                let (from, to) = (self.value(key), self.value(key + 1));
                from.iter()
                    .zip(&to)
                    .map(|(a, b)| (1.0 - along) * a + along * b)
                    .collect()
            }
            Interpolation::CubicSpline => self.spline(key, along, length),
        }
    }

    /// The value of a key, without its tangents.
    fn value(&self, key: usize) -> Vec<f64> {
        match self.interpolation {
            Interpolation::CubicSpline => self.element(3 * key + 1).to_vec(),
            _ => self.element(key).to_vec(),
        }
    }

    fn element(&self, element: usize) -> &[f64] {
        &self.values[element * self.width..(element + 1) * self.width]
    }

    /// The Hermite spline of appendix C.5; a key's elements are in-tangent, value, out-tangent.
    fn spline(&self, key: usize, t: f64, length: f64) -> Vec<f64> {
        let (from, out_tangent) = (self.element(3 * key + 1), self.element(3 * key + 2));
        let (in_tangent, to) = (self.element(3 * key + 3), self.element(3 * key + 4));
        let (t2, t3) = (t * t, t * t * t);
        (0..self.width)
            .map(|index| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * from[index]
                    + length * (t3 - 2.0 * t2 + t) * out_tangent[index]
                    + (-2.0 * t3 + 3.0 * t2) * to[index]
                    + length * (t3 - t2) * in_tangent[index]
            })
            .collect()
    }
}

/// Spherical linear interpolation the shorter way (appendix C.4).
fn slerp(from: &[f64], to: &[f64], along: f64) -> Vec<f64> {
    let from = Vector4::from_row_slice(from).normalize();
    let to = Vector4::from_row_slice(to).normalize();
    let to = if from.dot(&to) < 0.0 { -to } else { to };
    // Exact for small angles too, where the arc cosine of the dot product is not.
    let angle = 2.0 * (to - from).norm().atan2((to + from).norm());
    let blended = match angle {
        0.0 => from,
        _ => (from * ((1.0 - along) * angle).sin() + to * (along * angle).sin()) / angle.sin(),
    };
    blended.as_slice().to_vec()
}
