//! The command line: arguments as typed (`args`) become a checked configuration (`config`), and
//! one verb runs with it. Errors are printed here, once, as one line, and become an exit code.

mod args;
mod camera;
mod check;
mod compare;
mod config;
mod console;
mod convergence;
mod doctor;
mod errors;
mod export;
mod folder;
mod frames;
mod generate;
mod probe;
mod profile;
mod relight;
mod render;
mod setup;
mod shots;
mod solve;
mod solved;
mod stored;

use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Verb};
use errors::{CliError, ExitKind};

/// Runs the command with the arguments of the process; the answer is the process's exit code, see
/// `docs/exit-codes.md`.
pub fn main() -> ExitCode {
    report_panics_as_faults();
    // What panicked has said so through the hook; nothing of it is used afterwards.
    let outcome = panic::catch_unwind(AssertUnwindSafe(|| run(std::env::args_os())));
    outcome.unwrap_or(ExitKind::Internal).into()
}

fn run(typed: impl Iterator<Item = OsString>) -> ExitKind {
    let arguments = match Arguments::try_parse_from(typed) {
        Ok(arguments) => arguments,
        Err(answer) => {
            // Help and version are answers too, on standard output. A closed pipe is no reason to fail.
            let _ = answer.print();
            return if answer.use_stderr() { ExitKind::Usage } else { ExitKind::Success };
        }
    };
    let result = match arguments.verb {
        Verb::Render(typed) => config::RenderConfig::check(*typed).and_then(|config| render::run(&config)),
        Verb::Solve(typed) => config::KeepConfig::check(*typed).and_then(|config| solve::run(&config)),
        Verb::Relight(typed) => config::RelightConfig::check(*typed).and_then(|config| relight::run(&config)),
        Verb::Export(typed) => config::ExportConfig::check(*typed).and_then(|config| export::run(&config)),
        Verb::Probe(typed) => config::ProbeConfig::check(*typed).and_then(|config| probe::run(&config)),
        Verb::Convergence(typed) => {
            config::ConvergenceConfig::check(*typed).and_then(|config| convergence::run(&config))
        }
        Verb::Profile(typed) => config::ProfileConfig::check(*typed).and_then(|config| profile::run(&config)),
        Verb::Check(typed) => config::CheckConfig::check(*typed).and_then(|config| check::run(&config)),
        Verb::Compare(typed) => config::CompareConfig::check(*typed).and_then(|config| compare::run(&config)),
        Verb::Doctor(typed) => doctor::run(&typed),
        Verb::Generate(typed) => generate::run(&typed.what),
    };
    match result {
        Ok(()) => ExitKind::Success,
        Err(error) => {
            console::error(&error.to_string());
            error.kind()
        }
    }
}

/// A panic is our fault, not the user's: one line says so, and `RUST_BACKTRACE` still gives details.
fn report_panics_as_faults() {
    let default_hook = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0") {
            default_hook(info);
        }
        let payload = info.payload();
        let formatted = payload.downcast_ref::<String>().map(String::as_str);
        let what = formatted.or(payload.downcast_ref::<&str>().copied()).unwrap_or("no message");
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        console::error(&CliError::Internal(format!("{what} ({place})")).to_string());
    }));
}
