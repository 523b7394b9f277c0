//! Frames after the first, and rays, allocate nothing.
#![expect(unsafe_code, reason = "a global allocator that counts is an unsafe trait")]

use restpose_bake::{
    BakeSettings,
    verify::{DrawnPose, PoseSource, Poses},
};
use restpose_formats::Bounds;
use restpose_runtime::{Affine, Asset, Posing, Ray, Scene};
use restpose_tests::{baked_asset, baked_with, sample_scenes};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
    sync::Arc,
};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    /// That were allocated and not yet freed.
    static BYTES: Cell<i64> = const { Cell::new(0) };
}

// SAFETY: every call is passed on to the system allocator unchanged; counting touches no memory that it manages.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        BYTES.with(|bytes| bytes.set(bytes.get() + layout.size() as i64));
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        BYTES.with(|bytes| bytes.set(bytes.get() - layout.size() as i64));
        // SAFETY: `pointer` came from `System` with this layout, as the caller promises of `Counting`.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        BYTES.with(|bytes| bytes.set(bytes.get() + size as i64 - layout.size() as i64));
        // SAFETY: as for `dealloc`, and `size` is the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn frames_and_rays_allocate_nothing_once_warm() {
    let mut outside = 0;
    for path in sample_scenes() {
        let (animation, sampled) = baked_asset(&path);
        let settings = BakeSettings {
            bounds: Bounds::Envelope,
            ..BakeSettings::default()
        };
        let enveloped = baked_with(&animation, &settings);
        for (asset, source, count) in [
            (&sampled, PoseSource::Samples, sampled.model().samples.len() as u64),
            (&enveloped, PoseSource::Clips, 40),
            (&enveloped, PoseSource::Random, 44),
        ] {
            let mut poses = Poses::new(&animation, asset.model(), source, 2, count);
            let poses: Vec<DrawnPose> = (0..count).map(|index| poses.pose(index)).collect();
            outside += assert_allocates_nothing(&format!("{}, {source:?}", path.display()), asset, &poses);
        }
    }
    assert!(outside > 0, "poses outside of their envelopes are among these");
}

/// Returns the clusters that were outside of their pose space.
#[track_caller]
fn assert_allocates_nothing(name: &str, asset: &Arc<Asset>, poses: &[DrawnPose]) -> u32 {
    let mut scene = Scene::new();
    let instances = [scene.add(asset), scene.add(asset)];
    let target = scene.commit().bounds().center();
    let target = [target[0] + 1.0, target[1], target[2]];
    let mut outside = 0;
    // The first lap may grow buffers: a top level of overlapping clusters has more references than a loose one. So may the
    // second: what its first frames expect, and pose at once, comes from the end of the lap before.
    for lap in 0..3 {
        let before = ALLOCATIONS.with(Cell::get);
        let mut hits = 0;
        for (step, pose) in poses.iter().enumerate() {
            for (instance, side) in instances.into_iter().zip([-1.0, 1.0]) {
                scene
                    .set_transform(instance, Affine::from_translation([side, 0.0, 0.0]))
                    .unwrap();
                pose.set(&mut scene, instance).unwrap();
            }
            let frame = scene.commit();
            for ray in 0..20 {
                let x = ray as f32 * 0.1 - 1.0 + step as f32 * 1e-3;
                let ray = Ray::between([target[0] + x, 10.0, 10.0], target);
                hits += u32::from(
                    frame
                        .closest_hit(&Ray {
                            t_max: f32::INFINITY,
                            ..ray
                        })
                        .is_some(),
                );
                hits += u32::from(frame.any_hit(&ray));
            }
            outside += frame.stats().clusters_outside;
        }
        let allocated = ALLOCATIONS.with(Cell::get) - before;
        assert!(hits > 0, "{name}");
        assert!(lap < 2 || allocated == 0, "{name}: {allocated} allocations");
    }
    outside
}

/// An instance that no ray touches is little more than its transform, its clip and its time, in a crowd of any size.
#[test]
fn untouched_instances_are_small() {
    let (_, asset) = baked_asset(&sample_scenes()[0]);
    let before = BYTES.with(Cell::get);
    let mut scene = Scene::new();
    let count = 100_000;
    for place in 0..count {
        let instance = scene.add(&asset);
        let at = Affine::from_translation([(place % 400) as f32 * 3.0, 0.0, (place / 400) as f32 * 3.0]);
        scene.set_transform(instance, at).unwrap();
        scene.play(instance, 0, place as f32 * 0.01).unwrap();
    }
    let frame = scene.commit();
    let ray = Ray::new([600.0, 50.0, 300.0], [0.0, -1.0, 0.0]);
    let _ = frame.closest_hit(&ray);
    assert!(frame.stats().instances_entered < 20, "{:?}", frame.stats());
    let each = (BYTES.with(Cell::get) - before) / count;
    assert!(each < 1024, "{each} bytes an instance");
}

/// One instance in turn has many rays: what is posed for it is posed in the memory of the last.
#[test]
fn memory_of_whole_instances_is_used_again() {
    let (_, asset) = baked_asset(&sample_scenes()[0]);
    let mut scene = Scene::new();
    let instances: Vec<_> = (0..40).map(|_| scene.add(&asset)).collect();
    let mut grown = 0;
    let mut random = fastrand::Rng::with_seed(4);
    for round in 0..200 {
        let before = BYTES.with(Cell::get);
        let chosen = random.usize(..instances.len());
        for (at, instance) in instances.iter().enumerate() {
            let posing = if at == chosen {
                Posing::Whole
            } else {
                Posing::Recomputed
            };
            scene.set_posing(*instance, posing).unwrap();
            scene.play(*instance, 0, round as f32 * 0.01).unwrap();
        }
        let frame = scene.commit();
        let mut order: Vec<usize> = (0..instances.len()).collect();
        random.shuffle(&mut order);
        for at in order {
            let _ = frame.vertex(instances[at], 0);
        }
        let center = frame.bounds().center();
        let ray = Ray::new([center[0] + 0.01, center[1] + 90.0, center[2]], [0.0, -1.0, 0.0]);
        let _ = frame.closest_hit(&ray);
        assert_eq!(frame.stats().instances_whole, 1);
        if round > 0 {
            grown += BYTES.with(Cell::get) - before;
        }
    }
    let whole = 12 * asset.model().vertices.len() as i64;
    assert!(
        grown < whole,
        "{grown} bytes in 200 frames, {whole} for positions alone"
    );
}
