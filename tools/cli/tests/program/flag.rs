//! A flag that bends beside a stone that flies, frame by frame: as OBJ with PC2, OBJ with MDD, and a folder of OBJ files.

use crate::run::restpose;
use restpose_formats::{AlignedBytes, Model, read, write};
use std::{fs, path::Path};

pub const FRAMES: usize = 6;
const COLUMNS: usize = 17;

/// Points of the flag, two per column, then of the stone, in one frame.
fn points(frame: usize) -> Vec<[f32; 3]> {
    // First the far end curls, then the near one: each half of the time has clusters of its own.
    let (early, late) = (frame.min(2) as f32 * 0.12, frame.saturating_sub(2) as f32 * 0.12);
    let cloth = (0..COLUMNS).flat_map(|column| {
        let x = column as f32 / 8.0;
        let near = 2.0 - x;
        let z = early * x * x * x + late * near * near * near;
        [[x, 1.0, z], [x, 2.0, z + 0.3 * early]]
    });
    let flown = frame as f32 * 0.5;
    let stone = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]];
    cloth.chain(stone.map(|[x, y, z]| [x + flown, y - 1.0, z])).collect()
}

fn obj(points: &[[f32; 3]]) -> String {
    let mut lines: Vec<String> = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}")).collect();
    lines.push("o cloth".to_owned());
    lines.extend((0..COLUMNS - 1).map(|column| {
        let first = 2 * column + 1;
        format!("f {first} {} {} {}", first + 2, first + 3, first + 1)
    }));
    lines.push("o stone".to_owned());
    lines.extend(["f -4 -2 -3", "f -4 -3 -1", "f -4 -1 -2", "f -3 -2 -1"].map(str::to_owned));
    lines.join("\n") + "\n"
}

/// Writes `flag.obj` and `flag.pc2`.
pub fn flag(folder: &Path) {
    fs::write(folder.join("flag.obj"), obj(&points(0))).expect("room");
    fs::write(folder.join("flag.pc2"), pc2(points(0).len())).expect("room");
}

/// A PC2 file of so many of the flag's points.
pub fn pc2(point_count: usize) -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    bytes.extend([1, point_count as i32].iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend([0.0f32, 1.0].iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend((FRAMES as i32).to_le_bytes());
    for frame in 0..FRAMES {
        let numbers = points(frame).into_iter().take(point_count).flatten();
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
    }
    bytes
}

/// Writes `flag.mdd`, four frames a second.
pub fn mdd(folder: &Path) {
    let mut bytes: Vec<u8> = [FRAMES as i32, points(0).len() as i32]
        .iter()
        .flat_map(|number| number.to_be_bytes())
        .collect();
    bytes.extend((0..FRAMES).flat_map(|frame| (frame as f32 / 4.0).to_be_bytes()));
    let numbers = (0..FRAMES).flat_map(points).flatten();
    bytes.extend(numbers.flat_map(f32::to_be_bytes));
    fs::write(folder.join("flag.mdd"), bytes).expect("room");
}

/// Writes `frames/f0.obj` and so on.
pub fn sequence(folder: &Path) {
    fs::create_dir(folder.join("frames")).expect("room");
    for frame in 0..FRAMES {
        fs::write(folder.join(format!("frames/f{frame}.obj")), obj(&points(frame))).expect("room");
    }
}

/// What makes the bake keep fuzzy trees, and split in time: with two clusters much motion is left.
pub const SEGMENTED: [&str; 8] = [
    "--rays-per-frame",
    "0",
    "--max-clusters",
    "2",
    "--segments",
    "2",
    "--size-worth",
    "0",
];

/// Bakes the flag to `flag.rpose` with these options.
pub fn baked_flag(folder: &Path, options: &[&str]) {
    flag(folder);
    let start = ["bake", "flag.obj", "flag.pc2", "-o", "flag.rpose"];
    restpose(folder, start.iter().chain(options)).succeeded();
}

/// A baked file.
pub fn model(file: &Path) -> Model {
    let bytes = AlignedBytes::copy_of(&fs::read(file).expect("just baked"));
    read(bytes.as_slice()).expect("a sound file").to_model()
}

/// A sound file whose stored positions stick out of their boxes, as `bad_flag.rpose`: what `verify` is to find.
pub fn outgrown_flag(folder: &Path) {
    baked_flag(folder, &["--rays-per-frame", "0", "--position-error", "0"]);
    let mut model = model(&folder.join("flag.rpose"));
    for word in &mut model.key_words {
        *word = (f32::from_bits(*word) * 1.5).to_bits();
    }
    for row in &mut model.cluster_bones {
        row.bounds.min = row.bounds.min.map(|x| x * 1.5);
        row.bounds.max = row.bounds.max.map(|x| x * 1.5);
    }
    fs::write(
        folder.join("bad_flag.rpose"),
        write(&model).expect("still a sound file"),
    )
    .expect("room");
}
