//! The actuator node, its line to the host a pair of files of a debugger.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("this is a program for a board: host-sim pil DESIGN");
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use slqg_nodes::actuator::{LONGEST_IN, LONGEST_OUT, Node};
    use slqg_nodes::front::{longest, of_actuator};
    let mut memory = slqg_nodes::design::ACTUATOR_MEMORY;
    slqg_nodes::bulk::run::<
        _,
        { longest(LONGEST_IN) },
        { slqg::wire::serial::stuffed_len(longest(LONGEST_OUT)) },
    >(of_actuator(Node::new(&mut memory)))
}
