//! Control cycles per second of the simulator: `cargo xtask bench simulate`.
//!
//! The pendulum on `good` with four inputs per sequence in `f32`: estimator, gains, encoding and decoding of all frames, plant
//! and links; nothing is recorded. Rates are per second of processor time, so that other work on the machine counts as little
//! as it can; caches and memory are still shared with it.

use gain_gen::design::Design;
use host_sim::{
    closed_loop::{RunPlan, run},
    contender::{Contender, Kind},
    fitted::Fitted,
};
use rustix::time::{ClockId, clock_gettime};
use std::{hint::black_box, sync::Barrier, thread, time::Instant};

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const STEPS: usize = 1000;
/// Runs per thread and measurement: a fraction of a second.
const RUNS: u64 = 150;
const MEASUREMENTS: usize = 15;
/// Of each thread, in bytes.
const STACK: usize = 1 << 26;

type Pendulum = Fitted<f32, 4, 1, 2>;

/// Processor time that this thread has used, in s.
fn thread_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// What a number of threads reached together.
struct Rates {
    /// Cycles per second of processor time, summed over the threads.
    processor: f64,
    /// Cycles per second on the clock.
    clock: f64,
}

/// Cycles per second with this many threads, each with runs of its own.
fn measure(threads: u64, fitted: &Pendulum, contender: &Contender) -> Rates {
    let ready = Barrier::new(threads as usize + 1);
    let cycles = (RUNS * STEPS as u64) as f64;
    let work = |thread: u64| {
        ready.wait();
        let start = thread_time();
        for number in thread * RUNS..(thread + 1) * RUNS {
            let plan = RunPlan { steps: STEPS, seed: 1, run: number };
            black_box(run(fitted, contender, plan, |_| ()));
        }
        cycles / (thread_time() - start)
    };
    thread::scope(|scope| {
        let spawn = |thread| {
            let builder = thread::Builder::new().stack_size(STACK);
            builder.spawn_scoped(scope, move || work(thread)).expect("a thread can be started")
        };
        let spawned: Vec<_> = (0..threads).map(spawn).collect();
        ready.wait();
        let start = Instant::now();
        let processor = spawned.into_iter().map(|thread| thread.join().expect("runs do not panic")).sum();
        Rates { processor, clock: threads as f64 * cycles / start.elapsed().as_secs_f64() }
    })
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn best(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

fn main() {
    let design = Design::parse(PENDULUM, "pendulum.toml").expect("a design of the project");
    let contender = Contender::new(Kind::Slqg, &design, STEPS).expect("a stabilised loop");
    let fitted = Pendulum::new(&design, &contender);
    // One after the other, so that both meet the same company on the machine.
    let measured: Vec<[Rates; 2]> =
        (0..MEASUREMENTS).map(|_| [1, 2].map(|threads| measure(threads, &fitted, &contender))).collect();

    println!(
        "pendulum on `good`, N = 4, f32; {MEASUREMENTS} measurements of {RUNS} runs of {STEPS} cycles\n"
    );
    println!("                                  median        best");
    for (threads, at) in [(1, 0), (2, 1)] {
        let processor = || measured.iter().map(move |pair| pair[at].processor);
        let clock = || measured.iter().map(move |pair| pair[at].clock);
        println!(
            "{threads} thread{}  cycles / s of CPU   {:>9.3e}   {:>9.3e}",
            if threads == 1 { " " } else { "s" },
            median(processor()),
            best(processor())
        );
        println!("           cycles / s on clock {:>9.3e}   {:>9.3e}", median(clock()), best(clock()));
    }
    let scaling = |of: fn(&Rates) -> f64| measured.iter().map(move |[one, two]| of(two) / of(one));
    println!(
        "\n2 threads do as much as 1, times {:.2} by CPU (median of pairs), {:.2} on the clock",
        median(scaling(|rates| rates.processor)),
        median(scaling(|rates| rates.clock))
    );
}
