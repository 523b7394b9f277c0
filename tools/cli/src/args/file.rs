use clap::Args;
use std::path::PathBuf;

/// Options of `info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// A .rpose file
    pub file: PathBuf,
}

/// Options of `validate`.
#[derive(Debug, Args)]
pub struct ValidateArgs {
    /// A .rpose file
    pub file: PathBuf,
}
