//! An actuator that takes frames whose checksums are right: it plays the newest sequence that is of use, and what leaves it is
//! finite, within its limits and its rates.
//!
//! It is compared with a model that counts cycles without wrapping.

use crate::script::{any_bytes, any_frame, byte, tick_near, up_to, vector, whole};
use arbitrary::{Result, Unstructured};
use slqg::actuator::{Actuator, Applied, Limits, Safe, Settings, memory_len};
use slqg::nalgebra::SVector;
use slqg::sequence::ControlSequence;
use slqg::wire::{self, control_len};
use slqg::{Age, DefaultInput, Health, Scalar, Tick};

/// Inputs of the longest sequence that the actuator has memory for.
const LENGTH: usize = 4;
/// Inputs of the longest sequence that is sent.
const LONGEST: usize = LENGTH + 2;

/// Plays a script: the first bytes say what actuator it is, the others what happens to it.
pub fn check(bytes: &[u8]) {
    let mut script = Unstructured::new(bytes);
    // A script that ends early has ended.
    let _ = match script.arbitrary() {
        Ok(true) => play::<f64, 2>(&mut script),
        _ => play::<f32, 1>(&mut script),
    };
}

fn play<T: Scalar, const NU: usize>(script: &mut Unstructured<'_>) -> Result<()> {
    let settings = settings::<T, NU>(script)?;
    // Near the wrap.
    let start = tick_near(script, Tick(0))?;
    let mut memory = [SVector::repeat(T::nearest(f64::NAN)); memory_len(LENGTH)];
    let mut actuator = Actuator::new(settings, start, &mut memory);
    let mut model = Model { settings, start, now: 0, held: None, idle: 0, last: SVector::zeros() };
    while !script.is_empty() {
        match up_to(script, 8)? {
            0..=2 => {
                let applied = actuator.step();
                model.compare(&applied);
                assert_eq!(actuator.tick(), applied.tick + 1);
                model.told(&actuator);
            }
            3 | 4 => {
                let (tick, inputs) = (tick_near(script, actuator.tick())?, inputs(script)?);
                let mut buffer = [0; control_len(8, LONGEST, 8)];
                let sequence = ControlSequence::<T, NU> { tick, inputs: &inputs };
                let frame = wire::encode_control(&sequence, &mut buffer).expect("there is room");
                take(&mut actuator, &mut model, frame);
            }
            5 => {
                let frame = any_frame(script, actuator.tick())?;
                take(&mut actuator, &mut model, &frame);
            }
            6 => take(&mut actuator, &mut model, &whole(any_bytes(script)?)),
            7 => {
                let (tick, inputs) = (tick_near(script, actuator.tick())?, inputs(script)?);
                let taken = actuator.offer(&ControlSequence { tick, inputs: &inputs }).is_ok();
                assert_eq!(model.takes(tick, &inputs), taken);
            }
            _ => {
                let start = tick_near(script, actuator.tick())?;
                actuator.restart(start);
                model = Model { settings, start, now: 0, held: None, idle: 0, last: SVector::zeros() };
            }
        }
    }
    Ok(())
}

/// Hands a frame to both; what the actuator does not take is counted and nothing else.
fn take<T: Scalar, const NU: usize>(
    actuator: &mut Actuator<'_, T, NU>,
    model: &mut Model<T, NU>,
    frame: &[u8],
) {
    let rejected = actuator.rejected_frames();
    let taken = actuator.receive(frame);
    if let Err(error) = &taken {
        assert!(!error.to_string().is_empty());
    }
    assert_eq!(actuator.rejected_frames(), rejected + u32::from(taken.is_err()));
    let mut room = [SVector::zeros(); LENGTH];
    let expected = match wire::decode_control::<T, NU>(frame, &mut room) {
        Ok(sequence) => model.takes(sequence.tick, sequence.inputs),
        Err(_) => false,
    };
    assert_eq!(taken.is_ok(), expected, "{taken:?}");
}

/// Inputs of any number and with any numbers in them.
fn inputs<T: Scalar, const NU: usize>(script: &mut Unstructured<'_>) -> Result<Vec<SVector<T, NU>>> {
    (0..up_to(script, LONGEST as u8)?).map(|_| vector(script)).collect()
}

fn settings<T: Scalar, const NU: usize>(script: &mut Unstructured<'_>) -> Result<Settings<T, NU>> {
    let choice = byte(script)?;
    let is = |bit: u8| choice & 1 << bit != 0;
    let finite = |script: &mut Unstructured<'_>| -> Result<SVector<T, NU>> {
        let vector = vector::<T, NU>(script)?;
        Ok(vector.map(|value: T| if value.is_finite() { value } else { T::zero() }))
    };
    let limits = if is(1) {
        let (one, other) = (finite(script)?, finite(script)?);
        let rate = if is(2) { Some(finite(script)?.abs()) } else { None };
        let (min, max) = (one.zip_map(&other, |a: T, b| a.min(b)), one.zip_map(&other, |a: T, b| a.max(b)));
        Some(Limits { min, max, rate })
    } else {
        None
    };
    let safe = if is(3) {
        let input = finite(script)?;
        Some(Safe { after: up_to(script, 5)?.into(), input })
    } else {
        None
    };
    Ok(Settings { default_input: if is(0) { DefaultInput::Hold } else { DefaultInput::Zero }, limits, safe })
}

/// What an actuator is to do, in cycles since it began.
struct Model<T: Scalar, const NU: usize> {
    settings: Settings<T, NU>,
    start: Tick,
    now: i64,
    /// The cycle of the newest sequence, and its inputs.
    held: Option<(i64, Vec<SVector<T, NU>>)>,
    idle: u16,
    last: SVector<T, NU>,
}

impl<T: Scalar, const NU: usize> Model<T, NU> {
    fn tick(&self) -> Tick {
        Tick(self.start.0.wrapping_add(self.now as u32))
    }

    /// Whether a sequence is of use; if so, it is the one that is played.
    fn takes(&mut self, tick: Tick, inputs: &[SVector<T, NU>]) -> bool {
        let made = self.now + i64::from(tick.since(self.tick()));
        let is_finite = inputs.iter().flatten().all(|value| value.is_finite());
        let is_due = made <= self.now && self.now < made + inputs.len() as i64;
        let is_newer = self.held.as_ref().is_none_or(|(held, _)| made > *held);
        let takes = is_finite && is_due && is_newer && inputs.len() <= LENGTH;
        if takes {
            self.held = Some((made, inputs.to_vec()));
        }
        takes
    }

    /// Compares what was applied with what is to be, and goes on to the next cycle.
    fn compare(&mut self, applied: &Applied<T, NU>) {
        assert_eq!(applied.tick, self.tick());
        let due = self.held.as_ref().and_then(|(made, inputs)| {
            let age = usize::try_from(self.now - made).ok()?;
            Some((inputs.get(age)?, Age::Steps(u8::try_from(age).ok()?)))
        });
        let (wanted, age) = match (due, &self.settings.safe) {
            (Some((input, age)), _) => (*input, age),
            (None, Some(safe)) if self.idle >= safe.after => (safe.input, Age::Empty),
            (None, _) if self.settings.default_input == DefaultInput::Hold => (self.last, Age::Empty),
            (None, _) => (SVector::zeros(), Age::Empty),
        };
        assert_eq!(applied.age, age);
        self.idle = if age == Age::Empty { self.idle + 1 } else { 0 };
        for place in 0..NU {
            let (value, before) = (applied.input[place], self.last[place]);
            assert!(value.is_finite(), "what is applied is finite");
            let mut wanted = wanted[place];
            if let Some(limits) = &self.settings.limits {
                let (min, max) = (limits.min[place], limits.max[place]);
                let rate = limits.rate.map(|rate| rate[place]);
                wanted = if wanted > max {
                    max
                } else if wanted < min {
                    min
                } else {
                    wanted
                };
                // With a rate it may be on the way to its limits, from the zero before the first cycle.
                let was_within = (min..=max).contains(&before) || rate.is_none();
                assert!(!was_within || (min..=max).contains(&value), "within the limits");
                if let Some(rate) = rate {
                    assert!(before - rate <= value && value <= before + rate, "within the rate");
                    wanted = wanted.max(before - rate).min(before + rate);
                }
            }
            assert_eq!(value, wanted, "the input that is wanted, as far as limits let it");
        }
        self.last = applied.input;
        self.now += 1;
    }

    /// What the actuator tells of itself.
    fn told(&self, actuator: &Actuator<'_, T, NU>) {
        let is_lost = self.settings.safe.is_some_and(|safe| self.idle > safe.after);
        assert_eq!(matches!(actuator.health(), Health::Lost(_)), is_lost);
        assert_eq!(actuator.health() == Health::Nominal, self.idle == 0);
        let told = actuator.acknowledgement(3).expect("it has played");
        assert_eq!(told.tick, self.tick() - 1);
        assert!((1..=3).contains(&told.ages.len()) && told.ages.len() as i64 <= self.now);
        assert_eq!(told.ages[0] == Age::Empty, self.idle > 0);
    }
}
