use restpose_formats::FormatError;
use std::path::PathBuf;

/// Why a file was not opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The file cannot be read or mapped.
    #[error("{path}: cannot read: {source}", path = .path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// The file's contents are refused.
    #[error("{path}: {source}", path = .path.display())]
    Format {
        /// File.
        path: PathBuf,
        /// Reason.
        source: FormatError,
    },
}

/// Why a pose was not taken. The instance keeps the pose that it had, but where it was refused when it was committed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The scene has no such instance, or no longer.
    #[error("instance {instance} does not exist, or was removed: this scene has {count}")]
    UnknownInstance {
        /// Index of the instance asked for.
        instance: usize,
        /// Instances there are.
        count: usize,
    },
    /// The instance has no such triangle, or no longer.
    #[error("triangle {triangle} does not exist: the instance has {count}")]
    UnknownTriangle {
        /// Triangle asked for.
        triangle: u32,
        /// Triangles there are.
        count: usize,
    },
    /// The instance is one of supplied geometry, which has no pose.
    #[error("instance {instance} is of supplied geometry and has no pose; use set_geometry and set_transform")]
    NoAsset {
        /// Instance asked for.
        instance: usize,
    },
    /// The instance is one of an asset, whose triangles are in its file.
    #[error(
        "instance {instance} is of an asset, whose triangles are in its file; make one for your own by add_geometry"
    )]
    NotGeometry {
        /// Instance asked for.
        instance: usize,
    },
    /// A supplied vertex is infinite or NaN.
    #[error("vertex {vertex} of the supplied geometry has an infinite or NaN coordinate; leave out its triangles")]
    VertexNotFinite {
        /// Its index.
        vertex: usize,
    },
    /// A supplied triangle names a vertex that does not exist.
    #[error(
        "triangle {triangle} of the supplied geometry has a corner at vertex {corner}; expected one below {vertices}"
    )]
    CornerOutOfRange {
        /// Its index.
        triangle: usize,
        /// Vertex named.
        corner: u32,
        /// Vertices given.
        vertices: usize,
    },
    /// There are more supplied triangles than a tree can count.
    #[error("{count} triangles supplied; expected at most {most} in one instance; use several")]
    TooManyTriangles {
        /// Triangles given.
        count: usize,
        /// Triangles that fit.
        most: usize,
    },
    /// The asset has no such clip.
    #[error("clip {clip} does not exist: the asset has {count}")]
    UnknownClip {
        /// Clip asked for.
        clip: usize,
        /// Clips there are.
        count: usize,
    },
    /// The palette has another number of bones than the asset.
    #[error("the palette has {found} entries, expected {expected}: one per bone row of the asset")]
    PaletteLength {
        /// Bones of the asset.
        expected: usize,
        /// Entries given.
        found: usize,
    },
    /// There is another number of morph weights than the asset has targets.
    #[error("{found} morph weights given, expected {expected}: one per morph target row of the asset")]
    MorphWeightsLength {
        /// Morph targets of the asset.
        expected: usize,
        /// Weights given.
        found: usize,
    },
    /// There is another number of cache frames than the asset has vertex caches.
    #[error("{found} cache frames given, expected {expected}: one per cache row of the asset")]
    CacheFramesLength {
        /// Vertex caches of the asset.
        expected: usize,
        /// Frames given.
        found: usize,
    },
    /// A cache frame is infinite or NaN.
    #[error("the frame of cache {cache} is infinite or NaN")]
    CacheFrameNotFinite {
        /// Cache row.
        cache: usize,
    },
    /// A bone's map has an infinite or NaN entry.
    #[error("bone {bone} ({name}) has an infinite or NaN entry")]
    BoneNotFinite {
        /// Bone row.
        bone: usize,
        /// Its name.
        name: String,
    },
    /// A morph weight is infinite or NaN.
    #[error("morph weight {target} is infinite or NaN")]
    MorphWeightNotFinite {
        /// Morph target row.
        target: usize,
    },
    /// The pose is outside the pose space, and the caller wants none that is.
    #[error(
        "instance {instance} is outside its pose space: the cluster of bone {bone} ({name}) would need boxes wider by {excess:e}; bake for more poses, or allow it"
    )]
    OutsidePoseSpace {
        /// Instance.
        instance: usize,
        /// Bone row of the cluster.
        bone: usize,
        /// Its name.
        name: String,
        /// Length by which the cluster's boxes would be widened, in its rest space.
        excess: f64,
    },
    /// The instance transform has an infinite or NaN entry.
    #[error("the instance transform has an infinite or NaN entry")]
    TransformNotFinite,
    /// The clip time is infinite or NaN.
    #[error("the clip time {seconds} is not finite")]
    TimeNotFinite {
        /// Time asked for.
        seconds: f32,
    },
}
