//! What a controller's cycle costs on the board, case by case: frames taken in, estimate, decision, frame made.
//!
//! QEMU must count instructions (`-icount`), or the board's timer says nothing; `cargo xtask bench target` sees to that and
//! makes instructions of the ticks. On the host there is no such timer, and nothing to count.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("instructions are counted on the board: cargo xtask bench target");
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use cortex_m_semihosting::hprintln;
    use slqg_bench::{CASES, board};

    board::start_timer();
    for case in CASES {
        let time = (case.run)(board::ticks).time;
        // Name, ticks of all cycles, of the longest, and cycles.
        hprintln!("{} {} {} {}", case.name, time.total, time.longest, time.cycles);
    }
    board::exit(true)
}
