//! The figures as lines of a design file: comments, then the link. To be pasted below `[network]`.

use super::{chance::readable, channel::Channel, figures::Figures};
use std::fmt::Write;

const WIDTH: usize = 110;

/// The fragment for the link named `link`.
pub fn fragment(figures: &Figures, link: &str) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut text, figures, link);
    text
}

fn write(text: &mut String, figures: &Figures, link: &str) -> std::fmt::Result {
    let Figures { packets, loss, log, .. } = figures;
    for file in &figures.files {
        // A name must not end the comment.
        writeln!(text, "# from {}", file.escape_debug())?;
    }
    match &figures.number {
        None => writeln!(text, "# {}", figures.format)?,
        Some(number) => writeln!(text, "# {}; packets told apart by {number}", figures.format)?,
    }
    if let Some(skipped) = log.skipped.words() {
        wrapped(text, "# skipped, as no packets of the link: ", "#          ", skipped.split(' '), " ");
    }
    for note in &figures.notes {
        wrapped(text, "# note: ", "#       ", note.split(' '), " ");
    }
    write!(text, "# {packets} packets, {} lost; cycles of {} s", loss.packets, figures.sample_time)?;
    match figures.offset {
        0.0 => writeln!(text)?,
        offset => writeln!(text, ", packets sent {offset} s after a cycle begins")?,
    }
    writeln!(text, "#\n#  delay    packets  probability   95 % interval")?;
    let shares = figures.delays.iter().enumerate().map(|(delay, share)| (delay.to_string(), share));
    for (name, share) in shares.chain([("lost".to_string(), loss)]) {
        writeln!(
            text,
            "# {name:>6} {:>10}   {:>10.7}   {:.7} .. {:.7}",
            share.packets, share.probability, share.low, share.high
        )?;
    }
    writeln!(text, "#\n# delays not in the list: together below {:.2e} with 95 %", figures.unseen_below)?;
    writeln!(text, "# mean delay {:.4} cycles", figures.mean_delay)?;
    match &figures.independence_of_losses {
        None => writeln!(text, "# independence of losses: nothing to test")?,
        Some(test) => writeln!(
            text,
            "# independence of losses: p {}; lost after an arrival {:.4}, after a loss {:.4}",
            readable(test.p_value),
            test.loss_after_arrival,
            test.loss_after_loss
        )?,
    }
    if let Some(bursts) = &figures.bursts {
        writeln!(
            text,
            "# losses in a row: mean {:.3}, if independent {:.3}; longest {}",
            bursts.mean, bursts.mean_if_independent, bursts.longest
        )?;
    }
    match &figures.correlation_of_delays {
        None => writeln!(text, "# correlation of delays: nothing to test")?,
        Some(found) => writeln!(
            text,
            "# correlation of delays: {:.4}, 95 % band +-{:.4}, p {}",
            found.correlation,
            found.band,
            readable(found.p_value)
        )?,
    }
    match &figures.drift {
        None => writeln!(text, "# first half against second: nothing to test")?,
        Some(drift) => writeln!(
            text,
            "# first half against second: p {} (chi-square {:.2}, {} degrees of freedom)",
            readable(drift.p_value),
            drift.chi_square,
            drift.degrees_of_freedom
        )?,
    }
    let arrived = packets - loss.packets + log.late;
    let share = 100.0 * log.reordered as f64 / arrived as f64;
    writeln!(text, "# overtaken by a later packet: {} ({share:.2} %)", log.reordered)?;
    if log.undecided > 0 {
        writeln!(text, "# at the ends of the logs, lost or not, and not counted: {}", log.undecided)?;
    }
    for warning in &figures.warnings {
        wrapped(text, "# warning: ", "#          ", warning.split(' '), " ");
    }
    writeln!(text, "{link} = {{ delays = [")?;
    let probabilities: Vec<String> =
        figures.delays.iter().map(|share| format!("{:?},", share.probability)).collect();
    wrapped(text, "    ", "    ", probabilities.iter().map(String::as_str), " ");
    writeln!(text, "] }}")?;
    match &figures.channel {
        None => Ok(()),
        Some(channel) => of_channel(text, channel, link),
    }
}

/// The line that takes the bursts with it, as a comment: which of the two is used is for the reader to decide.
fn of_channel(text: &mut String, channel: &Channel, link: &str) -> std::fmt::Result {
    let fit = match channel.fit_p_value {
        None => "too few losses tell whether bursts are of this kind".to_string(),
        Some(p_value) => format!(
            "that a loss depends on the last packet alone has p {}{}",
            readable(p_value),
            if p_value < 0.01 { ", so bursts are of another kind" } else { "" }
        ),
    };
    let said = format!(
        "a channel of two states is likelier than independent losses (likelihood ratio {:.1}, information criterion lower by {:.1}); {fit}. It \
         remembers bursts; to use it, take this line instead:",
        channel.likelihood_ratio, channel.bic_gain
    );
    wrapped(text, "# ", "# ", said.split(' '), " ");
    let good: Vec<String> = channel.good.iter().map(|probability| format!("{probability:?}")).collect();
    writeln!(
        text,
        "# {link} = {{ gilbert_elliott = {{ to_bad = {:?}, to_good = {:?}, good = [{}], bad = [] }} }}",
        channel.to_bad,
        channel.to_good,
        good.join(", ")
    )
}

/// Words in lines of at most [`WIDTH`] characters.
fn wrapped<'a>(
    text: &mut String,
    first: &str,
    other: &str,
    words: impl Iterator<Item = &'a str>,
    between: &str,
) {
    let mut line = first.to_string();
    let mut is_empty = true;
    for word in words {
        if !is_empty && line.chars().count() + between.len() + word.chars().count() > WIDTH {
            text.push_str(&line);
            text.push('\n');
            line = other.to_string();
            is_empty = true;
        }
        if !is_empty {
            line.push_str(between);
        }
        line.push_str(word);
        is_empty = false;
    }
    text.push_str(&line);
    text.push('\n');
}
