use fastrand::Rng;
use restpose_formats::{
    ModelView,
    rows::{ClipBoundsRow, STRETCHES},
};
use restpose_runtime::{Affine, Asset, Scene};
use std::sync::Arc;

/// Numbers on either side of a time that are tried as well: a border of stretches is off by fewer, for it takes three
/// roundings to find the stretch of a time, and two to find a border here.
const BESIDE: usize = 5;

/// Vertices that a triangle with area uses.
pub fn used_vertices(asset: &Asset) -> Vec<usize> {
    let model = asset.model();
    let mut used = vec![false; model.vertices.len()];
    for triangle in model.triangles {
        let [a, b, c] = triangle.corners;
        if a != b && b != c && c != a {
            triangle.corners.iter().for_each(|corner| used[*corner as usize] = true);
        }
    }
    (0..used.len()).filter(|vertex| used[*vertex]).collect()
}

/// Any affine map, now and then none or a flat one.
fn random_transform(random: &mut Rng, unit: f32) -> Affine {
    let size = 10f32.powi(random.i32(-3..=3));
    let mut transform = Affine {
        columns: std::array::from_fn(|_| std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * size)),
    };
    transform.columns[3] = transform.columns[3].map(|x| x * unit);
    match random.u32(..4) {
        0 => Affine::IDENTITY,
        1 => {
            transform.columns[random.usize(..3)] = [0.0; 3];
            transform
        }
        _ => transform,
    }
}

/// Random times in and about a clip, some far from it, and all at and beside its keys and the borders of its stretches.
fn times_of(model: &ModelView, clip: usize, random_times: usize, random: &mut Rng) -> Vec<f32> {
    let row = &model.clips[clip];
    let (start, length) = (row.start_seconds, row.end_seconds - row.start_seconds);
    let mut times = vec![f32::MIN, start - 1.0, row.end_seconds + 1.0, f32::MAX];
    times.extend((0..random_times).map(|_| start + (random.f32() * 1.1 - 0.05) * length));
    let channels = &model.channels[row.channel_first as usize..][..row.channel_count as usize];
    let keys = channels
        .iter()
        .flat_map(|channel| &model.key_times[channel.time_first as usize..][..channel.key_count as usize]);
    let borders = (0..=STRETCHES).map(|border| start + length * border as f32 / STRETCHES as f32);
    for time in keys.copied().chain(borders) {
        let mut beside = (0..BESIDE).fold(time, |time, _| time.next_down());
        for _ in 0..=2 * BESIDE {
            times.push(beside);
            beside = beside.next_up();
        }
    }
    times.sort_by(f32::total_cmp);
    times.dedup();
    times
}

/// Sees that posed vertices lie in the boxes of instances that play each clip, and that these took no pose, at
/// [`times_of`] each clip. How many of the rows that say so are not known; all of them, where there are none.
pub fn assert_contains(name: &str, asset: &Arc<Asset>, random_times: usize, seed: u64) -> usize {
    let mut random = Rng::with_seed(seed);
    let model = asset.model();
    let used = used_vertices(asset);
    let unit = model.vertices.iter().flat_map(|vertex| vertex.position_rest);
    let unit = unit.fold(0.0f32, |most, x| most.max(x.abs()));
    let mut scene = Scene::new();
    let instance = scene.add(asset);
    let mut vertices = Vec::new();
    let mut poses = vec![(None, 0.0); random_times];
    for clip in 0..model.clips.len() {
        let times = times_of(model, clip, random_times, &mut random);
        poses.extend(times.into_iter().map(|seconds| (Some(clip), seconds)));
    }
    for (clip, seconds) in poses {
        let row = ClipBoundsRow::row_at(model.clips, clip, seconds);
        if !model.clip_bounds.get(row).is_some_and(ClipBoundsRow::is_known) {
            continue;
        }
        match clip {
            Some(clip) => scene.play(instance, clip, seconds).unwrap(),
            None => scene.set_default_pose(instance).unwrap(),
        }
        let transform = random_transform(&mut random, unit);
        scene.set_transform(instance, transform).unwrap();
        let frame = scene.commit();
        let bounds = frame.instance_bounds(instance).unwrap();
        assert_eq!(frame.stats().instances_entered, 0, "{name}: the box took a palette");
        frame.vertices(instance, &mut vertices).unwrap();
        for vertex in &used {
            let at = vertices[*vertex];
            assert!(
                bounds.contains(at),
                "{name}: clip {clip:?} at {seconds} s under {transform:?}: vertex {vertex} at {at:?} is not in {bounds:?}"
            );
        }
    }
    let known = model.clip_bounds.iter().filter(|row| row.is_known()).count();
    model.clips.len() * STRETCHES + 1 - known
}
