//! A controller under the law of a bank does what one does whose design has that law.

use slqg::actuator::Settings;
use slqg::bank::Bank;
use slqg::blob::{BlobError, DesignId, Shape, encode, encoded_len};
use slqg::controller::{CycleError, Design, InvalidDesign, Law};
use slqg::gains::{Gains, Tables};
use slqg::{DefaultInput, Tick};

mod double_integrator;
mod lent;
use double_integrator::{LENGTH, Workshop};

const SETTINGS: Settings<f32, 1> = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };

#[test]
fn a_switched_law_runs_as_if_the_design_had_it() {
    let mut workshop = Workshop::<f32>::double_integrator(SETTINGS);
    workshop.model.initial_mean.fill(1.0);
    let design = workshop.design();
    let (lx, m, arrival) =
        ([-0.5; 2 * LENGTH], [0.25; LENGTH * (LENGTH - 1)], [0.5; LENGTH * (LENGTH - 1) / 2]);
    let mut bank = lent::bank::<f32, 2, 1>(LENGTH, DefaultInput::Zero);
    let numbers: Vec<_> = lx.iter().chain(&m).chain(&arrival).copied().collect();
    bank.spare().copy_from_slice(&numbers);
    bank.switch(0.5).expect("gains");

    let tables = Tables::check(&lx, &m, &arrival).expect("gains");
    let gains = Gains::<f32, 2, 1>::check(LENGTH, DefaultInput::Zero, tables).expect("gains");
    let mut other =
        lent::controller(Design { gains, arrives_at_once: 0.5, ..design }, Tick(0)).expect("it fits");
    let mut switched = lent::controller(design, Tick(0)).expect("it fits");
    let (mut under, mut of) = ([0; 64], [0; 64]);
    let mut unswitched = lent::controller(design, Tick(0)).expect("it fits");
    let designed = unswitched.cycle(&mut [0; 64]).expect("there is room").map(<[u8]>::to_vec);
    for cycle in 0..20 {
        let under = switched.cycle_under(&bank.law().expect("in force"), &mut under).expect("it fits");
        assert_eq!(under, other.cycle(&mut of).expect("there is room"));
        assert!(cycle > 0 || under != designed.as_deref(), "the law makes no difference");
    }
}

#[test]
fn a_law_of_another_length_is_refused_before_the_cycle_runs() {
    let workshop = Workshop::<f32>::double_integrator(SETTINGS);
    let mut controller = lent::controller(workshop.design(), Tick(7)).expect("it fits");
    let tables = Tables::check(&[0.0; 2], &[], &[]).expect("gains");
    let gains = Gains::<f32, 2, 1>::check(1, DefaultInput::Zero, tables).expect("gains");
    let outcome = controller.cycle_under(&Law { gains, arrives_at_once: 0.5 }, &mut [0; 64]).map(drop);
    assert_eq!(outcome, Err(CycleError::Law(InvalidDesign::Length)));
    assert_eq!(controller.tick(), Tick(7));
}

/// A law of halves and its blob for the plant `id`.
fn blob(id: u32, length: usize) -> Vec<u8> {
    let shape = Shape { length, states: 2, inputs: 1, default_input: DefaultInput::Zero };
    let (lx, m, arrival) =
        (vec![0.5; 2 * length], vec![0.5; length * (length - 1)], vec![0.5; length * (length - 1) / 2]);
    let tables = Tables::check(&lx, &m, &arrival).expect("gains");
    let mut buffer = vec![0; encoded_len(&shape, 4)];
    encode::<f32>(DesignId(id), &shape, &tables, &mut buffer).expect("gains").to_vec()
}

#[test]
fn a_blob_comes_into_force_whole_or_not_at_all() {
    let mut bank = lent::bank::<f32, 2, 1>(LENGTH, DefaultInput::Zero);
    let load = |bank: &mut Bank<'_, f32, 2, 1>, blob: &[u8]| bank.load(blob, DesignId(7), 0.5);
    assert_eq!(load(&mut bank, &blob(8, LENGTH)), Err(BlobError::Design(DesignId(8))));
    assert_eq!(load(&mut bank, &blob(7, LENGTH - 1)), Err(BlobError::Sequence));
    let mut damaged = blob(7, LENGTH);
    damaged[20] ^= 1;
    assert_eq!(load(&mut bank, &damaged), Err(BlobError::Checksum));
    assert!(bank.law().is_none(), "nothing is in force");
    assert_eq!(load(&mut bank, &blob(7, LENGTH)), Ok(()));
    assert_eq!(bank.law().expect("now one is").gains.arrival(1, 0), 0.5);
    assert_eq!(load(&mut bank, &damaged), Err(BlobError::Checksum));
    assert!(bank.law().is_some(), "the one in force stays");
}
