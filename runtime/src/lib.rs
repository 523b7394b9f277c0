//! Maps a baked `.rpose` file, poses it, and ray traces any pose without rebuilding, refitting or skinning the mesh.
//!
//! ```no_run
//! use restpose_runtime::{Affine, Asset, Ray, Scene};
//! use std::sync::Arc;
//!
//! let asset = Arc::new(Asset::open("character.rpose".as_ref())?);
//! let mut scene = Scene::new();
//! let character = scene.add(&asset);
//! scene.set_transform(character, Affine::from_translation([0.0, 0.0, 5.0]))?;
//! scene.play(character, asset.clip("walk").expect("the clip is in the file"), 0.25)?;
//!
//! let frame = scene.commit();
//! if let Some(hit) = frame.closest_hit(&Ray::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0])) {
//!     let surface = frame.surface(&hit)?;
//!     println!("{} m, bone {}", hit.t, asset.model().meta.bone_names[surface.bone as usize]);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What a frame costs
//!
//! What its rays touch. A commit bounds the instances that changed, by their clips' boxes in the file, by their palettes, or by
//! the tracks of their vertex caches, and refits or builds the tree over all. The first ray that enters an instance poses its bones and bounds its clusters, the first that
//! enters a cluster inverts its matrix and measures its pose; in its tree boxes follow the pose as rays come by, and a ray that
//! reaches a triangle poses its vertices. Where many rays come, all vertices are posed and the tree is refitted, once
//! ([`Posing`]). Threads do so side by side without waiting; hits do not depend on any of it. [`FrameStats`] says what was
//! touched.
//!
//! [`InstanceState`]s are past or future poses: [`Scene::state`], [`Scene::set_state`], and for rays with times of their own
//! [`Scene::set_motion`] and [`Frame::closest_hit_at`]. [`Frame::closest_hit_among`] passes through some instances, such
//! as the one that shoots.
//!
//! # Files and poses
//!
//! [`Asset::open`] reads a file into memory; [`Asset::map`] maps it, which is `unsafe` because the file must not change
//! meanwhile; [`Asset::map_written`] leaves out the checks that the writer has made. Poses come from a clip ([`Scene::play`]) or from the caller ([`Scene::set_palette`]). Parts whose motion has
//! no coherence get a hierarchy over their posed triangles in every frame, and so do triangles that the caller supplies
//! ([`Scene::set_geometry`]).
//!
//! # The contract
//!
//! For every finite pose and every ray, [`Frame::closest_hit`] returns the same triangle, `t` and barycentric coordinates,
//! bit for bit, as testing every triangle of the scene with [`triangle::PreparedRay::intersect`]. Equal `t` is decided by the
//! lowest instance, then the lowest triangle. `cluster_frame` holds the proof, `excess` that of poses that the file was not
//! baked for: they cost time, no hits, and [`FrameStats::clusters_outside`] counts them.
//!
//! Only a file that was baked with sampled bounds promises less: the poses of its sample section, under any instance
//! transform.

mod affine64;
mod asset;
mod asset_instance;
mod atomic;
mod box_tree;
pub mod build;
mod cache;
mod cluster_frame;
mod envelope_hints;
mod error;
mod excess;
mod frame;
mod geometry_instance;
mod hit;
mod instance;
mod instance_state;
mod map;
mod motion;
mod motion_bounds;
mod mover_maps;
mod owned_bytes;
mod pose;
mod pose_space;
mod posed_bounds;
mod posed_maps;
mod posed_mesh;
mod posed_tree;
mod posing;
mod prepared;
mod ray;
mod refitted_tree;
mod relative_motions;
mod rest_boxes;
mod scene;
mod set_bits;
pub mod simd;
mod stats;
mod surface;
mod top_level;
mod trace;
pub mod triangle;
mod vertex;
mod vertex_memo;
#[cfg(test)]
mod vertex_memo_tests;
mod whole_pose;
mod wide;

pub use asset::Asset;
pub use cluster_frame::invert_frame;
pub use error::{OpenError, PoseError};
pub use frame::{ClusterBounds, Frame};
pub use hit::{Hit, InstanceId};
pub use instance_state::InstanceState;
pub use pose::{NodeLocal, Pose, PoseEvaluator};
pub use posing::Posing;
pub use ray::Ray;
/// What is in a file: the types behind [`Asset::model`].
pub use restpose_formats as formats;
pub use restpose_formats::geom::{Aabb, Affine};
pub use scene::Scene;
pub use stats::{FrameStats, TraceCounters};
pub use surface::SurfacePoint;
