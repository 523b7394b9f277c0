//! Lidar: a sensor with 64 beams turns once in a tenth of a second, in a street where people walk and run.
//!
//! While it turns the people move on: each column of beams has a time of its own between two poses, and meets everybody
//! just where they are then. Compares the scan with one of people who stand still meanwhile, and writes both as point clouds:
//! out/lidar.ply and out/lidar_still.ply. Fails if a column differs from a scene that was posed for its moment.
//!
//! `cargo run --release -p restpose-samples --example lidar`
#![expect(clippy::print_stdout, reason = "a program for people")]

use glam::Vec3;
use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_runtime::{Affine, Asset, Frame, Hit, InstanceId, Ray, Scene};
use std::{
    error::Error,
    fs,
    io::{self, BufWriter, Write},
    path::Path,
    sync::Arc,
    time::Instant,
};

const BEAMS: usize = 64;
const COLUMNS: usize = 1800;
/// The lowest and the highest beam, degrees above the horizon.
const BEAMS_DEG: [f32; 2] = [-24.0, 8.0];
const TURN_SECONDS: f32 = 0.1;
const SENSOR: Vec3 = Vec3::new(0.0, 1.9, 0.0);
/// Metres.
const RANGE: f32 = 60.0;
const PEOPLE: usize = 40;
/// As fast as the feet of the clip move over the ground, metres per second.
const WALK_SPEED: f32 = 0.883;
/// The street runs along z: half its width between the house fronts, half its length, and their height, metres.
const STREET: [f32; 3] = [8.0, 40.0, 9.0];
/// Columns that are compared with scenes posed for their moment.
const CHECKED_COLUMNS: usize = 12;

struct Person {
    instance: InstanceId,
    start: Vec3,
    /// 1 up the street, -1 down.
    way: f32,
    /// How many times faster than a walk, in steps as in metres.
    haste: f32,
    /// Seconds in the clip's cycle of one second.
    phase: f32,
}

impl Person {
    fn walk(&self, scene: &mut Scene, clip: usize, seconds: f32) -> Result<(), Box<dyn Error>> {
        let mut world_from_asset = Affine::IDENTITY;
        world_from_asset.columns[0][0] = self.way;
        world_from_asset.columns[2][2] = self.way;
        let path = self.way * self.haste * WALK_SPEED * seconds;
        world_from_asset.columns[3] = (self.start + path * Vec3::Z).to_array();
        scene.set_transform(self.instance, world_from_asset)?;
        scene.play(self.instance, clip, (self.phase + self.haste * seconds).fract())?;
        Ok(())
    }
}

/// A sensor's turn: beams column by column, and the time of each between the begin and the end of the turn.
struct Turn {
    rays: Vec<Ray>,
    times: Vec<f32>,
}

impl Turn {
    fn new() -> Self {
        let (mut rays, mut times) = (Vec::new(), Vec::new());
        for column in 0..COLUMNS {
            let time = column as f32 / COLUMNS as f32;
            let (east, north) = (time * std::f32::consts::TAU).sin_cos();
            for beam in 0..BEAMS {
                let part = beam as f32 / (BEAMS - 1) as f32;
                let degrees = BEAMS_DEG[0] + part * (BEAMS_DEG[1] - BEAMS_DEG[0]);
                let (up, level) = degrees.to_radians().sin_cos();
                // At length one, but for rounding, so that t counts in metres.
                let direction = [level * east, up, level * north];
                rays.push(Ray {
                    t_max: RANGE,
                    ..Ray::new(SENSOR.to_array(), direction)
                });
                times.push(time);
            }
        }
        Self { rays, times }
    }
}

struct Street {
    scene: Scene,
    people: Vec<InstanceId>,
}

impl Street {
    /// The street at the begin of a turn, in which all people move.
    fn new() -> Result<Self, Box<dyn Error>> {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker.glb");
        let baked = bake(&import(&source)?.animation, &BakeSettings::default(), &NoProgress)?;
        let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?);
        let clip = asset.clip("walk").ok_or("the walker walks")?;
        let mut scene = Scene::new();
        add_houses(&mut scene)?;
        let mut chance = fastrand::Rng::with_seed(6);
        let mut people = Vec::new();
        for _ in 0..PEOPLE {
            // On the pavements, not where the sensor stands.
            let side = if chance.bool() { 1.0 } else { -1.0 };
            let person = Person {
                instance: scene.add(&asset),
                start: Vec3::new(side * (2.5 + 4.0 * chance.f32()), 0.0, 50.0 * (chance.f32() - 0.5)),
                way: if chance.bool() { 1.0 } else { -1.0 },
                haste: 1.0 + 3.0 * chance.f32(),
                phase: chance.f32(),
            };
            person.walk(&mut scene, clip, TURN_SECONDS)?;
            let end = scene.state(person.instance)?;
            person.walk(&mut scene, clip, 0.0)?;
            scene.set_motion(person.instance, Some(&end))?;
            people.push(person.instance);
        }
        Ok(Self { scene, people })
    }

    /// Sets everybody to where they are at a time of the turn, and makes them stand there.
    fn stop_at(&mut self, moving: &Frame, time: f32) -> Result<(), Box<dyn Error>> {
        for person in &self.people {
            self.scene.set_state(*person, &moving.state_at(*person, time)?)?;
            self.scene.set_motion(*person, None)?;
        }
        Ok(())
    }
}

/// The ground and a row of houses on each side.
fn add_houses(scene: &mut Scene) -> Result<(), Box<dyn Error>> {
    let [x, z, height] = STREET;
    let positions = [
        [-x, 0.0, -z],
        [x, 0.0, -z],
        [-x, 0.0, z],
        [x, 0.0, z],
        [-x, height, -z],
        [x, height, -z],
        [-x, height, z],
        [x, height, z],
    ];
    let (ground, left, right) = ([0, 1, 3, 2], [0, 2, 6, 4], [1, 3, 7, 5]);
    let triangles = [ground, left, right].map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let houses = scene.add_geometry();
    scene.set_geometry(houses, &positions, triangles.as_flattened())?;
    Ok(())
}

struct Scan {
    hits: Vec<Option<Hit>>,
    millis: f64,
}

fn scan(frame: &Frame, turn: &Turn) -> Scan {
    let mut hits = vec![None; turn.rays.len()];
    let start = Instant::now();
    frame.closest_hits_at(&turn.rays, &turn.times, &mut hits);
    let millis = start.elapsed().as_secs_f64() * 1e3;
    Scan { hits, millis }
}

/// The same as if nobody moved while the sensor turns.
fn scan_still(frame: &Frame, turn: &Turn) -> Scan {
    let mut hits = vec![None; turn.rays.len()];
    let start = Instant::now();
    frame.closest_hits(&turn.rays, &mut hits);
    let millis = start.elapsed().as_secs_f64() * 1e3;
    Scan { hits, millis }
}

/// Whether columns hit what they hit in a scene that is posed for their moment. Tells how many beams met a person.
fn check(moving: &Frame, turn: &Turn, hits: &[Option<Hit>]) -> Result<usize, Box<dyn Error>> {
    let mut stopped = Street::new()?;
    let mut met = 0;
    for column in (0..COLUMNS).step_by(COLUMNS / CHECKED_COLUMNS) {
        let first = column * BEAMS;
        stopped.stop_at(moving, turn.times[first])?;
        let frame = stopped.scene.commit();
        for beam in first..first + BEAMS {
            let (expected, found) = (frame.closest_hit(&turn.rays[beam]), hits[beam]);
            if found != expected {
                return Err(format!("beam {beam}: {found:?}, but {expected:?} in the scene of its moment").into());
            }
            met += usize::from(found.is_some_and(|hit| stopped.people.contains(&hit.instance)));
        }
    }
    Ok(met)
}

/// What motion during a turn does to the points on people.
#[derive(Debug, Default)]
struct Shift {
    points: usize,
    /// Beams that return from something else than in the still street, or from nothing.
    changed: usize,
    /// Metres by which the skin under a point has moved since the turn began.
    mean: f32,
    largest: f32,
}

fn shift(frame: &Frame, people: &[InstanceId], turn: &Turn, hits: &[Option<Hit>], still: &[Option<Hit>]) -> Shift {
    let mut shift = Shift::default();
    let named = |hit: &Option<Hit>| hit.map(|hit| hit.instance);
    for ((ray, hit), still) in turn.rays.iter().zip(hits).zip(still) {
        shift.changed += usize::from(named(hit) != named(still));
        let Some(hit) = hit.filter(|hit| people.contains(&hit.instance)) else {
            continue;
        };
        // Triangles of a frame are those of the begin.
        if let Some(corners) = frame.triangle(hit.instance, hit.triangle) {
            let [a, b, c] = corners.map(Vec3::from);
            let at_begin = (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c;
            let moved = point(ray, hit.t).distance(at_begin);
            shift.points += 1;
            shift.mean += moved;
            shift.largest = shift.largest.max(moved);
        }
    }
    shift.mean /= shift.points.max(1) as f32;
    shift
}

fn point(ray: &Ray, t: f32) -> Vec3 {
    Vec3::from(ray.origin) + t * Vec3::from(ray.direction)
}

/// Writes a point per hit as binary PLY: place in metres, intensity from 0 to 1, number of the instance.
fn write_ply(turn: &Turn, hits: &[Option<Hit>], people: &[InstanceId], out: &mut impl Write) -> io::Result<()> {
    let returns = turn.rays.iter().zip(hits).filter_map(|(ray, hit)| Some((ray, (*hit)?)));
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "element vertex {}", returns.clone().count())?;
    for property in ["float x", "float y", "float z", "float intensity", "uint instance"] {
        writeln!(out, "property {property}")?;
    }
    writeln!(out, "end_header")?;
    for (ray, hit) in returns {
        // Cloth gives back more than plaster and stones, and all give back less from afar.
        let albedo = if people.contains(&hit.instance) { 0.9 } else { 0.4 };
        let intensity = albedo / (1.0 + (hit.t / 15.0).powi(2));
        for number in point(ray, hit.t).to_array().into_iter().chain([intensity]) {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&(hit.instance.index() as u32).to_le_bytes())?;
    }
    out.flush()
}

fn main() -> Result<(), Box<dyn Error>> {
    let turn = Turn::new();
    let mut street = Street::new()?;
    let frame = street.scene.commit();
    let moving = scan(&frame, &turn);
    let still = scan_still(&frame, &turn);
    let met = check(&frame, &turn, &moving.hits)?;

    println!(
        "{} beams, {} returns; {:.1} ms, {:.1} ms if nobody moved",
        turn.rays.len(),
        moving.hits.iter().flatten().count(),
        moving.millis,
        still.millis
    );
    println!("{CHECKED_COLUMNS} columns are those of scenes posed for their moments; {met} of their beams met people");
    let shift = shift(&frame, &street.people, &turn, &moving.hits, &still.hits);
    println!(
        "{} points on people have moved by {:.3} m on average, {:.3} m at most, when their beam comes",
        shift.points, shift.mean, shift.largest
    );
    println!(
        "{} beams return from something else than if nobody moved",
        shift.changed
    );

    fs::create_dir_all("out")?;
    for (path, hits) in [("out/lidar.ply", &moving.hits), ("out/lidar_still.ply", &still.hits)] {
        write_ply(
            &turn,
            hits,
            &street.people,
            &mut BufWriter::new(fs::File::create(path)?),
        )?;
        println!("wrote {path}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_meet_people_where_they_are_at_their_time() {
        let turn = Turn::new();
        let mut street = Street::new().expect("the walker is baked");
        let frame = street.scene.commit();
        let moving = scan(&frame, &turn);
        let met = check(&frame, &turn, &moving.hits).expect("columns are those of scenes posed for their moments");
        assert!(met > 20, "{met} of the beams that are checked meet people");
        let still = scan_still(&frame, &turn);
        let shift = shift(&frame, &street.people, &turn, &moving.hits, &still.hits);
        assert!(shift.points > 1000 && shift.changed > 100, "{shift:?}");
        // The body of the fastest moves by 0.35 m in a turn, a leg that swings about twice as far.
        assert!(shift.largest > 0.2 && shift.largest < 0.9, "{shift:?}");
        check(&frame, &turn, &still.hits).expect_err("a still scan is not that of people who move");
    }

    #[test]
    fn a_point_cloud_holds_each_return_once() {
        let turn = Turn::new();
        let mut street = Street::new().expect("the walker is baked");
        let frame = street.scene.commit();
        let hits = scan(&frame, &turn).hits;
        let mut file = Vec::new();
        write_ply(&turn, &hits, &street.people, &mut file).expect("a vector takes all");
        let end = b"end_header\n";
        let header = file.windows(end.len()).position(|bytes| bytes == end);
        let (header, points) = file.split_at(header.expect("a header") + end.len());
        let header = std::str::from_utf8(header).expect("text");
        let returns = hits.iter().flatten().count();
        assert!(header.contains(&format!("element vertex {returns}\n")));
        assert_eq!(points.len(), returns * 20);
        let (first, _) = points.as_chunks::<4>().0.split_at(5);
        let beam = hits.iter().position(Option::is_some).expect("a return");
        let hit = hits[beam].expect("a return");
        let place = point(&turn.rays[beam], hit.t).to_array();
        assert_eq!(first[..3], place.map(f32::to_le_bytes));
        assert_eq!(first[4], (hit.instance.index() as u32).to_le_bytes());
    }
}
