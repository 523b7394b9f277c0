//! Figures of Günther, *Ray Tracing of Dynamic Scenes*, §3.5.2, to stand beside ours. Single-core Opterons of 2.4 GHz,
//! packets of 4 × 4 rays, pictures of 1024 × 1024 pixels with shading: compare shapes, not speeds.

use serde::Serialize;

/// A row of Table 3.1, scene UT2003.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThesisPoseSpace {
    /// Pose space, by the names used here.
    pub pose_space: &'static str,
    /// Sampled poses.
    pub samples: u32,
    /// Sum of the surface areas of all fuzzy boxes; the thesis gives no unit.
    pub fuzzy_box_area: f64,
    /// The same relative to the last row.
    pub area_ratio: f64,
    /// Average triangles per leaf.
    pub triangles_per_leaf: f64,
    /// Pictures per second.
    pub frames_per_s: f64,
    /// The same relative to the last row.
    pub relative_speed: f64,
}

/// A row of Table 3.3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThesisTessellation {
    /// Scene.
    pub scene: &'static str,
    /// Triangles, as rounded there.
    pub triangles: u32,
    /// Sampling poses and bounding triangles in them.
    pub sampling_seconds: f64,
    /// Building fuzzy kd-trees.
    pub tree_seconds: f64,
    /// Pictures per second.
    pub frames_per_s: f64,
}

/// Table 3.1.
pub const POSE_SPACES: [ThesisPoseSpace; 4] = [
    pose_space("arbitrary", 1000, 747e3, 4.1, 7.7),
    pose_space("limits", 245, 580e3, 3.4, 10.2),
    pose_space("clips", 124, 552e3, 3.2, 11.6),
    pose_space("one clip", 62, 515e3, 3.1, 12.0),
];

/// Table 3.3.
pub const TESSELLATIONS: [ThesisTessellation; 10] = [
    tessellation("CALLY", 3_000, 0.63, 0.65, 9.5),
    tessellation("CALLY", 10_000, 1.80, 2.28, 7.1),
    tessellation("CALLY", 30_000, 5.21, 8.77, 5.7),
    tessellation("CALLY", 90_000, 16.4, 34.5, 3.6),
    tessellation("CALLY", 271_000, 50.4, 150.0, 2.0),
    tessellation("UT2003", 2_000, 0.59, 0.39, 15.5),
    tessellation("UT2003", 7_000, 1.23, 1.67, 12.3),
    tessellation("UT2003", 22_000, 3.08, 6.41, 7.4),
    tessellation("UT2003", 67_000, 8.63, 23.8, 4.0),
    tessellation("UT2003", 200_000, 29.7, 88.9, 1.9),
];

const fn pose_space(
    pose_space: &'static str,
    samples: u32,
    fuzzy_box_area: f64,
    triangles_per_leaf: f64,
    frames_per_s: f64,
) -> ThesisPoseSpace {
    ThesisPoseSpace {
        pose_space,
        samples,
        fuzzy_box_area,
        area_ratio: fuzzy_box_area / 515e3,
        triangles_per_leaf,
        frames_per_s,
        relative_speed: frames_per_s / 12.0,
    }
}

const fn tessellation(
    scene: &'static str,
    triangles: u32,
    sampling_seconds: f64,
    tree_seconds: f64,
    frames_per_s: f64,
) -> ThesisTessellation {
    ThesisTessellation {
        scene,
        triangles,
        sampling_seconds,
        tree_seconds,
        frames_per_s,
    }
}
