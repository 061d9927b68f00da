//! Plants whose right answers are known from arithmetic of high precision, and how far from them the tools are.

use crate::{Rows, matrix, relative_difference};
use gain_gen::{design::Design, report::Report, solve::Method};
use serde::Deserialize;
use std::{collections::BTreeMap, fs, path::PathBuf};

/// A design with one input per packet over perfect links, and what is to come out.
#[derive(Debug)]
pub struct Plant {
    /// Name, or number in its collection.
    pub name: String,
    /// What distinguishes it from others of that name; may be empty.
    pub parameter: String,
    /// Design file.
    pub design: String,
    /// What is to come out.
    pub answer: Answer,
}

/// The right answer, found with many more digits than a double has.
#[derive(Debug, Deserialize)]
pub struct Answer {
    /// Whether no gains exist: the design is to be refused when it is read.
    #[serde(default)]
    pub refused: bool,
    /// `Lx`, `nu x nx`.
    pub lx: Option<Rows>,
    /// Square of the closed loop's spectral radius.
    pub mean_square_rate: Option<f64>,
    /// `tr(P W)`.
    pub control_cost: Option<f64>,
    /// Where the last bit of the plant's entries moves the gains: what counts as right for gains and cost.
    pub gain_tolerance: Option<f64>,
}

/// How far an answer is from the right one.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Largest of the gains' errors, relative to the largest gain; absolute if all are zero.
    pub gain: f64,
    /// Error of the mean-square rate.
    pub rate: f64,
    /// Error of the cost, relative to it.
    pub cost: f64,
}

fn data(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The plants of `tests/data/plants`: what engineers bring, in the units they bring it in.
pub fn collection() -> Vec<Plant> {
    let answers: BTreeMap<String, Answer> =
        serde_json::from_str(&data("plants/answers.json")).expect("answers by plant");
    let plant = |(name, answer)| Plant {
        design: data(&format!("plants/{name}.toml")),
        parameter: String::new(),
        name,
        answer,
    };
    answers.into_iter().map(plant).collect()
}

/// One entry of `tests/data/riccati_benchmark.json`.
#[derive(Debug, Deserialize)]
struct Example {
    example: String,
    parameter: String,
    a: Rows,
    b: Rows,
    q: Rows,
    r: Rows,
    #[serde(flatten)]
    answer: Answer,
}

/// The examples of Benner, Laub and Mehrmann, with states that are measured and noise of one unit in each.
pub fn riccati_benchmark() -> Vec<Plant> {
    let examples: Vec<Example> =
        serde_json::from_str(&data("riccati_benchmark.json")).expect("a list of examples");
    examples.into_iter().map(plant).collect()
}

fn plant(example: Example) -> Plant {
    let states = example.a.len();
    let one: Rows = (0..states).map(|row| (0..states).map(|at| f64::from(at == row)).collect()).collect();
    let zero = vec![0.0; states];
    let Example { example: name, parameter, a, b, q, r, answer } = example;
    let design = format!(
        "name = \"example {name}\"\n\
         [plant]\n\
         sample_time = 1.0\n\
         discrete = {{ a = {a:?}, b = {b:?} }}\n\
         c = {one:?}\n\
         process_noise = {one:?}\n\
         measurement_noise = {one:?}\n\
         initial_mean = {zero:?}\n\
         initial_covariance = {one:?}\n\
         [cost]\n\
         q = {q:?}\n\
         r = {r:?}\n\
         [network]\n\
         controller_to_actuator.delays = [1.0]\n\
         sensor_to_controller.delays = [1.0]\n\
         [controller]\n\
         sequence_length = 1\n\
         scalar = \"f64\"\n"
    );
    Plant { name, parameter, design, answer }
}

impl Plant {
    /// How far the report on the design is from the right answer.
    ///
    /// # Errors
    /// Why there is no report, or why the loop is not stable.
    ///
    /// # Panics
    /// If the design is one that is to be refused.
    pub fn errors(&self) -> Result<Errors, String> {
        let design = Design::parse(&self.design, &self.name).map_err(|error| error.to_string())?;
        let report = Report::new(&design, Method::InFlight);
        report.require_stable().map_err(|error| error.to_string())?;
        let answer = "the answer of a plant that is not refused";
        let gains = matrix(self.answer.lx.as_ref().expect(answer));
        let (rate, cost) =
            (self.answer.mean_square_rate.expect(answer), self.answer.control_cost.expect(answer));
        let found = &report.solution.law.lx;
        Ok(Errors {
            gain: if gains.amax() > 0.0 { relative_difference(found, &gains) } else { found.amax() },
            rate: (report.solution.mean_square_rate - rate).abs(),
            cost: (report.control_cost() / cost - 1.0).abs(),
        })
    }
}
