//! Hands the bytes of a file to a property, as a run of fuzzing has kept them: `replay PROPERTY FILE..`.

use std::process::ExitCode;
use std::{env, fs};

fn main() -> ExitCode {
    let mut arguments = env::args().skip(1);
    let Some((name, property)) =
        arguments.next().and_then(|name| slqg_properties::named(&name).map(|property| (name, property)))
    else {
        let names: Vec<_> = slqg_properties::PROPERTIES.iter().map(|(name, _)| *name).collect();
        eprintln!("error: give a property and files of bytes; the properties are {}", names.join(", "));
        return ExitCode::from(2);
    };
    for file in arguments {
        match fs::read(&file) {
            Ok(bytes) => property(&bytes),
            Err(error) => {
                eprintln!("error: {file}: cannot be read: {error}");
                return ExitCode::from(2);
            }
        }
        println!("{file}: {name} holds");
    }
    ExitCode::SUCCESS
}
