//! A double integrator with the trigger for its law.

use crate::double_integrator::{LENGTH, Number, Workshop, at_fixed_point};
use slqg::DefaultInput;
use slqg::actuator::Settings;
use slqg::controller::Design;
use slqg::event::{InvalidTrigger, TableLengths, Tables, Trigger};

/// Both default inputs.
pub(crate) const BOTH: [DefaultInput; 2] = [DefaultInput::Zero, DefaultInput::Hold];

/// A scalar type in which triggers can be checked.
pub(crate) trait Judge: Number {
    fn trigger<'a>(
        length: usize,
        default_input: DefaultInput,
        send_cost: f64,
        tables: Tables<'a, Self>,
    ) -> Result<Trigger<'a, Self, 2, 1>, InvalidTrigger>;
}

impl Judge for f32 {
    fn trigger<'a>(
        length: usize,
        default_input: DefaultInput,
        send_cost: f64,
        tables: Tables<'a, f32>,
    ) -> Result<Trigger<'a, f32, 2, 1>, InvalidTrigger> {
        Trigger::<f32, 2, 1>::check(length, default_input, send_cost as f32, tables)
    }
}

impl Judge for f64 {
    fn trigger<'a>(
        length: usize,
        default_input: DefaultInput,
        send_cost: f64,
        tables: Tables<'a, f64>,
    ) -> Result<Trigger<'a, f64, 2, 1>, InvalidTrigger> {
        Trigger::<f64, 2, 1>::check(length, default_input, send_cost, tables)
    }
}

/// The double integrator with the tables of its trigger.
pub(crate) struct Bench<T> {
    pub(crate) workshop: Workshop<T>,
    default_input: DefaultInput,
    state: Vec<T>,
    in_flight: Vec<T>,
    sequence: Vec<T>,
}

impl<T: Judge> Bench<T> {
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
        let workshop = Workshop::double_integrator(Settings { default_input, limits: None });
        Self { workshop, default_input, state, in_flight, sequence }
    }

    fn tables(&self) -> Tables<'_, T> {
        Tables { state: &self.state, in_flight: &self.in_flight, sequence: &self.sequence }
    }

    pub(crate) fn trigger(&self, send_cost: f64) -> Trigger<'_, T, 2, 1> {
        T::trigger(LENGTH, self.default_input, send_cost, self.tables()).expect("tables of the right shape")
    }

    pub(crate) fn design<'b>(&'b self, trigger: Option<Trigger<'b, T, 2, 1>>) -> Design<'b, T, 2, 1, 1> {
        Design { trigger, ..self.workshop.design() }
    }
}
