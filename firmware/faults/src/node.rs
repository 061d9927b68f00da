//! A node in the emulator, and the line to it.

use crate::Error;
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    fs::{CWD, Mode, mkfifoat},
};
use slqg::{
    Tick,
    wire::{
        self, Clock, Kind, Question, Status,
        serial::{Unstuffer, stuff, stuffed_len},
    },
};
use std::{
    fs::{self, File},
    io::{Read, Write},
    path::{Path, PathBuf, absolute},
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};
use tempfile::TempDir;

const PROGRAM: &str = "qemu-system-arm";
const LONGEST: usize = 512;

/// A node that runs, and ends with its owner.
pub(crate) struct Node {
    emulator: Child,
    input: File,
    output: File,
    unstuffer: Box<Unstuffer<LONGEST>>,
    to_send: Vec<u8>,
    folder: TempDir,
    /// How long it may be silent.
    patience: Duration,
}

/// It has been silent for too long, or its emulator has ended.
#[derive(Debug)]
pub(crate) struct Stopped;

impl Node {
    /// Starts the emulator with the node's program; with a debugger's stub the machine waits for it.
    pub(crate) fn start(image: &Path, is_debugged: bool, patience: Duration) -> Result<Self, Error> {
        let folder = tempfile::tempdir()?;
        let line = |extension: &str| {
            let fifo = folder.path().join(format!("n.{extension}"));
            mkfifoat(CWD, &fifo, Mode::RUSR | Mode::WUSR)?;
            // Opened both ways, which waits for nobody.
            File::options().read(true).write(true).open(fifo)
        };
        let (input, output) = (line("in")?, line("out")?);
        let mut command = Command::new(PROGRAM);
        command
            .args(["-M", "mps2-an386", "-display", "none", "-monitor", "none", "-kernel"])
            .arg(absolute(image)?);
        command.args(["-semihosting-config", "enable=on,target=native,arg=node,arg=n"]);
        command.args(["-serial", "null", "-chardev", "file,id=log,path=log", "-serial", "chardev:log"]);
        if is_debugged {
            command.args([
                "-S",
                "-chardev",
                "socket,id=gdb,path=gdb,server=on,wait=off",
                "-gdb",
                "chardev:gdb",
            ]);
        }
        command.current_dir(folder.path()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let emulator = command.spawn().map_err(|error| format!("cannot start {PROGRAM}: {error}"))?;
        Ok(Self { emulator, input, output, unstuffer: Box::default(), to_send: vec![0], folder, patience })
    }

    pub(crate) fn debugger_socket(&self) -> PathBuf {
        self.folder.path().join("gdb")
    }

    /// What it has logged so far.
    pub(crate) fn log(&self) -> Vec<u8> {
        fs::read(self.folder.path().join("log")).unwrap_or_default()
    }

    /// Waits until the node says that it is there, and tells it that cycle 0 comes next.
    pub(crate) fn begin(&mut self) -> Result<(), Stopped> {
        self.frames_up_to(Kind::Status)?;
        self.clock(Tick(0), false);
        Ok(())
    }

    pub(crate) fn status(&mut self) -> Result<Status, Stopped> {
        let mut buffer = [0; wire::LONGEST_SERVICE];
        let question =
            wire::encode_service::<f32, _>(Tick(0), &Question {}, &mut buffer).map_err(|_| Stopped)?;
        self.send(question);
        let frames = self.frames_up_to(Kind::Status)?;
        let last = frames.last().ok_or(Stopped)?;
        Ok(wire::decode_service::<f32, Status>(last).map_err(|_| Stopped)?.1)
    }

    pub(crate) fn clock(&mut self, tick: Tick, begins: bool) {
        let mut buffer = [0; wire::LONGEST_SERVICE];
        let clock = wire::encode_service::<f32, _>(tick, &Clock { begins, period_us: 0 }, &mut buffer);
        self.send(clock.expect("the buffer holds every service frame"));
    }

    pub(crate) fn send(&mut self, frame: &[u8]) {
        let mut buffer = vec![0; stuffed_len(frame.len())];
        self.to_send.extend(stuff(frame, &mut buffer).expect("the buffer is as long as asked for"));
    }

    /// Writes what is queued, and waits for the frames up to one of this kind.
    pub(crate) fn frames_up_to(&mut self, last: Kind) -> Result<Vec<Vec<u8>>, Stopped> {
        self.input.write_all(&self.to_send).map_err(|_| Stopped)?;
        self.to_send.clear();
        let (mut frames, mut chunk) = (Vec::new(), [0; 1024]);
        let deadline = Instant::now() + self.patience;
        let look = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
        loop {
            let ready =
                poll(&mut [PollFd::new(&self.output, PollFlags::IN)], Some(&look)).map_err(|_| Stopped)?;
            if ready == 0 {
                let has_ended = !matches!(self.emulator.try_wait(), Ok(None));
                if has_ended || Instant::now() > deadline {
                    return Err(Stopped);
                }
                continue;
            }
            let count = self.output.read(&mut chunk).map_err(|_| Stopped)?;
            for byte in &chunk[..count] {
                if let Some(frame) = self.unstuffer.take(*byte) {
                    frames.push(frame.to_vec());
                }
            }
            if frames.last().is_some_and(|frame| Kind::of(frame) == Some(last)) {
                return Ok(frames);
            }
            // A node that says the wrong things without end.
            if frames.len() > 1000 {
                return Err(Stopped);
            }
        }
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        // Both fail only for an emulator that has ended.
        let _ = self.emulator.kill();
        let _ = self.emulator.wait();
    }
}
