mod bad_input;
mod known_motion;
mod on_scenes;
mod soup;
