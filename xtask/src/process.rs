//! Running other programs, with messages that can be pasted into a shell.

use std::env;
use std::ffi::OsStr;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};

use crate::Result;

/// Prints a line on standard output. A reader that has seen enough and closes the pipe is no failure.
pub(crate) fn print(line: impl Display) -> Result<()> {
    match writeln!(io::stdout(), "{line}") {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        outcome => outcome.map_err(|error| format!("standard output: cannot be written: {error}").into()),
    }
}

/// Runs a command on this terminal; an exit status other than 0 is an error that shows the command.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    let status = command.status().map_err(|error| cannot_start(command, &error))?;
    verdict(status, command)
}

/// As [`run`], but returns what the command writes to its standard output.
pub(crate) fn stdout_of(command: &mut Command) -> Result<String> {
    let (output, ended) = output_of(command)?;
    ended.map(|()| output)
}

/// What the command writes to its standard output, and apart from that how it ended.
pub(crate) fn output_of(command: &mut Command) -> Result<(String, Result<()>)> {
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| cannot_start(command, &error))?;
    let text =
        String::from_utf8(output.stdout).map_err(|_| format!("not UTF-8: output of {}", shown(command)))?;
    Ok((text, verdict(output.status, command)))
}

/// Whether a command runs and succeeds; its output is of no interest.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// The first executable of that name on `PATH`.
pub(crate) fn on_path(program: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    env::split_paths(&path).map(|folder| folder.join(program)).find(|candidate| candidate.is_file())
}

/// The command as one would type it, with the variables set for it.
pub(crate) fn shown(command: &Command) -> String {
    let variables = command.get_envs().filter_map(|(name, value)| {
        value.map(|value| format!("{}={}", name.to_string_lossy(), quoted(value)))
    });
    // Cargo hands its full path down; whoever reads this has it on PATH.
    let is_cargo = env::var_os("CARGO").is_some_and(|cargo| cargo == command.get_program());
    let program = if is_cargo { "cargo".into() } else { quoted(command.get_program()) };
    let arguments = command.get_args().map(quoted);
    variables.chain([program]).chain(arguments).collect::<Vec<_>>().join(" ")
}

fn quoted(word: &OsStr) -> String {
    let word = word.to_string_lossy();
    if word.contains([' ', '"', '$']) { format!("'{word}'") } else { word.into_owned() }
}

fn verdict(status: ExitStatus, command: &Command) -> Result<()> {
    if status.success() { Ok(()) } else { Err(format!("{status} from: {}", shown(command)).into()) }
}

fn cannot_start(command: &Command, error: &std::io::Error) -> String {
    format!("cannot start `{}`: {error}", shown(command))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_command_is_named_with_its_variables() {
        let error = run(Command::new("false").arg("a b").env("SPEED", "11")).unwrap_err().to_string();
        assert!(error.ends_with("from: SPEED=11 false 'a b'"), "{error}");
    }

    #[test]
    fn a_missing_program_is_named() {
        let error = run(&mut Command::new("no-such-program")).unwrap_err().to_string();
        assert!(error.starts_with("cannot start `no-such-program`"), "{error}");
    }
}
