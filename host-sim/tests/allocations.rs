//! A run allocates when it begins, and nothing in its cycles.

use gain_gen::design::Design;
use host_sim::{
    closed_loop::{RunPlan, run},
    contender::{Contender, Kind},
    fitted::Fitted,
};
use slqg::Scalar;
use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

/// The system's allocator, counting what each thread asks of it.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: all is the system's; a thread-local counter without a destructor allocates nothing itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: as promised by the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as promised by the caller.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const BAD: &str = include_str!("../../designs/double_integrator_bad.toml");
const BURSTY: &str = include_str!("../../designs/double_integrator_bursty.toml");
const DRIVE: &str = include_str!("../../designs/drive_event.toml");
const LONG: usize = 1000;

/// Allocations of one run of each length, 100 cycles and 1000.
fn allocations<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    kind: Kind,
    text: &str,
) -> [u64; 2] {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    // Copies are packets too.
    design.network.controller_to_actuator.duplicates = 0.2;
    let contender = Contender::new(kind, &design, LONG).expect("a stabilised loop");
    let fitted = Fitted::<T, NX, NU, NY>::new(&design, &contender);
    [100, LONG].map(|steps| {
        let before = ALLOCATIONS.get();
        run(&fitted, &contender, RunPlan { steps, seed: 4, run: 2 }, |_| ());
        ALLOCATIONS.get() - before
    })
}

#[test]
fn a_run_of_a_thousand_cycles_allocates_as_much_as_one_of_a_hundred() {
    let late = BAD.replace("acknowledgement = \"instant\"", "acknowledgement = { delays = [0.5, 0.2, 0.1] }");
    assert_ne!(late, BAD);
    for [short, long] in [
        allocations::<f32, 4, 1, 2>(Kind::Slqg, PENDULUM),
        allocations::<f32, 4, 1, 2>(Kind::Lqg, PENDULUM),
        allocations::<f32, 4, 1, 2>(Kind::SlqgTuning, PENDULUM),
        allocations::<f32, 2, 1, 2>(Kind::Slqg, BAD),
        allocations::<f32, 2, 1, 2>(Kind::SlqgUdp, BAD),
        allocations::<f64, 2, 1, 2>(Kind::Slqg, &late),
        allocations::<f32, 2, 1, 2>(Kind::SlqgChannel, BURSTY),
        allocations::<f32, 4, 1, 2>(Kind::Slqg, DRIVE),
    ] {
        assert!(short > 0, "the allocator counts");
        assert_eq!(long, short);
    }
}
