use super::states::States;

/// The points of one cluster, each once, with the weight that the cluster's triangles give it: a third of each
/// triangle's, so that tessellation does not decide.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Members {
    /// Ascending.
    pub points: Vec<u32>,
    /// Per entry of `points`.
    pub weights: Vec<f64>,
    /// Triangles, ascending.
    pub triangles: Vec<u32>,
}

impl Members {
    /// The members of each of `clusters` clusters.
    pub(super) fn of_clusters(states: &States, cluster_of: &[u32], clusters: usize) -> Vec<Self> {
        let mut out = vec![Self::default(); clusters];
        for (triangle, cluster) in cluster_of.iter().enumerate() {
            out[*cluster as usize].triangles.push(triangle as u32);
        }
        let mut sums = vec![0.0; states.points];
        for members in &mut out {
            members.collect_points(states, &mut sums);
        }
        out
    }

    /// The points of a list of triangles.
    pub(super) fn of_triangles(states: &States, triangles: Vec<u32>) -> Self {
        let mut out = Self {
            triangles,
            ..Self::default()
        };
        out.collect_points(states, &mut vec![0.0; states.points]);
        out
    }

    /// `sums` is zero before and after.
    fn collect_points(&mut self, states: &States, sums: &mut [f64]) {
        for triangle in &self.triangles {
            let third = states.weights[*triangle as usize] / 3.0;
            for corner in states.triangles[*triangle as usize] {
                if sums[corner as usize] == 0.0 {
                    self.points.push(corner);
                }
                sums[corner as usize] += third;
            }
        }
        self.points.sort_unstable();
        self.weights = self
            .points
            .iter()
            .map(|point| std::mem::take(&mut sums[*point as usize]))
            .collect();
    }
}
