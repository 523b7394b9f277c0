//! What hangs together: points that coincide in every key are one, triangles that share a point are one component.

use super::KeyFrames;

/// Bits of a position, with -0 as 0.
fn bits(position: [f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
}

/// Per point, the lowest point that coincides with it in every key.
fn weld(keys: &KeyFrames) -> Vec<u32> {
    let count = keys.frames.first().map_or(0, |frame| frame.len());
    let mut order: Vec<u32> = (0..count as u32).collect();
    let compare = |a: &u32, b: &u32| {
        keys.frames
            .iter()
            .map(|frame| bits(frame[*a as usize]).cmp(&bits(frame[*b as usize])))
            .find(|order| order.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    };
    order.sort_by(|a, b| compare(a, b).then(a.cmp(b)));
    let mut welded: Vec<u32> = (0..count as u32).collect();
    for pair in order.windows(2) {
        if compare(&pair[0], &pair[1]).is_eq() {
            welded[pair[1] as usize] = welded[pair[0] as usize];
        }
    }
    welded
}

/// A component: its triangles and its points, both ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Component {
    pub triangles: Vec<u32>,
    pub points: Vec<u32>,
}

/// The mesh with coinciding points as one, in components.
pub(super) struct Components {
    /// Corners of every triangle after welding.
    pub triangles: Vec<[u32; 3]>,
    /// In order of their lowest triangle.
    pub components: Vec<Component>,
}

impl Components {
    pub(super) fn new(keys: &KeyFrames) -> Self {
        let welded = weld(keys);
        let triangles: Vec<[u32; 3]> = keys
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| welded[corner as usize]))
            .collect();
        let labels = labels(welded.len(), &triangles);
        let mut component_of = vec![u32::MAX; welded.len()];
        let mut components: Vec<Component> = Vec::new();
        for (triangle, corners) in triangles.iter().enumerate() {
            let root = labels[corners[0] as usize] as usize;
            if component_of[root] == u32::MAX {
                component_of[root] = components.len() as u32;
                components.push(Component::default());
            }
            let component = &mut components[component_of[root] as usize];
            component.triangles.push(triangle as u32);
            component.points.extend(corners);
        }
        for component in &mut components {
            component.points.sort_unstable();
            component.points.dedup();
        }
        Self { triangles, components }
    }
}

/// Per point, a point that stands for its component.
pub(super) fn labels(points: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..points as u32).collect();
    for [a, b, c] in triangles {
        let low = root(&mut parents, *a);
        for other in [*b, *c] {
            let other = root(&mut parents, other);
            parents[other as usize] = low;
        }
    }
    (0..points as u32).map(|point| root(&mut parents, point)).collect()
}

/// The representative of a point's set; halves the path to it.
fn root(parents: &mut [u32], mut point: u32) -> u32 {
    while parents[point as usize] != point {
        let grandparent = parents[parents[point as usize] as usize];
        parents[point as usize] = grandparent;
        point = grandparent;
    }
    point
}
