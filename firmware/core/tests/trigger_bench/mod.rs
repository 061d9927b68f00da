//! A double integrator with the trigger for its law.

use crate::double_integrator::{LENGTH, Workshop, at_fixed_point};
use slqg::actuator::Settings;
use slqg::checked::NonNegative;
use slqg::controller::Design;
use slqg::event::{TableLengths, Tables, Trigger};
use slqg::{DefaultInput, Scalar};

/// Both default inputs.
pub(crate) const BOTH: [DefaultInput; 2] = [DefaultInput::Zero, DefaultInput::Hold];

/// The double integrator with the tables of its trigger.
pub(crate) struct Bench<T> {
    pub(crate) workshop: Workshop<T>,
    default_input: DefaultInput,
    state: Vec<T>,
    in_flight: Vec<T>,
    sequence: Vec<T>,
}

impl<T: Scalar> Bench<T> {
    pub(crate) fn new(default_input: DefaultInput) -> Self {
        let tables = at_fixed_point(default_input, |synthesis, _| {
            let lengths = TableLengths::of(LENGTH, default_input, 2, 1);
            let mut tables =
                [lengths.state, lengths.in_flight, lengths.sequence].map(|length| vec![0.0; length]);
            let [state, in_flight, sequence] = &mut tables;
            synthesis.fill_trigger(state, in_flight, sequence);
            tables
        });
        let [state, in_flight, sequence] =
            tables.map(|table| table.iter().map(|value| T::nearest(*value)).collect());
        let workshop = Workshop::double_integrator(Settings { default_input, limits: None, safe: None });
        Self { workshop, default_input, state, in_flight, sequence }
    }

    pub(crate) fn trigger(&self, send_cost: f64) -> Trigger<'_, T, 2, 1> {
        let tables = Tables::check(&self.state, &self.in_flight, &self.sequence).expect("finite");
        let send_cost = NonNegative::check(T::nearest(send_cost)).expect("a cost");
        Trigger::check(LENGTH, self.default_input, send_cost, tables).expect("tables of the right shape")
    }

    pub(crate) fn design<'b>(&'b self, trigger: Option<Trigger<'b, T, 2, 1>>) -> Design<'b, T, 2, 1, 1> {
        Design { trigger, ..self.workshop.design() }
    }
}
