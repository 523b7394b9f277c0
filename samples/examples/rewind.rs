//! Rewind (lag compensation): a shot is judged in the pose that its shooter saw, not in the one that the server has by now.
//!
//! A server keeps the states of its players over the last 64 ticks in a ring; a state is a small value, a palette in it is
//! shared and not copied. Shots come late. For each the players are set back to the tick on the shooter's screen, in a
//! second scene, while the present frame goes on answering. Fails if a shot is not judged bit for bit as it was seen, or if
//! the present changes.
//!
//! `cargo run --release -p restpose-samples --example rewind`
#![expect(clippy::print_stdout, reason = "a program for people")]

use glam::Vec3;
use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_runtime::{Affine, Asset, Frame, Hit, InstanceId, InstanceState, Ray, Scene};
use std::{error::Error, path::Path, sync::Arc, time::Instant};

const PLAYERS: usize = 100;
const TICKS_KEPT: u64 = 64;
const TICKS: u64 = 200;
const TICK: f32 = 1.0 / 64.0;
/// Players run: the walk, four times as fast.
const HASTE: f32 = 4.0;
const SPEED: f32 = HASTE * 0.883;
/// One of so many players turns the head as no clip does, and so has a palette of its own.
const PER_OWN_PALETTE: usize = 10;
/// Metres to a side of the square where players begin.
const ARENA: f32 = 40.0;
/// Metres between shooter and target at most.
const RANGE: f32 = 15.0;
/// Ticks that shots are late, 60 ms to a second: some come when their tick is forgotten.
const LATENESS: std::ops::Range<u64> = 4..68;

struct Player {
    start: Vec3,
    /// Radians from z towards x.
    heading: f32,
    /// Seconds in the clip's cycle of one second.
    phase: f32,
}

impl Player {
    fn place(&self, tick: u64) -> Vec3 {
        let forward = Vec3::new(self.heading.sin(), 0.0, self.heading.cos());
        self.start + SPEED * TICK * tick as f32 * forward
    }
}

/// A map that turns about the upright axis and puts the origin at `place`.
fn turned(radians: f32, place: Vec3) -> Affine {
    let (sine, cosine) = radians.sin_cos();
    Affine {
        columns: [
            [cosine, 0.0, -sine],
            [0.0, 1.0, 0.0],
            [sine, 0.0, cosine],
            place.to_array(),
        ],
    }
}

/// The states of all players in the last ticks.
#[derive(Default)]
struct Ring {
    /// A tick is at its number modulo the length.
    slots: Vec<Vec<InstanceState>>,
    /// Ticks recorded so far.
    recorded: u64,
}

impl Ring {
    fn record(&mut self, scene: &Scene, players: &[InstanceId]) -> Result<(), Box<dyn Error>> {
        let slot = (self.recorded % TICKS_KEPT) as usize;
        if slot == self.slots.len() {
            self.slots.push(Vec::with_capacity(players.len()));
        }
        self.slots[slot].clear();
        for player in players {
            self.slots[slot].push(scene.state(*player)?);
        }
        self.recorded += 1;
        Ok(())
    }

    /// `None` where the tick is forgotten or yet to come.
    fn at(&self, tick: u64) -> Option<&[InstanceState]> {
        let is_kept = tick < self.recorded && tick + TICKS_KEPT >= self.recorded;
        is_kept.then(|| self.slots[(tick % TICKS_KEPT) as usize].as_slice())
    }
}

/// What a shooter saw when the trigger was pulled.
struct Shot {
    /// The tick on the shooter's screen.
    seen: u64,
    /// The tick in which the server hears of it.
    heard: u64,
    shooter: InstanceId,
    ray: Ray,
    hit: Hit,
}

struct Game {
    asset: Arc<Asset>,
    clip: usize,
    head: usize,
    players: Vec<Player>,
    ids: Vec<InstanceId>,
    present: Scene,
    /// The same players in the same order, so that hits name them alike. Shares the asset.
    past: Scene,
    ring: Ring,
}

#[derive(Default)]
struct Verdicts {
    judged: usize,
    /// Shots whose tick the ring had forgotten.
    too_late: usize,
    /// Judged shots that would have missed their target in the present pose.
    missed_now: usize,
    /// Per judged shot: setting all players back, and the ray.
    micros: Vec<f64>,
}

impl Game {
    fn new() -> Result<Self, Box<dyn Error>> {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker.glb");
        let baked = bake(&import(&source)?.animation, &BakeSettings::default(), &NoProgress)?;
        let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?);
        let (mut present, mut past) = (Scene::new(), Scene::new());
        let mut chance = fastrand::Rng::with_seed(6);
        let players = (0..PLAYERS).map(|_| Player {
            start: Vec3::new(chance.f32() * ARENA, 0.0, chance.f32() * ARENA),
            heading: chance.f32() * std::f32::consts::TAU,
            phase: chance.f32(),
        });
        let players = players.collect();
        let add_to_both = |_| {
            past.add(&asset);
            present.add(&asset)
        };
        let ids = (0..PLAYERS).map(add_to_both).collect();
        Ok(Self {
            clip: asset.clip("walk").ok_or("the walker walks")?,
            head: asset.bone("head").ok_or("the walker has a head")?,
            asset,
            players,
            ids,
            present,
            past,
            ring: Ring::default(),
        })
    }

    /// Moves all players to a tick, and keeps it.
    fn advance(&mut self, tick: u64) -> Result<(), Box<dyn Error>> {
        for (number, (player, id)) in self.players.iter().zip(&self.ids).enumerate() {
            let seconds = tick as f32 * TICK;
            self.present
                .set_transform(*id, turned(player.heading, player.place(tick)))?;
            self.present
                .play(*id, self.clip, (player.phase + HASTE * seconds).fract())?;
            if number % PER_OWN_PALETTE == 0 {
                let mut palette = self.present.pose(*id)?.palette;
                let rest_from_joint = self.asset.model().bones[self.head].inverse_bind().columns[3].map(|x| -x);
                let pivot = Vec3::from(palette[self.head].transform_point(rest_from_joint));
                let turn = turned((3.0 * seconds).sin(), pivot) * Affine::from_translation((-pivot).to_array());
                palette[self.head] = turn * palette[self.head];
                self.present.set_palette(*id, &palette, &[])?;
            }
        }
        self.ring.record(&self.present, &self.ids)
    }

    /// A shot at the chest of another player, if there is one in range and nobody in between.
    fn fire(&mut self, tick: u64, chance: &mut fastrand::Rng) -> Option<Shot> {
        let [shooter, target] = [0; 2].map(|_| chance.usize(..PLAYERS));
        let from = self.players[shooter].place(tick) + 1.5 * Vec3::Y;
        let line = self.players[target].place(tick) + 1.2 * Vec3::Y - from;
        let length = line.length();
        if shooter == target || length > RANGE {
            return None;
        }
        // At length one, so that t counts in metres.
        let ray = Ray::new(from.to_array(), (line / length).to_array());
        let [shooter, target] = [shooter, target].map(|player| self.ids[player]);
        // A shot passes through the player who fires it.
        let hit = self.present.commit().closest_hit_among(&ray, |id| id != shooter)?;
        (hit.instance == target).then(|| Shot {
            seen: tick,
            heard: tick + chance.u64(LATENESS),
            shooter,
            ray,
            hit,
        })
    }

    /// Judges a shot in the tick that its shooter saw.
    fn judge(&mut self, shot: &Shot, verdicts: &mut Verdicts) -> Result<(), Box<dyn Error>> {
        let present = self.present.commit();
        let others = |id| id != shot.shooter;
        let now = present.closest_hit_among(&shot.ray, others);

        let Some(states) = self.ring.at(shot.seen) else {
            verdicts.too_late += 1;
            return Ok(());
        };
        let start = Instant::now();
        let judged = rewound(&mut self.past, &self.ids, states)?.closest_hit_among(&shot.ray, others);
        verdicts.micros.push(start.elapsed().as_secs_f64() * 1e6);

        if judged != Some(shot.hit) {
            return Err(format!("seen as {:?}, judged as {judged:?}", shot.hit).into());
        }
        if present.closest_hit_among(&shot.ray, others) != now {
            return Err("judging the past has changed the present".into());
        }
        verdicts.judged += 1;
        verdicts.missed_now += usize::from(now.is_none_or(|hit| hit.instance != shot.hit.instance));
        Ok(())
    }

    fn play(&mut self) -> Result<Verdicts, Box<dyn Error>> {
        let mut chance = fastrand::Rng::with_seed(7);
        let mut shots: Vec<Shot> = Vec::new();
        let mut verdicts = Verdicts::default();
        for tick in 0..TICKS {
            self.advance(tick)?;
            for _ in 0..20 {
                shots.extend(self.fire(tick, &mut chance));
            }
            for shot in shots.extract_if(.., |shot| shot.heard == tick) {
                self.judge(&shot, &mut verdicts)?;
            }
        }
        Ok(verdicts)
    }
}

/// All players as they were.
fn rewound<'a>(
    scene: &'a mut Scene,
    ids: &[InstanceId],
    states: &[InstanceState],
) -> Result<Frame<'a>, Box<dyn Error>> {
    for (id, state) in ids.iter().zip(states) {
        scene.set_state(*id, state)?;
    }
    Ok(scene.commit())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut game = Game::new()?;
    let mut verdicts = game.play()?;

    let states = TICKS_KEPT as usize * PLAYERS;
    let palettes = states / PER_OWN_PALETTE;
    let palette_bytes = game.asset.model().bones.len() * size_of::<Affine>();
    println!(
        "the ring: {TICKS_KEPT} ticks of {PLAYERS} players, {} KiB of states and {} KiB of {palettes} own palettes",
        states * size_of::<InstanceState>() / 1024,
        palettes * palette_bytes / 1024,
    );
    println!(
        "{} shots were judged as their shooters saw them; {} came too late",
        verdicts.judged, verdicts.too_late
    );
    println!(
        "in the present pose {} of them would have missed; the present was not touched",
        verdicts.missed_now
    );
    verdicts.micros.sort_by(f64::total_cmp);
    let at = |part: f64| verdicts.micros[(part * (verdicts.micros.len() - 1) as f64) as usize];
    println!(
        "setting all players back and judging one shot: {:.1} us, the median; {:.1} us at most in 99 of 100",
        at(0.5),
        at(0.99)
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shots_are_judged_as_they_were_seen() {
        let mut game = Game::new().expect("the walker is baked");
        let verdicts = game.play().expect("each shot is judged as it was seen");
        assert!(verdicts.judged > 100 && verdicts.too_late > 0);
        // Players run on for 60 ms and more, past lines as wide as a point: most shots miss by then.
        assert!(verdicts.missed_now * 2 > verdicts.judged);
    }

    #[test]
    fn the_ring_keeps_just_the_last_ticks() {
        let mut game = Game::new().expect("the walker is baked");
        assert!(game.ring.at(0).is_none());
        for tick in 0..TICKS_KEPT + 3 {
            game.advance(tick).expect("the players run");
        }
        assert!(game.ring.at(2).is_none() && game.ring.at(TICKS_KEPT + 3).is_none());
        for tick in 3..TICKS_KEPT + 3 {
            let states = game.ring.at(tick).expect("the tick is kept");
            let expected = turned(game.players[7].heading, game.players[7].place(tick));
            assert_eq!(states[7].transform(), &expected);
        }
    }
}
