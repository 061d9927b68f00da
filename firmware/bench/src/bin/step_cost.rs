//! What each step of a cycle costs on the board, by design and sequence length.
//!
//! QEMU must count instructions, as for `cycle_cost`; `cargo xtask bench target` makes a table of both.
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
    use slqg_bench::{Cost, board, each_step_cost};

    board::start_timer();
    each_step_cost(board::ticks, &mut |cost| {
        let Cost { design, length, step, time, multiply_adds } = cost;
        // Ticks of all cycles, of the longest, cycles, and multiply-adds, 0 where there are none.
        hprintln!(
            "{} {} {} {} {} {} {}",
            design,
            length,
            step,
            time.total,
            time.longest,
            time.cycles,
            multiply_adds.unwrap_or(0)
        );
    });
    board::exit(true)
}
