//! An estimator driven by hand: what is sent, measured and acknowledged in each cycle is the test's choice.

use slqg::actuator::{Age, Limits, Settings};
use slqg::estimator::{Merging, ModeFilter, Model, Surroundings};
use slqg::gains::{Gains, Tables};
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::{DefaultInput, Scalar, Tick, arrival, sequence::ControlSequence};

/// All ways to merge.
#[allow(dead_code)]
pub(crate) const MERGINGS: [Merging; 3] = [Merging::Single, Merging::Imm, Merging::Gpb2];

/// A scalar type in which gains can be checked.
pub(crate) trait Number: Scalar {
    /// `Gains::check` of this type.
    fn gains<'a, const NX: usize, const NU: usize>(
        length: usize,
        default_input: DefaultInput,
        tables: Tables<'a, Self>,
    ) -> Gains<'a, Self, NX, NU>;
}

impl Number for f32 {
    fn gains<'a, const NX: usize, const NU: usize>(
        length: usize,
        default_input: DefaultInput,
        tables: Tables<'a, f32>,
    ) -> Gains<'a, f32, NX, NU> {
        Gains::<f32, NX, NU>::check(length, default_input, tables).expect("tables of the right shape")
    }
}

impl Number for f64 {
    fn gains<'a, const NX: usize, const NU: usize>(
        length: usize,
        default_input: DefaultInput,
        tables: Tables<'a, f64>,
    ) -> Gains<'a, f64, NX, NU> {
        Gains::<f64, NX, NU>::check(length, default_input, tables).expect("tables of the right shape")
    }
}

/// The loop around an estimator: sequences have as many inputs as there is capacity for.
#[derive(Debug, Clone)]
pub(crate) struct Link<T: Number, const NX: usize, const NU: usize, const NY: usize, const N: usize> {
    pub(crate) model: Model<T, NX, NU, NY>,
    pub(crate) settings: Settings<T, NU>,
    pub(crate) merging: Merging,
    arrives_at_once: T,
    arrival: Vec<T>,
    gains: Vec<T>,
}

impl<T: Number, const NX: usize, const NU: usize, const NY: usize, const N: usize> Link<T, NX, NU, NY, N> {
    /// A packet is `d` cycles late with the probability `delays[d]`; the rest to 1 is loss.
    pub(crate) fn new(model: Model<T, NX, NU, NY>, delays: &[f64], settings: Settings<T, NU>) -> Self {
        let mut survival = [0.0; N];
        arrival::survival(delays, 1.0 - delays.iter().sum::<f64>(), &mut survival);
        let mut table = vec![0.0; arrival::table_len(N)];
        arrival::fill_table(&survival, &mut table);
        Self {
            model,
            settings,
            merging: Merging::Single,
            arrives_at_once: T::nearest(delays[0]),
            arrival: table.iter().map(|value| T::nearest(value.clamp(0.0, 1.0))).collect(),
            gains: vec![T::zero(); N * NU * NX.max(N * NU)],
        }
    }

    /// An estimator in this loop that takes measurements up to `late` cycles late.
    pub(crate) fn driven<const H: usize, const E: usize>(
        &self,
        merging: Merging,
        late: usize,
        start: Tick,
    ) -> Driven<T, NX, NU, NY, N, H, E> {
        let link = Self { merging, ..self.clone() };
        let filter = ModeFilter::new(&link.model, late, start);
        Driven { link, filter, in_flight: InFlight::default() }
    }

    fn gains(&self) -> Gains<'_, T, NX, NU> {
        let default_input = self.settings.default_input;
        let m = &self.gains[..N * NU * default_input.in_flight(N) * NU];
        T::gains(N, default_input, Tables { lx: &self.gains[..N * NU * NX], m, arrival: &self.arrival })
    }
}

/// An estimator and its loop.
#[derive(Debug, Clone)]
pub(crate) struct Driven<
    T: Number,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize,
> {
    pub(crate) link: Link<T, NX, NU, NY, N>,
    pub(crate) filter: ModeFilter<T, NX, NU, NY, N, H, E>,
    in_flight: InFlight<T, NU, N, H>,
}

#[allow(dead_code)]
impl<
    T: Number,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize,
> Driven<T, NX, NU, NY, N, H, E>
{
    fn with<Out>(
        &mut self,
        run: impl FnOnce(&mut ModeFilter<T, NX, NU, NY, N, H, E>, &Surroundings<'_, T, NX, NU, NY, N, H>) -> Out,
    ) -> Out {
        let Self { link, filter, in_flight } = self;
        let gains = link.gains();
        let around = Surroundings {
            model: &link.model,
            in_flight,
            actuator: &link.settings,
            gains: &gains,
            arrives_at_once: link.arrives_at_once,
            merging: link.merging,
        };
        run(filter, &around)
    }

    /// Filters up to the current cycle.
    pub(crate) fn filter(&mut self) {
        self.with(|filter, around| filter.filter(around));
    }

    /// Ends the cycle, in which `sent` was sent.
    pub(crate) fn advance(&mut self, sent: Option<[SVector<T, NU>; N]>) {
        self.filter();
        let tick = self.filter.tick();
        let inputs = |inputs: [SVector<T, NU>; N]| inputs.into_iter().collect();
        self.in_flight.push(sent.map(|sent| ControlSequence { tick, inputs: inputs(sent) }));
        self.with(|filter, around| filter.advance(around));
    }

    /// The mean of what may have been applied in the last cycle but one that was filtered.
    pub(crate) fn expected_input(&mut self, tick: Tick) -> Option<SVector<T, NU>> {
        self.with(|filter, around| filter.expected_input(around, tick))
    }

    /// The probability of each age in the cycle before the one filtered last, the empty buffer last.
    pub(crate) fn probabilities(&self) -> Vec<f64> {
        let modes = self.filter.modes().expect("filtered");
        ages::<N>().map(|age| modes.probability(age).widen()).collect()
    }

    /// Mean and covariance.
    pub(crate) fn numbers(&self) -> Vec<T> {
        let Self { filter, .. } = self;
        filter.posterior_mean().iter().chain(filter.posterior_covariance().iter()).copied().collect()
    }

    /// Mean, covariance and the probabilities of ages, as bits.
    pub(crate) fn bits(&self) -> Vec<u64> {
        let numbers = self.numbers().into_iter().map(T::widen);
        numbers.chain(self.probabilities()).map(f64::to_bits).collect()
    }

    /// Whether every number is one, and the probabilities are some.
    pub(crate) fn is_sound(&self) -> bool {
        let probabilities = self.probabilities();
        let sum: f64 = probabilities.iter().sum();
        self.numbers().iter().all(|number| number.is_finite())
            && probabilities.iter().all(|probability| (0.0..=1.0 + 1e-6).contains(probability))
            && (sum - 1.0).abs() < 1e-5
    }
}

/// Every age of sequences of `N` inputs, newest first and the empty buffer last.
pub(crate) fn ages<const N: usize>() -> impl Iterator<Item = Age> {
    (0..N as u8).map(Age::Steps).chain([Age::Empty])
}

/// An actuator without limits, or with some of this size.
#[allow(dead_code)]
pub(crate) fn settings<T: Number>(default_input: DefaultInput, limit: Option<f64>) -> Settings<T, 1> {
    let bound = |limit: f64| SVector::from([T::nearest(limit)]);
    Settings { default_input, limits: limit.map(|limit| Limits { min: bound(-limit), max: bound(limit) }) }
}
