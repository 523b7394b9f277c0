use clap::{Args, ValueEnum};
use restpose_bake::BakeSettings;
use restpose_formats::TreeKind;

/// The option that says what fuzzy trees are.
#[derive(Debug, Args)]
pub struct TreeArgs {
    /// Trees over the boxes of all clusters
    #[arg(long, value_enum, default_value_t = TreeChoice::from(BakeSettings::default().tree), help_heading = "Trees")]
    tree: TreeChoice,
}

impl TreeArgs {
    /// What a bake takes.
    pub fn kind(&self) -> TreeKind {
        match self.tree {
            TreeChoice::Kd => TreeKind::Kd,
            TreeChoice::Wide => TreeKind::Wide,
        }
    }
}

/// Kinds of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TreeChoice {
    /// kd-trees, in whose leaves a box says which triangles a ray may meet
    Kd,
    /// Hierarchies of boxes with eight children to a node, tested at once
    Wide,
}

impl From<TreeKind> for TreeChoice {
    fn from(kind: TreeKind) -> Self {
        match kind {
            TreeKind::Kd => Self::Kd,
            TreeKind::Wide => Self::Wide,
        }
    }
}
