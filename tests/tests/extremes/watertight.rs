//! No ray passes through a closed surface, along its edges and through its vertices least of all.
//!
//! What is asserted is what can be proven. The triangle test shears every corner by a function of the corner alone, so
//! for one ray the sheared triangles are again a closed surface, and each corner is off by at most `VERTEX_ERROR` times
//! its distance. While that is less than the distance from a point to the surface, the sheared surface winds around the
//! point as often as the exact one. So
//!
//! - a ray from a point around which the surface winds hits, whichever way it goes;
//! - a segment from outside the surface's box to such a point hits.
//!
//! A hit cannot hide in triangles seen edge-on, which are never hit: rays beside it would have to hit others, and those
//! are closed.

#![expect(
    clippy::print_stdout,
    reason = "what was measured is printed for whoever asks with --nocapture"
)]

use fastrand::Rng;
use rayon::prelude::*;
use restpose_bake::verify::Oracle;
use restpose_runtime::{Aabb, Affine, Frame, Hit, Ray};
use restpose_tests::{
    MeshRecipe, Stage, baked_animation, cached_mesh, closed_surfaces, hit_bits,
    inside::{Corners, is_inside, size},
    jointed_mesh, tube,
};

/// Rays over all solids.
const RAYS: usize = 10_000_000;

const RAYS_PER_TASK: usize = 4_000;

/// One ray in so many is compared with brute force as well.
const COMPARED: usize = 50;

/// Least distance of inner points from the surface, relative to its size: thousands of times what the shear moves, as rays
/// begin at most a few sizes away.
const CLEARANCE: f64 = 1.0 / 64.0;

fn solids() -> Vec<(String, Stage)> {
    let turned = Affine {
        columns: [
            [0.36, 0.48, -0.8],
            [-0.8, 0.6, 0.0],
            [0.48, 0.64, 0.6],
            [3.0, -5.0, 7.0],
        ],
    };
    let mut tiny = turned;
    tiny.columns.iter_mut().flatten().for_each(|x| *x *= 1e-15);
    let mut solids = Vec::new();
    for (name, surface) in closed_surfaces() {
        let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, 0)));
        solids.push((format!("{name} that stands"), Stage::with(&asset, Affine::IDENTITY, 0)));
    }
    for (name, surface) in closed_surfaces() {
        let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, 4)));
        let transform = if name == "sphere" { tiny } else { turned };
        solids.push((format!("{name} bent by joints"), Stage::with(&asset, transform, 3)));
    }
    let tube = tube();
    let bent = |frame: u32| {
        let bend = f64::from(frame) * 0.3;
        let place = |p: [f64; 3]| [p[0] + bend * p[1] * p[1], p[1], p[2] - bend * p[0] * p[1]].map(|x| x as f32);
        tube.positions.iter().map(|p| place(p.to_array())).collect()
    };
    let asset = baked_animation(&cached_mesh(&tube.triangles, &(0..6).map(bent).collect::<Vec<_>>()));
    let mut stage = Stage::default();
    let instance = stage.add(&asset, turned, 0);
    stage.scene.set_cache_frames(instance, &[3.7]).unwrap();
    solids.push(("tube bent by a vertex cache".to_owned(), stage));
    solids
}

/// Points to aim from and at.
struct Targets {
    triangles: Vec<Corners>,
    bounds: Aabb,
    /// Inside.
    inner: Vec<[f32; 3]>,
    /// Inside, and on a line along an axis through a vertex or a point of an edge.
    beside_edges: Vec<([f32; 3], usize)>,
}

impl Targets {
    fn new(name: &str, triangles: Vec<Corners>) -> Self {
        let mut random = Rng::with_seed(41);
        let clearance = CLEARANCE * size(&triangles);
        let mut targets = Self {
            bounds: Aabb::around(triangles.as_flattened().iter().copied()),
            triangles,
            inner: Vec::new(),
            beside_edges: Vec::new(),
        };
        let Aabb { min, max } = targets.bounds;
        for round in 0..20_000 {
            if targets.inner.len() == 64 && targets.beside_edges.len() == 64 {
                break;
            }
            let point: [f32; 3] = std::array::from_fn(|k| min[k] + random.f32() * (max[k] - min[k]));
            if targets.inner.len() < 64 && is_inside(&targets.triangles, point, clearance) {
                targets.inner.push(point);
            }
            let (axis, mut beside) = (round % 3, targets.on_surface(&mut random));
            beside[axis] = point[axis];
            if targets.beside_edges.len() < 64 && is_inside(&targets.triangles, beside, clearance) {
                targets.beside_edges.push((beside, axis));
            }
        }
        let found = [targets.inner.len(), targets.beside_edges.len()];
        assert_eq!(found, [64; 2], "{name} is too thin");
        targets
    }

    /// A vertex, or a point of an edge.
    fn on_surface(&self, random: &mut Rng) -> [f32; 3] {
        let corners = &self.triangles[random.usize(..self.triangles.len())];
        let corner = random.usize(..3);
        let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
        let s = [0.0, 0.5, random.f32()][random.usize(..3)];
        std::array::from_fn(|k| a[k] + s * (b[k] - a[k]))
    }

    /// Rays that hit, and as many that hit behind their origin or from outside.
    fn rays(&self, random: &mut Rng) -> [Ray; 2] {
        if random.u32(..4) == 0 {
            let (origin, axis) = self.beside_edges[random.usize(..self.beside_edges.len())];
            let mut direction = [0.0; 3];
            direction[axis] = 1.0;
            return [
                Ray::new(origin, direction),
                Ray::new(origin, direction.map(|d: f32| -d)),
            ];
        }
        let from = self.inner[random.usize(..self.inner.len())];
        let to = self.on_surface(random);
        let direction: [f32; 3] = std::array::from_fn(|k| to[k] - from[k]);
        let outwards = Ray::new(from, direction);
        if random.bool() {
            return [outwards, Ray::new(from, direction.map(|d| -d))];
        }
        let mut factor = 1.5 + random.f32();
        let outside = loop {
            let point: [f32; 3] = std::array::from_fn(|k| from[k] + factor * direction[k]);
            if !self.bounds.contains(point) {
                // As boxes are convex, a quarter further is a quarter of the clearance away from this one.
                break std::array::from_fn(|k| from[k] + 1.25 * factor * direction[k]);
            }
            factor *= 2.0;
        };
        [outwards, Ray::between(outside, from)]
    }
}

/// Traces one task's rays; how many of the hits are on an edge or a corner of their triangle, or the first ray at fault.
fn trace(frame: &Frame, oracle: &Oracle, targets: &Targets, seed: u64) -> Result<usize, String> {
    let mut random = Rng::with_seed(seed);
    let rays: Vec<Ray> = (0..RAYS_PER_TASK / 2).flat_map(|_| targets.rays(&mut random)).collect();
    let mut hits = vec![None; rays.len()];
    frame.closest_hits(&rays, &mut hits);
    for (index, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
        if hit.is_none() {
            return Err(format!("seed {seed}: {ray:?} passes through"));
        }
        if index % COMPARED == 0 && hit_bits(*hit) != hit_bits(oracle.closest_hit(ray)) {
            return Err(format!("seed {seed}: {ray:?} hits {hit:?}, not as by brute force"));
        }
    }
    let on_edge = |hit: &&Hit| hit.u == 0.0 || hit.v == 0.0 || hit.u + hit.v == 1.0;
    Ok(hits.iter().flatten().filter(on_edge).count())
}

#[test]
fn no_ray_passes_through_a_closed_surface() {
    let mut solids = solids();
    let tasks = RAYS / RAYS_PER_TASK / solids.len() + 1;
    for (name, stage) in &mut solids {
        let (frame, oracle, marks) = stage.commit();
        let targets = Targets::new(name, marks.triangles);
        let on_edge = (0..tasks as u64)
            .into_par_iter()
            .map(|seed| trace(&frame, &oracle, &targets, seed))
            .try_reduce(|| 0, |a, b| Ok(a + b))
            .unwrap_or_else(|fault| panic!("{name}, {fault}"));
        let rays = tasks * RAYS_PER_TASK;
        println!("{name}: {rays} rays, {on_edge} of them hit an edge or a vertex bit for bit");
        assert!(on_edge > rays / 20, "{name}: {on_edge} of {rays} rays are on an edge");
    }
}
