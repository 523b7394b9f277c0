//! Writes the sample scenes into `samples/scenes`, or with `--check` says which of the files there differ.

use restpose_samples::scene_files;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(code) => code,
        Err(error) => {
            // A closed error stream leaves nobody to tell.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let check = match arguments.as_slice() {
        [] => false,
        [only] if only == "--check" => true,
        _ => return Err("expected no argument or --check".into()),
    };
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes");
    std::fs::create_dir_all(&folder)?;
    let mut code = ExitCode::SUCCESS;
    let mut output = std::io::stdout().lock();
    for file in scene_files()? {
        let path = folder.join(file.name);
        let length = file.bytes.len();
        if !check {
            std::fs::write(&path, &file.bytes)?;
            writeln!(output, "wrote {} ({length} bytes)", file.name)?;
        } else if std::fs::read(&path).is_ok_and(|committed| committed == file.bytes) {
            writeln!(output, "same {} ({length} bytes)", file.name)?;
        } else {
            writeln!(output, "differs {}: regenerate it without --check", file.name)?;
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}
