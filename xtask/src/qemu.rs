//! The reference board in QEMU: runs an image and brings back what it printed and how it ended.

use std::fs;
use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::workspace::Workspace;
use crate::{Result, packages, process};

const PROGRAM: &str = "qemu-system-arm";
const MACHINE: &str = "mps2-an386";
/// See [`Qemu::run_counting`].
const COUNT_SHIFT: u32 = 10;
/// Ticks of the board's timer, 25 MHz, in an instruction when they are counted.
pub(crate) const TICKS_PER_INSTRUCTION: f64 = (1 << COUNT_SHIFT) as f64 * 25e6 / 1e9;

/// An emulator on this machine.
pub(crate) struct Qemu {
    program: PathBuf,
}

/// How a run ended.
pub(crate) struct Ended {
    pub(crate) status: ExitStatus,
    pub(crate) output: String,
}

impl Qemu {
    /// Looks on `PATH`, then for one that was unpacked before; installs the Debian package where that is possible, and
    /// unpacks it beside what there is where installing it would remove something else.
    pub(crate) fn find_or_install() -> Result<Self> {
        if process::on_path(PROGRAM).is_none() {
            let folder = Workspace::find()?.target.join("qemu");
            if !folder.join("bin").join(PROGRAM).is_file() {
                let advice = format!(
                    "Install QEMU for Arm system emulation and have {PROGRAM} on PATH; as root on Debian:\n  \
                     apt-get install --no-install-recommends {PROGRAM}"
                );
                packages::refresh_index();
                let why = format!("{PROGRAM} is missing");
                if let Err(error) = packages::install(&[PROGRAM.to_owned()], &why, &advice) {
                    unpack(&folder).map_err(|other| format!("{error}\nNor could it be unpacked: {other}"))?;
                }
            }
            if process::on_path(PROGRAM).is_none() {
                put_on_path(&folder.join("bin"))?;
            }
        }
        let program = process::on_path(PROGRAM).ok_or_else(|| format!("{PROGRAM} is not on PATH"))?;
        Ok(Self { program })
    }

    /// Runs an image with a semihosting command line of its name and `arguments`.
    ///
    /// A run that does not end in time is stopped, and is an error.
    pub(crate) fn run(&self, image: &Path, arguments: &[&str], limit: Duration) -> Result<Ended> {
        self.run_with(&[], image, arguments, limit)
    }

    /// The same with time that is made of instructions: two runs count alike, on any machine. An instruction takes
    /// 2^`COUNT_SHIFT` ns.
    pub(crate) fn run_counting(&self, image: &Path, limit: Duration) -> Result<Ended> {
        self.run_with(&["-icount", &format!("shift={COUNT_SHIFT}")], image, &[], limit)
    }

    fn run_with(&self, options: &[&str], image: &Path, arguments: &[&str], limit: Duration) -> Result<Ended> {
        let name = image.file_name().unwrap_or_default().to_string_lossy();
        let mut semihosting = String::from("enable=on,target=native");
        for word in [&*name].iter().chain(arguments) {
            // A comma separates QEMU's options, two stand for one.
            semihosting.push_str(",arg=");
            semihosting.push_str(&word.replace(',', ",,"));
        }
        let mut command = Command::new(&self.program);
        command
            .args(options)
            .args(["-M", MACHINE, "-nographic", "-monitor", "none", "-serial", "none"])
            .args(["-semihosting-config", &semihosting, "-kernel"])
            .arg(image)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let child = command.spawn().map_err(|error| format!("cannot start {PROGRAM}: {error}"))?;
        let mut running = Running(child);
        // Read while it runs: a full pipe would stop the emulator.
        let printed = collect(running.0.stdout.take());
        let complaints = collect(running.0.stderr.take());
        let status = running.wait(limit)?;
        // Its ends of the pipes are closed by now, whether it has ended or has been killed.
        drop(running);
        let mut output = printed.join().unwrap_or_default();
        output.push_str(&complaints.join().unwrap_or_default());
        match status {
            Some(status) => Ok(Ended { status, output }),
            None => {
                let limit = limit.as_secs();
                Err(format!("no end within {limit} s of: {}\n{output}", process::shown(&command)).into())
            }
        }
    }
}

/// Unpacks the Debian package into `folder`, with a script in `folder/bin` that starts the program with its own libraries.
fn unpack(folder: &Path) -> Result<()> {
    let root = packages::unpack(PROGRAM, folder)?;
    let below = format!("lib/{}-linux-gnu", std::env::consts::ARCH);
    let libraries = root.join("usr").join(&below);
    let script = format!(
        "#!/bin/sh\nLD_LIBRARY_PATH='{0}:{0}/pulseaudio:{2}' QEMU_MODULE_DIR='{0}/qemu' exec '{1}/usr/bin/{PROGRAM}' -L '{1}/usr/share/qemu' \"$@\"\n",
        libraries.display(),
        root.display(),
        root.join(&below).display(),
    );
    let bin = folder.join("bin");
    fs::create_dir_all(&bin)?;
    let program = bin.join(PROGRAM);
    fs::write(&program, script)?;
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755))?;
    process::run(Command::new(&program).arg("--version").stdout(Stdio::null()))
}

/// For this process and those that it starts.
fn put_on_path(folder: &Path) -> Result<()> {
    let before = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(folder.to_owned()).chain(std::env::split_paths(&before));
    let path = std::env::join_paths(folders)?;
    // SAFETY: tools are looked for before anything else is done; no other thread is there yet.
    unsafe { std::env::set_var("PATH", path) };
    Ok(())
}

/// A child that does not outlive its owner.
struct Running(Child);

impl Running {
    /// `None` when the limit is reached.
    fn wait(&mut self, limit: Duration) -> Result<Option<ExitStatus>> {
        let deadline = Instant::now() + limit;
        loop {
            if let Some(status) = self.0.try_wait()? {
                return Ok(Some(status));
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
            thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail only for a child that has already ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn collect(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // What has been read up to an error is still worth showing.
            let _ = pipe.read_to_end(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_does_not_end_is_stopped() {
        let child = Command::new("sleep").arg("600").stdout(Stdio::piped()).spawn().unwrap();
        let mut running = Running(child);
        let output = collect(running.0.stdout.take());
        assert_eq!(running.wait(Duration::from_millis(20)).unwrap(), None);
        drop(running);
        // Ends only when the child has.
        assert_eq!(output.join().unwrap(), "");
    }
}
