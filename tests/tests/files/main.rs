//! Files: opened, cut short, of the same bytes each time; and that tests of the contract see one that is too tight.

mod determinism;
mod opening;
mod sabotage;
mod wide_files;
