/// What tracking did in one build. Nodes that are swept exactly, or are leaves by their size, are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackingStats {
    /// Nodes whose plane was found from its prediction.
    pub tracked_nodes: u32,
    /// Nodes whose plane was searched without one.
    pub untracked_nodes: u32,
    /// Evaluations of the cost from predictions, over all tracked nodes.
    pub tracked_steps: u32,
    /// Evaluations over all untracked nodes: from the extremes, and from predictions that turned out useless. A search
    /// over bins counts none.
    pub untracked_steps: u32,
    /// Sum of |predicted − found| over the tracked nodes, in lengths of the box around each node's boxes.
    pub error_sum: f64,
}

impl TrackingStats {
    /// Share of the searched nodes that were tracked, 0 to 1; 0 if there are none.
    #[must_use]
    pub fn tracked_share(&self) -> f64 {
        ratio(self.tracked_nodes, self.tracked_nodes + self.untracked_nodes)
    }

    /// Evaluations per tracked node.
    #[must_use]
    pub fn steps_per_tracked_node(&self) -> f64 {
        ratio(self.tracked_steps, self.tracked_nodes)
    }

    /// Evaluations per untracked node.
    #[must_use]
    pub fn steps_per_untracked_node(&self) -> f64 {
        ratio(self.untracked_steps, self.untracked_nodes)
    }

    /// Mean |predicted − found| of the tracked nodes, in lengths of the box around each node's boxes.
    #[must_use]
    pub fn prediction_error(&self) -> f64 {
        self.error_sum / f64::from(self.tracked_nodes.max(1))
    }
}

fn ratio(part: u32, whole: u32) -> f64 {
    f64::from(part) / f64::from(whole.max(1))
}
