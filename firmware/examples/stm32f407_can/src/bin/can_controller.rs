//! The controller node on a CAN bus.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use slqg::wire::Role;
use slqg_nodes::controller::Node;

#[cortex_m_rt::entry]
fn main() -> ! {
    slqg_stm32f407_can::program::run(Node::default(), Role::Controller)
}
