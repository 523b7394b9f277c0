/// Which pose of which mesh was measured; errors say so.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Place {
    /// A sampled pose of a tessellation.
    #[error("subdivided {subdivisions} times, sample {sample}")]
    Sample {
        /// Times that the source's triangles were split into four.
        subdivisions: u32,
        /// Row of the sample section.
        sample: usize,
    },
    /// A pose of a kind.
    #[error("subdivided {subdivisions} times, {kind} pose {pose}, {rays} rays")]
    Drawn {
        /// Times that the source's triangles were split into four.
        subdivisions: u32,
        /// Kind of the pose.
        kind: &'static str,
        /// Its number among those of its kind.
        pose: usize,
        /// Kind of the rays.
        rays: &'static str,
    },
    /// A pose of a crowd.
    #[error("pose {pose}, {rays} rays")]
    Crowd {
        /// Number of the pose.
        pose: usize,
        /// Kind of the rays.
        rays: &'static str,
    },
    /// A time of the clip.
    #[error("at {seconds} s")]
    Time {
        /// Seconds.
        seconds: f32,
    },
}
