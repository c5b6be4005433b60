//! The `lightshaft` command; everything happens in [`lightshaft::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    lightshaft::cli::main()
}
