//! Instances are prepared by the rays that enter them: in any order, from many threads, between any changes.

use restpose_bake::{
    BakeSettings,
    import::import,
    verify::{Oracle, Rays},
};
use restpose_formats::TreeKind;
use restpose_runtime::{Affine, Asset, Hit, InstanceId, PoseError, Posing, Ray, Scene, TraceCounters};
use restpose_tests::{baked_with, sample_scenes};
use std::sync::{Arc, Barrier};

const POSINGS: [Posing; 5] = [
    Posing::Chosen,
    Posing::Recomputed,
    Posing::Remembered,
    Posing::Whole,
    Posing::Expecting(3),
];

fn asset(name: &str, tree: TreeKind) -> Arc<Asset> {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.file_stem().is_some_and(|stem| stem == name))
        .unwrap_or_else(|| panic!("no sample {name}"));
    let settings = BakeSettings {
        tree,
        ..BakeSettings::default()
    };
    baked_with(&import(&path).unwrap().animation, &settings)
}

fn shifted(random: &mut fastrand::Rng) -> Affine {
    let mut by = || (random.f32() - 0.5) * 4.0;
    Affine::from_translation([by(), by() * 0.2, by()])
}

/// Poses an instance at random: by a clip, by nothing, or by a palette.
fn pose(scene: &mut Scene, instance: InstanceId, asset: &Asset, random: &mut fastrand::Rng) {
    let clips = asset.model().clips.len();
    match random.usize(..4) {
        0 => scene.set_default_pose(instance).unwrap(),
        1 => {
            let mut given = scene.pose(instance).unwrap();
            for map in &mut given.palette {
                map.columns[3][random.usize(..3)] += random.f32() * 0.05;
            }
            // Ends of a motion with palettes and morphs that have nothing to do with each other.
            for weight in &mut given.morph_weights {
                *weight = random.f32() * 8.0 - 4.0;
            }
            scene
                .set_palette(instance, &given.palette, &given.morph_weights)
                .unwrap();
        }
        _ => scene.play(instance, random.usize(..clips), random.f32() * 2.0).unwrap(),
    }
}

/// What a ray has posed no later one poses again, in the same pose, but where nothing is to be kept.
#[test]
fn remembered_vertices_are_posed_once_in_a_pose() {
    for tree in TreeKind::ALL {
        let asset = asset("walker", tree);
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        for (posing, is_kept) in [(Posing::Remembered, true), (Posing::Recomputed, false)] {
            scene.set_posing(instance, posing).unwrap();
            for seconds in [0.1, 0.4] {
                scene.play(instance, 0, seconds).unwrap();
                let frame = scene.commit();
                let oracle = Oracle::new(&frame, &[instance]);
                let rays: Vec<Ray> = Rays::new(&oracle, 3).take(200).collect();
                let posed = || {
                    let mut counters = TraceCounters::default();
                    for ray in &rays {
                        let _ = frame.closest_hit_counted(ray, &mut counters);
                    }
                    counters.vertices_posed
                };
                let (first, again) = (posed(), posed());
                assert!(first > 100, "{tree:?}, {posing:?}: {first} vertices");
                assert_eq!(again, if is_kept { 0 } else { first }, "{tree:?}, {posing:?}");
            }
        }
    }
}

/// Many threads enter the same instances at once, at the thresholds too, and agree with brute force.
#[test]
fn threads_that_come_first_at_once_agree() {
    let mut random = fastrand::Rng::with_seed(61);
    let mut hits = 0;
    for tree in TreeKind::ALL {
        let asset = asset("walker", tree);
        let mut scene = Scene::new();
        let instances: Vec<InstanceId> = (0..2).map(|_| scene.add(&asset)).collect();
        for round in 0..60 {
            for instance in &instances {
                scene.set_posing(*instance, POSINGS[round % POSINGS.len()]).unwrap();
                pose(&mut scene, *instance, &asset, &mut random);
            }
            let frame = scene.commit();
            let oracle = Oracle::new(&frame, &instances);
            let rays: Vec<Ray> = Rays::new(&oracle, round as u64).take(200).collect();
            let expected: Vec<Option<Hit>> = rays.iter().map(|ray| oracle.closest_hit(ray)).collect();
            // The oracle has prepared them: begin again.
            for instance in &instances {
                let state = scene.state(*instance).unwrap();
                scene.set_state(*instance, &state).unwrap();
            }
            let frame = scene.commit();
            let barrier = Barrier::new(4);
            std::thread::scope(|scope| {
                for thread in 0..4 {
                    let (rays, expected, barrier) = (&rays, &expected, &barrier);
                    scope.spawn(move || {
                        barrier.wait();
                        for at in 0..rays.len() {
                            let at = (at + thread * 50) % rays.len();
                            assert_eq!(frame.closest_hit(&rays[at]), expected[at], "{:?}", rays[at]);
                        }
                    });
                }
            });
            hits += expected.iter().flatten().count();
        }
    }
    assert!(hits > 5_000, "{hits}");
}

/// What a scene answers after any number of changes is what one answers that was made so.
#[test]
fn changes_in_any_order_leave_nothing_behind() {
    let mut random = fastrand::Rng::with_seed(7);
    let assets = [
        asset("walker", TreeKind::Wide),
        asset("tentacle", TreeKind::Kd),
        asset("mixed", TreeKind::Wide),
    ];
    let mut scene = Scene::new();
    let mut alive: Vec<(InstanceId, Arc<Asset>)> = Vec::new();
    let mut removed: Vec<InstanceId> = Vec::new();
    let mut hits = 0;
    for round in 0..120 {
        for _ in 0..random.usize(..4) {
            match random.usize(..5) {
                0 | 1 => {
                    let asset = &assets[random.usize(..assets.len())];
                    let instance = scene.add(asset);
                    assert!(!removed.contains(&instance), "an id has no namesake");
                    scene
                        .set_posing(instance, POSINGS[random.usize(..POSINGS.len())])
                        .unwrap();
                    alive.push((instance, Arc::clone(asset)));
                }
                2 if !alive.is_empty() => {
                    let (instance, _) = alive.swap_remove(random.usize(..alive.len()));
                    scene.remove(instance).unwrap();
                    removed.push(instance);
                }
                _ if !alive.is_empty() => {
                    let (instance, asset) = &alive[random.usize(..alive.len())];
                    scene.set_transform(*instance, shifted(&mut random)).unwrap();
                    pose(&mut scene, *instance, asset, &mut random);
                }
                _ => {}
            }
        }
        for gone in &removed {
            let unknown = scene.set_transform(*gone, Affine::IDENTITY);
            assert!(matches!(unknown, Err(PoseError::UnknownInstance { .. })), "{unknown:?}");
        }
        // The same instances in a scene of their own, by ascending index, so that ties are decided alike.
        alive.sort_by_key(|(instance, _)| instance.index());
        let mut fresh = Scene::new();
        let twins: Vec<InstanceId> = alive
            .iter()
            .map(|(instance, asset)| {
                let twin = fresh.add(asset);
                fresh.set_state(twin, &scene.state(*instance).unwrap()).unwrap();
                twin
            })
            .collect();
        let frame = scene.commit();
        let ids: Vec<InstanceId> = alive.iter().map(|(instance, _)| *instance).collect();
        let fresh = fresh.commit();
        if ids.is_empty() {
            assert_eq!(frame.closest_hit(&Ray::new([0.0, 9.0, 0.0], [0.0, -1.0, 0.0])), None);
            assert!(frame.bounds().is_empty());
            continue;
        }
        let oracle = Oracle::new(&fresh, &twins);
        for ray in Rays::new(&oracle, round).take(150) {
            let same = |hit: Hit| (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.triangle);
            let expected = oracle.closest_hit(&ray);
            let found = frame.closest_hit(&ray);
            assert_eq!(found.map(same), expected.map(same), "round {round}: {ray:?}");
            let place =
                |hit: Option<Hit>, of: &[InstanceId]| hit.map(|hit| of.iter().position(|id| *id == hit.instance));
            assert_eq!(place(found, &ids), place(expected, &twins), "round {round}: {ray:?}");
            hits += u64::from(found.is_some());
        }
    }
    assert!(
        removed.len() > 10 && hits > 2_000,
        "{} removed, {hits} hits",
        removed.len()
    );
}

#[test]
fn states_of_another_asset_are_refused() {
    let (walker, tentacle) = (asset("walker", TreeKind::Wide), asset("tentacle", TreeKind::Wide));
    let mut scene = Scene::new();
    let (a, b) = (scene.add(&walker), scene.add(&tentacle));
    let given = scene.pose(a).unwrap();
    scene.set_palette(a, &given.palette, &given.morph_weights).unwrap();
    let state = scene.state(a).unwrap();
    let kept = scene.state(b).unwrap();
    assert!(matches!(
        scene.set_state(b, &state),
        Err(PoseError::PaletteLength { .. })
    ));
    assert!(matches!(
        scene.set_motion(b, Some(&state)),
        Err(PoseError::PaletteLength { .. })
    ));
    assert_eq!(scene.state(b).unwrap(), kept);
    // A state that is kept stays as it was, whatever its instance does.
    let mut moved = given.palette.clone();
    moved.iter_mut().for_each(|map| map.columns[3][1] += 1.0);
    scene.set_palette(a, &moved, &given.morph_weights).unwrap();
    scene.set_state(a, &state).unwrap();
    assert_eq!(scene.pose(a).unwrap(), given);
}

/// A ray at a time meets what stands there in a scene that stands still in that state, and all of it within its bounds.
#[test]
fn rays_at_a_time_meet_the_state_of_that_time() {
    let mut random = fastrand::Rng::with_seed(23);
    let mut hits = 0;
    for path in sample_scenes() {
        for tree in TreeKind::ALL {
            let settings = BakeSettings {
                tree,
                ..BakeSettings::default()
            };
            let asset = baked_with(&import(&path).unwrap().animation, &settings);
            let name = format!("{}, {tree:?}", path.display());
            let vertices = asset.model().vertices.len() as u32 - 1;
            for round in 0..3 {
                let mut scene = Scene::new();
                let instances = [scene.add(&asset), scene.add(&asset)];
                for instance in instances {
                    pose(&mut scene, instance, &asset, &mut random);
                    scene.set_transform(instance, shifted(&mut random)).unwrap();
                    let begin = scene.state(instance).unwrap();
                    pose(&mut scene, instance, &asset, &mut random);
                    scene.set_transform(instance, shifted(&mut random)).unwrap();
                    let end = scene.state(instance).unwrap();
                    scene.set_state(instance, &begin).unwrap();
                    scene.set_motion(instance, Some(&end)).unwrap();
                }
                let frame = scene.commit();
                for time in [0.0, 1.0, 0.5, random.f32(), random.f32()] {
                    let mut still = Scene::new();
                    let twins = instances.map(|instance| {
                        let twin = still.add(&asset);
                        still.set_state(twin, &frame.state_at(instance, time).unwrap()).unwrap();
                        twin
                    });
                    let still = still.commit();
                    for (instance, twin) in instances.into_iter().zip(twins) {
                        let bounds = frame.instance_bounds(instance).unwrap();
                        for vertex in (0..vertices).step_by(7) {
                            let vertex = still.vertex(twin, vertex).unwrap();
                            assert!(
                                bounds.contains(vertex),
                                "{name}, time {time}: {vertex:?} outside of {bounds:?}"
                            );
                        }
                    }
                    let oracle = Oracle::new(&still, &twins);
                    let rays: Vec<Ray> = Rays::new(&oracle, round).take(60).collect();
                    let mut together = vec![None; rays.len()];
                    frame.closest_hits_at(&rays, &vec![time; rays.len()], &mut together);
                    let mut any = vec![false; rays.len()];
                    frame.any_hits_at(&rays, &vec![time; rays.len()], &mut any);
                    for ((ray, together), any) in rays.iter().zip(together).zip(any) {
                        let expected = oracle.closest_hit(ray);
                        let hit = frame.closest_hit_at(ray, time);
                        assert_eq!(hit, expected, "{name}, time {time}: {ray:?}");
                        assert_eq!(together, expected, "{name}, time {time}: {ray:?}");
                        assert_eq!(frame.any_hit_at(ray, time), expected.is_some());
                        assert_eq!(any, expected.is_some());
                        if let Some(hit) = &hit {
                            let surface = frame.surface_at(hit, time).unwrap();
                            let place = twins[usize::from(hit.instance != instances[0])];
                            let still = still
                                .surface(&Hit {
                                    instance: place,
                                    ..*hit
                                })
                                .unwrap();
                            assert_eq!(surface, still, "{name}, time {time}: {ray:?}");
                        }
                        hits += u64::from(hit.is_some());
                    }
                }
                let ray = Ray::new([0.0, 9.0, 0.0], [0.0, -1.0, 0.01]);
                assert_eq!(frame.closest_hit_at(&ray, -3.0), frame.closest_hit_at(&ray, 0.0));
                assert_eq!(frame.closest_hit_at(&ray, 0.0), frame.closest_hit(&ray));
                assert_eq!(
                    frame.closest_hit_at(&ray, f32::INFINITY),
                    frame.closest_hit_at(&ray, 1.0)
                );
                assert_eq!(frame.closest_hit_at(&ray, f32::NAN), None);
            }
        }
    }
    assert!(hits > 1_000, "{hits}");
}

/// One scene is prepared while another is traced: they share what is in the file, nothing else.
#[test]
fn two_scenes_in_two_threads_do_not_meet() {
    let asset = asset("walker", TreeKind::Wide);
    let run = |seed: u64| {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        for round in 0..40 {
            pose(&mut scene, instance, &asset, &mut random);
            let frame = scene.commit();
            let oracle = Oracle::new(&frame, &[instance]);
            for ray in Rays::new(&oracle, seed + round).take(40) {
                assert_eq!(frame.closest_hit(&ray), oracle.closest_hit(&ray), "{ray:?}");
            }
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(|| run(1));
        scope.spawn(|| run(1000));
    });
}

/// Rays among some instances hit what they would if there were no others.
#[test]
fn rays_among_some_instances_pass_through_the_others() {
    let asset = asset("walker", TreeKind::Wide);
    let mut scene = Scene::new();
    let instances: Vec<InstanceId> = (0..12).map(|_| scene.add(&asset)).collect();
    let ground = scene.add_geometry();
    let corners = [[-9.0, 0.7, -9.0], [9.0, 0.7, -9.0], [0.0, 0.8, 9.0]];
    scene.set_geometry(ground, &corners, &[[0, 1, 2]]).unwrap();
    for (at, instance) in (0..).zip(&instances) {
        let place = Affine::from_translation([(at % 4) as f32 * 0.4, 0.0, (at / 4) as f32 * 0.3]);
        scene.set_transform(*instance, place).unwrap();
        scene.play(*instance, 0, at as f32 * 0.21).unwrap();
    }
    let frame = scene.commit();
    let oracle = Oracle::new(&frame, &instances);
    let rays: Vec<Ray> = Rays::new(&oracle, 5).take(600).collect();
    let accepted = |id: InstanceId| id == ground || id.index() % 3 == 1;
    let hits: Vec<_> = rays.iter().map(|ray| frame.closest_hit_among(ray, accepted)).collect();
    let any: Vec<_> = rays.iter().map(|ray| frame.any_hit_among(ray, accepted)).collect();
    let all: Vec<_> = rays.iter().map(|ray| frame.closest_hit(ray)).collect();
    assert!(rays.iter().all(|ray| frame.closest_hit_among(ray, |_| false).is_none()));
    for instance in instances.iter().filter(|id| !accepted(**id)) {
        scene.remove(*instance).unwrap();
    }
    let frame = scene.commit();
    for (at, ray) in rays.iter().enumerate() {
        assert_eq!(hits[at], frame.closest_hit(ray), "{ray:?}");
        assert_eq!(any[at], hits[at].is_some(), "{ray:?}");
    }
    let (found, passed) = (
        hits.iter().flatten().count(),
        hits.iter().zip(&all).filter(|(a, b)| a != b).count(),
    );
    assert!(found > 100 && passed > 100, "{found} {passed}");
}
