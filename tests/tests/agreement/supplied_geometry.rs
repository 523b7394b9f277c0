//! Triangles that the caller supplies anew: hits equal brute force, whatever they are and however often they change.

use restpose_bake::verify::{Oracle, Rays};
use restpose_runtime::{Affine, InstanceId, PoseError, Ray, Scene};
use restpose_samples::shatter::shatter;
use restpose_tests::{MeshRecipe, assert_rays_equal, baked_animation, hit_bits, jointed_mesh};

type Soup = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// Triangles anywhere within `half`, some of them long, some degenerate, some twice.
fn soup(random: &mut fastrand::Rng, count: usize, half: f32, size: f32) -> Soup {
    let mut soup = Soup::default();
    for _ in 0..count {
        if random.u8(..) < 8 && !soup.1.is_empty() {
            soup.1.push(soup.1[random.usize(..soup.1.len())]);
            continue;
        }
        let center: [f32; 3] = std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * half);
        let size = if random.u8(..) < 16 { half } else { size };
        let first = soup.0.len() as u32;
        for _ in 0..3 {
            soup.0.push(center.map(|x| x + (random.f32() * 2.0 - 1.0) * size));
        }
        let last = if random.u8(..) < 8 { first } else { first + 2 };
        soup.1.push([first, first + 1, last]);
    }
    soup
}

/// Rays through corners, middles of edges and points inside.
fn aimed(random: &mut fastrand::Rng, (positions, triangles): &Soup, transform: Affine, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for _ in 0..count {
        if triangles.is_empty() {
            break;
        }
        let corners = triangles[random.usize(..triangles.len())].map(|corner| positions[corner as usize]);
        let weights = [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.25, 0.25, 0.5]][random.usize(..3)];
        let point = std::array::from_fn(|k| (0..3).map(|i| weights[i] * corners[i][k]).sum());
        let point = transform.transform_point(point);
        let direction: [f32; 3] = std::array::from_fn(|_| random.f32() * 2.0 - 1.0);
        let far = 3.0 * random.f32();
        rays.push(Ray::new(
            std::array::from_fn(|k| point[k] - far * direction[k]),
            direction,
        ));
    }
    rays
}

#[test]
fn any_triangles_in_any_number_equal_brute_force() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut scene = Scene::new();
    let rubble = scene.add_geometry();
    for round in 0..60 {
        let count = [0, 1, 2, 3, 7, 30, 200, 9000][random.usize(..8)];
        let half = [1e-20, 1.0, 1.0, 50.0, 1e7, 1e20][random.usize(..6)];
        let soup = soup(&mut random, count, half, half * 0.05);
        let turn = Affine {
            columns: std::array::from_fn(|_| std::array::from_fn(|_| random.f32() * 2.0 - 1.0)),
        };
        let transform = [Affine::IDENTITY, Affine::from_translation([half, -half, 3.0]), turn][random.usize(..3)];
        scene.set_transform(rubble, transform).unwrap();
        scene.set_geometry(rubble, &soup.0, &soup.1).unwrap();
        let frame = scene.commit();
        let oracle = Oracle::new(&frame, &[rubble]);
        assert_eq!(oracle.triangle_count(), count);
        let name = format!("round {round}: {count} triangles within {half}");
        let rays = if count > 1000 { 300 } else { 1500 };
        if count > 0 {
            let ordinary: Vec<Ray> = Rays::new(&oracle, round).take(rays).collect();
            assert_rays_equal(&name, &frame, &oracle, ordinary);
        }
        let aimed = aimed(&mut random, &soup, transform, rays);
        let hits = assert_rays_equal(&name, &frame, &oracle, aimed.clone());
        assert!(
            hits * 3 >= aimed.len() || half == 1e-20 || count < 7,
            "{name}: {hits} of {}",
            aimed.len()
        );
    }
}

#[test]
fn geometry_and_assets_share_a_scene() {
    let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&restpose_samples::solids::sphere(2), 3)));
    let mut random = fastrand::Rng::with_seed(5);
    let mut scene = Scene::new();
    let around = soup(&mut random, 400, 2.0, 0.2);
    let before = scene.add_geometry();
    let actor = scene.add(&asset);
    let behind = scene.add_geometry();
    for (instance, side) in [(before, -0.5), (behind, 0.5)] {
        scene.set_geometry(instance, &around.0, &around.1).unwrap();
        scene
            .set_transform(instance, Affine::from_translation([side, 0.0, 0.0]))
            .unwrap();
    }
    let frame = scene.commit();
    assert_eq!(frame.stats().clusters_rebuilt, 2);
    let oracle = Oracle::new(&frame, &[before, actor, behind]);
    let rays: Vec<Ray> = Rays::new(&oracle, 1).take(20_000).collect();
    let mut hit = [0; 3];
    for found in rays.iter().filter_map(|ray| frame.closest_hit(ray)) {
        hit[found.instance.index()] += 1;
    }
    assert!(hit.iter().all(|count| *count > 100), "{hit:?}");
    assert_rays_equal("geometry around an asset", &frame, &oracle, rays);
}

#[test]
fn what_does_not_change_stays_and_what_changes_does_not() {
    let frames = shatter().frames;
    let triangles: Vec<[u32; 3]> = (0..frames[0].len() as u32 / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let mut scene = Scene::new();
    let vase = scene.add_geometry();
    let fresh = |positions: &[[f32; 3]], rays: &[Ray]| -> Vec<_> {
        let mut scene = Scene::new();
        let vase = scene.add_geometry();
        scene.set_geometry(vase, positions, &triangles).unwrap();
        let frame = scene.commit();
        rays.iter().map(|ray| hit_bits(frame.closest_hit(ray))).collect()
    };
    let mut hits = 0;
    for positions in &frames {
        scene.set_geometry(vase, positions, &triangles).unwrap();
        let oracle = Oracle::new(&scene.commit(), &[vase]);
        let rays: Vec<Ray> = Rays::new(&oracle, 3).take(500).collect();
        let expected = fresh(positions, &rays);
        // The second commit rebuilds nothing.
        for _ in 0..2 {
            let frame = scene.commit();
            let found: Vec<_> = rays.iter().map(|ray| hit_bits(frame.closest_hit(ray))).collect();
            assert_eq!(found, expected);
            hits += found.iter().flatten().count();
        }
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn geometry_moves_with_its_transform_alone() {
    let mut random = fastrand::Rng::with_seed(8);
    let soup = soup(&mut random, 300, 1.0, 0.2);
    let mut scene = Scene::new();
    let rubble = scene.add_geometry();
    scene.set_geometry(rubble, &soup.0, &soup.1).unwrap();
    for x in [0.0, 40.0, -3.0] {
        let transform = Affine::from_translation([x, 0.0, 0.0]);
        scene.set_transform(rubble, transform).unwrap();
        let frame = scene.commit();
        let center = frame.bounds().center()[0];
        assert!(
            (center - x).abs() < 1.0,
            "the box of what lies within 1.2 of {x} is about {center}"
        );
        let oracle = Oracle::new(&frame, &[rubble]);
        let rays = aimed(&mut random, &soup, transform, 500);
        let hits = assert_rays_equal(&format!("moved to {x}"), &frame, &oracle, rays);
        assert!(hits > 200, "{hits}");
    }
}

#[test]
fn a_hit_tells_the_triangle_and_the_point_before_the_transform() {
    let mut scene = Scene::new();
    let wall = scene.add_geometry();
    let positions = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 9.0]];
    scene.set_geometry(wall, &positions, &[[0, 1, 3], [0, 1, 2]]).unwrap();
    scene
        .set_transform(wall, Affine::from_translation([10.0, 0.0, 0.0]))
        .unwrap();
    let frame = scene.commit();
    let hit = frame
        .closest_hit(&Ray::new([11.0, 2.0, 5.0], [0.0, 0.0, -1.0]))
        .unwrap();
    assert_eq!((hit.instance, hit.triangle, hit.t), (wall, 1, 5.0));
    let surface = frame.surface(&hit).unwrap();
    assert_eq!(surface.position_world, [11.0, 2.0, 0.0]);
    assert_eq!(surface.position_rest, [1.0, 2.0, 0.0]);
    assert_eq!(surface.normal_world, [0.0, 0.0, 1.0]);
    assert_eq!(
        (surface.source_triangle, surface.bone, surface.part),
        (1, u32::MAX, u32::MAX)
    );
    assert_eq!(frame.vertex(wall, 1), Some([14.0, 0.0, 0.0]));
    assert_eq!((frame.vertex(wall, 4), frame.triangle(wall, 2)), (None, None));
    assert_eq!(frame.clusters().count(), 0);
}

#[test]
fn bad_geometry_is_refused_and_the_old_stays() {
    let mut scene = Scene::new();
    let wall = scene.add_geometry();
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    scene.set_geometry(wall, &positions, &[[0, 1, 2]]).unwrap();
    for value in [f32::NAN, f32::INFINITY] {
        let mut broken = positions;
        broken[1][2] = value;
        let error = scene.set_geometry(wall, &broken, &[]).unwrap_err();
        assert_eq!(error, PoseError::VertexNotFinite { vertex: 1 });
    }
    let error = scene
        .set_geometry(wall, &positions, &[[0, 1, 2], [2, 3, 1]])
        .unwrap_err();
    let expected = PoseError::CornerOutOfRange {
        triangle: 1,
        corner: 3,
        vertices: 3,
    };
    assert_eq!(error, expected);
    let ray = Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    assert!(scene.commit().any_hit(&ray));

    let no_asset = Err(PoseError::NoAsset { instance: 0 });
    assert_eq!(scene.play(wall, 0, 0.0), no_asset);
    assert_eq!(scene.set_palette(wall, &[], &[]), no_asset);
    assert_eq!(scene.set_default_pose(wall), no_asset);
    assert_eq!(scene.set_cache_frames(wall, &[]), no_asset);
    assert_eq!(
        scene.pose(wall).map(|pose| pose.palette.len()),
        Err(PoseError::NoAsset { instance: 0 })
    );
    let surface = restpose_samples::solids::sphere(1);
    let actor = scene.add(&baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, 0))));
    let error = scene.set_geometry(actor, &positions, &[]).unwrap_err();
    assert_eq!(error, PoseError::NotGeometry { instance: 1 });
    let mut other = Scene::new();
    let unknown: InstanceId = actor;
    let error = other.set_geometry(unknown, &[], &[]).unwrap_err();
    assert_eq!(error, PoseError::UnknownInstance { instance: 1, count: 0 });

    scene.set_geometry(wall, &[], &[]).unwrap();
    let frame = scene.commit();
    assert!(!frame.any_hit(&ray) || frame.closest_hit(&ray).unwrap().instance == actor);
}
