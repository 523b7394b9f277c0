use crate::{
    MeasureError, Place, checked_rays::CheckedRays, clock::pose, ray_sums::RaySums, static_twin::StaticTwin, view::View,
};
use rayon::ThreadPool;
use restpose_bake::verify::{Oracle, RayKind, Rays};
use restpose_formats::rows::SampleRow;
use restpose_runtime::{Asset, FrameStats, Scene};
use std::sync::Arc;

/// Which rays are traced in a pose, and how often.
pub(crate) struct RaySettings<'a> {
    pub view: &'a View,
    /// Pixels of a side of the picture.
    pub picture_side: u32,
    pub random_rays: u32,
    pub repeats: u32,
    pub seed: u64,
    pub pools: &'a [ThreadPool],
}

/// One pose, by fuzzy trees and by its static twin.
pub(crate) struct PosedRays {
    pub primary: RaySums,
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
        pose(&mut scene, instance, sample)?;
        let frame = scene.commit();

        let twin = StaticTwin::new(&frame, instance, asset)?;
        let mut twin_scene = Scene::new();
        twin_scene.add(&twin.asset);
        let frames = [frame, twin_scene.commit()];

        let oracle = Oracle::new(&frame, &[instance]);
        let mut supply = Rays::new(&oracle, settings.seed);
        let random = (0..settings.random_rays).map(|_| supply.ray(RayKind::Random)).collect();
        let random = CheckedRays::new(frames, &oracle, random, place)?;
        let primary = CheckedRays::new(frames, &oracle, settings.view.rays(settings.picture_side), place)?;

        let mut out = Self {
            primary: RaySums::default(),
            random: RaySums::default(),
            stats: *frame.stats(),
            static_build_seconds: twin.report.seconds.build,
            static_box_area: twin.report.fuzzy_box_area,
        };
        out.primary.add(&primary, frames, settings.repeats, settings.pools)?;
        out.random.add(&random, frames, settings.repeats, settings.pools)?;
        Ok(out)
    }
}
