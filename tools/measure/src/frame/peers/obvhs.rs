use super::{super::contestant::Tracing, Inputs, skinned::Structure};
use crate::MeasureError;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray as OwnRay, RayHit},
    rt_triangle::RtTriangle,
};
use rayon::prelude::*;
use restpose_runtime::Ray;
use std::time::Duration;

/// Rays that a task traces: as many as the runtime's.
const RAYS_PER_TASK: usize = 256;

/// The binary tree of `obvhs`, with triangles in the order of its leaves.
struct Obvhs {
    refits: bool,
    vertices: Vec<[f32; 4]>,
    corners: Vec<[u32; 3]>,
    boxes: Vec<Aabb>,
    triangles: Vec<RtTriangle>,
    bvh: Option<Bvh2>,
    rays: Vec<OwnRay>,
    hits: Vec<RayHit>,
}

/// Refitted, or built anew by its preset for the fastest build.
pub(super) fn structure(inputs: &Inputs, refits: bool) -> Box<dyn Structure> {
    Box::new(Obvhs {
        refits,
        vertices: inputs.all_vertices(),
        corners: inputs.all_triangles(),
        boxes: Vec::new(),
        triangles: Vec::new(),
        bvh: None,
        rays: Vec::new(),
        hits: Vec::new(),
    })
}

fn triangle(vertices: &[[f32; 4]], corners: [u32; 3]) -> RtTriangle {
    let [a, b, c] = corners.map(|corner| {
        let [x, y, z, _] = vertices[corner as usize];
        [x, y, z]
    });
    RtTriangle::new(a.into(), b.into(), c.into())
}

fn bounds(vertices: &[[f32; 4]], corners: [u32; 3]) -> Aabb {
    let points = corners.map(|corner| {
        let [x, y, z, _] = vertices[corner as usize];
        [x, y, z].into()
    });
    Aabb::from_points(&points)
}

impl Structure for Obvhs {
    fn vertices(&mut self) -> &mut [[f32; 4]] {
        &mut self.vertices
    }

    fn update(&mut self) -> Result<(), MeasureError> {
        let (vertices, corners) = (&self.vertices, &self.corners);
        let bvh = match &mut self.bvh {
            Some(bvh) if self.refits => {
                let leaves = bvh.nodes.par_iter_mut().filter(|node| node.is_leaf());
                let ids = &bvh.primitive_indices;
                leaves.for_each(|node| {
                    let first = node.first_index as usize;
                    let own = ids[first..first + node.prim_count as usize].iter();
                    let boxes = own.map(|id| bounds(vertices, corners[*id as usize]));
                    if let Some(bounds) = boxes.reduce(|a, b| a.union(&b)) {
                        node.set_aabb(bounds);
                    }
                });
                bvh.refit_all();
                bvh
            }
            _ => {
                let boxes = corners.par_iter().map(|corners| bounds(vertices, *corners));
                boxes.collect_into_vec(&mut self.boxes);
                let preset = if self.refits {
                    BvhBuildParams::medium_build()
                } else {
                    BvhBuildParams::fastest_build()
                };
                let bvh = self
                    .bvh
                    .insert(build_bvh2(&self.boxes, preset, &mut Duration::default()));
                if self.refits {
                    // Refitting is one sweep then.
                    bvh.reorder_in_stack_traversal_order();
                }
                bvh
            }
        };
        let ids = bvh.primitive_indices.par_iter();
        ids.map(|id| triangle(vertices, corners[*id as usize]))
            .collect_into_vec(&mut self.triangles);
        Ok(())
    }

    fn set_rays(&mut self, rays: &[Ray], _tracing: Tracing) {
        let own = |ray: &Ray| OwnRay::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max);
        self.rays = rays.iter().map(own).collect();
        self.hits = vec![RayHit::none(); rays.len()];
    }

    fn trace(&mut self) -> Result<(), MeasureError> {
        let Some(bvh) = &self.bvh else { return Ok(()) };
        let triangles = &self.triangles;
        let tasks = self.rays.par_chunks(RAYS_PER_TASK);
        let tasks = tasks.zip(self.hits.par_chunks_mut(RAYS_PER_TASK));
        tasks.for_each(|(rays, hits)| {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = RayHit::none();
                bvh.ray_traverse(*ray, hit, |ray, place| triangles[place].intersect(ray));
            }
        });
        Ok(())
    }

    fn distances(&self) -> Vec<f32> {
        let distance = |hit: &RayHit| {
            if hit.primitive_id == u32::MAX {
                f32::INFINITY
            } else {
                hit.t
            }
        };
        self.hits.iter().map(distance).collect()
    }
}
