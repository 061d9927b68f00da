//! Random numbers: one stream per run and purpose, so that neither threads nor other draws shift them.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a stream of random numbers is for. Each has its own, so that controllers compared on the same seed meet the
/// same noise and the same packet fates, however many draws each of them makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// State before the first cycle.
    InitialState = 0,
    /// Noise on the state.
    ProcessNoise = 1,
    /// Noise on the outputs.
    MeasurementNoise = 2,
    /// Delays from sensor to controller.
    SensorLink = 3,
    /// Delays from controller to actuator.
    ActuatorLink = 4,
    /// Delays of acknowledgements.
    AcknowledgementLink = 5,
    /// Phase, other traffic and errors of a bus.
    Bus = 6,
    /// Delays from controller to actuator once that link has become another one.
    ChangedLink = 7,
}

const PURPOSES: u64 = 8;

/// The random numbers of run number `run` for one purpose.
pub fn stream(seed: u64, run: u64, purpose: Purpose) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(run * PURPOSES + purpose as u64);
    random
}

/// The random numbers of what happens once for all runs, such as nodes that are killed: no run's stream is this one.
pub fn common(seed: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(u64::MAX);
    random
}
