use super::states::States;

/// Which triangles touch which point, to walk from a triangle to its neighbours.
pub(super) struct Neighbours {
    /// Per point, where its triangles begin in `triangles`; one more at the end.
    firsts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Neighbours {
    /// `corners` are those of every triangle, below `points`.
    pub(super) fn new(points: usize, corners: &[[u32; 3]]) -> Self {
        let mut firsts = vec![0u32; points + 1];
        for corner in corners.iter().flatten() {
            firsts[*corner as usize + 1] += 1;
        }
        for point in 0..points {
            firsts[point + 1] += firsts[point];
        }
        let mut next = firsts.clone();
        let mut triangles = vec![0; corners.len() * 3];
        for (triangle, corners) in corners.iter().enumerate() {
            for corner in corners {
                triangles[next[*corner as usize] as usize] = triangle as u32;
                next[*corner as usize] += 1;
            }
        }
        Self { firsts, triangles }
    }

    /// The triangles that touch a point.
    pub(super) fn around(&self, point: u32) -> &[u32] {
        &self.triangles[self.firsts[point as usize] as usize..self.firsts[point as usize + 1] as usize]
    }

    /// A triangle and those around it, nearest first in steps over shared points, up to `count`; only triangles that
    /// `allowed` admits are passed.
    pub(super) fn patch(&self, states: &States, seed: u32, count: usize, allowed: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut seen = vec![false; states.triangles.len()];
        let mut patch = vec![seed];
        seen[seed as usize] = true;
        let mut walked = 0;
        while let Some(triangle) = patch.get(walked).copied() {
            walked += 1;
            for point in states.triangles[triangle as usize] {
                for next in self.around(point) {
                    if patch.len() >= count {
                        return patch;
                    }
                    if !seen[*next as usize] && allowed(*next) {
                        seen[*next as usize] = true;
                        patch.push(*next);
                    }
                }
            }
        }
        patch
    }
}
