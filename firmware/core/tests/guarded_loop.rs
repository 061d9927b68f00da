//! A loop whose ends are behind guards does what the same loop does without them, bit by bit, through losses and attacks.

mod double_integrator;
mod guarded;
mod lent;
#[path = "random/dice.rs"]
mod random;

use double_integrator::{LENGTH, Workshop};
use guarded::{Counter, IDENTITY, end, keys};
use proptest::prelude::*;
use random::Dice;
use slqg::actuator::{Actuator, Settings};
use slqg::authentication::{
    AlarmSettings, Association, Guard, Guarded, HEAD_LEN, HELLO_LEN, Nonces, Session, Side,
};
use slqg::controller::Controller;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Measurement};
use slqg::{DefaultInput, Tick};

const SETTINGS: Settings<f32, 1> = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
const LOOP_KEY: u8 = 10 * Association::Loop as u8;
const SENSING_KEY: u8 = 10 * Association::Sensing as u8;

type Ends<'d> = (Guarded<Controller<'d, f32, 2, 1, 1>, 2>, Guarded<Actuator<'d, f32, 1>, 1>, Guard<1>);

fn session(association: Association, side: Side, key: u8) -> Session {
    Session::new(association, side, IDENTITY, keys(key))
}

/// Controller, actuator and sensor, in sessions with each other.
fn ends<'d>(workshop: &'d Workshop<f32>, nonces: &mut impl Nonces) -> Ends<'d> {
    let controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    let of_controller = [
        session(Association::Loop, Side::Upstream, LOOP_KEY),
        session(Association::Sensing, Side::Downstream, SENSING_KEY),
    ];
    let mut controller = Guarded::new(controller, Guard::new(of_controller, AlarmSettings::default()));
    let actuator = lent::actuator(SETTINGS, Tick(0), LENGTH);
    let mut actuator = Guarded::new(actuator, end(Association::Loop, Side::Downstream));
    let mut sensor = end(Association::Sensing, Side::Upstream);
    while let Some(hello) = controller.guard_mut().due(nonces) {
        // Whoever it is not for refuses it.
        let mut answer =
            actuator.receive(&hello, nonces).ok().flatten().or_else(|| match sensor.open(&hello, nonces) {
                Ok(slqg::authentication::Opened::Hello(answer)) => answer,
                _ => None,
            });
        while let Some(bytes) = answer {
            let Some(reply) = controller.receive(&bytes, nonces).ok().flatten() else { break };
            answer = actuator.receive(&reply, nonces).ok().flatten();
            sensor.open(&reply, nonces).ok();
        }
    }
    assert!(controller.guard().stands() && actuator.guard().stands() && sensor.stands());
    (controller, actuator, sensor)
}

fn measured(tick: u32, output: f64) -> ([u8; 64], usize) {
    let mut buffer = [0; 64];
    let measurement = Measurement { tick: Tick(tick), output: SVector::from([output as f32]) };
    let len = wire::encode_measurement(&measurement, &mut buffer).expect("there is room").len();
    (buffer, len)
}

#[test]
fn a_guarded_loop_plays_the_inputs_of_the_plain_one_under_losses_and_forgeries() {
    let workshop = Workshop::double_integrator(SETTINGS);
    let mut nonces = Counter(0);
    let (mut controller, mut actuator, mut sensor) = ends(&workshop, &mut nonces);
    let mut plain = (
        lent::controller(workshop.design(), Tick(0)).expect("a fitting design"),
        lent::actuator(SETTINGS, Tick(0), LENGTH),
    );
    let mut dice = Dice(0x1234_5678_9abc_def1);
    let (mut buffer, mut sealed) = ([0; 128], [0; 128]);
    for tick in 0..2000 {
        let (frame, len) = measured(tick, (f64::from(tick) * 0.01).sin());
        let frame = &frame[..len];
        let of_sensor = sensor.seal(frame, &mut sealed).expect("a session").to_vec();
        if dice.roll() < 0.8 {
            plain.0.receive(frame).expect("of use");
            controller.receive(&of_sensor, &mut nonces).expect("of use");
            controller.receive(&of_sensor, &mut nonces).expect_err("it was taken");
        }
        let sent = plain.0.cycle(&mut buffer).expect("there is room").expect("sent").to_vec();
        let mut of_controller = controller.cycle(&mut sealed).expect("there is room").expect("sent").to_vec();
        assert_eq!(of_controller[HEAD_LEN..], sent, "cycle {tick}");
        if dice.roll() < 0.7 {
            plain.1.receive(&sent).expect("of use");
            of_controller[5] ^= 4;
            actuator.receive(&of_controller, &mut nonces).expect_err("forged");
            of_controller[5] ^= 4;
            actuator.receive(&of_controller, &mut nonces).expect("of use");
        }
        let (applied, expected) = (actuator.step(), plain.1.step());
        assert_eq!((applied.age, applied.input[0].to_bits()), (expected.age, expected.input[0].to_bits()));
        let told = plain.1.acknowledgement(1).expect("it has played");
        let told = wire::encode_acknowledgement::<f32>(&told, &mut buffer).expect("there is room").to_vec();
        let of_actuator = actuator.acknowledgement(1, &mut sealed).expect("it has played").to_vec();
        assert_eq!(of_actuator[HEAD_LEN..], told);
        if dice.roll() < 0.7 {
            plain.0.receive(&told).expect("of use");
            controller.receive(&of_actuator, &mut nonces).expect("of use");
        }
    }
    assert!(actuator.guard().failures().forged > 1000);
    assert_eq!(controller.end().counts(), plain.0.counts());
}

#[test]
fn a_controller_without_a_session_runs_on_and_takes_what_it_could_not_send_for_lost() {
    let workshop = Workshop::double_integrator(SETTINGS);
    let controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    let guard = end(Association::Loop, Side::Upstream);
    let mut controller = Guarded::new(controller, guard);
    let mut buffer = [0; 128];
    for _ in 0..5 {
        assert_eq!(controller.cycle(&mut buffer), Ok(None));
    }
    assert_eq!(controller.end().tick(), Tick(5));
}

proptest! {
    #[test]
    fn no_bytes_make_a_guard_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..80),
        form in 0xa0_u8..0xa4,
        association in 0_u8..9,
    ) {
        let mut nonces = Counter(0);
        let mut guard = end(Association::Loop, Side::Downstream);
        for length in [bytes.len(), HELLO_LEN] {
            let mut bytes = bytes.clone();
            bytes.resize(length, 0);
            if let [first, second, ..] = &mut bytes[..] {
                (*first, *second) = (form, association);
            }
            prop_assert!(guard.open(&bytes, &mut nonces).is_err());
            let _ = slqg::authentication::sealed_len(&bytes);
            let _ = guard.seal(&bytes, &mut [0; 64]);
        }
    }
}
