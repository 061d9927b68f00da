//! Where and when bits flip, and the table of what became of them.

use crate::{
    Error, Options,
    closed_loop::{Run, run as run_loop},
    debugger::{Debugger, Flip},
    image::Image,
    log,
    node::Node,
    outcome::{ALL, Outcome},
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use slqg::wire::Role;
use std::{
    fmt::Write as _,
    ops::Range,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
    thread,
    time::Duration,
};

/// Cycles of a run whose inputs differ to its end. The filter forgets a wrong rate of the cart in some 300 cycles only: where nothing
/// pushes, it believes its model.
const CYCLES: usize = 3000;
/// Cycles that are traced. Bits flip in all but the first of them: the loop has begun, and has time to come back.
const TRACED: usize = 60;
const FIRST: usize = 15;
/// Silence after which a node has stopped. One that is traced is slow.
const PATIENCE: Duration = Duration::from_secs(2);
const PATIENCE_TRACED: Duration = Duration::from_secs(30);

/// Attempts at a run until its flip has been done.
const ATTEMPTS: u32 = 5;

/// A part of a node's memory.
struct Region {
    name: &'static str,
    addresses: Range<u32>,
}

/// A node's program, what it does without a fault, and its memory.
struct Subject<'o> {
    role: Role,
    path: &'o Path,
    image: Image,
    undisturbed: Run,
    /// Functions in the order in which they were entered.
    entered: Vec<u32>,
    regions: [Region; 3],
}

/// Runs the campaign; the table as text.
pub(crate) fn run(options: &Options) -> Result<String, Error> {
    let mut table = format!("{:<12}{:<11}{:>6}{:>7}", "node", "memory", "bytes", "flips");
    ALL.iter().for_each(|(_, name)| table.push_str(&format!("{name:>10}")));
    for (role, path) in [(Role::Controller, &options.controller), (Role::Actuator, &options.actuator)] {
        let subject = Subject::look_at(role, path, options.seed)?;
        let done = AtomicUsize::new(0);
        let flips: Vec<(usize, Flip)> =
            (0..options.flips).map(|number| subject.draw(options.seed, number)).collect();
        let found: Vec<(usize, Outcome)> = flips
            .into_par_iter()
            .map(|(region, flip)| {
                let outcome = subject.try_out(options.seed, flip)?;
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                if done.is_multiple_of(100) {
                    eprintln!("{}: {done} of {}", name(role), options.flips);
                }
                if options.each && outcome != Outcome::Masked {
                    eprintln!("{} {outcome:?}: {flip:x?}", name(role));
                }
                Ok((region, outcome))
            })
            .collect::<Result<_, Error>>()?;
        for (number, region) in subject.regions.iter().enumerate() {
            let of_region: Vec<Outcome> =
                found.iter().filter(|(of, _)| *of == number).map(|(_, outcome)| *outcome).collect();
            let bytes = region.addresses.len();
            write!(table, "\n{:<12}{:<11}{bytes:>6}{:>7}", name(role), region.name, of_region.len())?;
            for (outcome, _) in ALL {
                write!(table, "{:>10}", of_region.iter().filter(|found| **found == outcome).count())?;
            }
        }
    }
    Ok(table)
}

fn name(role: Role) -> &'static str {
    match role {
        Role::Controller => "controller",
        Role::Actuator => "actuator",
    }
}

impl<'o> Subject<'o> {
    /// Runs without a fault: once undisturbed, and once function by function.
    fn look_at(role: Role, path: &'o Path, seed: u64) -> Result<Self, Error> {
        let image = Image::read(path)?;
        let mut node = Node::start(path, false, PATIENCE)?;
        let undisturbed = run_loop(&mut node, role, seed, CYCLES, &[]);
        if undisturbed.has_fallen || undisturbed.has_stopped || log::tells(&node.log(), &image.grave) {
            return Err(format!("{}: the loop does not hold without a fault either", path.display()).into());
        }
        let status = node.status().map_err(|_| "no answer")?;
        drop(node);

        let mut entered = Vec::new();
        let mut node = Node::start(path, true, PATIENCE_TRACED)?;
        let debugger = Debugger::connect(&node.debugger_socket())?;
        let stack = thread::scope(|scope| {
            let tracing = scope.spawn(|| debugger.trace(&image, |function| entered.push(function)));
            let traced = run_loop(&mut node, role, seed, TRACED, &[]);
            drop(node);
            let stack = tracing.join().map_err(|_| Error::from("the debugger has failed"))??;
            if traced.has_stopped {
                return Err(Error::from("the program does not run under the debugger"));
            }
            Ok(stack)
        })?;
        let lowest = image.stack_start - status.stack;
        let regions = [
            Region { name: "variables", addresses: image.variables.clone() },
            Region { name: "state", addresses: stack..image.stack_start },
            Region { name: "stack", addresses: lowest..stack },
        ];
        Ok(Self { role, path, image, undisturbed, entered, regions })
    }

    /// Flip number `number`: any bit of the memory in use is as likely, and any function that is entered.
    fn draw(&self, seed: u64, number: u32) -> (usize, Flip) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(u64::from(number) << 8 | self.role as u64);
        let bytes: usize = self.regions.iter().map(|region| region.addresses.len()).sum();
        let mut place = random.random_range(0..bytes) as u32;
        let bit = random.random_range(0..8);
        let mut region = 0;
        while place >= self.regions[region].addresses.len() as u32 {
            place -= self.regions[region].addresses.len() as u32;
            region += 1;
        }
        // Where exactly the trace ends depends on how fast the emulator was ended.
        let last = (self.entered.len() - self.entered.len() / 10) / 100 * 100;
        let at = random.random_range(last * FIRST / TRACED..last);
        let function = self.entered[at];
        let entered = self.entered[..=at].iter().filter(|other| **other == function).count() as u32;
        (region, Flip { function, entered, address: self.regions[region].addresses.start + place, bit })
    }

    /// Runs the loop with this flip; again where the machine was too busy for the node to answer before it.
    fn try_out(&self, seed: u64, flip: Flip) -> Result<Outcome, Error> {
        let tries = (1..ATTEMPTS).find_map(|_| self.try_once(seed, flip).ok());
        tries.map_or_else(|| self.try_once(seed, flip), Ok)
    }

    fn try_once(&self, seed: u64, flip: Flip) -> Result<Outcome, Error> {
        let mut node = Node::start(self.path, true, PATIENCE)?;
        let debugger = Debugger::connect(&node.debugger_socket())?;
        let (run, log) = thread::scope(|scope| {
            let flipping = scope.spawn(move || debugger.flip(flip));
            let run = run_loop(&mut node, self.role, seed, CYCLES, &self.undisturbed.inputs);
            let log = node.log();
            drop(node);
            flipping.join().map_err(|_| Error::from("the debugger has failed"))??;
            Ok::<_, Error>((run, log))
        })?;
        Ok(Outcome::of(&run, &self.undisturbed, log::tells(&log, &self.image.grave)))
    }
}
