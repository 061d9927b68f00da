//! The debugger stub of the emulator, in the remote protocol of GDB: breakpoints, registers, memory.

use crate::{Error, image::Image};
use std::{
    io::{BufRead, BufReader, Read, Write},
    os::unix::net::UnixStream,
    path::Path,
    thread,
    time::{Duration, Instant},
};

/// Time for the emulator to listen.
const BEGIN: Duration = Duration::from_secs(20);
/// Numbers of the stack pointer and the program counter.
const SP: usize = 13;
const PC: usize = 15;

/// A bit that flips when a function has been entered so many times.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flip {
    pub(crate) function: u32,
    /// Counted from 1.
    pub(crate) entered: u32,
    pub(crate) address: u32,
    pub(crate) bit: u32,
}

/// A connection to the stub of a machine that has not begun.
pub(crate) struct Debugger(BufReader<UnixStream>);

impl Debugger {
    pub(crate) fn connect(socket: &Path) -> Result<Self, Error> {
        let deadline = Instant::now() + BEGIN;
        let stream = loop {
            match UnixStream::connect(socket) {
                Ok(stream) => break stream,
                Err(_) if Instant::now() < deadline => thread::sleep(Duration::from_millis(2)),
                Err(error) => return Err(format!("no debugger stub at {}: {error}", socket.display()).into()),
            }
        };
        stream.set_read_timeout(Some(Duration::from_secs(60)))?;
        let mut debugger = Self(BufReader::new(stream));
        debugger.ask("QStartNoAckMode")?;
        debugger.0.get_mut().write_all(b"+")?;
        Ok(debugger)
    }

    /// Lets the machine run until the flip is due, does it, and leaves the machine alone. Ends with the machine.
    pub(crate) fn flip(mut self, flip: Flip) -> Result<(), Error> {
        self.set_breakpoint(flip.function, true)?;
        for entered in 1..=flip.entered {
            self.resume()?;
            if entered < flip.entered {
                // Beyond the breakpoint.
                self.ask("s")?;
            }
        }
        let before = self.ask(&format!("m{:x},1", flip.address))?;
        let byte = u8::from_str_radix(&before, 16)
            .map_err(|_| format!("no memory at {:#x}: {before}", flip.address))?;
        self.ask(&format!("M{:x},1:{:02x}", flip.address, byte ^ 1 << flip.bit))?;
        self.set_breakpoint(flip.function, false)?;
        self.ask("D")?;
        Ok(())
    }

    /// Lets the machine run to its end, and calls `entered` with each function that it enters; returns the stack pointer at the entry
    /// of the main loop.
    pub(crate) fn trace(mut self, image: &Image, mut entered: impl FnMut(u32)) -> Result<u32, Error> {
        for function in &image.functions {
            self.set_breakpoint(*function, true)?;
        }
        let mut stack = image.stack_start;
        // It ends with the connection, anywhere.
        while let Ok([sp, function]) = self.resume().and_then(|()| self.registers()) {
            if Some(function) == image.main_loop {
                stack = sp;
            }
            entered(function);
            if self.ask("s").is_err() {
                break;
            }
        }
        Ok(stack)
    }

    fn set_breakpoint(&mut self, address: u32, is_set: bool) -> Result<(), Error> {
        let answer = self.ask(&format!("{}0,{address:x},2", if is_set { 'Z' } else { 'z' }))?;
        if answer == "OK" { Ok(()) } else { Err(format!("no breakpoint at {address:#x}: {answer}").into()) }
    }

    /// Stack pointer and program counter.
    fn registers(&mut self) -> Result<[u32; 2], Error> {
        let answer = self.ask("g")?;
        let value = |number: usize| {
            let digits = answer.get(number * 8..number * 8 + 8).unwrap_or_default();
            let value =
                u32::from_str_radix(digits, 16).map_err(|_| format!("register {number}: {answer}"))?;
            Ok::<_, Error>(value.swap_bytes())
        };
        Ok([value(SP)?, value(PC)?])
    }

    /// Goes on to the next stop.
    fn resume(&mut self) -> Result<(), Error> {
        let answer = self.ask("c")?;
        if answer.starts_with('T') { Ok(()) } else { Err(format!("the machine has ended: {answer}").into()) }
    }

    fn ask(&mut self, request: &str) -> Result<String, Error> {
        let sum = request.bytes().fold(0_u8, u8::wrapping_add);
        self.0.get_mut().write_all(format!("${request}#{sum:02x}").as_bytes())?;
        let (mut before, mut answer) = (Vec::new(), Vec::new());
        self.0.read_until(b'$', &mut before)?;
        self.0.read_until(b'#', &mut answer)?;
        if answer.pop() != Some(b'#') {
            return Err("the emulator has closed its debugger stub".into());
        }
        self.0.read_exact(&mut [0; 2])?;
        Ok(String::from_utf8(answer)?)
    }
}
