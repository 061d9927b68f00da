//! The actuator node on a CAN bus.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use slqg::wire::Role;
use slqg_nodes::actuator::Node;

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut memory = slqg_nodes::design::ACTUATOR_MEMORY;
    slqg_stm32f407_can::program::run(Node::new(&mut memory), Role::Actuator)
}
