//! What it costs the board to solve its own gains: the pendulum, whose link turns from good to bad.
//!
//! QEMU must count instructions (`-icount`), or the board's timer says nothing; `cargo xtask bench solve` sees to that and
//! makes instructions of the ticks. On the host there is no such timer, and nothing to count.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("instructions are counted on the board: cargo xtask bench solve");
}

#[cfg(target_os = "none")]
mod count {
    use core::mem::size_of;
    use cortex_m_semihosting::hprintln;
    use slqg::tuning::{Parameters, Progress, Solver};
    use slqg_bench::board;

    /// What the generator makes of a design.
    macro_rules! design {
        ($name:ident) => {
            #[allow(dead_code, unreachable_pub)]
            mod $name {
                include!(concat!(env!("OUT_DIR"), "/", stringify!($name), ".rs"));
            }
        };
    }
    design!(pendulum);
    design!(pendulum_bad_4);
    design!(pendulum_8);
    design!(pendulum_bad);

    /// Ticks of slices of one kind.
    #[derive(Clone, Copy, Default)]
    struct Slices {
        count: u32,
        ticks: u64,
        longest: u32,
    }

    /// Solves for the link, slice by slice, and prints a line: name, bytes of memory, then for the backward steps and for the
    /// slices of the proof their number, all their ticks, and those of the longest.
    fn solve<const NX: usize, const NU: usize>(
        name: &str,
        bytes: usize,
        solver: &mut Solver<'_, f32, NX, NU>,
        link: &[f32],
    ) -> bool {
        solver.begin(link);
        let (mut steps, mut proof) = (Slices::default(), Slices::default());
        loop {
            let is_proving = solver.is_proving();
            let start = board::ticks();
            let progress = solver.slice();
            let ticks = board::ticks().wrapping_sub(start);
            let slices = if is_proving { &mut proof } else { &mut steps };
            slices.count += 1;
            slices.ticks += u64::from(ticks);
            slices.longest = slices.longest.max(ticks);
            match progress {
                Progress::Working => {}
                Progress::Solved(_) => break,
                Progress::Idle | Progress::Unsolved(_) => return false,
            }
        }
        let of = |slices: Slices| (slices.count, slices.ticks, slices.longest);
        let ((a, b, c), (d, e, f)) = (of(steps), of(proof));
        hprintln!("{} {} {} {} {} {} {} {}", name, bytes, a, b, c, d, e, f);
        true
    }

    /// From nothing to the good link, then from there to the bad one.
    macro_rules! pendulum {
        ($good:ident, $bad:ident, $first:literal, $then:literal) => {{
            let mut memory = [0.0; $good::TUNING_MEMORY];
            let bytes = size_of::<$good::Tuner<'_>>() + 4 * $good::TUNING_MEMORY;
            let most = Parameters::DEFAULT.most_steps;
            let solver = Solver::new(&$good::MODEL, $good::TUNING, most, &mut memory);
            solver.is_ok_and(|mut solver| {
                solve($first, bytes, &mut solver, $good::TUNING.survival)
                    && solve($then, bytes, &mut solver, $bad::TUNING.survival)
            })
        }};
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        board::start_timer();
        let four = pendulum!(pendulum, pendulum_bad_4, "N=4,from-zero", "N=4,good-to-bad");
        let eight = pendulum!(pendulum_8, pendulum_bad, "N=8,from-zero", "N=8,good-to-bad");
        board::exit(four && eight)
    }
}
