use super::{
    NodeLocal,
    slerp::{LANES, slerp},
};
use crate::simd::{Four, SimdLevel};

/// The way between two keys of a rotation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    /// Quaternions x, y, z, w at its ends, as stored.
    pub keys: [[f32; 4]; 2],
    /// Part of the way, 0 to 1.
    pub fraction: f64,
}

/// Rotations of a pose that are still to be interpolated, which goes by several at a time.
#[derive(Debug, Default)]
pub(super) struct Arcs {
    /// With node rows.
    arcs: Vec<(u32, Arc)>,
}

impl Arcs {
    pub(super) fn clear(&mut self) {
        self.arcs.clear();
    }

    pub(super) fn push(&mut self, node: u32, arc: Arc) {
        self.arcs.push((node, arc));
    }

    /// Writes the rotations of all nodes that have an arc.
    pub(super) fn rotate(&self, level: SimdLevel, locals: &mut [NodeLocal]) {
        for some in self.arcs.chunks(LANES) {
            // The last ones are made full by repetition.
            let arc = |lane: usize| &some[lane.min(some.len() - 1)].1;
            let arcs = [arc(0), arc(1), arc(2), arc(3)];
            let lanes = |of: fn(&Arc, usize) -> f64, i| -> Four { arcs.map(|arc| of(arc, i)) };
            let key = |of| [lanes(of, 0), lanes(of, 1), lanes(of, 2), lanes(of, 3)];
            let rotations = slerp(
                level,
                &key(|arc, i| arc.keys[0][i].into()),
                &key(|arc, i| arc.keys[1][i].into()),
                &arcs.map(|arc| arc.fraction),
            );
            for (lane, (node, _)) in some.iter().enumerate() {
                locals[*node as usize].set_rotation(rotations.map(|component| component[lane]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every count of arcs, from no node's to more than are computed together.
    #[test]
    fn rotations_take_the_shorter_arc_at_even_speed() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // From none to a quarter turn about z, given with the opposite sign.
        let keys = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, -half, -half]];
        let at_rest = NodeLocal::Trs {
            translation: [1.0, 2.0, 3.0],
            rotation: [1.0, 0.0, 0.0, 0.0],
            scale: [1.0; 3],
        };
        for count in 0..=2 * LANES + 1 {
            let mut locals = vec![at_rest; count + 1];
            let mut arcs = Arcs::default();
            let fraction = |node: usize| (node + 1) as f64 / (count + 1) as f64;
            for node in (0..count).rev() {
                arcs.push(
                    node as u32,
                    Arc {
                        keys,
                        fraction: fraction(node),
                    },
                );
            }
            arcs.rotate(SimdLevel::detect(), &mut locals);
            for (node, local) in locals[..count].iter().enumerate() {
                let NodeLocal::Trs {
                    translation, rotation, ..
                } = local
                else {
                    panic!("{local:?}");
                };
                let found = 2.0 * libm::atan2(rotation[2], rotation[3]).to_degrees();
                let degrees = 90.0 * fraction(node);
                // Keys are f32.
                assert!((found - degrees).abs() < 1e-5, "{found} is not {degrees}");
                assert_eq!(*translation, [1.0, 2.0, 3.0]);
            }
            assert_eq!(locals[count], at_rest, "a node without an arc");
        }
    }
}
