use serde::{Deserialize, Serialize};

/// How the fuzzy boxes were bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bounds {
    /// Around the poses of the sample section only. Between samples, and for poses from elsewhere, hits can be missed.
    Sampled,
    /// Around the poses of the clusters' envelopes. A reader tells of each pose by how much it leaves them, and widens the
    /// boxes accordingly: no pose misses a hit.
    Envelope,
}

/// What the fuzzy trees of a file are; all are of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TreeKind {
    /// kd-trees whose leaves list triangles: rows of kd nodes, references and their boxes.
    #[default]
    Kd,
    /// Eight-wide hierarchies with a triangle per leaf: rows of wide nodes; the references list the same triangles.
    Wide,
}

impl TreeKind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [Self; 2] = [Self::Kd, Self::Wide];

    /// The name that options and reports use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Kd => "kd",
            Self::Wide => "wide",
        }
    }
}

/// Everything in a file that is not a bulk array.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Meta {
    /// Program and version that wrote the file.
    pub generator: String,
    /// File name of the source, without its folder.
    pub source_name: String,
    /// The options of the bake, as name and value, in a fixed order.
    pub options: Vec<(String, String)>,
    /// One name per part row; empty where the source has none.
    pub part_names: Vec<String>,
    /// One name per bone row: its node's, or `node` and the source's number.
    pub bone_names: Vec<String>,
    /// One name per clip row; the source's number where it has no name.
    pub clip_names: Vec<String>,
    /// How the fuzzy boxes were bounded.
    pub bounds: Bounds,
    /// What the fuzzy trees are.
    pub tree: TreeKind,
    /// Triangles that have no area in any pose: kept in the numbering, in no tree.
    pub degenerate_triangle_count: u32,
}

impl Default for Meta {
    fn default() -> Self {
        Self {
            generator: String::new(),
            source_name: String::new(),
            options: Vec::new(),
            part_names: Vec::new(),
            bone_names: Vec::new(),
            clip_names: Vec::new(),
            bounds: Bounds::Sampled,
            tree: TreeKind::Kd,
            degenerate_triangle_count: 0,
        }
    }
}
