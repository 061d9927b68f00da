//! A board in QEMU: started with a line to its node, and stopped when it is no longer needed.
//!
//! What goes over the line is [`super::remote`]'s, where its files are is [`super::files`]'. QEMU runs in the folder of the
//! lines, so that it is told names without folders: neither its options nor the node's command line could hold any path.

use super::{files::Files, remote::name};
use rustix::fs::{CWD, Mode, mkfifoat};
use slqg::wire::Role;
use std::{
    env,
    ffi::{OsStr, OsString},
    fs::{self, File},
    io::{self, Read},
    os::{
        fd::OwnedFd,
        unix::{
            ffi::{OsStrExt, OsStringExt},
            net::UnixStream,
        },
    },
    path::{Path, PathBuf, absolute},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

const PROGRAM: &str = "qemu-system-arm";
/// Time for an emulator to end once it has closed its line.
const END: Duration = Duration::from_secs(5);

/// How bytes get to a node and back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Transport {
    /// The board's UART, interrupt by interrupt: the programs as they are flashed.
    Uart,
    /// Files of a debugger: the same nodes without interrupts and timer, for long runs.
    Bulk,
}

impl Transport {
    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uart => "uart",
            Self::Bulk => "bulk",
        }
    }
}

/// A board that QEMU knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Board {
    /// Arm MPS2 with a Cortex-M4F.
    #[value(name = "mps2_an386")]
    Mps2An386,
    /// Stellaris LM3S6965, a Cortex-M3 without floating-point unit.
    #[value(name = "lm3s6965evb")]
    Lm3s6965evb,
}

impl Board {
    /// As in `firmware/nodes/boards`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mps2An386 => "mps2_an386",
            Self::Lm3s6965evb => "lm3s6965evb",
        }
    }

    fn machine(self) -> &'static str {
        match self {
            Self::Mps2An386 => "mps2-an386",
            Self::Lm3s6965evb => "lm3s6965evb",
        }
    }

    /// Where the memory is that stands for one that outlives power, as in `firmware/nodes/boards`.
    fn kept(self) -> u32 {
        match self {
            Self::Mps2An386 => 0x2001_0000,
            Self::Lm3s6965evb => 0x2000_f000,
        }
    }

    /// Cycles of the processor in a second.
    fn core_hz(self) -> f64 {
        match self {
            Self::Mps2An386 => 25e6,
            Self::Lm3s6965evb => 12e6,
        }
    }

    /// Ticks of the node's clock in an instruction when QEMU counts instructions, 2^[`COUNT_SHIFT`] ns each.
    pub(super) fn ticks_per_instruction(self) -> f64 {
        f64::from(1 << COUNT_SHIFT) * self.core_hz() / 1e9
    }
}

/// See [`Board::ticks_per_instruction`].
const COUNT_SHIFT: u32 = 10;

/// Which image to run, and how.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The program.
    pub image: PathBuf,
    /// The board it is for.
    pub board: Board,
    /// The line to it.
    pub transport: Transport,
    /// Whether instructions are counted: the node's clock then tells them.
    pub counts: bool,
}

/// There is no emulator.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{PROGRAM} is in no folder of PATH ({}); install QEMU for Arm system emulation, on Debian:\n  \
     apt-get install --no-install-recommends {PROGRAM}",
    Path::new(path).display()
)]
pub struct NoEmulator {
    path: OsString,
}

/// Where the emulator is.
///
/// # Errors
/// If it is not on `PATH`.
pub fn find_emulator() -> Result<PathBuf, NoEmulator> {
    let path = env::var_os("PATH").unwrap_or_default();
    let found = env::split_paths(&path).map(|folder| folder.join(PROGRAM)).find(|file| file.is_file());
    found.ok_or(NoEmulator { path })
}

/// A running emulator; ends with its owner.
pub(super) struct Emulator(Child);

/// The line to a node.
pub(super) struct Line {
    /// Bytes to the node.
    pub(super) input: File,
    /// Bytes from it.
    pub(super) output: File,
}

impl Emulator {
    /// Starts the image of the node `role`, with its line. Its log goes on where it ends. `boots` is what a counter of boots that
    /// outlives power says: QEMU writes it to memory that the program leaves alone.
    pub(super) fn start(setup: &Setup, files: &Files, role: Role, boots: u32) -> io::Result<(Self, Line)> {
        let program = find_emulator().map_err(io::Error::other)?;
        let mut command = Command::new(absolute(program)?);
        command.args(["-M", setup.board.machine(), "-display", "none", "-monitor", "none"]);
        if setup.counts {
            command.args(["-icount", &format!("shift={COUNT_SHIFT}")]);
        }
        let kept = setup.board.kept();
        command.args(["-device", &format!("loader,addr={kept:#x},data={boots},data-len=4")]);
        command.arg("-kernel").arg(absolute(&setup.image)?).current_dir(files.lines());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let line = match setup.transport {
            Transport::Uart => uart(&mut command)?,
            Transport::Bulk => bulk(&mut command, files.lines(), name(role))?,
        };
        let log = option("file,id=log,append=on,path=", files.log(role).as_os_str());
        command.arg("-chardev").arg(log).args(["-serial", "chardev:log"]);
        match command.spawn() {
            Ok(child) => Ok((Self(child), line)),
            Err(error) => Err(io::Error::other(format!("cannot start {PROGRAM}: {error}"))),
        }
    }

    /// What QEMU said as it ended, if it has ended.
    pub(super) fn last_words(&mut self) -> Option<String> {
        let status = self.0.try_wait().ok().flatten()?;
        let mut text = String::new();
        if let Some(stderr) = &mut self.0.stderr {
            // What has been read up to an error is still worth showing.
            let _ = stderr.read_to_string(&mut text);
        }
        Some(format!("{PROGRAM} has ended ({status}) {}", text.trim()))
    }

    /// The same of one that is about to end, as its closed line tells.
    pub(super) fn wait_for_last_words(&mut self) -> Option<String> {
        let deadline = Instant::now() + END;
        loop {
            match self.last_words() {
                None if Instant::now() < deadline => thread::sleep(Duration::from_millis(2)),
                words => return words,
            }
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Both fail only for a child that has already ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The board's first UART, on a socket without a name that QEMU has for its standard input.
fn uart(command: &mut Command) -> io::Result<Line> {
    let (own, of_qemu) = UnixStream::pair()?;
    command.stdin(OwnedFd::from(of_qemu));
    command.args(["-chardev", "socket,id=line,fd=0", "-serial", "chardev:line"]);
    let input = File::from(OwnedFd::from(own.try_clone()?));
    Ok(Line { input, output: File::from(OwnedFd::from(own)) })
}

/// Two FIFOs in `folder`, whose names the node is told.
fn bulk(command: &mut Command, folder: &Path, name: &str) -> io::Result<Line> {
    let open = |extension: &str| {
        let fifo = folder.join(format!("{name}.{extension}"));
        // Of the node that ran before.
        let _ = fs::remove_file(&fifo);
        mkfifoat(CWD, &fifo, Mode::RUSR | Mode::WUSR)?;
        // Opened both ways, which waits for nobody; the node finds the other end there.
        File::options().read(true).write(true).open(fifo)
    };
    let line = Line { input: open("in")?, output: open("out")? };
    command.args(["-semihosting-config", &format!("enable=on,target=native,arg=node,arg={name}")]);
    command.args(["-serial", "null"]);
    Ok(line)
}

/// An option of QEMU that ends with a path: a comma separates options, two stand for one.
fn option(before: &str, path: &OsStr) -> OsString {
    let mut bytes = before.as_bytes().to_vec();
    for byte in path.as_bytes() {
        bytes.push(*byte);
        if *byte == b',' {
            bytes.push(b',');
        }
    }
    OsString::from_vec(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comma_in_a_path_does_not_end_the_option() {
        let path = OsStr::from_bytes(b"/of a, b=\xff/node.log");
        let expected = OsStr::from_bytes(b"path=/of a,, b=\xff/node.log");
        assert_eq!(option("path=", path), expected);
    }
}
