//! Measurements of baked assets: tables and plots of numbers that a run produced. Nothing here prints.

mod error;
pub mod frame;
mod plot;
mod statistics;

pub use error::{MeasureError, WrongHit};
