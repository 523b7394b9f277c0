//! The `restpose` program. Results go to stdout, everything else to stderr; exit codes are in [`exit_code`].

mod args;
mod clip_choice;
mod commands;
mod exit_code;
mod failure;
mod import_options;
mod input_file;
mod mapped_asset;
mod output;
mod output_folder;
mod picture;
mod pose_settings;
mod progress;
mod source_files;
mod table;

use args::{Cli, Command, GlobalArgs};
use clap::Parser;
use commands::Context;
use exit_code::ExitCode;
use failure::Failure;
use output::Answer;
use progress::{Reporter, Style};

fn main() -> std::process::ExitCode {
    let code = match Cli::try_parse() {
        Ok(cli) => {
            let json = cli.global.json;
            output::finish(run(&cli), json)
        }
        Err(error) => refuse(&error),
    };
    code.into()
}

fn run(cli: &Cli) -> Result<Answer, Failure> {
    let GlobalArgs {
        quiet,
        progress,
        threads,
        ..
    } = cli.global;
    if let Some(threads) = threads {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global();
        pool.map_err(|error| {
            Failure::new(
                ExitCode::Internal,
                format!("{threads} threads cannot be started: {error}"),
            )
        })?;
    }
    let context = Context {
        reporter: Reporter::new(Style::chosen(progress, quiet)),
        quiet,
    };
    context.reporter.set_label(cli.command.name());
    match &cli.command {
        Command::Bake(args) => commands::bake::run(args, &context),
        Command::Info(args) => commands::info::run(args),
        Command::Validate(args) => commands::validate::run(args),
        Command::Verify(args) => commands::verify::run(args, &context),
        Command::Render(args) => commands::render::run(args, &context),
        Command::Demo(args) => commands::demo::run(args, &context),
        Command::Measure(args) => commands::measure::run(args, &context),
    }
}

/// Ends a run whose command line was not understood, or asked for help.
fn refuse(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // `--help` and `--version` are results. Whoever closes the pipe early has seen enough of them.
        let _ = error.print();
        return ExitCode::Ok;
    }
    let json = std::env::args_os().any(|word| word == "--json");
    if json {
        let text = error.render().to_string();
        // The first paragraph says what is wrong; usage and tips follow.
        let message = text
            .split("\n\n")
            .next()
            .unwrap_or(&text)
            .trim_start_matches("error: ")
            .trim();
        return output::finish(Err(Failure::new(ExitCode::CommandLine, message)), true);
    }
    let _ = error.print();
    ExitCode::CommandLine
}
