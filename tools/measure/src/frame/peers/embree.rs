#![expect(unsafe_code, reason = "a C library reads our vertices")]

use super::{super::contestant::Tracing, Inputs, skinned::Structure};
use crate::{
    MeasureError,
    embree::{Meshes, RayHit, RayHits, Scene, Update},
};
use rayon::prelude::*;
use restpose_runtime::Ray;

/// Rays that a task traces: as many as the runtime's.
const RAYS_PER_TASK: usize = 256;

/// Embree's trees. The scene goes before what it reads.
struct Embree {
    scene: Scene,
    meshes: Meshes,
    rays: Rays,
}

/// Rays as they were given, and with what they hit.
enum Rays {
    Single(Vec<RayHit>, Vec<RayHit>),
    Eight(Vec<RayHits<8>>, Vec<RayHits<8>>),
    Sixteen(Vec<RayHits<16>>, Vec<RayHits<16>>),
}

/// One scene over the triangles of all instances.
pub(super) fn flat(inputs: &Inputs, update: Update) -> Box<dyn Structure> {
    let meshes = Meshes {
        vertices: inputs.all_vertices(),
        triangles: inputs.all_triangles(),
    };
    let count = meshes.vertices.len();
    // SAFETY: the vectors keep their length and place: only entries of vertices are written, between updates and rays.
    let scene = unsafe { Scene::of_mesh(inputs.device, &meshes, 0, count, update) };
    structure(scene, meshes)
}

/// A scene per instance, refitted, and one over these.
pub(super) fn instances(inputs: &Inputs) -> Box<dyn Structure> {
    let meshes = Meshes {
        vertices: inputs.all_vertices(),
        triangles: inputs.triangles.clone(),
    };
    let count = inputs.vertex_count;
    let child = |instance| {
        // SAFETY: as in `flat`.
        unsafe { Scene::of_mesh(inputs.device, &meshes, instance * count, count, Update::Refit) }
    };
    let children = (0..inputs.instances).map(child).collect();
    structure(Scene::of_scenes(inputs.device, children), meshes)
}

fn structure(scene: Scene, meshes: Meshes) -> Box<dyn Structure> {
    Box::new(Embree {
        scene,
        meshes,
        rays: Rays::Single(Vec::new(), Vec::new()),
    })
}

/// Packets of sixteen where the machine has vectors of sixteen.
fn sixteen() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx512f");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

impl Structure for Embree {
    fn tracings(&self) -> &'static [Tracing] {
        &[Tracing::Single, Tracing::Packets]
    }

    fn vertices(&mut self) -> &mut [[f32; 4]] {
        &mut self.meshes.vertices
    }

    fn update(&mut self) -> Result<(), MeasureError> {
        self.scene
            .update()
            .map_err(|code| MeasureError::peer("Embree", format!("its update ends with error {code}")))
    }

    fn set_rays(&mut self, rays: &[Ray], tracing: Tracing) {
        self.rays = match tracing {
            Tracing::Single => {
                let own: Vec<RayHit> = rays.iter().map(RayHit::new).collect();
                Rays::Single(own.clone(), own)
            }
            Tracing::Packets if sixteen() => {
                let own: Vec<_> = rays.chunks(16).map(RayHits::new).collect();
                Rays::Sixteen(own.clone(), own)
            }
            Tracing::Packets => {
                let own: Vec<_> = rays.chunks(8).map(RayHits::new).collect();
                Rays::Eight(own.clone(), own)
            }
        };
    }

    fn trace(&mut self) -> Result<(), MeasureError> {
        let scene = &self.scene;
        // Rays are copied from how they were given, since hits are written into them.
        match &mut self.rays {
            Rays::Single(given, traced) => each(given, traced, RAYS_PER_TASK, |rays| scene.intersect(rays)),
            Rays::Eight(given, traced) => each(given, traced, RAYS_PER_TASK / 8, |packets| {
                packets.iter_mut().for_each(|packet| scene.intersect_8(packet));
            }),
            Rays::Sixteen(given, traced) => each(given, traced, RAYS_PER_TASK / 16, |packets| {
                packets.iter_mut().for_each(|packet| scene.intersect_16(packet));
            }),
        }
        Ok(())
    }

    fn distances(&self) -> Vec<f32> {
        match &self.rays {
            Rays::Single(_, traced) => traced.iter().map(RayHit::distance).collect(),
            Rays::Eight(_, traced) => traced.iter().flat_map(RayHits::distances).collect(),
            Rays::Sixteen(_, traced) => traced.iter().flat_map(RayHits::distances).collect(),
        }
    }
}

fn each<T: Copy + Send + Sync>(given: &[T], traced: &mut [T], per_task: usize, trace: impl Fn(&mut [T]) + Sync) {
    let tasks = given.par_chunks(per_task).zip(traced.par_chunks_mut(per_task));
    tasks.for_each(|(given, traced)| {
        traced.copy_from_slice(given);
        trace(traced);
    });
}
