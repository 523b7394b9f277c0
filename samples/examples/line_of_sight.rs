//! Line of sight in a crowd: a thousand figures walk over a field, each in its own phase, and ten of them keep watch.
//!
//! In every tick all move, and each guard asks of all others in reach of its eyes whether somebody stands in between. Only
//! the figures whose boxes these lines enter are posed, and of these only what the lines reach. Fails if `any_hits` and
//! `closest_hits` disagree, or if somebody stands in their own line.
//!
//! `cargo run --release -p restpose-samples --example line_of_sight`
#![expect(clippy::print_stdout, reason = "a program for people")]

use glam::Vec3;
use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_runtime::{Affine, Asset, Frame, Hit, InstanceId, Ray, Scene};
use std::{error::Error, path::Path, sync::Arc, time::Instant};

const ROWS: usize = 25;
const COLUMNS: usize = 40;
/// Every so many figures one is a guard.
const PER_GUARD: usize = 100;
/// Metres between figures, before each steps aside a little.
const SPACING: f32 = 2.0;
const TICK: f32 = 1.0 / 30.0;
const TICKS: usize = 31;
/// As fast as the feet of the clip move over the ground, metres per second.
const SPEED: f32 = 0.883;
/// How far a guard sees, metres.
const SIGHT: f32 = 15.0;
/// Cosine of the angle to both sides at which a guard still sees: 60 degrees.
const VIEW_COSINE: f32 = 0.5;
const EYES: f32 = 1.63;
const CHEST: f32 = 1.25;
/// A line begins and ends so many metres from the figures' middles, outside of their own arms.
const REACH: f32 = 0.6;

struct Figure {
    instance: InstanceId,
    start: Vec3,
    /// Radians from z towards x.
    heading: f32,
    /// Seconds in the clip's cycle of one second.
    phase: f32,
}

impl Figure {
    fn forward(&self) -> Vec3 {
        Vec3::new(self.heading.sin(), 0.0, self.heading.cos())
    }

    fn place(&self, seconds: f32) -> Vec3 {
        self.start + SPEED * seconds * self.forward()
    }

    fn walk(&self, scene: &mut Scene, clip: usize, seconds: f32) -> Result<(), Box<dyn Error>> {
        let (sine, cosine) = self.heading.sin_cos();
        let place = self.place(seconds).to_array();
        let world_from_asset = Affine {
            columns: [[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine], place],
        };
        scene.set_transform(self.instance, world_from_asset)?;
        scene.play(self.instance, clip, (self.phase + seconds).fract())?;
        Ok(())
    }
}

/// Who looks at whom, by number, and along which line.
struct Looks {
    pairs: Vec<[usize; 2]>,
    lines: Vec<Ray>,
}

fn looks(figures: &[Figure], seconds: f32) -> Looks {
    let (mut pairs, mut lines) = (Vec::new(), Vec::new());
    for (guard, from) in figures.iter().enumerate().step_by(PER_GUARD) {
        let eyes = from.place(seconds) + EYES * Vec3::Y;
        for (other, to) in figures.iter().enumerate() {
            let chest = to.place(seconds) + CHEST * Vec3::Y;
            let line = chest - eyes;
            let length = line.length();
            let is_in_reach = (2.0 * REACH..=SIGHT).contains(&length);
            if is_in_reach && line.dot(from.forward()) > VIEW_COSINE * length {
                pairs.push([guard, other]);
                lines.push(Ray {
                    t_min: REACH / length,
                    t_max: 1.0 - REACH / length,
                    ..Ray::between(eyes.to_array(), chest.to_array())
                });
            }
        }
    }
    Looks { pairs, lines }
}

struct Tick {
    looks: Looks,
    blocked: Vec<bool>,
    /// From the first figure that is moved to the last answer.
    micros: f64,
    entered: u32,
    instances: u32,
}

impl Tick {
    fn visible(&self) -> impl Iterator<Item = [usize; 2]> {
        let pairs = self.looks.pairs.iter().zip(&self.blocked);
        pairs.filter(|(_, blocked)| !**blocked).map(|(pair, _)| *pair)
    }
}

struct Field {
    scene: Scene,
    clip: usize,
    figures: Vec<Figure>,
}

impl Field {
    fn new() -> Result<Self, Box<dyn Error>> {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker.glb");
        let baked = bake(&import(&source)?.animation, &BakeSettings::default(), &NoProgress)?;
        let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?);
        let clip = asset.clip("walk").ok_or("the walker walks")?;
        let mut chance = fastrand::Rng::with_seed(6);
        let mut scene = Scene::new();
        let figures = (0..ROWS * COLUMNS).map(|number| {
            let [x, z] = [number % COLUMNS, number / COLUMNS].map(|k| (k as f32 + 0.5 * chance.f32()) * SPACING);
            Figure {
                instance: scene.add(&asset),
                start: Vec3::new(x, 0.0, z),
                heading: chance.f32() * std::f32::consts::TAU,
                phase: chance.f32(),
            }
        });
        let figures = figures.collect();
        Ok(Self { scene, clip, figures })
    }

    fn tick(&mut self, seconds: f32) -> Result<Tick, Box<dyn Error>> {
        let looks = looks(&self.figures, seconds);
        let mut blocked = vec![false; looks.lines.len()];
        let start = Instant::now();
        for figure in &self.figures {
            figure.walk(&mut self.scene, self.clip, seconds)?;
        }
        let frame = self.scene.commit();
        frame.any_hits(&looks.lines, &mut blocked);
        let micros = start.elapsed().as_secs_f64() * 1e6;
        let stats = frame.stats();
        check(&frame, &self.figures, &looks, &blocked)?;
        Ok(Tick {
            looks,
            blocked,
            micros,
            entered: stats.instances_entered,
            instances: stats.instances,
        })
    }
}

/// Whether the answers are those of closest hits, and nobody blocks their own line.
fn check(frame: &Frame, figures: &[Figure], looks: &Looks, blocked: &[bool]) -> Result<(), Box<dyn Error>> {
    let mut hits: Vec<Option<Hit>> = vec![None; looks.lines.len()];
    frame.closest_hits(&looks.lines, &mut hits);
    for ((hit, blocked), pair) in hits.iter().zip(blocked).zip(&looks.pairs) {
        if hit.is_some() != *blocked {
            return Err(format!("{pair:?}: blocked is {blocked}, the closest hit is {hit:?}").into());
        }
        if let Some(hit) = hit
            && pair.iter().any(|figure| figures[*figure].instance == hit.instance)
        {
            return Err(format!("{pair:?}: one of them stands in their own line").into());
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut field = Field::new()?;
    let mut ticks = Vec::new();
    for tick in 0..TICKS {
        ticks.push(field.tick(tick as f32 * TICK)?);
    }
    for (number, tick) in ticks.iter().enumerate().step_by(5) {
        println!(
            "tick {number:2}: {} of {} lines are free; {:.0} us; rays entered {} of {} figures",
            tick.visible().count(),
            tick.looks.lines.len(),
            tick.micros,
            tick.entered,
            tick.instances,
        );
    }
    let mut micros: Vec<f64> = ticks.iter().map(|tick| tick.micros).collect();
    micros.sort_by(f64::total_cmp);
    println!(
        "all figures moved and all lines asked in {:.0} us, the median",
        micros[TICKS / 2]
    );

    let last = &ticks[TICKS - 1];
    println!("in the last tick");
    for guard in (0..field.figures.len()).step_by(PER_GUARD) {
        let seen = last.visible().filter(|pair| pair[0] == guard);
        let seen: Vec<String> = seen.map(|pair| pair[1].to_string()).collect();
        println!("  guard {guard} sees {}", seen.join(" "));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_are_seen_and_few_are_posed() {
        let mut field = Field::new().expect("the walker is baked");
        for seconds in [0.0, 0.4, 0.8] {
            let tick = field.tick(seconds).expect("both kinds of query agree");
            let (asked, free) = (tick.looks.lines.len(), tick.visible().count());
            assert!(
                free > asked / 10 && free < asked * 9 / 10,
                "{free} of {asked} lines are free"
            );
            assert!(
                tick.entered > 0 && tick.entered < tick.instances,
                "{} entered",
                tick.entered
            );
        }
    }

    #[test]
    fn who_steps_in_between_blocks_the_line() {
        let mut field = Field::new().expect("the walker is baked");
        let tick = field.tick(0.0).expect("both kinds of query agree");
        let [guard, seen] = tick.visible().next().expect("somebody is seen");
        let free = tick.visible().count();
        let between = (0..field.figures.len()).find(|figure| ![guard, seen].contains(figure));
        let between = between.expect("there are others");
        field.figures[between].start = (field.figures[guard].start + field.figures[seen].start) / 2.0;
        let tick = field.tick(0.0).expect("both kinds of query agree");
        assert!(tick.visible().all(|pair| pair != [guard, seen]));
        assert!(tick.visible().count() != free);
    }
}
