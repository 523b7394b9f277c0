//! What reaches stdout and stderr: results on stdout, everything else on stderr.

use crate::{exit_code::ExitCode, failure::Failure};
use serde::Serialize;
use std::io::Write;

/// What a command found out: the same result as text and as JSON.
pub struct Answer {
    text: String,
    json: String,
    failure: Option<Failure>,
}

#[derive(Serialize)]
struct WithError<'a, R> {
    #[serde(flatten)]
    report: &'a R,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a Failure>,
}

impl Answer {
    /// A result. `report` must serialise to a JSON object.
    pub fn new(report: &impl Serialize, text: String) -> Result<Self, Failure> {
        Self::with_failure(report, text, None)
    }

    /// A result that is itself a failure, such as a verification with a missed hit.
    pub fn with_failure(report: &impl Serialize, text: String, failure: Option<Failure>) -> Result<Self, Failure> {
        let json = serde_json::to_string(&WithError {
            report,
            error: failure.as_ref(),
        })
        .map_err(|error| {
            Failure::new(
                ExitCode::Internal,
                format!("the report cannot be written as JSON: {error}"),
            )
        })?;
        Ok(Self { text, json, failure })
    }
}

/// Prints what a command ended with and says how the program ends.
pub fn finish(result: Result<Answer, Failure>, json: bool) -> ExitCode {
    let (printed, failure) = match result {
        Ok(answer) => (print(if json { &answer.json } else { &answer.text }), answer.failure),
        Err(failure) if json => (print(&error_object(&failure)), Some(failure)),
        Err(failure) => (Ok(()), Some(failure)),
    };
    if let Some(failure) = failure {
        complain(&failure);
        return failure.code;
    }
    match printed {
        // Whoever reads the pipe has seen enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::Ok,
        Err(error) => {
            note(&format!("error: cannot write to stdout: {error}"));
            ExitCode::Io
        }
        Ok(()) => ExitCode::Ok,
    }
}

/// A line on stderr. Nobody is left to be told when that fails.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

fn print(text: &str) -> std::io::Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(text.trim_end().as_bytes())?;
    stdout.write_all(b"\n")?;
    stdout.flush()
}

fn error_object(failure: &Failure) -> String {
    #[derive(Serialize)]
    struct Object<'a> {
        error: &'a Failure,
    }
    // Numbers and strings only: serialising cannot fail.
    serde_json::to_string(&Object { error: failure }).unwrap_or_default()
}

fn complain(failure: &Failure) {
    note(&format!("error: {}", failure.message));
    // A single fault is already in the message.
    if failure.faults.len() > 1 {
        failure
            .faults
            .iter()
            .for_each(|fault| note(&format!("  {}: {fault}", severity(fault))));
    }
}

fn severity(fault: &restpose_bake::import::Fault) -> &'static str {
    match fault.severity {
        restpose_bake::import::Severity::Warning => "warning",
        restpose_bake::import::Severity::Error => "error",
    }
}
