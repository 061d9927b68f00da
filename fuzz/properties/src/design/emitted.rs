//! What is emitted reads back as the gains that were computed, rounded to the device's scalar, bit by bit.

use gain_gen::design::DeviceScalar;
use gain_gen::emit::{Emission, EmitError, Format, Output, design_id, emit};
use gain_gen::report::Report;
use slqg::blob::{self, storage_len};
use std::path::Path;

/// Name of the design file in what is emitted.
const ORIGIN: &str = "fuzzed.toml";

/// The numbers of `Lx`, `M` and `r` one after the other, by rows, as bits of `f64`.
type Tables = Vec<u64>;

pub(super) fn reads_back(report: &Report, emission: &Emission<'_>) {
    let law = report.law();
    let computed: Vec<f64> =
        [law.lx.transpose().as_slice(), law.m.transpose().as_slice(), &law.arrival].concat();
    let scalar = report.design.controller.scalar;
    let rounded: Tables = computed.iter().map(|value| rounded(*value, scalar).to_bits()).collect();
    if let Some(blob) = file(Output::blob(Path::new("law.blob")), emission) {
        assert_eq!(loaded(&blob, report), rounded, "the blob");
    }
    match emit(emission, ORIGIN, Format::Rust) {
        Ok(source) => {
            assert_eq!(in_source(&source, scalar), rounded, "Rust");
            let head = source.split("\n\n").next().unwrap_or_default();
            assert!(head.lines().all(|line| line.starts_with("//")), "no name ends the comment:\n{head}");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    if let Some(source) = file(Output::c(Path::new("law.h")).expect("a name"), emission) {
        let source = String::from_utf8(source).expect("text");
        assert_eq!(source.matches("/*").count(), source.matches("*/").count(), "no name ends the comment");
    }
    let json = emit(emission, ORIGIN, Format::Json).expect("every design has a JSON form");
    serde_json::from_str::<serde_json::Value>(&json).expect("JSON");
    let gains = [in_json(&json, "lx"), in_json(&json, "m")].concat();
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Tables>();
    assert_eq!(bits(&gains), bits(&computed[..gains.len()]), "JSON is not rounded");
}

/// The numbers of a field of JSON, which has a line of its own. Read here: a reader of JSON may be off in the last bit.
fn in_json(json: &str, name: &str) -> Vec<f64> {
    let begin = format!("\"{name}\": [");
    let line =
        json.lines().find_map(|line| line.trim_start().strip_prefix(&begin)).expect("a line of its own");
    let numbers = line.split(['[', ']', ',', ' ']).filter(|text| !text.is_empty());
    numbers.map(|text| text.parse().expect("a number")).collect()
}

fn rounded(value: f64, scalar: DeviceScalar) -> f64 {
    match scalar {
        DeviceScalar::F32 => f64::from(value as f32),
        DeviceScalar::F64 => value,
    }
}

/// The first file of an output; `None` if it cannot carry the design.
fn file(output: Output<'_>, emission: &Emission<'_>) -> Option<Vec<u8>> {
    let files: Result<_, EmitError> = output.files(emission, ORIGIN);
    files
        .inspect_err(|error| assert!(!error.to_string().is_empty()))
        .ok()
        .map(|files| files[0].content.clone())
}

/// The numbers that a device loads.
fn loaded(blob: &[u8], report: &Report) -> Tables {
    let header = blob::header(blob).expect("a blob");
    let (law, shape) = (&report.solution.law, header.shape);
    assert_eq!(header.design, design_id(&report.design));
    assert_eq!((shape.length, shape.default_input), (law.length, law.default_input));
    match report.design.controller.scalar {
        DeviceScalar::F32 => {
            let mut storage = vec![0.0_f32; storage_len(&shape)];
            loads(blob, &mut storage, (shape.states, shape.inputs));
            storage.iter().map(|value| f64::from(*value).to_bits()).collect()
        }
        DeviceScalar::F64 => {
            let mut storage = vec![0.0_f64; storage_len(&shape)];
            loads(blob, &mut storage, (shape.states, shape.inputs));
            storage.iter().map(|value| value.to_bits()).collect()
        }
    }
}

/// Loads into the storage, with the static types of the dimensions.
fn loads<T: slqg::Scalar>(blob: &[u8], storage: &mut [T], dimensions: (usize, usize)) {
    let loaded = match dimensions {
        (1, 1) => blob::load::<T, 1, 1>(blob, storage, None).map(drop),
        (1, 2) => blob::load::<T, 1, 2>(blob, storage, None).map(drop),
        (1, 3) => blob::load::<T, 1, 3>(blob, storage, None).map(drop),
        (2, 1) => blob::load::<T, 2, 1>(blob, storage, None).map(drop),
        (2, 2) => blob::load::<T, 2, 2>(blob, storage, None).map(drop),
        (2, 3) => blob::load::<T, 2, 3>(blob, storage, None).map(drop),
        (3, 1) => blob::load::<T, 3, 1>(blob, storage, None).map(drop),
        (3, 2) => blob::load::<T, 3, 2>(blob, storage, None).map(drop),
        (3, 3) => blob::load::<T, 3, 3>(blob, storage, None).map(drop),
        other => panic!("{other:?}: not a small design"),
    };
    loaded.expect("what was emitted is loaded");
}

/// The numbers of the three tables in Rust source.
fn in_source(source: &str, scalar: DeviceScalar) -> Tables {
    let of_table = |name: &str| {
        let (_, rest) = source.split_once(name).unwrap_or_else(|| panic!("no {name} in\n{source}"));
        let (numbers, _) = rest.split_once("])").expect("the end of a table");
        let texts = numbers.split(',').map(str::trim).filter(|text| !text.is_empty()).map(str::to_owned);
        texts.collect::<Vec<_>>()
    };
    let names = ["lx: slqg::checked::Finite::<Scalar>::new(&[", "m: slqg::checked::Finite::<Scalar>::new(&["];
    let names = names.into_iter().chain(["arrival: slqg::checked::Probabilities::<Scalar>::new(&["]);
    let number = |text: String| match scalar {
        DeviceScalar::F32 => f64::from(text.parse::<f32>().expect("a number")).to_bits(),
        DeviceScalar::F64 => text.parse::<f64>().expect("a number").to_bits(),
    };
    names.flat_map(of_table).map(number).collect()
}
