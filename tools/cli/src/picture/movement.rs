use glam::Vec3;
use rayon::prelude::*;
use restpose_formats::geom::Aabb;
use restpose_runtime::{Frame, InstanceId, PoseError, Scene};

/// What an instance plays, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Movement {
    /// Clip row; `None` for the pose of the file.
    pub clip: Option<usize>,
    /// Times of the frames, seconds.
    pub times: Vec<f32>,
    /// From the first time to the end of the last frame, seconds.
    pub duration: f64,
}

impl Movement {
    /// The pose of the file, once.
    pub fn rest() -> Self {
        Self {
            clip: None,
            times: vec![0.0],
            duration: 0.0,
        }
    }

    /// `count` times spread evenly from `from` up to, but without, `to`: a clip that ends as it began then repeats
    /// without a halt. Where both are equal there is one frame.
    pub fn new(clip: usize, from: f32, to: f32, count: u32) -> Self {
        let duration = f64::from(to) - f64::from(from);
        let count = if duration > 0.0 { count } else { 1 };
        let time = |i: u32| (f64::from(from) + duration * f64::from(i) / f64::from(count)) as f32;
        Self {
            clip: Some(clip),
            times: (0..count).map(time).collect(),
            duration: duration.max(0.0),
        }
    }

    /// Poses an instance as at frame `index`; the last frame stays from there on.
    pub fn pose(&self, scene: &mut Scene, instance: InstanceId, index: usize) -> Result<(), PoseError> {
        match (self.clip, self.times.get(index).or(self.times.last())) {
            (Some(clip), Some(seconds)) => scene.play(instance, clip, *seconds),
            _ => scene.set_default_pose(instance),
        }
    }

    /// The box around every listed vertex at every frame; empty when there is none.
    pub fn bounds(&self, scene: &mut Scene, instance: InstanceId, vertices: &[u32]) -> Result<Aabb, PoseError> {
        let mut bounds = Aabb::EMPTY;
        for index in 0..self.times.len() {
            self.pose(scene, instance, index)?;
            bounds = bounds.union(bounds_now(&scene.commit(), instance, vertices));
        }
        Ok(bounds)
    }
}

fn bounds_now(frame: &Frame<'_>, instance: InstanceId, vertices: &[u32]) -> Aabb {
    let place = |vertex: &u32| {
        frame
            .vertex(instance, *vertex)
            .filter(|place| Vec3::from(*place).is_finite())
    };
    // The least and the greatest do not depend on the order in which they are looked for.
    vertices
        .par_iter()
        .with_min_len(1024)
        .filter_map(place)
        .fold(|| Aabb::EMPTY, Aabb::with_point)
        .reduce(|| Aabb::EMPTY, Aabb::union)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_start_at_from_and_stop_before_to() {
        let movement = Movement::new(2, 1.0, 3.0, 4);
        assert_eq!(movement.times, [1.0, 1.5, 2.0, 2.5]);
        assert_eq!(movement.duration, 2.0);
        assert_eq!(Movement::new(0, 1.0, 1.0, 9).times, [1.0]);
    }
}
