//! Batches, whose coherent rays go together, answer each ray as if it were alone.

use restpose_bake::{
    BakeSettings, MotionClass,
    import::{ImportSettings, import, import_files},
    subdivide::subdivide,
    verify::{Oracle, Rays},
};
use restpose_formats::TreeKind;
use restpose_runtime::{Affine, Asset, Frame, InstanceId, Posing, Ray, Scene};
use restpose_tests::{baked_with, hit_bits, sample_scenes};
use std::{path::Path, sync::Arc, time::Duration};

/// Rays of a camera in tiles of eight by eight, as pictures should be traced: coherent but for those near its axes.
fn camera(frame: &Frame, side: usize, from: [f32; 3]) -> Vec<Ray> {
    let bounds = frame.bounds();
    let center = bounds.center();
    let reach = (0..3).fold(0.0f32, |most, k| most.max(bounds.max[k] - bounds.min[k]));
    let origin = std::array::from_fn(|k| center[k] + from[k] * reach);
    (0..side * side)
        .map(|index| {
            let (tile, place) = (index / 64, index % 64);
            let tiles = side / 8;
            let x = (tile % tiles * 8 + place % 8) as f32 / side as f32 - 0.5;
            let y = (tile / tiles * 8 + place / 8) as f32 / side as f32 - 0.5;
            let target = [center[0] + x * reach, center[1] + y * reach, center[2] + x * y * reach];
            Ray::new(origin, std::array::from_fn(|k| target[k] - origin[k]))
        })
        .collect()
}

/// Parallel rays along an axis, in tiles: as of an orthographic camera, or of the sun at noon.
fn parallel(frame: &Frame, side: usize, axis: usize, sign: f32) -> Vec<Ray> {
    let bounds = frame.bounds();
    (0..side * side)
        .map(|index| {
            let (tile, place, tiles) = (index / 64, index % 64, side / 8);
            let across = [
                (tile % tiles * 8 + place % 8) as f32 / side as f32,
                (tile / tiles * 8 + place / 8) as f32 / side as f32,
            ];
            let mut origin = [0.0; 3];
            for (step, part) in (1..).zip(across) {
                let k = (axis + step) % 3;
                origin[k] = bounds.min[k] + part * (bounds.max[k] - bounds.min[k]);
            }
            origin[axis] = if sign > 0.0 {
                bounds.min[axis] - 1.0
            } else {
                bounds.max[axis] + 1.0
            };
            let mut direction = [0.0, -0.0, 0.0];
            direction[axis] = sign;
            Ray::new(origin, direction)
        })
        .collect()
}

fn assert_alike(name: &str, frame: &Frame, rays: &[Ray]) -> usize {
    let alone: Vec<_> = rays.iter().map(|ray| frame.closest_hit(ray)).collect();
    let mut hits = vec![None; rays.len()];
    frame.closest_hits(rays, &mut hits);
    let mut any = vec![false; rays.len()];
    frame.any_hits(rays, &mut any);
    for (place, ray) in rays.iter().enumerate() {
        assert_eq!(hits[place], alone[place], "{name}: {ray:?}");
        assert_eq!(any[place], alone[place].is_some(), "{name}: {ray:?}");
    }
    alone.iter().flatten().count()
}

#[test]
fn batches_answer_what_single_rays_do() {
    let mut hits = 0;
    let scenes = sample_scenes();
    let trees = scenes
        .iter()
        .flat_map(|path| [TreeKind::Wide, TreeKind::Kd].map(|tree| (path, tree)));
    for (index, (path, tree)) in trees.enumerate() {
        let settings = BakeSettings {
            tree,
            ..BakeSettings::default()
        };
        let asset = baked_with(&import(path).unwrap().animation, &settings);
        for posing in [Posing::Whole, Posing::Chosen] {
            let mut scene = Scene::new();
            let instances: Vec<InstanceId> = (0..3).map(|_| scene.add(&asset)).collect();
            let ground = scene.add_geometry();
            scene
                .set_geometry(
                    ground,
                    &[[-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.1, 9.0]],
                    &[[0, 1, 2]],
                )
                .unwrap();
            for (at, instance) in (0..).zip(&instances) {
                let shift = Affine::from_translation([at as f32 * 0.7, 0.0, at as f32 * -0.3]);
                scene.set_transform(*instance, shift).unwrap();
                // Whole ones beside such whose rays go one by one.
                let own = if at == 1 { Posing::Recomputed } else { posing };
                scene.set_posing(*instance, own).unwrap();
                if !asset.model().clips.is_empty() {
                    scene.play(*instance, 0, at as f32 * 0.37).unwrap();
                }
            }
            let frame = scene.commit();
            let name = format!("{}, {tree:?}, {posing:?}", path.display());
            for from in [[0.1, 0.2, 1.4], [-1.0, 0.6, 0.3], [0.0, 0.1, 0.2]] {
                hits += assert_alike(&name, &frame, &camera(&frame, 48, from));
            }
            for axis in 0..3 {
                for sign in [1.0, -0.5] {
                    hits += assert_alike(&name, &frame, &parallel(&frame, 32, axis, sign));
                }
            }
            let oracle = Oracle::new(&frame, &instances);
            let mixed: Vec<Ray> = Rays::new(&oracle, index as u64).take(700).collect();
            hits += assert_alike(&name, &frame, &mixed);
            // Ranges, and rays that can hit nothing, among coherent ones.
            let mut cut = camera(&frame, 16, [0.3, 0.4, 1.0]);
            for (at, ray) in cut.iter_mut().enumerate() {
                ray.t_max = if at % 3 == 0 { 1.0 } else { f32::INFINITY };
                ray.t_min = if at % 5 == 0 { 0.9 } else { 0.0 };
                if at % 50 == 7 {
                    ray.direction = [f32::NAN; 3];
                }
            }
            assert_alike(&name, &frame, &cut);
        }
    }
    assert!(hits > 5_000, "{hits}");
}

/// Many rays through many instances: rays with ends and without, that overlap hundreds of boxes, that hit nothing.
#[test]
fn rays_through_crowds_answer_what_single_rays_do() {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    let asset = baked_with(&import(&path).unwrap().animation, &BakeSettings::default());
    // Apart, touching, and all but on top of each other: there a ray's way is too long to be listed.
    let mut hits = 0;
    for (spacing, seed) in [(1.5, 1), (0.4, 2), (0.01, 3)] {
        let mut scene = Scene::new();
        let instances: Vec<InstanceId> = (0..90).map(|_| scene.add(&asset)).collect();
        for (at, instance) in (0..).zip(&instances) {
            let (row, column) = (at / 10, at % 10);
            let place = Affine::from_translation([column as f32 * spacing, 0.0, row as f32 * spacing]);
            scene.set_transform(*instance, place).unwrap();
            scene.play(*instance, 0, at as f32 * 0.11).unwrap();
        }
        // Gaps in the slots.
        scene.remove(instances[13]).unwrap();
        scene.remove(instances[57]).unwrap();
        let instances: Vec<InstanceId> = instances.into_iter().filter(|own| scene.state(*own).is_ok()).collect();
        let frame = scene.commit();
        let oracle = Oracle::new(&frame, &instances);
        let mut rays: Vec<Ray> = Rays::new(&oracle, seed).take(1_500).collect();
        for (at, ray) in rays.iter_mut().enumerate() {
            match at % 7 {
                0 => ray.t_max = 0.8,
                1 => ray.t_min = 1.2,
                2 if at % 5 == 0 => ray.direction = [0.0; 3],
                _ => {}
            }
        }
        hits += assert_alike(&format!("spacing {spacing}"), &frame, &rays);
    }
    assert!(hits > 1_000, "{hits}");
}

/// Rays that run the same way along each axis but begin anywhere: not bundles, whatever their signs say.
#[test]
fn rays_that_are_far_apart_answer_what_single_rays_do() {
    let mut random = fastrand::Rng::with_seed(31);
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    let mut animation = subdivide(&import(&path).unwrap().animation, 2);
    // One triangle so far away that bundles look narrow beside the mesh.
    let primitive = &mut animation.meshes[0].primitives[0];
    for corner in 0..3u8 {
        let vertex = primitive.positions.len() as u32;
        primitive
            .positions
            .push([100.0, 100.0 + f32::from(corner % 2), 100.0 + f32::from(corner / 2)]);
        primitive.influences.push(primitive.influences[0].clone());
        if corner == 2 {
            primitive.triangles.push([vertex - 2, vertex - 1, vertex]);
        }
    }
    let asset = baked_with(&animation, &BakeSettings::default());
    let mut hits = 0;
    for posing in [Posing::Whole, Posing::Recomputed] {
        let mut scene = Scene::new();
        let walker = scene.add(&asset);
        scene.set_posing(walker, posing).unwrap();
        scene.play(walker, 0, 0.4).unwrap();
        let frame = scene.commit();
        for spread in [0.0, 0.05, 0.9] {
            let rays: Vec<Ray> = (0..2_000)
                .map(|_| {
                    let origin = [-2.0, -0.5, -1.0].map(|low: f32| low + random.f32() * 2.0);
                    let direction = [0.9, 0.4, 0.3].map(|along| along + spread * (random.f32() - 0.3));
                    Ray::new(origin, direction)
                })
                .collect();
            hits += assert_alike(&format!("{posing:?}, {spread}"), &frame, &rays);
        }
    }
    assert!(hits > 2_000, "{hits}");
}

/// More rays than are sorted at once.
#[test]
fn large_batches_answer_what_single_rays_do() {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    let asset = baked_with(&import(&path).unwrap().animation, &BakeSettings::default());
    let mut scene = Scene::new();
    scene.add(&asset);
    let frame = scene.commit();
    let bounds = frame.bounds();
    let mut random = fastrand::Rng::with_seed(41);
    let mut point =
        || std::array::from_fn(|k| bounds.min[k] + (bounds.max[k] - bounds.min[k]) * (3.0 * random.f32() - 1.0));
    let rays: Vec<Ray> = (0..(1 << 18) + 100).map(|_| Ray::between(point(), point())).collect();
    let hits = assert_alike("large", &frame, &rays);
    assert!(hits > 1_000, "{hits}");
}

/// Bundles count what they cost an instance: few do not make the runtime pose all of it, many do.
#[test]
fn many_bundles_are_worth_posing_all_of_an_instance() {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    let animation = subdivide(&import(&path).unwrap().animation, 2);
    let asset = baked_with(&animation, &BakeSettings::default());
    for (side, whole) in [(64, 0), (1024, 1)] {
        let mut scene = Scene::new();
        let walker = scene.add(&asset);
        scene.play(walker, 0, 0.4).unwrap();
        let frame = scene.commit();
        let rays = camera(&frame, side, [0.3, 0.4, 1.2]);
        let mut hits = vec![None; rays.len()];
        frame.closest_hits(&rays, &mut hits);
        assert!(hits.iter().flatten().count() > rays.len() / 50);
        assert_eq!(frame.stats().instances_whole, whole, "{side}");
    }
}

/// The bundled vase, in free motion.
fn free_vase() -> Arc<Asset> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    let files = ["shatter.obj", "shatter.pc2"].map(|name| folder.join(name));
    let animation = import_files(&files, &ImportSettings::default()).unwrap().animation;
    let settings = BakeSettings {
        class_overrides: [("vase".into(), MotionClass::Free)].into_iter().collect(),
        ..BakeSettings::default()
    };
    baked_with(&animation, &settings)
}

/// Compares a batch with single rays, and some of these with brute force.
fn assert_exact(name: &str, frame: &Frame, instance: InstanceId) {
    let oracle = Oracle::new(frame, &[instance]);
    let mut rays = camera(frame, 104, [0.1, 0.2, 1.4]);
    rays.extend(Rays::new(&oracle, 1).take(2_000));
    let hits = assert_alike(name, frame, &rays);
    assert!(hits > 1_000, "{name}: {hits}");
    for ray in rays.iter().step_by(71) {
        assert_eq!(
            hit_bits(frame.closest_hit(ray)),
            hit_bits(oracle.closest_hit(ray)),
            "{name}: {ray:?}"
        );
    }
}

/// Each pose has another tree over the same triangles.
#[test]
fn batches_meet_free_motion_and_supplied_geometry_in_every_pose() {
    let asset = free_vase();
    let triangles: Vec<[u32; 3]> = asset.model().triangles.iter().map(|row| row.corners).collect();
    for posing in [Posing::Recomputed, Posing::Whole, Posing::Chosen] {
        let (mut scene, mut supplied) = (Scene::new(), Scene::new());
        let vase = scene.add(&asset);
        let rubble = supplied.add_geometry();
        scene.set_posing(vase, posing).unwrap();
        // What overflows, all above a height of 0.14, is in no tree, and in the next one again.
        scene.play(vase, 0, 0.0).unwrap();
        let overflow = Affine {
            columns: [[3e38, 0.0, 0.0], [0.0, 3e38, 0.0], [0.0, 0.0, 3e38], [0.0, 3e38, 0.0]],
        };
        scene.set_transform(vase, overflow).unwrap();
        let frame = scene.commit();
        assert!(frame.bounds().max[1].is_finite());
        let center = frame.bounds().center();
        let _ = frame.closest_hit(&Ray::new([center[0], center[1], f32::MIN], [0.0, 0.0, 1.0]));
        assert!(posing != Posing::Whole || frame.stats().instances_whole == 1);
        scene.set_transform(vase, Affine::IDENTITY).unwrap();
        for time in [0.0, 0.31, 0.72, 0.74] {
            scene.play(vase, 0, time).unwrap();
            let frame = scene.commit();
            assert_exact(&format!("{posing:?} at {time}"), &frame, vase);
            let mut vertices = Vec::new();
            frame.vertices(vase, &mut vertices).unwrap();
            supplied.set_geometry(rubble, &vertices, &triangles).unwrap();
            assert_exact(&format!("supplied at {time}"), &supplied.commit(), rubble);
        }
    }
}

/// Almost parallel, through half of the box: narrow enough for the scene's tree, which has one node, and not for one of more than
/// ten thousand.
#[test]
fn bundles_that_are_too_broad_for_supplied_geometry_go_one_by_one() {
    let mut random = fastrand::Rng::with_seed(4);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for first in (0..60_000u32).map(|triangle| 3 * triangle) {
        let center: [f32; 3] = std::array::from_fn(|_| random.f32());
        positions.extend((0..3).map(|_| center.map(|x| x + 0.02 * random.f32())));
        triangles.push([first, first + 1, first + 2]);
    }
    let mut scene = Scene::new();
    let rubble = scene.add_geometry();
    scene.set_geometry(rubble, &positions, &triangles).unwrap();
    let frame = scene.commit();
    // So many that the wide tree pays.
    let mut hits = vec![None; 128 * 128];
    frame.closest_hits(&camera(&frame, 128, [0.1, 0.2, 1.4]), &mut hits);
    let mut found = 0;
    for _ in 0..20 {
        let broad: [Ray; 64] = std::array::from_fn(|_| {
            let direction = [0.001, 0.002, 1.0 + 0.001 * random.f32()];
            Ray::new([0.72 * random.f32(), 0.72 * random.f32(), -1.0], direction)
        });
        found += assert_alike("broad", &frame, &broad);
    }
    assert!(found > 600, "{found}");
}

/// Making a wide tree takes tasks of other threads, whose rays must not wait for it.
#[test]
fn threads_that_make_a_tree_do_not_wait_for_each_other() {
    let (done, is_done) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let asset = free_vase();
        let triangles: Vec<[u32; 3]> = asset.model().triangles.iter().map(|row| row.corners).collect();
        let mut scene = Scene::new();
        let vase = scene.add(&asset);
        scene.play(vase, 0, 0.72).unwrap();
        let frame = scene.commit();
        let mut vertices = Vec::new();
        frame.vertices(vase, &mut vertices).unwrap();
        let oracle = Oracle::new(&frame, &[vase]);
        let rays: Vec<Ray> = Rays::new(&oracle, 2).take(20_000).collect();
        let alone: Vec<bool> = rays.iter().map(|ray| frame.any_hit(ray)).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(6).build().unwrap();
        for _ in 0..40 {
            let mut scene = Scene::new();
            let rubble = scene.add_geometry();
            scene.set_geometry(rubble, &vertices, &triangles).unwrap();
            let frame = scene.commit();
            let mut any = vec![false; rays.len()];
            // A thread outside of the pool traces the same frame.
            std::thread::scope(|scope| {
                scope.spawn(|| rays.iter().rev().filter(|ray| frame.any_hit(ray)).count());
                pool.install(|| frame.any_hits(&rays, &mut any));
            });
            assert_eq!(any, alone);
        }
        done.send(()).unwrap();
    });
    // It takes a few seconds.
    is_done
        .recv_timeout(Duration::from_secs(300))
        .expect("no thread waits for ever, none fails");
}
