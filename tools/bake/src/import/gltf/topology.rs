/// How a primitive's vertices form triangles. Source: glTF 2.0 §3.7.2.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    /// Three vertices each.
    List,
    /// Each vertex from the third on with the two before it, every second one turned over.
    Strip,
    /// Each vertex from the third on with the one before it and the first.
    Fan,
}

impl Topology {
    /// Triangles that `count` vertices form.
    pub fn triangle_count(self, count: usize) -> usize {
        match self {
            Self::List => count / 3,
            Self::Strip | Self::Fan => count.saturating_sub(2),
        }
    }

    /// Vertices at the end that form no triangle.
    pub fn left_over(self, count: usize) -> usize {
        match self {
            Self::List => count % 3,
            Self::Strip | Self::Fan if count < 3 => count,
            Self::Strip | Self::Fan => 0,
        }
    }

    /// The triangles, in the corner order that the specification gives.
    pub fn triangles(self, vertices: &[u32]) -> Vec<[u32; 3]> {
        match self {
            Self::List => vertices
                .chunks_exact(3)
                .filter_map(|three| three.try_into().ok())
                .collect(),
            Self::Strip => {
                let turned = |(place, three): (usize, &[u32])| match *three {
                    [a, b, c] if place % 2 == 0 => Some([a, b, c]),
                    [a, b, c] => Some([a, c, b]),
                    _ => None,
                };
                vertices.windows(3).enumerate().filter_map(turned).collect()
            }
            Self::Fan => match vertices.split_first() {
                Some((first, rest)) => rest
                    .windows(2)
                    .filter_map(|two| if let [a, b] = *two { Some([a, b, *first]) } else { None })
                    .collect(),
                None => Vec::new(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_stand_as_the_specification_orders_them() {
        let vertices = [10, 11, 12, 13, 14];
        assert_eq!(Topology::List.triangles(&vertices), [[10, 11, 12]]);
        assert_eq!(
            Topology::Strip.triangles(&vertices),
            [[10, 11, 12], [11, 13, 12], [12, 13, 14]]
        );
        assert_eq!(
            Topology::Fan.triangles(&vertices),
            [[11, 12, 10], [12, 13, 10], [13, 14, 10]]
        );
    }

    #[test]
    fn counts_agree_with_the_triangles_for_every_small_length() {
        for topology in [Topology::List, Topology::Strip, Topology::Fan] {
            for count in 0..9 {
                let vertices: Vec<u32> = (0..count).collect();
                assert_eq!(
                    topology.triangles(&vertices).len(),
                    topology.triangle_count(count as usize)
                );
            }
        }
        assert_eq!(
            [
                Topology::List.left_over(5),
                Topology::Strip.left_over(2),
                Topology::Fan.left_over(4)
            ],
            [2, 2, 0]
        );
    }
}
