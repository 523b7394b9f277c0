//! Wide hierarchies: eight children to a node, on a lattice, as a baked file has them.

mod builder;
mod collapse;
mod fault;
mod plan;

pub use builder::{TooManyBoxes, WideBuilder};
pub use fault::WideFault;

use restpose_formats::{
    geom::Aabb,
    rows::{ReferenceBoxRow, WideChild, WideNodeRow, box_steps},
};
use restpose_runtime::build::BvhSettings;

/// A wide hierarchy over boxes, one to a leaf.
///
/// The root is `nodes[0]`, nodes stand depth first, and in a node leaves stand before nodes. At most
/// [`MAX_WIDE_DEPTH`](restpose_formats::rows::MAX_WIDE_DEPTH) nodes lie on a path to a leaf. The box of a leaf is the smallest
/// on the lattice over `bounds` that contains its own, that of a node the smallest around those in it.
#[derive(Clone, Debug, PartialEq)]
pub struct WideBvh {
    /// The box around everything, whose lattice the nodes' boxes are on. Empty until built.
    pub bounds: Aabb,
    /// Nodes; the root first. Leaves name boxes by their indices.
    pub nodes: Vec<WideNodeRow>,
    /// Indices of boxes in the order of the leaves: by nodes, in a node by places.
    pub references: Vec<u32>,
}

impl Default for WideBvh {
    fn default() -> Self {
        Self {
            bounds: Aabb::EMPTY,
            nodes: Vec::new(),
            references: Vec::new(),
        }
    }
}

impl WideBvh {
    /// Most boxes that leaves can name.
    pub const MAX_COUNT: usize = WideChild::MAX_INDEX as usize + 1;

    /// Places in use per node, mean over the nodes; 0 before anything was built.
    #[must_use]
    pub fn mean_children(&self) -> f64 {
        let children = self.references.len() + self.nodes.len().saturating_sub(1);
        children as f64 / self.nodes.len().max(1) as f64
    }

    /// The expected cost of a ray that meets `bounds`: K_Trav is charged for nodes, K_Isec for leaves whose box it meets.
    ///
    /// A tree whose bounds have no area is measured by the lengths of its boxes instead, one that is a point by counts.
    ///
    /// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, Eq. 4.1.
    #[must_use]
    pub fn sah_cost(&self, settings: &BvhSettings) -> f64 {
        let share = Share::new(&self.bounds);
        let steps = box_steps(&self.bounds).map(f64::from);
        let mut cost = if self.nodes.is_empty() {
            0.0
        } else {
            settings.traversal_cost
        };
        for node in &self.nodes {
            for (place, child) in node.children().enumerate() {
                let bounds = box_of(node, place);
                let sides = [0, 1, 2].map(|k| f64::from(bounds.max[k] - bounds.min[k]) * steps[k]);
                cost += share.of_sides(sides)
                    * match child {
                        WideChild::Node(_) => settings.traversal_cost,
                        WideChild::Leaf(_) | WideChild::Empty => settings.intersection_cost,
                    };
            }
        }
        cost
    }
}

/// The box of a place.
fn box_of(node: &WideNodeRow, place: usize) -> ReferenceBoxRow {
    let corner = |corners: &[[u16; 8]; 3]| [corners[0][place], corners[1][place], corners[2][place]];
    ReferenceBoxRow {
        min: corner(&node.min),
        max: corner(&node.max),
    }
}

/// How likely a ray that meets a whole box is to meet one inside.
#[derive(Clone, Copy, Debug)]
struct Share {
    by_length: bool,
    whole: f64,
}

impl Share {
    fn new(whole: &Aabb) -> Self {
        let by_length = whole.surface_area() <= 0.0;
        let mut share = Self { by_length, whole: 1.0 };
        share.whole = share.measure(sides_of(whole));
        share
    }

    fn measure(&self, [x, y, z]: [f64; 3]) -> f64 {
        if self.by_length {
            x + y + z
        } else {
            2.0 * (x * y + y * z + z * x)
        }
    }

    fn of_sides(&self, sides: [f64; 3]) -> f64 {
        if self.whole > 0.0 {
            self.measure(sides) / self.whole
        } else {
            1.0
        }
    }

    fn of(&self, part: &Aabb) -> f64 {
        self.of_sides(sides_of(part))
    }
}

/// Lengths of the sides, without overflow.
fn sides_of(bounds: &Aabb) -> [f64; 3] {
    [0, 1, 2].map(|k| f64::from(bounds.max[k]) - f64::from(bounds.min[k]))
}
