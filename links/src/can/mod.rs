//! A CAN bus, event by event: other traffic, arbitration, bit errors, retransmission, error confinement.
//!
//! Nothing here knows what frames mean. Times are nanoseconds, so that bits of both bit rates of CAN FD and the periods
//! of the nodes are whole numbers. `docs/can.md` says what is modelled, after which sources, and what is not.
//!
//! | file | what lives there |
//! |---|---|
//! | `time` | nanoseconds, and how many of them a bit lasts |
//! | `id`, `frame` | identifiers as arbitration orders them, formats and payloads |
//! | `bits`, `length` | the bits of a frame with CRC and stuffing, and how long they last |
//! | `source`, `background` | messages that nodes send by themselves, and a realistic set of them |
//! | `errors` | which bits are disturbed |
//! | `settings` | how a bus is set up |
//! | `node` | transmit queue and error counters of a node |
//! | `bus`, `arrival`, `transmission` | the bus itself: order of events, frames into queues, frames on the bus |
//! | `event`, `statistics`, `log` | what it tells |
//! | `response_time` | worst-case response times by analysis |

mod arrival;
mod background;
mod bits;
mod bus;
mod errors;
mod event;
mod frame;
mod id;
mod length;
mod log;
mod node;
mod response_time;
mod settings;
mod source;
mod statistics;
mod time;
mod transmission;

pub use background::{Background, BackgroundError};
pub use bits::bits;
pub use bus::{Bus, OfferError};
pub use errors::{Errors, ErrorsError, Phase};
pub use event::{Event, Fate, Origin, What};
pub use frame::{Attempts, FD_SIZES, Format, Frame, LARGEST_PAYLOAD, PayloadError};
pub use id::{Id, IdError};
pub use length::Length;
pub use log::{Log, Record};
pub use response_time::{Periodic, meets_deadlines, response_times};
pub use settings::{Recovery, Settings, SettingsError, Stuffing};
pub use source::{NodeId, Pattern, Source, SourceError};
pub use statistics::{Message, Response, Statistics};
pub use time::{INTERMISSION, RateError, Rates, SECOND, Time};
pub use transmission::Confinement;
