use crate::{
    fixture::{baked_door, folder, sample},
    run::restpose,
};
use image::{AnimationDecoder, RgbImage};
use std::{fs, path::Path};

const VIEWS: [&str; 4] = ["shaded", "clusters", "boxes", "steps"];

/// Renders `scene.rpose`, three frames unless the options say otherwise, and gives the files by name.
fn render(folder: &Path, output: &str, options: &[&str]) -> Vec<(String, Vec<u8>)> {
    let start = ["render", "scene.rpose", "-o", output, "--size", "64x48"];
    let frames: &[&str] = if options.contains(&"--frames") {
        &[]
    } else {
        &["--frames", "3"]
    };
    restpose(folder, start.iter().chain(frames).chain(options)).succeeded();
    let mut contents: Vec<(String, Vec<u8>)> = fs::read_dir(folder.join(output))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .map(|path| {
            (
                path.file_name().expect("a name").to_string_lossy().into_owned(),
                fs::read(&path).expect("bytes"),
            )
        })
        .collect();
    contents.sort();
    contents
}

fn pixels(png: &[u8]) -> RgbImage {
    image::load_from_memory(png).expect("a picture").into_rgb8()
}

#[test]
fn pictures_do_not_depend_on_threads() {
    let folder = folder();
    let source = sample("walker.glb");
    restpose(
        folder.path(),
        ["bake", source.to_str().expect("text"), "-o", "scene.rpose"],
    )
    .succeeded();
    for view in VIEWS {
        let one = render(folder.path(), &format!("{view}1"), &["--view", view, "-j", "1"]);
        let two = render(folder.path(), &format!("{view}2"), &["--view", view, "-j", "2"]);
        assert!(one == two, "{view}");
        let names: Vec<&str> = one.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            ["animation.gif", "frame_0000.png", "frame_0001.png", "frame_0002.png"]
        );
    }
}

#[test]
fn every_view_shows_something_else_and_every_frame_moves() {
    let folder = folder();
    fs::rename(baked_door(folder.path()), folder.path().join("scene.rpose")).expect("same folder");
    let views = VIEWS.map(|view| render(folder.path(), view, &["--view", view]));
    for (i, a) in views.iter().enumerate() {
        assert!(views[..i].iter().all(|b| a[1] != b[1]), "{}", VIEWS[i]);
        assert!(a[1].1 != a[2].1 && a[2].1 != a[3].1, "{}", VIEWS[i]);
        let image = pixels(&a[1].1);
        assert_eq!(image.dimensions(), (64, 48));
    }
}

#[test]
fn the_animation_holds_the_frames_for_the_length_of_the_clip() {
    let folder = folder();
    fs::rename(baked_door(folder.path()), folder.path().join("scene.rpose")).expect("same folder");
    let contents = render(folder.path(), "out", &[]);
    let decoder = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(&contents[0].1)).expect("a GIF");
    let frames = decoder.into_frames().collect_frames().expect("whole frames");
    assert_eq!(frames.len(), 3);
    let milliseconds: u32 = frames.iter().map(|frame| frame.delay().numer_denom_ms().0).sum();
    assert_eq!(milliseconds, 1000);
    for (frame, (_, png)) in frames.iter().zip(&contents[1..]) {
        let apart = frame
            .buffer()
            .pixels()
            .zip(pixels(png).pixels().copied().collect::<Vec<_>>());
        let sum: u32 = apart
            .map(|(a, b)| (0..3).map(|k| u32::from(a[k].abs_diff(b[k]))).sum::<u32>())
            .sum();
        // On average a channel is within four steps: 255 colours and the dither stand for about 3,000.
        assert!(sum < 64 * 48 * 3 * 4, "{sum}");
    }
}

#[test]
fn the_door_throws_a_shadow_on_the_floor() {
    let folder = folder();
    fs::rename(baked_door(folder.path()), folder.path().join("scene.rpose")).expect("same folder");
    // At the start the door stands in the plane z = 0 over x from 0 to 0.8: light along z shadows the floor behind it.
    let view = [
        "--from",
        "0",
        "--frames",
        "1",
        "--camera",
        "0,6,0.01",
        "--target",
        "0,0,0",
        "--fov",
        "30",
        "--no-floor",
    ];
    let brightness = |light: &str, output: &str, x: u32, y: u32| -> u32 {
        let contents = render(folder.path(), output, &[&view[..], &["--light", light]].concat());
        pixels(&contents[1].1)
            .get_pixel(x, y)
            .0
            .iter()
            .map(|byte| u32::from(*byte))
            .sum()
    };
    // 64 × 48 pixels see 3.2 units upwards: a unit is 15 pixels, x to the right, z downwards. The light comes from
    // the front (+z) at 45 degrees, so the shadow lies at z from -0.1 to -1.1, left of x = 0.8.
    let shadowed = brightness("0,1,1", "a", 32 + 6, 24 - 8);
    let beside = brightness("0,1,1", "b", 32 - 6, 24 - 8);
    let from_behind = brightness("0,1,-1", "c", 32 + 6, 24 - 8);
    assert!(shadowed + 60 < beside, "{shadowed} {beside}");
    assert_eq!(beside, from_behind);
}

#[test]
fn a_folder_is_filled_again_over_older_pictures() {
    let folder = folder();
    fs::rename(baked_door(folder.path()), folder.path().join("scene.rpose")).expect("same folder");
    let first = render(folder.path(), "deep/out", &[]);
    let second = render(folder.path(), "deep/out", &["--view", "steps"]);
    assert_eq!(first.len(), second.len());
    assert!(first.iter().zip(&second).all(|(a, b)| a.0 == b.0 && a.1 != b.1));
}
