//! Proof that no bytes from the link make either end panic: in an image that does nothing but receive, nothing that panics
//! is left.
//!
//! The linker drops what nothing calls. If a check of an index, a sum or an `Option` in that image could fail, as far as
//! the compiler can tell, the code that reports it is still there, and so is its name.

use std::fs;
use std::path::Path;

use object::{Object, ObjectSymbol};

use crate::Result;
use crate::artifacts::Built;

/// The image that takes in any bytes and does nothing else.
const RECEIVE_ONLY: &str = "receive_only";
/// One that may panic, and says so on its console.
const MAY_PANIC: &str = "closed_loop";
/// Every panic of the core library ends in this module; the other is the panic handler's own name.
const MARKS: [&str; 2] = ["panicking", "rust_begin_unwind"];

/// Looks for what panics in the image that must not, and in one where it must be found.
pub(crate) fn check(built: &Built) -> Result<()> {
    let found = panicking(built.binary(RECEIVE_ONLY)?)?;
    if !found.is_empty() {
        return Err(format!(
            "{RECEIVE_ONLY} can panic, by way of\n  {}\n\
             To see who calls it: arm-none-eabi-objdump -dC {}",
            found.join("\n  "),
            built.binary(RECEIVE_ONLY)?.display()
        )
        .into());
    }
    if panicking(built.binary(MAY_PANIC)?)?.is_empty() {
        return Err(format!(
            "{MAY_PANIC} panics where its design does not fit, and no symbol tells: were they stripped?"
        )
        .into());
    }
    eprintln!("nothing in {RECEIVE_ONLY} can panic");
    Ok(())
}

/// Symbols of an image that belong to panics.
fn panicking(image: &Path) -> Result<Vec<String>> {
    let bytes = fs::read(image).map_err(|error| format!("cannot read {}: {error}", image.display()))?;
    let file = object::File::parse(&*bytes).map_err(|error| format!("{}: {error}", image.display()))?;
    Ok(marked(file.symbols().filter_map(|symbol| symbol.name().ok())))
}

fn marked<'n>(names: impl Iterator<Item = &'n str>) -> Vec<String> {
    names.filter(|name| MARKS.iter().any(|mark| name.contains(mark))).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_are_found_under_either_mangling_and_nothing_else_is() {
        let legacy = "_ZN4core9panicking18panic_bounds_check17h0123456789abcdefE";
        let v0 = "_RNvNtCs1234_4core9panicking9panic_fmt";
        let handler = "_RNvCs1234_7___rustc17rust_begin_unwind";
        let other = "_RNvNtCs1234_4slqg4wire14decode_control";
        assert_eq!(marked([legacy, other, v0, handler].into_iter()), [legacy, v0, handler]);
    }
}
