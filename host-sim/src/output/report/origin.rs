//! How the report was made, so that it can be made again.

use super::page::{Page, escaped};
use crate::output::{Simulation, json};

/// Options that say where to write, and no more; `true`: a value follows.
const OUTPUTS: [(&str, bool); 3] = [("--report", true), ("--plots", true), ("--json", false)];

pub(super) fn add(page: &mut Page, simulation: &Simulation<'_>, command: &str) {
    let plan = simulation.plan;
    page.section("How this was made");
    page.add(format_args!("<pre class=\"command\">{}</pre>", escaped(command)));
    page.paragraph(&format!(
        "host-sim {}, seed {}, {} runs per controller of {} steps, with the design file named there. The same design and seed \
         give the same bytes, on any number of threads.",
        env!("CARGO_PKG_VERSION"),
        plan.seed,
        plan.runs,
        plan.steps
    ));
    page.folded("Results as JSON", |page| {
        page.add(format_args!("<pre>{}</pre>", escaped(&json(simulation))));
    });
}

/// The command line of these arguments, the program's name first, without the options that say where to write.
pub fn command_line(arguments: impl IntoIterator<Item = String>) -> String {
    let mut words = vec!["host-sim".to_string()];
    let mut arguments = arguments.into_iter().skip(1);
    while let Some(argument) = arguments.next() {
        let name = argument.split('=').next().unwrap_or_default();
        match OUTPUTS.iter().find(|(output, _)| *output == name) {
            Some((_, true)) if !argument.contains('=') => drop(arguments.next()),
            Some(_) => (),
            None => words.push(quoted(argument)),
        }
    }
    words.join(" ")
}

/// The argument as a shell takes it.
fn quoted(argument: String) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "-_./=,:+@%".contains(letter);
    match !argument.is_empty() && argument.chars().all(is_plain) {
        true => argument,
        false => format!("'{}'", argument.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_leaves_out_where_to_write_and_quotes_what_a_shell_would_split() {
        let arguments =
            ["/bin/x", "run", "a b.toml", "--report", "r.html", "--plots=d", "--json", "--seed", "3"];
        let line = command_line(arguments.map(String::from));
        assert_eq!(line, "host-sim run 'a b.toml' --seed 3");
    }
}
