//! The command line: what can be asked for, with every default and range.

mod bake;
mod builders;
mod demo;
mod file;
mod frame;
mod frame_range;
mod keyframed;
mod measure;
mod poses;
mod render;
mod tree;
mod values;
mod verify;

pub use bake::BakeArgs;
pub use builders::BuildersArgs;
pub use demo::DemoArgs;
pub use file::{InfoArgs, ValidateArgs};
pub use frame::FrameArgs;
pub use measure::{MeasureArgs, MeasureTable, MotionArgs, PosesArgs, TessellationsArgs};
pub use poses::{BoundsKind, PoseArgs, PoseSpaceKind};
pub use render::{RenderArgs, SamplesPerPixel, View};
pub use values::{Size, Vector};
pub use verify::VerifyArgs;

use crate::exit_code::ExitCode;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::num::NonZeroUsize;

/// Bake an animated mesh once, then ray trace any pose of it without rebuilding anything.
#[derive(Debug, Parser)]
#[command(name = "restpose", version, after_help = ExitCode::table(), max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub global: GlobalArgs,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn an animated scene into a .rpose file
    #[command(after_help = ExitCode::table())]
    Bake(BakeArgs),
    /// Show what is in a .rpose file
    #[command(visible_alias = "inspect", after_help = ExitCode::table())]
    Info(InfoArgs),
    /// Check a .rpose file: structure and checksums, without its source
    #[command(after_help = ExitCode::table())]
    Validate(ValidateArgs),
    /// Check a .rpose file against brute force on its source
    #[command(after_help = ExitCode::table())]
    Verify(VerifyArgs),
    /// Ray trace a clip into pictures
    #[command(after_help = ExitCode::table())]
    Render(Box<RenderArgs>),
    /// Bake, render and verify the bundled samples
    #[command(after_help = ExitCode::table())]
    Demo(DemoArgs),
    /// Measure what a frame costs
    #[command(after_help = ExitCode::table())]
    Measure(MeasureArgs),
}

impl Command {
    /// The word on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Bake(_) => "bake",
            Self::Info(_) => "info",
            Self::Validate(_) => "validate",
            Self::Verify(_) => "verify",
            Self::Render(_) => "render",
            Self::Demo(_) => "demo",
            Self::Measure(_) => "measure",
        }
    }
}

/// Options of every command.
#[derive(Debug, Args)]
#[command(next_help_heading = "Global options")]
pub struct GlobalArgs {
    /// Print one JSON object on stdout instead of text, on failure too (keys: tools/cli/JSON.md) [default: off]
    #[arg(long, global = true)]
    pub json: bool,
    /// Say nothing on stderr but errors [default: off]
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Progress on stderr; auto: bars on a terminal, plain lines elsewhere
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = When::Auto)]
    pub progress: When,
    /// Threads, 1 to 1024; results do not depend on it [default: one per core]
    #[arg(short = 'j', long, global = true, value_name = "N", value_parser = values::threads)]
    pub threads: Option<NonZeroUsize>,
}

/// When progress bars are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum When {
    /// Bars on a terminal, plain lines elsewhere
    Auto,
    /// Bars wherever stderr goes
    Always,
    /// No progress at all
    Never,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_option_with_a_value_states_its_default_or_says_what_happens_without() {
        for command in Cli::command().get_subcommands() {
            for argument in command
                .get_arguments()
                .filter(|a| !a.is_positional() && !a.is_required_set())
            {
                let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
                let stated = help.contains("[default:") || !argument.get_default_values().is_empty();
                assert!(
                    stated,
                    "{} --{}: no default in {help:?}",
                    command.get_name(),
                    argument.get_id()
                );
            }
        }
    }
}
