//! An estimator driven by hand: what is sent, measured and acknowledged in each cycle is the test's choice.

use crate::lent;
use slqg::actuator::{Limits, Settings};
use slqg::estimator::{Merging, ModeFilter, Model, Plausibility, Surroundings};
use slqg::gains::{Gains, Tables};
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::{Age, DefaultInput, Scalar, Tick, arrival};

/// All ways to merge.
#[allow(dead_code)]
pub(crate) const MERGINGS: [Merging; 3] = [Merging::Single, Merging::Imm, Merging::Gpb2];

/// The loop around an estimator, for sequences of `N` inputs.
#[derive(Debug, Clone)]
pub(crate) struct Link<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const N: usize> {
    pub(crate) model: Model<T, NX, NU, NY>,
    pub(crate) settings: Settings<T, NU>,
    pub(crate) merging: Merging,
    /// Nothing is rejected unless a test says so.
    pub(crate) plausibility: Plausibility<T, NY>,
    arrives_at_once: T,
    arrival: Vec<T>,
    gains: Vec<T>,
}

#[allow(dead_code)]
impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const N: usize> Link<T, NX, NU, NY, N> {
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
            plausibility: Plausibility::NONE,
            arrives_at_once: T::nearest(delays[0]),
            arrival: table.iter().map(|value| T::nearest(value.clamp(0.0, 1.0))).collect(),
            gains: vec![T::zero(); N * NU * NX.max(N * NU)],
        }
    }

    /// An estimator in this loop that takes measurements up to `late` cycles late.
    ///
    /// It remembers `H` cycles and keeps as many estimates as the merging asks for.
    pub(crate) fn driven<const H: usize>(
        &self,
        merging: Merging,
        late: usize,
        start: Tick,
    ) -> Driven<T, NX, NU, NY, N, H> {
        self.driven_keeping(merging.estimates(N), merging, late, start)
    }

    /// The same with `kept` estimates.
    pub(crate) fn driven_keeping<const H: usize>(
        &self,
        kept: usize,
        merging: Merging,
        late: usize,
        start: Tick,
    ) -> Driven<T, NX, NU, NY, N, H> {
        let link = Self { merging, ..self.clone() };
        let filter = lent::filter(&link.model, late, start, (N, H, kept));
        Driven { link, filter, in_flight: lent::in_flight(N, N + H, start) }
    }

    fn gains(&self) -> Gains<'_, T, NX, NU> {
        let default_input = self.settings.default_input;
        let m = &self.gains[..N * NU * default_input.in_flight(N) * NU];
        let tables = Tables::check(&self.gains[..N * NU * NX], m, &self.arrival).expect("finite");
        Gains::check(N, default_input, tables).expect("tables of the right shape")
    }
}

/// An estimator and its loop.
#[derive(Debug)]
pub(crate) struct Driven<
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
> {
    pub(crate) link: Link<T, NX, NU, NY, N>,
    pub(crate) filter: ModeFilter<'static, T, NX, NU, NY>,
    in_flight: InFlight<'static, T, NU>,
}

#[allow(dead_code)]
impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const N: usize, const H: usize>
    Driven<T, NX, NU, NY, N, H>
{
    fn with<Out>(
        &mut self,
        run: impl FnOnce(&mut ModeFilter<'static, T, NX, NU, NY>, &Surroundings<'_, T, NX, NU, NY>) -> Out,
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
            plausibility: &link.plausibility,
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
        if let Some(sent) = &sent {
            self.in_flight.candidate().copy_from_slice(sent);
        }
        self.in_flight.push(sent.is_some());
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
pub(crate) fn settings<T: Scalar>(default_input: DefaultInput, limit: Option<f64>) -> Settings<T, 1> {
    let bound = |limit: f64| SVector::from([T::nearest(limit)]);
    Settings {
        default_input,
        limits: limit.map(|limit| Limits { min: bound(-limit), max: bound(limit), rate: None }),
        safe: None,
    }
}
