use crate::{
    MeasureError, Place, checked_rays::CheckedRays, clock::pose, ray_sums::RaySums, static_twin::StaticTwin, view::View,
};
use rayon::ThreadPool;
use restpose_bake::verify::{Oracle, RayKind, Rays};
use restpose_formats::rows::SampleRow;
use restpose_runtime::{Asset, Frame, FrameStats, InstanceId, Posing, Scene};
use std::sync::Arc;

/// Which rays are traced in a pose, and how often.
pub(crate) struct RaySettings<'a> {
    pub cameras: &'a [Camera],
    /// Pixels of a side of a picture.
    pub picture_side: u32,
    pub random_rays: u32,
    pub repeats: u32,
    pub seed: u64,
    pub pools: &'a [ThreadPool],
}

/// Where camera rays come from.
pub(crate) enum Camera {
    /// From here in every pose.
    Fixed(View),
    /// From where the pose fills the picture.
    Filled,
}

/// One pose, by fuzzy trees and by its static twin.
pub(crate) struct PosedRays {
    /// Per camera.
    pub cameras: Vec<RaySums>,
    pub random: RaySums,
    /// Of the fuzzy trees.
    pub stats: FrameStats,
    /// Building the static tree, one thread.
    pub static_build_seconds: f64,
    /// Sum of the surfaces of the posed triangles' own boxes.
    pub static_box_area: f64,
}

impl PosedRays {
    /// Poses an asset, builds its static twin, and checks, counts and times the rays.
    pub fn measure(
        asset: &Arc<Asset>,
        sample: &SampleRow,
        place: Place,
        settings: &RaySettings,
    ) -> Result<Self, MeasureError> {
        let mut scene = Scene::new();
        let instance = scene.add(asset);
        scene.set_posing(instance, Posing::Remembered)?;
        pose(&mut scene, instance, sample)?;
        let frame = scene.commit();

        let twin = StaticTwin::new(&frame, instance, asset)?;
        let mut twin_scene = Scene::new();
        let twin_instance = twin_scene.add(&twin.asset);
        twin_scene.set_posing(twin_instance, Posing::Remembered)?;
        let frames = [frame, twin_scene.commit()];

        frame.prepare();
        let oracle = Oracle::new(&frame, &[instance]);
        let mut supply = Rays::new(&oracle, settings.seed);
        let random = (0..settings.random_rays).map(|_| supply.ray(RayKind::Random)).collect();
        let random = CheckedRays::new(frames, &oracle, random, place)?;
        let mut out = Self {
            cameras: Vec::with_capacity(settings.cameras.len()),
            random: RaySums::default(),
            stats: frame.stats(),
            static_build_seconds: twin.report.seconds.build,
            static_box_area: twin.report.fuzzy_box_area,
        };
        out.random.add(&random, frames, settings.repeats, settings.pools)?;
        for camera in settings.cameras {
            let rays = match camera {
                Camera::Fixed(view) => view.rays(settings.picture_side),
                Camera::Filled => View::filled_by(&corners(&frame, instance, asset)).rays(settings.picture_side),
            };
            let rays = CheckedRays::new(frames, &oracle, rays, place)?;
            let mut sums = RaySums::default();
            sums.add(&rays, frames, settings.repeats, settings.pools)?;
            out.cameras.push(sums);
        }
        Ok(out)
    }
}

/// The corners of all triangles.
pub(crate) fn corners(frame: &Frame, instance: InstanceId, asset: &Asset) -> Vec<[f32; 3]> {
    let corners = asset.model().triangles.iter().flat_map(|row| row.corners);
    corners.filter_map(|vertex| frame.vertex(instance, vertex)).collect()
}
