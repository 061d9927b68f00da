//! What the programs say: answers on standard output, the rest on standard error. Neither ever panics.
//!
//! An answer that cannot be written is an error of its own: a script must not take half of it for all. A reader that has seen
//! enough and closes the pipe is no failure, and nobody is told.

use clap::Parser;
use std::fmt::Display;
use std::io::{self, BufWriter, StdoutLock, Write};
use std::process::ExitCode;

/// Standard output could not be written: a full disk, for instance.
#[derive(Debug, thiserror::Error)]
#[error("standard output: cannot be written: {0}; give it somewhere to go that has room")]
pub struct NotPrinted(#[from] io::Error);

/// Prints an answer.
///
/// # Errors
/// It cannot be written, and not because its reader has gone.
pub fn print(answer: impl Display) -> Result<(), NotPrinted> {
    print_by(|stdout| write!(stdout, "{answer}"))
}

/// Prints what `write` writes.
///
/// # Errors
/// As [`print()`].
pub fn print_by(write: impl FnOnce(&mut BufWriter<StdoutLock>) -> io::Result<()>) -> Result<(), NotPrinted> {
    let mut stdout = BufWriter::new(io::stdout().lock());
    let written = write(&mut stdout).and_then(|()| stdout.flush());
    // What is left would be written again, and fail again, when it is dropped.
    let _ = stdout.into_parts();
    judged(written)
}

fn judged(written: io::Result<()>) -> Result<(), NotPrinted> {
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        outcome => Ok(outcome?),
    }
}

/// Tells people something; where nobody can hear it, it is lost.
pub fn tell(message: impl Display) {
    let _ = writeln!(io::stderr(), "{message}");
}

/// The command line. Help and version are printed here, as is what is wrong with it.
///
/// # Errors
/// The exit status of a program that has nothing more to do: 0 after help, 2 where the command line is wrong or help could
/// not be printed.
pub fn parse<C: Parser>() -> Result<C, ExitCode> {
    C::try_parse().map_err(|answer| {
        if answer.use_stderr() {
            let _ = answer.print();
            return ExitCode::from(2);
        }
        match judged(answer.print().and_then(|()| io::stdout().flush())) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                tell(format_args!("error: {error}"));
                ExitCode::from(2)
            }
        }
    })
}
