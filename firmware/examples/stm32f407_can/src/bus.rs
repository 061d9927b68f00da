//! The bus as all nodes of the loop agree on it: identifiers, bit timing, and what this node lets in.

use bxcan::{
    Can, Fifo, FilterOwner, Instance,
    filter::{BankConfig, ListEntry32},
};
use embedded_can::{Id, StandardId};
use slqg::wire::{Role, can::Identifiers};
use slqg_nodes::{
    can::{Form, taken_by},
    design::{DESIGN_ID, INPUT_GRID, INPUTS, OUTPUT_GRID, OUTPUTS, Scalar},
};

/// The clock of the CAN controller, that of the bus APB1.
pub(crate) const APB1_HZ: u32 = 42_000_000;
/// Bits in a second on the bus. The `bit_rate` of the design's `[network.can]` is to be the same.
const BIT_RATE: u32 = 500_000;

// A bit has 1 + 11 + 2 = 14 quanta of 6 clocks, 143 ns each, and is sampled at 12/14 of it, 86 %: late enough for long cables,
// with two quanta left for clocks that differ. Each node may shift its edges by both of them.
const PRESCALER: u32 = 6;
const SEGMENT_1: u32 = 11;
const SEGMENT_2: u32 = 2;
const JUMP: u32 = 2;
const _: () = assert!(APB1_HZ == BIT_RATE * PRESCALER * (1 + SEGMENT_1 + SEGMENT_2));
/// The register CAN_BTR: each field holds one less than it means.
const BIT_TIMING: u32 = (JUMP - 1) << 24 | (SEGMENT_2 - 1) << 20 | (SEGMENT_1 - 1) << 16 | (PRESCALER - 1);

/// Identifiers as those of `designs/pendulum_can.toml`; the clock goes before all traffic.
const CLOCK: u16 = 0x084;
const MEASUREMENT: u16 = 0x704;
const CONTROL: u16 = 0x705;
const ACKNOWLEDGEMENT: u16 = 0x706;

const fn standard(id: u16) -> Id {
    match StandardId::new(id) {
        Some(id) => Id::Standard(id),
        None => panic!("more than 11 bits"),
    }
}

/// The loop's frames on this bus.
pub(crate) fn form() -> Form<Scalar, INPUTS, OUTPUTS> {
    const IDENTIFIERS: Identifiers = Identifiers {
        measurement: standard(MEASUREMENT),
        control: standard(CONTROL),
        acknowledgement: standard(ACKNOWLEDGEMENT),
    };
    Form::new(DESIGN_ID, const { standard(CLOCK) }, IDENTIFIERS, INPUT_GRID, OUTPUT_GRID)
        .expect("different identifiers, and grids that the generator has checked")
}

/// Puts the node on the bus. Waits for it: a bus that is cut or short-circuited never falls silent.
pub(crate) fn join<I: Instance + FilterOwner>(instance: I, role: Role) -> Can<I> {
    // What meets a disturbance is sent again until it is through, or until a newer frame takes its place: see `Line`.
    let mut can = Can::builder(instance).set_bit_timing(BIT_TIMING).leave_disabled();
    let form = form();
    {
        let mut filters = can.modify_filters();
        filters.clear();
        // A bank of its own for each identifier, which it has twice: a bank holds two.
        let identifiers = taken_by(role).iter().filter_map(|kind| form.identifier(*kind));
        for (bank, id) in (0..).zip(identifiers) {
            let entry = ListEntry32::data_frames_with_id(id_of_driver(id));
            // Three frames fit into a FIFO. A node gets three in a cycle: no burst of them is lost, even while it computes.
            filters.enable_bank(bank, Fifo::Fifo0, BankConfig::List32([entry, entry]));
        }
    }
    // The controller comes back by itself after it has been off the bus for too many errors.
    while can.enable_non_blocking().is_err() {}
    can
}

/// The driver's filters have an identifier type of their own.
fn id_of_driver(id: Id) -> bxcan::Id {
    match id {
        Id::Standard(id) => bxcan::StandardId::new(id.as_raw()).expect("11 bits").into(),
        Id::Extended(id) => bxcan::ExtendedId::new(id.as_raw()).expect("29 bits").into(),
    }
}
