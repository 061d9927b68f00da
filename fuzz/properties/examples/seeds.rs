//! Writes the seeds to `fuzz/corpus`.

use slqg_properties::seeds;
use std::{fs, io};

fn main() -> io::Result<()> {
    for (property, seeds) in seeds::all() {
        fs::create_dir_all(seeds::corpus().join(property))?;
        for (name, bytes) in seeds {
            fs::write(seeds::file(property, name), bytes)?;
        }
    }
    Ok(())
}
