//! The controller node, its line to the host an interrupt-driven UART.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("this is a program for a board: cargo xtask firmware");
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use slqg_nodes::controller::{LONGEST_IN, LONGEST_OUT, Node};
    use slqg_nodes::front::{longest, of_controller};
    use slqg_nodes::{
        design::Memory,
        laws::{BANK_MEMORY, Sent},
    };
    let mut memory = Memory::new();
    let mut bank = [0.0; BANK_MEMORY];
    let mut laws = Sent::new(&mut bank);
    slqg_nodes::program::run::<
        _,
        { longest(LONGEST_IN) },
        { slqg::wire::serial::stuffed_len(longest(LONGEST_OUT)) },
    >(of_controller(Node::new(&mut memory, &mut laws)))
}
