//! The sample time against what it has to follow: resonances, growth, and the loop that is closed.

use super::Warning;
use super::eigenvalues;
use crate::design::Design;
use crate::figure::figure;
use nalgebra::Complex;
use std::f64::consts::{E, PI};

const KEY: &str = "plant.sample_time";
/// Damping beyond which an oscillation is no resonance.
const DAMPED: f64 = 0.7;
/// Radians per cycle beyond which there are fewer than three samples a period.
const COARSE: f64 = 2.0 * PI / 3.0;
/// Decay in nepers per cycle of what is over before it is sampled again.
const GONE: f64 = 3.0;
/// Of a discrete plant: decay per cycle of what goes on ringing for ten of them.
const RINGS: f64 = 0.1;
/// Samples a period to advise.
const SAMPLES: f64 = 10.0;

/// Exponents per cycle: eigenvalues of the continuous plant times the sample time, or logarithms of those per cycle.
struct Exponents {
    values: Vec<Complex<f64>>,
    /// Of a discrete plant, of which nothing is known beyond half the sampling frequency.
    are_discrete: bool,
}

impl Exponents {
    fn of(design: &Design) -> Option<Self> {
        let plant = &design.plant;
        match &plant.continuous {
            Some((a, _)) => {
                Some(Self { values: eigenvalues(&(a * plant.sample_time))?, are_discrete: false })
            }
            None => {
                let values = eigenvalues(&plant.a)?.into_iter().filter(|value| value.norm() > 0.0);
                Some(Self { values: values.map(|value| value.ln()).collect(), are_discrete: true })
            }
        }
    }

    /// The resonance with the most radians per cycle for which `counts` says so.
    fn fastest(&self, counts: impl Fn(&Complex<f64>) -> bool) -> Option<Complex<f64>> {
        let resonances =
            self.values.iter().filter(|value| value.im > 0.0 && -value.re < DAMPED * value.norm());
        resonances.filter(|value| counts(value)).max_by(|a, b| a.im.total_cmp(&b.im)).copied()
    }
}

pub(super) fn of_plant(design: &Design) -> Vec<Warning> {
    let Some(exponents) = Exponents::of(design) else { return Vec::new() };
    let mut found = Vec::new();
    if exponents.are_discrete {
        // A single negative eigenvalue is no resonance that was sampled: those come in pairs.
        let ringing = exponents.fastest(|value| (COARSE..PI).contains(&value.im) && value.re > -RINGS);
        found.extend(ringing.map(|resonance| coarse(design, resonance)));
    } else if let Some(resonance) = exponents.fastest(|value| value.im > PI) {
        found.push(aliased(design, resonance));
    } else {
        let ringing = exponents.fastest(|value| value.im > COARSE && value.re > -GONE);
        found.extend(ringing.map(|resonance| coarse(design, resonance)));
    }
    let fastest = exponents.values.iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max);
    if fastest > 1.0 {
        let time = design.plant.sample_time;
        found.push(Warning::new(
            design,
            KEY,
            format!(
                "found {} s, but the plant grows by a factor of {} within that time: nothing holds it between two samples",
                figure(time),
                figure(fastest.exp())
            ),
            format!("sample every {} s or faster", advised(time / fastest)),
        ));
    }
    found
}

/// The loop's second moments shrink by `rate` per cycle.
pub(super) fn of_loop(design: &Design, rate: f64) -> Option<Warning> {
    let plant = &design.plant;
    // e^-2: amplitudes shrink by more than e.
    let settles_within_a_cycle = rate < E.powi(-2);
    // A discrete plant that forgets everything at once, such as a delay line, has no slower sampling to be compared with.
    let is_sampled = plant.continuous.is_some() || crate::stability::open_loop_modulus(&plant.a) > E.recip();
    (settles_within_a_cycle && is_sampled).then(|| {
        Warning::new(
            design,
            KEY,
            format!(
                "found {} s, but the closed loop settles within that time (mean-square rate {}): it does not see what it \
                 controls",
                figure(plant.sample_time),
                figure(rate)
            ),
            "sample several times while the loop settles, or weigh the inputs more and control more slowly".into(),
        )
    })
}

fn aliased(design: &Design, resonance: Complex<f64>) -> Warning {
    let (found, period) = spoken(design, resonance);
    // The nearest multiple of the sampling frequency is what its samples cannot be told from.
    let apparent = (resonance.im - 2.0 * PI * (resonance.im / (2.0 * PI)).round()).abs();
    let looks = figure(apparent / (2.0 * PI * design.plant.sample_time));
    Warning::new(
        design,
        KEY,
        format!("{found}: its samples look like {looks} Hz, and nothing is known of it between them"),
        format!("sample every {} s or faster, or leave the resonance out of the model", advised(period)),
    )
}

fn coarse(design: &Design, resonance: Complex<f64>) -> Warning {
    let (found, period) = spoken(design, resonance);
    Warning::new(
        design,
        KEY,
        format!("{found}: what happens between two samples is out of control"),
        format!("sample every {} s or faster, or leave the resonance out of the model", advised(period)),
    )
}

/// What was found, and the period of the resonance in seconds.
fn spoken(design: &Design, resonance: Complex<f64>) -> (String, f64) {
    let (time, samples) = (design.plant.sample_time, 2.0 * PI / resonance.im);
    let period = samples * time;
    let found = format!(
        "found {} s, but the plant has a resonance at {} Hz, {} samples a period",
        figure(time),
        figure(period.recip()),
        figure(samples)
    );
    (found, period)
}

/// A sample time for something that takes `time`, in one digit.
fn advised(time: f64) -> String {
    format!("{}", format!("{:.0e}", time / SAMPLES).parse::<f64>().unwrap_or(time / SAMPLES))
}
