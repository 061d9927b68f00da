//! What a node needs of its board, and the board of its node, as traits: nodes are tested with a board made of memory.

use crate::design::{INPUTS, Scalar};
use slqg::{
    Health, Tick,
    actuator::Applied,
    wire::{TuningStep, Verdict},
};

/// A board as its node sees it.
pub trait Board {
    /// Sends a frame to the host. One that does not fit into the queue any more is lost as a whole.
    fn send(&mut self, frame: &[u8]);
    /// Begins the period of the cycle timer anew: a cycle begins.
    fn restart_period(&mut self);
    /// Puts an input to the plant. The boards here have no output that would drive one; the frame that tells the host of it
    /// takes its place.
    fn apply(&mut self, _applied: &Applied<Scalar, INPUTS>) {}
    /// Ticks of the board's clock, which wraps somewhere.
    fn ticks(&self) -> u32;
    /// Ticks from `begin` until now; right for spans up to a control cycle.
    fn elapsed(&self, begin: u32) -> u32;
    /// What memory and queues have come to.
    fn usage(&self) -> Usage;
    /// Something that whoever looks after the node wants to know.
    fn note(&mut self, notice: Notice);
}

/// A node as its board sees it.
pub trait Node {
    /// Begins: tells the host that it is there.
    fn start(&mut self, board: &mut impl Board);
    /// Takes a frame from the host.
    fn take(&mut self, frame: &[u8], board: &mut impl Board);
    /// The cycle timer says that a period is over.
    fn period_over(&mut self, board: &mut impl Board);
    /// The frame that leaves the plant safe when the program has failed; empty if there is nothing to say.
    fn safe_frame<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8];
}

/// What memory and queues have come to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Usage {
    /// Most bytes of stack in use so far.
    pub stack: u32,
    /// Bytes of static variables.
    pub variables: u32,
    /// Frames lost because a queue was full or they were too long.
    pub overruns: u32,
}

/// What a node does beyond its daily work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Notice {
    /// The clock has told the first cycle.
    Aligned(Tick),
    /// The clock has told another cycle than the next one, often enough to be believed: the node begins anew.
    Realigned(Tick),
    /// The clock has jumped to this cycle, and nothing confirms that yet: the node goes on as it was.
    ClockRefused(Tick),
    /// No clock for too long, or none yet: the plant gets the safe input.
    Safe,
    /// The end of the loop on this node is in another health than before.
    Health(Health),
    /// A blob of gains has come to an end.
    Gains(Verdict),
    /// A controller that tunes itself has done something about its gains.
    Tuned(TuningStep),
    /// Frames that are refused for their tags come too often.
    #[cfg(feature = "authentication")]
    Alarm(slqg::authentication::Alarm),
    /// A frame changed nothing; holds what kind it said it was, 0 if nothing.
    Rejected(u8),
}
