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
    /// A time of the clip.
    #[error("at {seconds} s")]
    Time {
        /// Seconds.
        seconds: f32,
    },
}
