//! Pictures of a scene. Every pixel is a pure function of its place, so any number of threads gives the same bytes.

mod animation_file;
mod camera;
mod canvas;
mod colour;
mod corner_fans;
mod film;
mod heat_map;
mod legend;
mod lettering;
mod line;
mod movement;
mod palette;
mod png_file;
mod sampling;
mod shading;
mod surroundings;
mod triangle_colours;
mod wire_boxes;

pub use animation_file::{AnimationFile, delays};
pub use film::{CameraPlace, Film, Look};
pub use movement::Movement;
pub use palette::ColourCount;
pub use png_file::{decode_png, encode_png};
