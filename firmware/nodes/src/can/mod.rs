//! A node's line over a CAN bus, whatever the controller: any driver that has [`embedded_can::nb::Can`].
//!
//! | file | what lives there |
//! |---|---|
//! | `form` | which frame is which on the bus: identifiers, and the bytes of each |
//! | `clock` | the clock in eight bytes, one of them its check |
//! | `line` | frames of a node to the bus and back, and what waits while the bus is busy |
//!
//! `docs/wire-format.md` is the normative page. Measurements, control frames and acknowledgements travel in the compact form of
//! [`slqg::wire::can`], so the design needs `wire.format = "can-classic"`. CAN FD is not for these traits: a frame of
//! [`embedded_can`] is one of CAN 2.0, 0 to 8 bytes. A node on CAN FD takes the types of its driver, with
//! [`slqg::wire::can::pad`] and [`slqg::wire::can::unpad`].
//!
//! Of the service frames only the clock is on the bus. Bit rate, pins, filters and what happens after too many errors are
//! the driver's; `firmware/examples` has a whole program.

mod clock;
mod form;
mod line;

pub use form::Form;
pub use line::{LONGEST, Line, Lost, taken_by};
