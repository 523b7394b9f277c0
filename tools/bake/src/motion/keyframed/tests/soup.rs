use super::super::KeyFrames;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Key frames that own their positions.
#[derive(Clone, Debug, Default)]
pub(super) struct Soup {
    pub frames: Vec<Vec<[f32; 3]>>,
    pub triangles: Vec<[u32; 3]>,
}

impl Soup {
    pub(super) fn keys(&self) -> KeyFrames<'_> {
        KeyFrames {
            frames: self.frames.iter().map(Vec::as_slice).collect(),
            triangles: &self.triangles,
        }
    }

    /// Adds a strip of `count` triangles with random corners around `centre`, within `size`, moved by `motion` (per
    /// key) and by noise of up to `noise`.
    pub(super) fn add_strip(
        &mut self,
        random: &mut fastrand::Rng,
        count: usize,
        centre: DVec3,
        size: f64,
        motion: &[DAffine3],
        noise: f64,
    ) {
        let first = self.frames.first().map_or(0, Vec::len) as u32;
        let vector = |random: &mut fastrand::Rng| DVec3::from_array(std::array::from_fn(|_| random.f64() * 2.0 - 1.0));
        let points: Vec<DVec3> = (0..count + 2).map(|_| centre + vector(random) * size).collect();
        self.frames.resize(motion.len(), Vec::new());
        for (frame, map) in self.frames.iter_mut().zip(motion) {
            let position = |point: &DVec3| {
                (map.transform_point3(*point) + vector(random) * noise)
                    .as_vec3()
                    .to_array()
            };
            frame.extend(points.iter().map(position));
        }
        self.triangles
            .extend((0..count as u32).map(|k| [first + k, first + k + 1, first + k + 2]));
    }
}

/// A smooth path of random turns, moves and, with `stretch`, scales along the axes of up to that factor.
pub(super) fn path(random: &mut fastrand::Rng, keys: usize, stretch: f64) -> Vec<DAffine3> {
    let unit = |random: &mut fastrand::Rng| {
        DVec3::from_array(std::array::from_fn(|_| random.f64() - 0.5)).normalize_or(DVec3::X)
    };
    let (axis, travel) = (unit(random), unit(random));
    let (spin, squeeze) = (
        random.f64() * 0.4,
        DVec3::from_array(std::array::from_fn(|_| random.f64() * 2.0 - 1.0)),
    );
    (0..keys)
        .map(|key| {
            let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, spin * key as f64));
            let swing = (key as f64 * 0.7).sin();
            let scale = (squeeze * swing * stretch.ln()).exp();
            DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), travel * key as f64 * 0.3)
        })
        .collect()
}
