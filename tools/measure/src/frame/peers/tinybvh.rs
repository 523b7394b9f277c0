#![expect(unsafe_code, reason = "C++ objects move between threads and are read by several")]

use super::{super::contestant::Tracing, Inputs, skinned::Structure};
use crate::MeasureError;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray as ObvhsRay, RayHit},
};
use rayon::prelude::*;
use restpose_runtime::Ray;
use std::time::Duration;
use tinybvh_rs::{
    Intersector,
    bvh::{BVH, BVHData},
};

/// Rays that a task traces: as many as the runtime's.
const RAYS_PER_TASK: usize = 256;

/// Its binary trees: one over all instances, or one for each under a tree of `obvhs`, since the crate has none for that.
struct TinyBvh {
    refits: bool,
    vertices: Vec<[f32; 4]>,
    vertex_count: usize,
    /// Of one tree.
    triangles: Vec<[u32; 3]>,
    trees: Vec<Tree>,
    top: Option<Bvh2>,
    rays: Vec<OwnRay>,
    /// Of the directions as they were given.
    lengths: Vec<f32>,
    hits: Vec<OwnRay>,
}

/// A tree over triangles that are not indexed: the crate takes no others.
#[derive(Default)]
struct Tree {
    corners: Vec<[f32; 4]>,
    data: Option<BVHData>,
}

// SAFETY: the object owns its arrays and no thread, and is changed by one thread at a time.
unsafe impl Send for Tree {}

/// A tree that rays meet.
struct Bound<'a>(BVH<'a>);

// SAFETY: rays only read the object and the corners that it is bound to.
unsafe impl Sync for Bound<'_> {}
// SAFETY: as for `Tree`.
unsafe impl Send for Bound<'_> {}

/// As C++ aligns it. Its direction has unit length.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct OwnRay(tinybvh_rs::Ray);

/// Of all instances, refitted or built anew by binned SAH.
pub(super) fn structure(inputs: &Inputs, refits: bool) -> Box<dyn Structure> {
    Box::new(TinyBvh {
        refits,
        vertices: inputs.all_vertices(),
        vertex_count: inputs.vertex_count * inputs.instances,
        triangles: inputs.all_triangles(),
        trees: vec![Tree::default()],
        top: None,
        rays: Vec::new(),
        lengths: Vec::new(),
        hits: Vec::new(),
    })
}

/// A tree per instance, refitted.
pub(super) fn instances(inputs: &Inputs) -> Box<dyn Structure> {
    let mut trees = Vec::new();
    trees.resize_with(inputs.instances, Tree::default);
    Box::new(TinyBvh {
        refits: true,
        vertices: inputs.all_vertices(),
        vertex_count: inputs.vertex_count,
        triangles: inputs.triangles.clone(),
        trees,
        top: None,
        rays: Vec::new(),
        lengths: Vec::new(),
        hits: Vec::new(),
    })
}

fn refused(error: tinybvh_rs::Error) -> MeasureError {
    MeasureError::peer("tinybvh", error.to_string())
}

impl Tree {
    fn update(&mut self, vertices: &[[f32; 4]], triangles: &[[u32; 3]], refits: bool) -> Result<(), MeasureError> {
        self.corners.resize(3 * triangles.len(), [0.0; 4]);
        let tasks = self.corners.par_chunks_mut(3 * RAYS_PER_TASK);
        tasks
            .zip(triangles.par_chunks(RAYS_PER_TASK))
            .for_each(|(out, triangles)| {
                for (out, corners) in out.chunks_exact_mut(3).zip(triangles) {
                    for (out, corner) in out.iter_mut().zip(corners) {
                        *out = vertices[*corner as usize];
                    }
                }
            });
        let corners = || self.corners.as_slice().into();
        let bvh = match self.data.take() {
            None => BVH::new(corners()),
            Some(data) if refits => data.bvh(corners()).map(|mut bvh| {
                bvh.refit();
                bvh
            }),
            Some(data) => data.bvh(corners()).and_then(|bvh| bvh.build(corners())),
        };
        self.data = Some(bvh.map_err(refused)?.data());
        Ok(())
    }

    /// Makes it ready for rays, which takes it away.
    fn bind(&mut self) -> Result<Bound<'_>, MeasureError> {
        let Self { corners, data } = self;
        let data = data.take();
        let data = data.ok_or_else(|| MeasureError::peer("tinybvh", "nothing was built"))?;
        Ok(Bound(data.bvh(corners.as_slice().into()).map_err(refused)?))
    }

    fn bounds(&self) -> Aabb {
        let root = self.data.as_ref().and_then(|data| data.nodes().first());
        root.map_or(Aabb::INVALID, |root| Aabb::new(root.min.into(), root.max.into()))
    }
}

impl Structure for TinyBvh {
    fn vertices(&mut self) -> &mut [[f32; 4]] {
        &mut self.vertices
    }

    fn update(&mut self) -> Result<(), MeasureError> {
        let (refits, triangles) = (self.refits, &self.triangles);
        let own = self.trees.par_iter_mut();
        own.zip(self.vertices.par_chunks_exact(self.vertex_count))
            .try_for_each(|(tree, vertices)| tree.update(vertices, triangles, refits))?;
        if self.trees.len() > 1 {
            let boxes: Vec<Aabb> = self.trees.iter().map(Tree::bounds).collect();
            let preset = BvhBuildParams::fast_build();
            self.top = Some(build_bvh2(&boxes, preset, &mut Duration::default()));
        }
        Ok(())
    }

    fn set_rays(&mut self, rays: &[Ray], _tracing: Tracing) {
        let own = |ray: &Ray| {
            let mut own = tinybvh_rs::Ray::new(ray.origin, ray.direction);
            own.hit.t = tinybvh_rs::INFINITE.min(ray.t_max * length(ray));
            OwnRay(own)
        };
        self.rays = rays.iter().map(own).collect();
        self.lengths = rays.iter().map(length).collect();
        self.hits.clone_from(&self.rays);
    }

    fn trace(&mut self) -> Result<(), MeasureError> {
        let trees = self
            .trees
            .iter_mut()
            .map(Tree::bind)
            .collect::<Result<Vec<Bound>, _>>()?;
        let tasks = self.rays.par_chunks(RAYS_PER_TASK);
        let tasks = tasks.zip(self.hits.par_chunks_mut(RAYS_PER_TASK));
        tasks.for_each(|(rays, hits)| {
            hits.copy_from_slice(rays);
            for hit in hits {
                match (&self.top, trees.as_slice()) {
                    (Some(top), trees) => intersect_instances(top, trees, &mut hit.0),
                    (None, [only, ..]) => drop(only.0.intersect(&mut hit.0)),
                    (None, []) => {}
                }
            }
        });
        let data: Vec<BVHData> = trees.into_iter().map(|bound| bound.0.data()).collect();
        for (tree, data) in self.trees.iter_mut().zip(data) {
            tree.data = Some(data);
        }
        Ok(())
    }

    fn distances(&self) -> Vec<f32> {
        let rays = self.rays.iter().zip(&self.hits).zip(&self.lengths);
        rays.map(|((given, traced), length)| {
            if traced.0.hit.t < given.0.hit.t {
                traced.0.hit.t / length
            } else {
                f32::INFINITY
            }
        })
        .collect()
    }
}

/// Enters the trees whose boxes the ray meets, nearest first.
fn intersect_instances(top: &Bvh2, trees: &[Bound], ray: &mut tinybvh_rs::Ray) {
    let own = ObvhsRay::new(ray.origin.into(), ray.dir.into(), 0.0, ray.hit.t);
    top.ray_traverse(own, &mut RayHit::none(), |_, place| {
        let before = ray.hit.t;
        trees[top.primitive_indices[place] as usize].0.intersect(ray);
        if ray.hit.t < before { ray.hit.t } else { f32::INFINITY }
    });
}

fn length(ray: &Ray) -> f32 {
    ray.direction.iter().map(|x| x * x).sum::<f32>().sqrt()
}
