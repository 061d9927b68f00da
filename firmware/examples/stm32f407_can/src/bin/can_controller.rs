//! The controller node on a CAN bus.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use slqg::wire::Role;
use slqg_nodes::controller::Node;
use slqg_nodes::design::Memory;
use slqg_nodes::laws::{BANK_MEMORY, Sent};

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut memory = Memory::new();
    let mut bank = [0.0; BANK_MEMORY];
    let mut laws = Sent::new(&mut bank);
    slqg_stm32f407_can::program::run(Node::new(&mut memory, &mut laws), Role::Controller)
}
