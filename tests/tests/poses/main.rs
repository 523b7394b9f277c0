//! Poses: what refuses one, what bounds hold in one, and that they hold without any slack beside what is proven.

mod clip_bounds;
mod exact_boxes;
mod key_boxes;
mod pose_space;
mod poses;
mod rounded_motion;
