//! Closed-loop simulation of the slqg core over links that lose and delay packets.
//!
//! There is no controller and no actuator here: both ends are the core's, and pass each other encoded frames. What
//! lives here is what surrounds them on a desk: the plant, the links, many runs, their statistics and pictures.
//!
//! | room | what lives there |
//! |---|---|
//! | [`plant`] | the true plant with its noise |
//! | [`contender`] | a controller to simulate: its gains and the network it gets |
//! | [`size_class`] | from matrices of any size to the core's static types, in one place |
//! | [`fitted`] | a controller's constant data padded to its size class |
//! | [`objective`] | what a run costs |
//! | [`carrier`] | frames as a CAN bus carries them |
//! | [`network`] | the links of a run in use |
//! | [`decision`] | what some controllers decide on the host, beside the core |
//! | [`ends`] | controller and actuator as the simulator drives them |
//! | [`closed_loop`] | one run: plant, links and the two ends, cycle by cycle |
//! | [`adaptation`] | costs before and after a link changes |
//! | [`recovery`] | from which states inputs within their limits lead back |
//! | [`losses`] | how often a loop under input limits is lost |
//! | [`monte_carlo`] | many runs in parallel, and what they say together |
//! | [`sweep`] | designs x controllers x lengths into a file: resumed, in shards, compared run by run |
//! | [`robustness`] | designed for one network, run on another |
//! | [`bus_report`] | load of a bus, and what became of the frames on it |
//! | [`figures`] | the thesis' figures, recomputed |
//! | [`identify`] | options of the command that reads logs of a link |
//! | [`lent`] | memory for the core's ends |
//! | [`node`] | the same loop in real time, as processes that pass each other datagrams |
//! | [`pil`] | the same loop with controller and actuator on boards in an emulator |
//! | [`sample`] | mean, standard error and quantiles |
//! | [`output`] | the table, the JSON and the report with pictures |
//!
//! Same design, same seed: same numbers, on any number of threads.

pub mod adaptation;
pub mod bus_report;
pub mod carrier;
pub mod closed_loop;
pub mod contender;
pub mod decision;
pub mod ends;
pub mod figures;
pub mod fitted;
pub mod identify;
pub mod lent;
pub mod losses;
pub mod monte_carlo;
pub mod network;
pub mod node;
pub mod objective;
pub mod output;
pub mod pil;
pub mod plant;
pub mod random;
pub mod recovery;
pub mod robustness;
pub mod sample;
pub mod size_class;
pub mod sweep;
