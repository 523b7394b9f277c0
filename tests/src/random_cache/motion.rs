use fastrand::Rng;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// How a piece of a random cache moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Not at all.
    Still,
    /// Turns and travels a little from frame to frame.
    Drift,
    /// Turned and put anywhere in each frame.
    Tumble,
    /// By half a turn from each frame to the next, about an axis that may be one of the coordinate axes.
    HalfTurns,
    /// By another affine map in each frame.
    Stretch,
    /// As [`Motion::Stretch`], and in some frames as its mirror image.
    Mirror,
    /// In some frames flattened onto a plane, a line or a point.
    Collapse,
    /// In each frame 1, 40, 1e-3 or 1e-9 times its size.
    Swell,
    /// In some frames a thousand units away.
    Teleport,
    /// Each point on its own, anywhere in each frame.
    Free,
}

impl Motion {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::Still,
        Self::Drift,
        Self::Tumble,
        Self::HalfTurns,
        Self::Stretch,
        Self::Mirror,
        Self::Collapse,
        Self::Swell,
        Self::Teleport,
        Self::Free,
    ];

    /// Those that keep all lengths and handedness.
    pub const RIGID: &'static [Self] = &[Self::Still, Self::Drift, Self::Tumble, Self::HalfTurns, Self::Teleport];
}

/// Where a piece's points are taken in one frame: turned and stretched about the piece's centre, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Map {
    pub linear: Matrix3<f64>,
    pub shift: Vector3<f64>,
    /// How far each point strays from the map, units.
    pub stray: f64,
}

/// One map per frame. One frame in six repeats the frame before.
pub(super) fn maps(motion: Motion, frames: usize, random: &mut Rng) -> Vec<Map> {
    let mut path = Path::new(motion, random);
    let mut maps: Vec<Map> = Vec::with_capacity(frames);
    for frame in 0..frames {
        let map = path.step(frame, random);
        let held = random.u32(..6) == 0;
        maps.push(maps.last().filter(|_| held).copied().unwrap_or(map));
    }
    maps
}

struct Path {
    motion: Motion,
    turn: UnitQuaternion<f64>,
    shift: Vector3<f64>,
    axis: Vector3<f64>,
}

impl Path {
    fn new(motion: Motion, random: &mut Rng) -> Self {
        let axis = if random.bool() {
            Vector3::ith(random.usize(..3), 1.0)
        } else {
            turn(random) * Vector3::x()
        };
        Self {
            motion,
            turn: turn(random),
            shift: vector(random, 0.3),
            axis,
        }
    }

    fn step(&mut self, frame: usize, random: &mut Rng) -> Map {
        let mut stray = 0.0;
        let upright: Matrix3<f64> = self.turn.to_rotation_matrix().into();
        let linear = match self.motion {
            Motion::Still => upright,
            Motion::Drift => {
                let little = Quaternion::from_parts(1.0, vector(random, 0.1));
                self.turn = UnitQuaternion::from_quaternion(little * self.turn.quaternion());
                self.shift += vector(random, 0.1);
                self.turn.to_rotation_matrix().into()
            }
            Motion::Tumble => {
                self.shift = vector(random, 1.0);
                turn(random).to_rotation_matrix().into()
            }
            // About an axis u, 2uuᵀ − 1: no rounding at all where u is a coordinate axis.
            Motion::HalfTurns if frame % 2 == 1 => self.axis * self.axis.transpose() * 2.0 - Matrix3::identity(),
            Motion::HalfTurns => Matrix3::identity(),
            Motion::Stretch => upright * affine(random),
            Motion::Mirror => {
                let sign = if random.bool() { -1.0 } else { 1.0 };
                upright * Matrix3::from_diagonal(&Vector3::new(sign, 1.0, 1.0)) * affine(random)
            }
            Motion::Collapse => {
                let kept = random.usize(..6).min(3);
                let kept = Vector3::from_fn(|axis, _| if axis < kept { 1.0 } else { 0.0 });
                upright * Matrix3::from_diagonal(&kept)
            }
            Motion::Swell => upright * [1.0, 40.0, 1e-3, 1e-9][random.usize(..4)],
            Motion::Teleport => {
                if random.u32(..3) == 0 {
                    self.shift = vector(random, 1e3);
                }
                upright
            }
            Motion::Free => {
                stray = 1.0;
                upright
            }
        };
        Map {
            linear,
            shift: self.shift,
            stray,
        }
    }
}

/// Uneven scales and shear about the identity.
fn affine(random: &mut Rng) -> Matrix3<f64> {
    Matrix3::identity() + Matrix3::from_fn(|_, _| signed(random, 0.6))
}

/// Any turn. Only square roots: the same on every machine.
fn turn(random: &mut Rng) -> UnitQuaternion<f64> {
    let parts = Quaternion::from_parts(signed(random, 1.0), vector(random, 1.0));
    UnitQuaternion::try_new(parts, 0.0).unwrap_or_default()
}

/// In a cube about the origin.
pub(super) fn vector(random: &mut Rng, magnitude: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| signed(random, magnitude))
}

fn signed(random: &mut Rng, magnitude: f64) -> f64 {
    (random.f64() * 2.0 - 1.0) * magnitude
}
