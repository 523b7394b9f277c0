//! `machine.gltf`: gears, a crank with a piston, hammers: rigid parts that only their nodes move.

use crate::column::{Column, Component, narrow_rotation, narrow3};
use crate::flat_mesh::{add_flat_mesh, add_mesh, cylinder, indexed, soup};
use crate::gltf_json::Node;
use crate::gltf_writer::{GltfWriter, Track, WriteError};
use crate::rotation::{about_x, about_z, cos_turn, sin_turn};
use crate::solids::{GearShape, circle, cuboid, gear, lathe, loft, sphere};
use crate::surface::Surface;
use glam::{DQuat, DVec3};

/// Height of the gears' axles.
const AXLE_Y: f64 = 1.0;
const DRIVE_RADIUS: f64 = 0.6;
const PINION_RADIUS: f64 = 0.3;
const CRANK_RADIUS: f64 = 0.36;
const ROD_LENGTH: f64 = 1.05;
/// Seconds for one turn of the drive gear.
const CYCLE: f64 = 2.0;
const KEYS: u32 = 32;

/// The scene's text, its buffer inside as a data URI.
///
/// # Errors
/// [`WriteError`] as [`GltfWriter::into_embedded_gltf`] says.
pub fn machine_gltf() -> Result<Vec<u8>, WriteError> {
    let mut writer = GltfWriter::new("machine");
    let paint = Paint {
        steel: writer.add_material("steel", [0.5, 0.53, 0.57]),
        brass: writer.add_material("brass", [0.72, 0.5, 0.16]),
        red: writer.add_material("red", [0.68, 0.1, 0.07]),
        dark: writer.add_material("dark", [0.16, 0.18, 0.2]),
    };
    let root = writer.add_root(named("machine", DVec3::ZERO));
    add_housing(&mut writer, root, &paint);
    let mut run = add_gears(&mut writer, root, &paint);
    run.extend(add_hammers(&mut writer, root, &paint));
    run.push(add_bellows(&mut writer, root, &paint));
    writer.add_clip("run", &run);
    let signal = add_signals(&mut writer, root, &paint);
    writer.add_clip("signal", &signal);
    writer.into_embedded_gltf()
}

struct Paint {
    steel: usize,
    brass: usize,
    red: usize,
    dark: usize,
}

fn named(name: &str, place: DVec3) -> Node {
    Node {
        name: name.to_owned(),
        translation: (place != DVec3::ZERO).then(|| narrow3(place)),
        ..Node::default()
    }
}

fn with_mesh(name: &str, place: DVec3, mesh: usize) -> Node {
    Node {
        mesh: Some(mesh),
        ..named(name, place)
    }
}

fn cuboid_between(low: [f64; 3], high: [f64; 3]) -> Surface {
    cuboid(DVec3::from(low), DVec3::from(high))
}

fn joined(solids: &[Surface]) -> Surface {
    let mut whole = Surface::default();
    for solid in solids {
        whole.append(solid);
    }
    whole
}

/// What stands still: the slab, the panel that carries the axles, the tower that guides the piston.
fn add_housing(writer: &mut GltfWriter, root: usize, paint: &Paint) {
    let slab = cuboid_between([-1.9, 0.0, -0.7], [1.9, 0.12, 1.1]);
    let rim = cuboid_between([-1.98, 0.0, -0.78], [1.98, 0.06, 1.18]);
    let primitives = vec![soup(writer, &slab, paint.steel), soup(writer, &rim, paint.dark)];
    let slab = add_mesh(writer, "slab", primitives);
    writer.add_child(root, with_mesh("slab", DVec3::ZERO, slab));

    let panel = joined(&[
        cuboid_between([-1.35, 0.12, -0.34], [1.35, 1.75, -0.24]),
        cuboid_between([-0.36, 1.7, -0.35], [0.36, 2.95, -0.25]),
        cuboid_between([-0.36, 1.75, -0.26], [-0.3, 2.95, 0.5]),
        cuboid_between([0.3, 1.75, -0.26], [0.36, 2.95, 0.5]),
    ]);
    let panel = add_flat_mesh(writer, "panel", &panel, paint.dark);
    writer.add_child(root, with_mesh("panel", DVec3::ZERO, panel));

    let primitives = cylinder(writer, 0.5, 20, paint.steel);
    let rod = add_mesh(writer, "round_bar", primitives);
    // One mesh under many nodes: axles, and the four posts of the slab.
    let lying = Some(narrow_rotation(about_x(90.0)));
    for (name, x) in [("axle_middle", 0.0), ("axle_right", 0.9), ("axle_left", -0.9)] {
        let node = Node {
            rotation: lying,
            scale: Some([0.16, 0.5, 0.16]),
            ..with_mesh(name, DVec3::new(x, AXLE_Y, -0.06), rod)
        };
        writer.add_child(root, node);
    }
    for (index, (x, z)) in [(-1.75, -0.55), (1.75, -0.55), (1.75, 0.95), (-1.75, 0.95)]
        .into_iter()
        .enumerate()
    {
        let node = Node {
            scale: Some([0.14, 0.3, 0.14]),
            ..with_mesh(&format!("post_{index}"), DVec3::new(x, 0.25, z), rod)
        };
        writer.add_child(root, node);
    }
}

/// Key times of one cycle.
fn cycle_times() -> Vec<f64> {
    (0..=KEYS).map(|key| CYCLE * f64::from(key) / f64::from(KEYS)).collect()
}

/// A linear track over one cycle from a function of the drive gear's turn (0 to 1).
fn rotation_track(node: usize, rotation: impl Fn(f64) -> DQuat) -> Track {
    let times = cycle_times();
    let values: Vec<_> = times.iter().map(|time| rotation(time / CYCLE)).collect();
    Track {
        node,
        path: "rotation",
        interpolation: "LINEAR",
        times,
        values: Column::rotations(&values),
    }
}

/// The drive gear with the crank on it, the rod and the piston, and the two pinions.
fn add_gears(writer: &mut GltfWriter, root: usize, paint: &Paint) -> Vec<Track> {
    let drive = gear(GearShape {
        teeth: 24,
        pitch_radius: DRIVE_RADIUS,
        bore_radius: 0.06,
        half_thickness: 0.06,
    });
    // Turned about x the disc's axis becomes that of the gears.
    let disc = loft(&[circle(0.47, 0.07, 28), circle(0.47, 0.14, 28)]);
    let pin = loft(&[circle(0.06, 0.1, 16), circle(0.06, 0.36, 16)]);
    let upright = |solid: Surface| solid.map(|point| DVec3::new(point.x, -point.z, point.y));
    let pin = upright(pin).translated(DVec3::new(0.0, CRANK_RADIUS, 0.0));
    let primitives = vec![
        indexed(writer, &drive, paint.brass, Component::U32),
        indexed(writer, &joined(&[upright(disc), pin]), paint.steel, Component::U16),
    ];
    let mesh = add_mesh(writer, "drive_gear", primitives);
    let drive = writer.add_child(root, with_mesh("drive_gear", DVec3::new(0.0, AXLE_Y, 0.0), mesh));
    let mut tracks = vec![rotation_track(drive, |turn| about_z(360.0 * turn))];

    let pinion = gear(GearShape {
        teeth: 12,
        pitch_radius: PINION_RADIUS,
        bore_radius: 0.06,
        half_thickness: 0.06,
    });
    let pinion = add_flat_mesh(writer, "pinion", &pinion, paint.red);
    for (name, sign) in [("pinion_right", 1.0), ("pinion_left", -1.0)] {
        let place = DVec3::new(sign * (DRIVE_RADIUS + PINION_RADIUS), AXLE_Y, 0.0);
        let node = writer.add_child(root, with_mesh(name, place, pinion));
        // Half a tooth ahead, so that a gap meets the drive gear's tooth.
        tracks.push(rotation_track(node, |turn| about_z(15.0 - 720.0 * turn)));
    }

    let place = DVec3::new(0.0, CRANK_RADIUS, 0.3);
    let mesh = add_flat_mesh(writer, "connecting_rod", &connecting_rod(), paint.steel);
    let rod = writer.add_child(drive, with_mesh("connecting_rod", place, mesh));
    tracks.push(rotation_track(rod, |turn| {
        let lean = libm::asin(-CRANK_RADIUS * sin_turn(turn) / ROD_LENGTH).to_degrees();
        about_z(lean - 360.0 * turn)
    }));
    tracks.push(add_piston(writer, root, paint));
    tracks
}

/// A bar with round ends, from the origin up to [`ROD_LENGTH`].
fn connecting_rod() -> Surface {
    let ends = 16_u32;
    let outline = |z: f64| -> Vec<DVec3> {
        (0..ends)
            .map(|step| {
                let turn = (f64::from(step) + 0.5) / f64::from(ends);
                let upper = turn < 0.5;
                let (radius, middle) = if upper { (0.085, ROD_LENGTH) } else { (0.11, 0.0) };
                DVec3::new(radius * cos_turn(turn), middle + radius * sin_turn(turn), z)
            })
            .collect()
    };
    loft(&[outline(-0.035), outline(0.035)])
}

fn add_piston(writer: &mut GltfWriter, root: usize, paint: &Paint) -> Track {
    let body = lathe(&[(0.2, -0.12), (0.22, -0.1), (0.22, 0.36), (0.2, 0.38)], 24);
    let ring = |y: f64| lathe(&[(0.2, y), (0.235, y + 0.01), (0.235, y + 0.04), (0.2, y + 0.05)], 24);
    let rings = joined(&[ring(0.2), ring(0.28)]);
    let primitives = vec![
        indexed(writer, &body, paint.steel, Component::U16),
        indexed(writer, &rings, paint.brass, Component::U16),
    ];
    let mesh = add_mesh(writer, "piston", primitives);
    let height = |turn: f64| {
        let aside = CRANK_RADIUS * sin_turn(turn);
        let rod = (ROD_LENGTH * ROD_LENGTH - aside * aside).sqrt();
        DVec3::new(0.0, AXLE_Y + CRANK_RADIUS * cos_turn(turn) + rod, 0.3)
    };
    let node = writer.add_child(root, with_mesh("piston", height(0.0), mesh));
    let times = cycle_times();
    let values: Vec<_> = times.iter().map(|time| height(time / CYCLE)).collect();
    Track {
        node,
        path: "translation",
        interpolation: "LINEAR",
        times,
        values: Column::vectors(&values),
    }
}

/// Two hammers of one mesh; the left one hangs under a node that mirrors it.
fn add_hammers(writer: &mut GltfWriter, root: usize, paint: &Paint) -> Vec<Track> {
    let arm = joined(&[
        cuboid_between([-0.08, -0.05, -0.05], [0.62, 0.05, 0.05]),
        // The head leans outwards, which tells the mirrored hammer from a turned one.
        cuboid_between([0.44, -0.24, -0.11], [0.64, 0.12, 0.11])
            .map(|point| DVec3::new(point.x + 0.25 * point.y, point.y, point.z)),
    ]);
    let arm = add_flat_mesh(writer, "hammer", &arm, paint.red);
    let stand = joined(&[
        cuboid_between([-0.07, -0.5, -0.15], [0.07, 0.1, -0.07]),
        cuboid_between([-0.07, -0.5, 0.07], [0.07, 0.1, 0.15]),
        cuboid_between([0.3, -0.5, -0.15], [0.66, -0.26, 0.15]),
    ]);
    let stand = add_flat_mesh(writer, "hammer_stand", &stand, paint.steel);
    let place = DVec3::new(0.75, 0.62, 0.65);

    let mirror = Node {
        scale: Some([-1.0, 1.0, 1.0]),
        ..named("mirror", DVec3::ZERO)
    };
    let mirror = writer.add_child(root, mirror);
    let mut tracks = Vec::new();
    for (side, parent, delay) in [("right", root, 0.0), ("left", mirror, 1.0)] {
        let stand_name = format!("hammer_stand_{side}");
        let stand = writer.add_child(parent, with_mesh(&stand_name, place, stand));
        let name = format!("hammer_{side}");
        let node = writer.add_child(stand, with_mesh(&name, DVec3::ZERO, arm));
        // Rises, drops, rests.
        let keys = [(0.0, 0.0), (0.7, 42.0), (0.8, 42.0), (0.92, 0.0), (1.0, 0.0)];
        let times = keys.map(|(time, _)| time + delay).to_vec();
        let values = keys.map(|(_, degrees)| about_z(degrees));
        tracks.push(Track {
            node,
            path: "rotation",
            interpolation: "LINEAR",
            times,
            values: Column::rotations(&values),
        });
    }
    tracks
}

/// A bellows on the panel that its node stretches.
fn add_bellows(writer: &mut GltfWriter, root: usize, paint: &Paint) -> Track {
    let folds: Vec<_> = (0..=10_u32)
        .map(|step| (if step % 2 == 0 { 0.12 } else { 0.19 }, 0.05 * f64::from(step)))
        .collect();
    let mesh = add_flat_mesh(writer, "bellows", &lathe(&folds, 20), paint.brass);
    let place = DVec3::new(0.9, 1.75, -0.05);
    let node = writer.add_child(root, with_mesh("bellows", place, mesh));
    let shelf = cuboid_between([-0.22, -0.05, -0.22], [0.22, 0.0, 0.22]);
    let shelf = add_flat_mesh(writer, "shelf", &shelf, paint.dark);
    writer.add_child(root, with_mesh("shelf", place, shelf));
    Track {
        node,
        path: "scale",
        interpolation: "LINEAR",
        times: vec![0.0, 0.5, 1.0, 1.5, 2.0],
        values: Column::floats(&[0.6, 1.2, 0.6, 1.2, 0.6].map(|height| [1.0, height, 1.0])),
    }
}

/// A counting wheel, an arm and a lamp, all of which jump from key to key.
fn add_signals(writer: &mut GltfWriter, root: usize, paint: &Paint) -> Vec<Track> {
    let wheel = gear(GearShape {
        teeth: 8,
        pitch_radius: 0.14,
        bore_radius: 0.03,
        half_thickness: 0.04,
    });
    let wheel = add_flat_mesh(writer, "counting_wheel", &wheel, paint.brass);
    let wheel = writer.add_child(root, with_mesh("counting_wheel", DVec3::new(-1.1, 1.5, -0.19), wheel));
    let arm = joined(&[
        cuboid_between([-0.06, -0.035, -0.02], [0.3, 0.035, 0.02]),
        cuboid_between([0.26, -0.08, -0.025], [0.46, 0.08, 0.025]),
    ]);
    let arm = add_flat_mesh(writer, "arm", &arm, paint.red);
    let arm = writer.add_child(root, with_mesh("arm", DVec3::new(1.2, 1.5, -0.2), arm));
    let lamp = sphere(2).map(|point| point * 0.16);
    let lamp = add_flat_mesh(writer, "lamp", &lamp, paint.red);
    let lamp = writer.add_child(root, with_mesh("lamp", DVec3::new(0.0, 3.02, -0.1), lamp));

    let stepped = |node, path, times: &[f64], values| Track {
        node,
        path,
        interpolation: "STEP",
        times: times.to_vec(),
        values,
    };
    let quarters = [0.0, 0.5, 1.0, 1.5, 2.0];
    let clicks = [0.0, 22.5, 45.0, 67.5, 90.0].map(about_z);
    let swings = [0.0, 45.0, 0.0, -45.0, 0.0].map(about_z);
    let sizes = [1.0_f32, 0.6, 1.0, 0.6, 1.0].map(|size| [size; 3]);
    let places = [3.02, 3.1, 3.02].map(|y| DVec3::new(0.0, y, -0.1));
    vec![
        stepped(wheel, "rotation", &quarters, Column::rotations(&clicks)),
        stepped(arm, "rotation", &quarters, Column::rotations(&swings)),
        stepped(lamp, "scale", &quarters, Column::floats(&sizes)),
        stepped(lamp, "translation", &[0.25, 1.25, 1.75], Column::vectors(&places)),
    ]
}
