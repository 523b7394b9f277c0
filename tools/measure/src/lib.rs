//! Measurements of baked assets: tables and plots of numbers that a run produced. Nothing here prints.

pub mod builders;
mod checked_rays;
mod clock;
#[cfg(feature = "peers")]
mod embree;
mod error;
pub mod frame;
pub mod motion;
mod page;
mod peak_memory;
mod place;
mod plot;
mod posed_rays;
pub mod poses;
mod ray_cost;
mod ray_sums;
mod spread;
mod static_twin;
mod statistics;
mod subdivision_limit;
pub mod tessellations;
mod text_row;
mod thread_pools;
mod view;

pub use error::{MeasureError, WrongHit, WrongTreeHit};
pub use place::Place;
pub use ray_cost::{RayCost, TreeCost};
pub use text_row::TextRow;
