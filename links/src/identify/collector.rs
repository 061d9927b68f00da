//! [`Collector`]: takes the frames of logs, tells the sender's from the receiver's, and finds the number that tells packets apart.

use super::{
    about::{About, Skip},
    choice::{Choice, choose},
    column::{Column, Sighting},
    early::Early,
    formats::message::{Direction, Message},
    logs::Selection,
    pairing::{self, Way},
    trace::{Trace, TraceError},
};
use std::path::Path;

/// Frames that are kept with their payload until it is decided what tells packets apart. A counter of 16 bits wraps before.
const ENOUGH: usize = 300_000;
/// Interfaces that are remembered for a message.
const MOST_INTERFACES: usize = 16;

/// How the ends of a link are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends<'s> {
    /// By the interface; where it is the same, by the direction.
    Interfaces { tx: &'s str, rx: &'s str },
    /// The first file is the sender's.
    Files,
    /// Two interfaces in one file: packets are seen at the sender's first.
    Order,
}

/// An end of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Sender = 0,
    Receiver = 1,
}

/// What is known while logs are read.
pub(super) struct Collector<'s> {
    files: Vec<&'s Path>,
    file: usize,
    ends: Ends<'s>,
    pub(super) selection: &'s Selection<'s>,
    about: About,
    interfaces: Vec<Vec<u8>>,
    early: Early,
    choice: Option<Choice>,
    main: [Column; 2],
    others: Vec<[Column; 2]>,
    /// Files in which each end was seen.
    seen_in: [Option<usize>; 2],
    has_two_clocks: bool,
}

impl<'s> Collector<'s> {
    pub(super) fn new(files: Vec<&'s Path>, ends: Ends<'s>, selection: &'s Selection<'s>) -> Self {
        Self {
            has_two_clocks: files.len() > 1,
            files,
            file: 0,
            ends,
            selection,
            about: About::default(),
            interfaces: Vec::new(),
            early: Early::default(),
            choice: None,
            main: Default::default(),
            others: Vec::new(),
            seen_in: [None; 2],
        }
    }

    /// The next file begins.
    pub(super) fn begin_file(&mut self, index: usize) {
        self.file = index;
    }

    /// Counts what is no packet of the link.
    pub(super) fn skip(&mut self, skip: Skip) {
        self.about.skipped.add(skip);
    }

    /// Counts frames that the logger says it missed.
    pub(super) fn dropped(&mut self, count: u64) {
        self.about.dropped = self.about.dropped.saturating_add(count);
    }

    /// Takes a frame.
    pub(super) fn message(&mut self, message: &Message<'_>) {
        let Some(end) = self.end(message) else { return self.skip(Skip::Interface) };
        self.seen_in[end as usize].get_or_insert(self.file);
        match &self.choice {
            None => self.early.push(message, end),
            Some(_) => self.take(message, end),
        }
    }

    fn end(&mut self, message: &Message<'_>) -> Option<End> {
        let place = match self.ends {
            Ends::Files => return Some(if self.file == 0 { End::Sender } else { End::Receiver }),
            Ends::Interfaces { tx, rx } if tx == rx => {
                self.know(message.interface);
                return match message.direction.filter(|_| message.interface == tx.as_bytes())? {
                    Direction::Sent => Some(End::Sender),
                    Direction::Heard => Some(End::Receiver),
                };
            }
            Ends::Interfaces { tx, .. } if is_same(message.interface, tx) => return Some(End::Sender),
            Ends::Interfaces { rx, .. } if is_same(message.interface, rx) => return Some(End::Receiver),
            Ends::Interfaces { .. } => {
                self.know(message.interface);
                return None;
            }
            Ends::Order => self.know(message.interface),
        };
        match place {
            Some(0) => Some(End::Sender),
            Some(1) => Some(End::Receiver),
            _ => None,
        }
    }

    /// Remembers an interface; which one it is.
    fn know(&mut self, interface: &[u8]) -> Option<usize> {
        let known = self.interfaces.iter().position(|known| known == interface);
        known.or_else(|| {
            if self.interfaces.len() == MOST_INTERFACES {
                return None;
            }
            self.interfaces.push(interface.to_vec());
            Some(self.interfaces.len() - 1)
        })
    }

    fn take(&mut self, message: &Message<'_>, end: End) {
        let Some(choice) = &self.choice else { return };
        match choice.number(message.stream, message.data) {
            Ok((way, number)) => {
                let ends = if way == 0 { &mut self.main } else { &mut self.others[way - 1] };
                ends[end as usize].push(Sighting { number, time: message.time });
            }
            Err(skip) => self.about.skipped.add(skip),
        }
    }

    /// Decides what tells packets apart, once enough was seen of both.
    pub(super) fn decide_if_enough(&mut self) -> Result<(), TraceError> {
        if self.choice.is_none() && self.early.len() >= ENOUGH { self.decide() } else { Ok(()) }
    }

    fn decide(&mut self) -> Result<(), TraceError> {
        self.check_interfaces()?;
        let choice = choose(&self.early, self.selection, self.has_two_clocks)
            .map_err(|problem| self.whole(problem))?;
        self.others = vec![Default::default(); choice.others()];
        self.about.number = Some(choice.to_string());
        self.choice = Some(choice);
        let early = std::mem::take(&mut self.early);
        early.each(|message, end| self.take(message, end));
        Ok(())
    }

    /// Refuses logs in which an end is missing.
    fn check_interfaces(&self) -> Result<(), TraceError> {
        let names: Vec<_> =
            self.interfaces.iter().map(|name| String::from_utf8_lossy(name).into_owned()).collect();
        let others = match names.as_slice() {
            [] => String::new(),
            names => format!("; other interfaces are there: {}", names.join(", ")),
        };
        match self.ends {
            Ends::Interfaces { tx, rx } if tx == rx && self.early.is_empty() => Err(self.whole(format!(
                "--tx and --rx are the same interface, and no frame on {tx} says in which direction it went; give two interfaces, or log \
                 with candump -x"
            ))),
            Ends::Interfaces { tx, .. } if self.early.has_none(End::Sender) => {
                Err(self.whole(format!("found no frame on {tx} to pair; check --tx and --id{others}")))
            }
            Ends::Order if names.len() != 2 => Err(self.whole(format!(
                "found packets on {} interface{}; give two captures, first the sender's, then the receiver's, or one capture with \
                 --tx INTERFACE and --rx INTERFACE{others}",
                names.len(),
                if names.len() == 1 { "" } else { "s" }
            ))),
            _ => Ok(()),
        }
    }

    fn whole(&self, problem: String) -> TraceError {
        match self.files.as_slice() {
            [file] => TraceError::file(file, problem),
            [first, second] => {
                TraceError::Whole(format!("{} and {}: {problem}", first.display(), second.display()))
            }
            _ => TraceError::Whole(problem),
        }
    }

    /// All logs are read: pairs what was seen.
    pub(super) fn finish(mut self) -> Result<Trace, TraceError> {
        if self.choice.is_none() {
            self.decide()?;
        }
        let Some(choice) = self.choice.take() else { return Err(self.whole("nothing was seen".into())) };
        let [sent, received] = std::mem::take(&mut self.main);
        if let (0, Ends::Interfaces { rx, .. }) = (received.len, self.ends) {
            return Err(self.whole(format!(
                "the receiver saw none of the packets on {rx}: check --rx and which log is which"
            )));
        }
        let moduli = choice.moduli();
        let main = Way { sent, received, modulus: moduli[0] };
        let others = std::mem::take(&mut self.others).into_iter().zip(&moduli[1..]);
        let others = others.map(|([sent, received], &modulus)| Way { sent, received, modulus });
        let same_file = self.seen_in[0] == self.seen_in[1];
        let order = pairing::Order {
            may_swap: self.ends == Ends::Order,
            has_two_clocks: self.has_two_clocks && !same_file,
        };
        let mut trace = pairing::pair(main, others.collect(), order, self.selection, &mut self.about)
            .map_err(|problem| self.whole(problem))?;
        trace.about = self.about;
        Ok(trace)
    }
}

/// Interfaces mostly differ at their end: can0, can1.
fn is_same(interface: &[u8], name: &str) -> bool {
    interface.last() == name.as_bytes().last() && interface == name.as_bytes()
}
