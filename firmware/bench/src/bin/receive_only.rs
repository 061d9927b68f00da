//! Both ends of the pendulum's link, which take in whatever bytes come and do nothing else.
//!
//! It is linked, not run: `cargo xtask test` looks in the image for what panics, and there must be nothing. The panic handler
//! of `board` would hide that, so this image has one of its own and nothing of the library.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("this image is for the board: cargo xtask test looks into it");
}

#[cfg(target_os = "none")]
mod on_board {
    use core::hint::black_box;
    use core::panic::PanicInfo;
    use slqg::Tick;
    use slqg::wire;

    #[allow(dead_code, unreachable_pub)]
    mod pendulum {
        include!(concat!(env!("OUT_DIR"), "/pendulum_8.rs"));
    }
    use pendulum::{INPUTS, OUTPUTS, SEQUENCE_LENGTH, Scalar};

    /// Its name in the image's symbols says that something reaches it.
    #[panic_handler]
    fn panic(_: &PanicInfo) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let (mut memory, mut of_actuator) = (pendulum::Memory::new(), pendulum::ACTUATOR_MEMORY);
        let controller = pendulum::Controller::new(pendulum::DESIGN, Tick(0), memory.lend());
        let mut actuator = pendulum::Actuator::new(pendulum::ACTUATOR, Tick(0), &mut of_actuator);
        let mut room = [[0.0; INPUTS].into(); SEQUENCE_LENGTH];
        // A design that does not fit is found out before anything is received.
        if let Ok(mut controller) = controller {
            loop {
                let bytes = black_box::<&[u8]>(&[]);
                // Behind these the compiler knows nothing of either end's state, as after any number of frames.
                let _ = black_box(black_box(&mut controller).receive(bytes));
                let _ = black_box(black_box(&mut actuator).receive(bytes));
                let _ = black_box(wire::decode_measurement::<Scalar, OUTPUTS>(bytes));
                let _ = black_box(wire::decode_acknowledgement::<Scalar>(bytes));
                let _ = black_box(wire::decode_control::<Scalar, INPUTS>(bytes, &mut room));
                let _ = black_box(wire::frame_len(bytes));
            }
        }
        loop {
            cortex_m::asm::wfi();
        }
    }
}
