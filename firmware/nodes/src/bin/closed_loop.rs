//! One closed loop with two faces, which shows that host and board compute the same bits.
//!
//! On the host it prints the end state, last of all the line `end 1a2b3c4d` with the run's digest. On the board it runs
//! the same loop, compares its digest with the one given as the argument, and succeeds only if they are equal.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    let slqg_nodes::Outcome { digest, state, applied, .. } = slqg_nodes::run();
    for (index, value) in state.iter().enumerate() {
        println!("state {index}  {:08x}  {value}", value.to_bits());
    }
    println!("applied  {:08x}  {applied}", applied.to_bits());
    println!("end {digest:08x}");
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    slqg_nodes::board::exit(on_board::agrees_with_host())
}

/// The comparison; values are printed as bits, for decimal formatting would be half of the image.
#[cfg(target_os = "none")]
mod on_board {
    use cortex_m_semihosting::hprintln;
    use slqg_nodes::{Outcome, board};

    pub(crate) fn agrees_with_host() -> bool {
        let mut buffer = [0; 128];
        let Some(arguments) = board::command_line(&mut buffer) else {
            hprintln!("no command line, or one above 127 bytes: pass the host's digest as the argument");
            return false;
        };
        let mut words = arguments.split_ascii_whitespace().skip(1);
        let (Some(word), None) = (words.next(), words.next()) else {
            hprintln!("expected one argument, the host's digest; the command line is `{}`", arguments);
            return false;
        };
        let Some(expected) = digest(word) else {
            hprintln!("`{}` is not a digest: 8 hexadecimal digits", word);
            return false;
        };

        let outcome = slqg_nodes::run();
        print(&outcome);
        let agrees = outcome.digest == expected;
        let verdict = if agrees { "equal" } else { "DIFFERENT" };
        hprintln!("board {:08x}, host {:08x}: {}", outcome.digest, expected, verdict);
        agrees
    }

    fn digest(word: &str) -> Option<u32> {
        let digits = word.len() == 8 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
        if digits { u32::from_str_radix(word, 16).ok() } else { None }
    }

    fn print(outcome: &Outcome) {
        for (index, value) in outcome.state.iter().enumerate() {
            hprintln!("state {}  {:08x}", index, value.to_bits());
        }
        hprintln!("applied  {:08x}", outcome.applied.to_bits());
    }
}
