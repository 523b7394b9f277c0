//! How precise `t`, barycentric coordinates and posed vertices are, measured against `f64`, and the bounds that the tables
//! of `EXTREMES.md` state. With `--nocapture` the tests print those tables.
//!
//! `f64` stands for exact numbers here: differences of the `f32` coordinates in question are exact in it, and what it
//! rounds is 2²⁹ times less than what is measured.

#![expect(
    clippy::print_stdout,
    reason = "what was measured is printed for whoever asks with --nocapture"
)]

use fastrand::Rng;
use nalgebra::Vector3;
use restpose_formats::geom::round::UNIT_ROUNDOFF;
use restpose_runtime::{Affine, Hit, Ray, triangle::VERTEX_ERROR};
use restpose_samples::surface::Surface;
use restpose_tests::{MeshRecipe, Stage, baked_animation, inside::Corners, jointed_mesh, tube};

type Vector = Vector3<f64>;

const RAYS: usize = 15_000;

/// Covers what `f64` rounds in the bounds and in the reference.
const F64_SLACK: f64 = 1.0 + 1e-6;

fn vector(point: [f32; 3]) -> Vector {
    point.map(f64::from).into()
}

/// A hit's errors and their bounds: of the hit's place along the ray in lengths, and of a barycentric coordinate.
#[derive(Clone, Copy, Default)]
struct Errors {
    along: f64,
    along_bound: f64,
    weight: f64,
    weight_bound: f64,
}

impl Errors {
    /// A hit is exact for corners moved by up to `VERTEX_ERROR`·D per axis, D the greatest distance per axis from the
    /// origin to a corner, but for the last rounding. That moves the plane by √3 times as much, and the ray meets it
    /// 1/cos θ times that sooner or later. Weights change by what the hit point moves in the plane over the height of
    /// the triangle.
    fn of(ray: &Ray, corners: &Corners, hit: &Hit) -> Self {
        let [a, b, c] = corners.map(|corner| vector(corner) - vector(ray.origin));
        let direction = vector(ray.direction);
        let normal = (b - a).cross(&(c - a));
        let (length, area) = (direction.norm(), normal.norm());
        let t = normal.dot(&a) / normal.dot(&direction);
        let point = direction * t - a;
        let weights = [
            point.cross(&(c - a)).dot(&normal) / (area * area),
            (b - a).cross(&point).dot(&normal) / (area * area),
        ];

        let cosine = normal.dot(&direction).abs() / (area * length);
        let moved = 3f64.sqrt() * VERTEX_ERROR * a.amax().max(b.amax()).max(c.amax());
        let found = f64::from(hit.t);
        let height = area / (b - a).norm().max((c - a).norm());
        Self {
            along: (found - t).abs() * length,
            along_bound: (moved / cosine + UNIT_ROUNDOFF * found.abs() * length) * F64_SLACK,
            weight: (f64::from(hit.u) - weights[0])
                .abs()
                .max((f64::from(hit.v) - weights[1]).abs()),
            weight_bound: (moved * (1.0 / cosine + 1.0) / height + UNIT_ROUNDOFF) * F64_SLACK,
        }
    }

    fn max(self, other: Self) -> Self {
        Self {
            along: self.along.max(other.along),
            along_bound: self.along_bound.max(other.along_bound),
            weight: self.weight.max(other.weight),
            weight_bound: self.weight_bound.max(other.weight_bound),
        }
    }
}

/// Rays of a given distance and angle at random points of a triangle: the greatest errors of those that hit, and their
/// count. Lengths are in units of the model.
fn measure(stage: &mut Stage, unit: f64, distance: f64, cosine: f64) -> (Errors, usize) {
    let (frame, oracle, marks) = stage.commit();
    let corners = marks.triangles[0];
    let [a, b, c] = corners.map(vector);
    let normal = (b - a).cross(&(c - a)).normalize();
    let mut random = Rng::with_seed(81);
    let (mut worst, mut hits) = (Errors::default(), 0);
    for round in 0..RAYS {
        let (s, t) = (random.f64(), random.f64());
        let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
        let point = a + (b - a) * s + (c - a) * t;
        let turn = random.f64() * std::f64::consts::TAU;
        let first = (b - a).normalize();
        let beside = first * turn.cos() + normal.cross(&first) * turn.sin();
        let direction = -normal * cosine + beside * (1.0 - cosine * cosine).sqrt();
        let origin = point - direction * (distance * unit);
        let direction = if round % 2 == 0 { direction } else { direction * unit };
        let ray = Ray::new(origin.map(|x| x as f32).into(), direction.map(|x| x as f32).into());
        let Some(hit) = frame.closest_hit(&ray) else { continue };
        assert_eq!(Some(hit), oracle.closest_hit(&ray));
        let errors = Errors::of(&ray, &corners, &hit);
        assert!(
            errors.along <= errors.along_bound && errors.weight <= errors.weight_bound,
            "{unit}, {distance}, {cosine}: {ray:?} {hit:?}: {} of {}, {} of {}",
            errors.along,
            errors.along_bound,
            errors.weight,
            errors.weight_bound
        );
        hits += 1;
        worst = worst.max(errors);
    }
    let lengths = Errors {
        along: worst.along / unit,
        along_bound: worst.along_bound / unit,
        ..worst
    };
    (lengths, hits)
}

#[test]
fn hits_are_as_precise_as_documented() {
    let mut surface = Surface::default();
    let corners = [[-0.51, -0.37, 0.11], [0.49, -0.29, -0.23], [0.07, 0.53, 0.31]];
    surface.triangles = vec![corners.map(|p| surface.push(p.into()))];
    println!("| distance | cos θ | hit point | bound | barycentric | bound |\n|---|---|---|---|---|---|");
    for distance in [1.0, 1e3, 1e6] {
        for cosine in [1.0, 0.1, 1e-2, 1e-3] {
            let (mut worst, mut most_hits) = (Errors::default(), 0);
            for exponent in (-30..=30).step_by(15) {
                let scale = 10f64.powi(exponent);
                let recipe = MeshRecipe {
                    scale,
                    ..MeshRecipe::new(&surface, 0)
                };
                let mut stage = Stage::with(&baked_animation(&jointed_mesh(&recipe)), Affine::IDENTITY, 0);
                let (errors, hits) = measure(&mut stage, scale, distance, cosine);
                worst = worst.max(errors);
                most_hits = most_hits.max(hits);
                assert!(hits > 10, "1e{exponent}, {distance}, {cosine}: {hits} hits");
            }
            println!(
                "| {distance:e} | {cosine} | {:.1e} | {:.1e} | {:.1e} | {:.1e} |",
                worst.along, worst.along_bound, worst.weight, worst.weight_bound
            );
        }
    }
}

/// Roundings of the vertex function with two influences and no morphs, and of the palette entries.
const VERTEX_ROUNDINGS: f64 = 9.0;

/// Posed vertices of a bent tube, one unit long, so far from the world's origin.
#[test]
fn vertices_are_as_precise_as_documented() {
    let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&tube(), 4)));
    let model = asset.model();
    println!("| distance | vertex | bound |\n|---|---|---|");
    for distance in [0.0f32, 1.0, 1e3, 1e6, 1e9] {
        let transform = Affine::from_translation([distance, -0.7 * distance, 0.3 * distance]);
        let mut stage = Stage::default();
        let instance = stage.add(&asset, transform, 3);
        let palette = stage.scene.pose(instance).unwrap().palette;
        let (frame, ..) = stage.commit();
        let (mut worst, mut worst_bound) = (0.0f64, 0.0f64);
        for vertex in 0..model.vertices.len() - 1 {
            let p = vector(model.vertices[vertex].position_rest);
            let (mut exact, mut reach) = (vector(transform.columns[3]), Vector::zeros());
            for influence in model.influences_of(vertex) {
                let [x, y, z, w] = palette[influence.bone as usize].columns.map(vector);
                let weight = f64::from(influence.weight);
                exact += (x * p.x + y * p.y + z * p.z + w) * weight;
                let moved = x.abs() * p.x.abs() + y.abs() * p.y.abs() + z.abs() * p.z.abs();
                reach += (moved + (w + vector(transform.columns[3])).abs()) * weight;
            }
            let posed = vector(frame.vertex(instance, vertex as u32).unwrap());
            for k in 0..3 {
                let bound = VERTEX_ROUNDINGS * UNIT_ROUNDOFF * reach[k] * F64_SLACK;
                let error = (posed[k] - exact[k]).abs();
                assert!(error <= bound, "{distance}, vertex {vertex}: {error} of {bound}");
                worst = worst.max(error);
                worst_bound = worst_bound.max(bound);
            }
        }
        println!("| {distance:e} | {worst:.1e} | {worst_bound:.1e} |");
    }
}
