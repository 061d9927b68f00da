//! A board in QEMU: started with a line to its node, and stopped when it is no longer needed.
//!
//! What goes over the line is [`super::remote`]'s.

use rustix::fs::{CWD, Mode, mkfifoat};
use std::{
    fs::{self, File},
    io::{self, Read},
    os::fd::OwnedFd,
    os::unix::net::{UnixListener, UnixStream},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

const PROGRAM: &str = "qemu-system-arm";
/// Time for an emulator to start.
const START: Duration = Duration::from_secs(20);

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
    /// Starts the image with its line and its log in `folder`, in files that begin with `name`.
    pub(super) fn start(setup: &Setup, folder: &Path, name: &str) -> io::Result<(Self, Line)> {
        let log = folder.join(format!("{name}.log"));
        let mut command = Command::new(PROGRAM);
        command.args(["-M", setup.board.machine(), "-display", "none", "-monitor", "none"]);
        if setup.counts {
            command.args(["-icount", &format!("shift={COUNT_SHIFT}")]);
        }
        command.arg("-kernel").arg(&setup.image);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let start = |command: &mut Command| match command.spawn() {
            Ok(child) => Ok(Self(child)),
            Err(error) => Err(io::Error::other(format!("cannot start {PROGRAM}: {error}"))),
        };
        match setup.transport {
            Transport::Uart => {
                let socket = folder.join(format!("{name}.sock"));
                // Of the node that ran before.
                let _ = fs::remove_file(&socket);
                let listener = UnixListener::bind(&socket)?;
                command.arg("-serial").arg(format!("unix:{}", socket.display()));
                command.arg("-serial").arg(format!("file:{}", log.display()));
                let mut emulator = start(&mut command)?;
                let stream = emulator.accept(&listener)?;
                let input = File::from(OwnedFd::from(stream.try_clone()?));
                Ok((emulator, Line { input, output: File::from(OwnedFd::from(stream)) }))
            }
            Transport::Bulk => {
                let base = folder.join(name);
                let path = |extension: &str| folder.join(format!("{name}.{extension}"));
                for fifo in [path("in"), path("out")] {
                    let _ = fs::remove_file(&fifo);
                    mkfifoat(CWD, &fifo, Mode::RUSR | Mode::WUSR)?;
                }
                let semihosting = format!(
                    "enable=on,target=native,arg=node,arg={}",
                    base.display().to_string().replace(',', ",,")
                );
                command.args(["-semihosting-config", &semihosting, "-serial", "null"]);
                command.arg("-serial").arg(format!("file:{}", log.display()));
                // Opened both ways, which waits for nobody; the node finds the other end there.
                let both = |path: PathBuf| File::options().read(true).write(true).open(path);
                let line = Line { input: both(path("in"))?, output: both(path("out"))? };
                Ok((start(&mut command)?, line))
            }
        }
    }

    /// The emulator's end of the socket, once it connects.
    fn accept(&mut self, listener: &UnixListener) -> io::Result<UnixStream> {
        listener.set_nonblocking(true)?;
        let deadline = Instant::now() + START;
        while Instant::now() < deadline {
            match listener.accept() {
                Ok((stream, _)) => return stream.set_nonblocking(false).map(|()| stream),
                Err(error) if error.kind() != io::ErrorKind::WouldBlock => return Err(error),
                Err(_) => (),
            }
            if let Some(words) = self.last_words() {
                return Err(io::Error::other(words));
            }
            thread::sleep(Duration::from_millis(2));
        }
        Err(io::Error::other(format!("{PROGRAM} does not open its UART")))
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
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Both fail only for a child that has already ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
