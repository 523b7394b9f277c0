//! The tables of `restpose measure`, on samples, with settings that take no time.

mod builders;
mod frame;
mod motion;
mod poses;
mod tessellations;
