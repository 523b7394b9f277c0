use super::{
    camera::{Camera, Lens},
    canvas::Canvas,
    colour::Colour,
    corner_fans::CornerFans,
    heat_map::{heat, scale_end},
    legend,
    movement::Movement,
    sampling,
    shading::{Shading, area_normals},
    surroundings::Surroundings,
    triangle_colours, wire_boxes,
};
use crate::args::{SamplesPerPixel, Size, Vector, View};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use restpose_formats::geom::Aabb;
use restpose_runtime::{Asset, Frame, InstanceId, PoseError, Posing, Ray, Scene, TraceCounters};
use std::sync::Arc;

/// The heat map's scale is found from every fourth pixel, both ways.
const SCALE_STRIDE: u32 = 4;
/// One in this many of the hottest pixels may lie beyond the scale's end.
const SCALE_IGNORED: usize = 500;

/// How pictures are to look.
#[derive(Clone, Debug)]
pub struct Look {
    pub view: View,
    pub size: Size,
    pub samples: SamplesPerPixel,
    /// Direction towards the light, world space.
    pub light: Vector,
    pub floor: bool,
    pub camera: CameraPlace,
    /// Vertical angle of view.
    pub fov_deg: f64,
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug)]
pub enum CameraPlace {
    /// At a point, looking at another, or at the middle of the clip.
    At { place: Vector, target: Option<Vector> },
    /// As far away as is needed to see the whole clip.
    Framing {
        yaw_deg: f64,
        pitch_deg: f64,
        target: Option<Vector>,
    },
}

impl CameraPlace {
    /// Angles of the automatic camera: a little from the side and from above.
    pub const DEFAULT_YAW_DEG: f64 = 35.0;
    pub const DEFAULT_PITCH_DEG: f64 = 14.0;
    /// Vertical angle of view: a long lens, as for portraits.
    pub const DEFAULT_FOV_DEG: f64 = 35.0;

    /// The automatic camera.
    pub const DEFAULT: Self = Self::Framing {
        yaw_deg: Self::DEFAULT_YAW_DEG,
        pitch_deg: Self::DEFAULT_PITCH_DEG,
        target: None,
    };
}

/// Takes pictures of one asset as it moves.
pub struct Film<'a> {
    movement: &'a Movement,
    scene: Scene,
    instance: InstanceId,
    studio: Studio<'a>,
}

/// What stays the same from frame to frame.
struct Studio<'a> {
    asset: &'a Asset,
    look: &'a Look,
    camera: Camera,
    around: Surroundings,
    fans: CornerFans,
    /// Per triangle, by part.
    part_colours: Vec<Colour>,
    /// Per cluster row.
    cluster_colours: Vec<Colour>,
    /// In each pixel.
    places: Vec<[f64; 2]>,
    /// Work per ray at the end of the heat map's scale.
    heat_end: u32,
}

impl<'a> Film<'a> {
    /// Sets camera, floor and scale up so that they fit every frame of the movement.
    pub fn new(asset: &'a Arc<Asset>, movement: &'a Movement, look: &'a Look) -> Result<Self, PoseError> {
        let model = asset.model();
        let mut scene = Scene::new();
        let instance = scene.add(asset);
        if look.view == View::Steps {
            // What a ray costs is not to depend on those that came before it.
            scene.set_posing(instance, Posing::Recomputed)?;
        }
        let mut used: Vec<u32> = model.triangles.iter().flat_map(|row| row.corners).collect();
        used.sort_unstable();
        used.dedup();
        let bounds = movement.bounds(&mut scene, instance, &used)?;
        // Nothing to see is still a picture: of the sky.
        let bounds = if bounds.is_empty() {
            Aabb {
                min: [-1.0; 3],
                max: [1.0; 3],
            }
        } else {
            bounds
        };
        let studio = Studio {
            asset,
            look,
            camera: camera(look, &bounds),
            around: Surroundings::new(look.light.0.into(), &bounds, look.floor),
            fans: CornerFans::new(model),
            part_colours: triangle_colours::by_part(model),
            cluster_colours: triangle_colours::of_clusters(model),
            places: sampling::places(look.samples.side()),
            heat_end: 0,
        };
        let mut film = Self {
            movement,
            scene,
            instance,
            studio,
        };
        if look.view == View::Steps {
            film.studio.heat_end = film.heat_end()?;
        }
        Ok(film)
    }

    /// Number of frames.
    pub fn frame_count(&self) -> usize {
        self.movement.times.len()
    }

    /// The picture at frame `index`: three bytes per pixel, row by row from the top.
    pub fn picture(&mut self, index: usize) -> Result<Vec<u8>, PoseError> {
        self.movement.pose(&mut self.scene, self.instance, index)?;
        let frame = self.scene.commit();
        let studio = &self.studio;
        let canvas = match studio.look.view {
            View::Steps => studio.heat_map(&frame),
            View::Shaded => studio.shaded(&frame, self.instance, &studio.part_colours),
            View::Clusters => {
                let active = frame.clusters().map(|cluster| cluster.cluster);
                let colours = triangle_colours::by_cluster(studio.asset.model(), &studio.cluster_colours, active);
                studio.shaded(&frame, self.instance, &colours)
            }
            View::Boxes => {
                let mut canvas = studio.shaded(&frame, self.instance, &studio.part_colours);
                studio.draw_boxes(&mut canvas, &frame);
                canvas
            }
        };
        Ok(canvas.to_rgb())
    }

    fn heat_end(&mut self) -> Result<u32, PoseError> {
        let mut all = Vec::new();
        for index in 0..self.frame_count() {
            self.movement.pose(&mut self.scene, self.instance, index)?;
            all.extend(self.studio.sampled_work(&self.scene.commit()));
        }
        Ok(scale_end(all, SCALE_IGNORED))
    }
}

impl Studio<'_> {
    /// `colours` are those of the triangles.
    fn shaded(&self, frame: &Frame<'_>, instance: InstanceId, colours: &[Colour]) -> Canvas {
        let triangle_count = self.asset.model().triangles.len() as u32;
        let normals = area_normals(frame, instance, triangle_count);
        let shading = Shading::new(*frame, &self.fans, &self.around, &normals);
        self.canvas(|x, y| {
            let mut sum = Colour::ZERO;
            let mut depth = f32::INFINITY;
            for ray in self.rays(x, y) {
                sum += match frame.closest_hit(&ray) {
                    Some(hit) => {
                        depth = depth.min(self.camera.depth_on(&ray, hit.t) as f32);
                        let own = colours.get(hit.triangle as usize).copied().unwrap_or(Colour::ONE);
                        shading.surface(&ray, &hit, own)
                    }
                    None => shading.background(&ray),
                };
            }
            (sum / self.places.len() as f32, depth)
        })
    }

    fn heat_map(&self, frame: &Frame<'_>) -> Canvas {
        let full = self.heat_end as f32 * self.places.len() as f32;
        let mut canvas = self.canvas(|x, y| {
            let sum: u64 = self.rays(x, y).map(|ray| work(frame, &ray)).sum();
            (heat(sum as f32 / full), f32::INFINITY)
        });
        legend::draw(&mut canvas, self.heat_end);
        canvas
    }

    fn draw_boxes(&self, canvas: &mut Canvas, frame: &Frame<'_>) {
        let thickness = (f64::from(self.look.size.height) / 400.0).max(1.0);
        for cluster in frame.clusters() {
            let number = cluster.cluster as usize;
            let colour = self.cluster_colours.get(number).copied().unwrap_or(Colour::ONE);
            wire_boxes::draw(canvas, &self.camera, &cluster.bounds_world, thickness, colour);
        }
    }

    /// Work of some of the pixels' rays, without those that miss everything at once: there are so many that they would
    /// hide the rest.
    fn sampled_work(&self, frame: &Frame<'_>) -> Vec<u32> {
        let Size { width, height } = self.look.size;
        let (columns, rows) = (width.div_ceil(SCALE_STRIDE), height.div_ceil(SCALE_STRIDE));
        let middle = |i: u32| f64::from(i * SCALE_STRIDE) + 0.5;
        let work = |i: u32| work(frame, &self.camera.ray(middle(i % columns), middle(i / columns)));
        (0..columns * rows)
            .into_par_iter()
            .with_min_len(64)
            .map(|i| u32::try_from(work(i)).unwrap_or(u32::MAX))
            .filter(|work| *work > 1)
            .collect()
    }

    fn rays(&self, x: u32, y: u32) -> impl Iterator<Item = Ray> {
        self.places
            .iter()
            .map(move |[dx, dy]| self.camera.ray(f64::from(x) + dx, f64::from(y) + dy))
    }

    fn canvas(&self, pixel: impl Fn(u32, u32) -> (Colour, f32) + Sync) -> Canvas {
        let Size { width, height } = self.look.size;
        let (colours, depths) = (0..width * height)
            .into_par_iter()
            .with_min_len(64)
            .map(|i| pixel(i % width, i / width))
            .unzip();
        Canvas::new(width, colours, depths)
    }
}

fn camera(look: &Look, bounds: &Aabb) -> Camera {
    let lens = Lens {
        fov_deg: look.fov_deg,
        width: look.size.width,
        height: look.size.height,
    };
    let point = |vector: Vector| DVec3::from(vector.0);
    match look.camera {
        CameraPlace::At { place, target } => {
            let middle = Vec3::from(bounds.center()).as_dvec3();
            Camera::looking_at(point(place), target.map_or(middle, point), lens)
        }
        CameraPlace::Framing {
            yaw_deg,
            pitch_deg,
            target,
        } => Camera::framing(bounds, yaw_deg, pitch_deg, target.map(point), lens),
    }
}

fn work(frame: &Frame<'_>, ray: &Ray) -> u64 {
    let mut counters = TraceCounters::default();
    // What it costs is asked, not what is hit.
    let _ = frame.closest_hit_counted(ray, &mut counters);
    counters.steps + counters.box_tests + counters.triangle_tests
}
