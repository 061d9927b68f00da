//! The controller node that solves its own gains when its link has changed, its line to the host an interrupt-driven UART.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("this is a program for a board: cargo xtask firmware --design DESIGN --tuning");
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use slqg_nodes::controller::{LONGEST_IN, LONGEST_OUT, Node};
    use slqg_nodes::design::{Scalar, TUNING_MEMORY};
    use slqg_nodes::laws::Tuned;

    const MEMORY: [Scalar; TUNING_MEMORY] = [0.0; TUNING_MEMORY];
    // Asked for once.
    let memory = cortex_m::singleton!(: [Scalar; TUNING_MEMORY] = MEMORY);
    let Some(tuned) = memory.and_then(|memory| Tuned::new(memory)) else {
        panic!("this design cannot be tuned")
    };
    slqg_nodes::program::run::<_, LONGEST_IN, { slqg::wire::serial::stuffed_len(LONGEST_OUT) }>(Node::new(
        tuned,
    ))
}
