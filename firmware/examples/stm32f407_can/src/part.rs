//! The part: clocks, pins, cycle timer, watchdog, output.
//!
//! | pin | what |
//! |---|---|
//! | PB9, PB8 | CAN1: to the transceiver's TXD, from its RXD |
//! | PA4 | DAC 1: the input of the plant, 0 V and 3.3 V its limits, zero half-way |
//! | PD14 | red LED of the Discovery board: the node has begun anew or has gone to its safe input |
//! | PH0, PH1 | crystal of 8 MHz: the RC oscillator is too inaccurate for CAN |

use crate::{bus, output};
use bxcan::Can;
use cortex_m::peripheral::DWT;
use slqg::wire::Role;
use slqg_nodes::design::SAMPLE_TIME;
use stm32f4xx_hal::{
    can::Can1,
    dac::C1,
    gpio::{Output, PD14},
    pac::{self, TIM2},
    prelude::*,
    rcc::Config,
    timer::CounterUs,
    watchdog::IndependentWatchdog,
};

/// The control cycle in microseconds; the timer has 32 bits of them.
const PERIOD: u32 = (SAMPLE_TIME * 1e6) as u32;
/// Time without the main loop after which the watchdog bites, in ms.
const WATCHDOG_MS: u32 = 100;

/// What the program has of the part.
pub(crate) struct Part {
    pub(crate) output: C1,
    pub(crate) led: PD14<Output>,
    period: CounterUs<TIM2>,
    watchdog: IndependentWatchdog,
}

impl Part {
    /// Sets everything up, the output at rest before the bus is there, and gives the CAN controller beside the rest. To be
    /// called once.
    pub(crate) fn start(role: Role) -> (Self, Can<Can1>) {
        let device = pac::Peripherals::take().expect("called once");
        let mut core = cortex_m::Peripherals::take().expect("called once");
        // The cycle counter, at the clock of the processor.
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();

        let clocks = Config::hse(8.MHz()).sysclk(168.MHz()).pclk1(bus::APB1_HZ.Hz());
        let mut rcc = device.RCC.freeze(clocks);

        let port_a = device.GPIOA.split(&mut rcc);
        let mut output = device.DAC.constrain(port_a.pa4.into_analog(), &mut rcc);
        output::start(&mut output);

        let led = device.GPIOD.split(&mut rcc).pd14.into_push_pull_output();
        let port_b = device.GPIOB.split(&mut rcc);
        let can = bus::join(device.CAN1.can((port_b.pb9, port_b.pb8), &mut rcc), role);

        let mut watchdog = IndependentWatchdog::new(device.IWDG);
        watchdog.start(WATCHDOG_MS.millis());
        let mut part = Self { output, led, period: device.TIM2.counter_us(&mut rcc), watchdog };
        part.restart_period();
        (part, can)
    }

    /// Begins the control cycle anew.
    pub(crate) fn restart_period(&mut self) {
        // Refuses what its 32 bits cannot hold only: no number of microseconds.
        let _ = self.period.start(PERIOD.micros());
    }

    /// Whether a control cycle has gone by since the last time that this was true.
    pub(crate) fn period_is_over(&mut self) -> bool {
        self.period.wait().is_ok()
    }

    /// Tells the watchdog that the program runs.
    pub(crate) fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }
}

/// Cycles of the processor; wraps after 25 s.
pub(crate) fn ticks() -> u32 {
    DWT::cycle_count()
}
