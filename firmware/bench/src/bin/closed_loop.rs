//! Closed loops with two faces, which show that host and board compute the same bits.
//!
//! On the host it prints the end states, last of all the line `end 1a2b3c4d` with the digest of all runs. On the board it
//! runs the same loops, compares its digest with the one given as the argument, and succeeds only if they are equal.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    let outcomes = slqg_bench::CASES.map(|case| (case.run)(|| 0));
    for (case, outcome) in slqg_bench::CASES.iter().zip(&outcomes) {
        println!(
            "{:<14}  {:08x}  sent {:>3}, end state {:?}",
            case.name, outcome.digest, outcome.sent, outcome.state
        );
    }
    println!("end {:08x}", slqg_bench::digest_of(&outcomes));
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    slqg_bench::board::exit(on_board::agrees_with_host())
}

/// The comparison; values are printed as bits, for decimal formatting would be half of the image.
#[cfg(target_os = "none")]
mod on_board {
    use cortex_m_semihosting::hprintln;
    use slqg_bench::{CASES, board, digest_of};

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

        let outcomes = CASES.map(|case| (case.run)(|| 0));
        for (case, outcome) in CASES.iter().zip(&outcomes) {
            hprintln!("{} {:08x}, sent {}", case.name, outcome.digest, outcome.sent);
        }
        let found = digest_of(&outcomes);
        let verdict = if found == expected { "equal" } else { "DIFFERENT" };
        hprintln!("board {:08x}, host {:08x}: {}", found, expected, verdict);
        found == expected
    }

    fn digest(word: &str) -> Option<u32> {
        let digits = word.len() == 8 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
        if digits { u32::from_str_radix(word, 16).ok() } else { None }
    }
}
