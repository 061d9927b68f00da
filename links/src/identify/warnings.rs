//! What a statistician would say about the figures. Each warning names what is wrong, the figure, and what to do.

use super::{chance::readable, figures::Figures, independence::ENOUGH};

/// Tests warn below this probability: of a hundred sound links one is warned of.
const LEVEL: f64 = 0.01;

pub(super) fn all(figures: &Figures) -> Vec<String> {
    [few(figures), losses(figures), delays(figures), drift(figures), log(figures)].concat()
}

fn few(figures: &Figures) -> Vec<String> {
    let is_rare = |packets: u64| packets > 0 && (packets as f64) < ENOUGH;
    let rare: Vec<String> = (figures.delays.iter().enumerate())
        .filter(|(_, share)| is_rare(share.packets))
        .map(|(delay, _)| delay.to_string())
        .collect();
    let mut warnings = Vec::new();
    if !rare.is_empty() {
        let plural = if rare.len() == 1 { "" } else { "s" };
        warnings.push(format!(
            "too few packets for the tail: delay{plural} {} seen fewer than 5 times, the probabilities are guesses; log longer",
            rare.join(", ")
        ));
    }
    if figures.loss.packets == 0 {
        warnings.push(format!(
            "no packet was lost: the loss is not 0 for certain, only below {:.2e} with 95 %",
            figures.unseen_below
        ));
    } else if is_rare(figures.loss.packets) {
        warnings.push(format!(
            "too few packets for the loss: {} lost, its probability is a guess; log longer",
            figures.loss.packets
        ));
    }
    warnings
}

fn losses(figures: &Figures) -> Vec<String> {
    let Some(losses) = figures.independence_of_losses.filter(|losses| losses.p_value < LEVEL) else {
        return Vec::new();
    };
    let bursts = figures.bursts.map_or_else(String::new, |bursts| {
        let come =
            if bursts.mean > bursts.mean_if_independent { "come in bursts" } else { "avoid each other" };
        format!(
            ": they {come}, {:.2} in a row on average instead of {:.2}, at most {}",
            bursts.mean, bursts.mean_if_independent, bursts.longest
        )
    });
    vec![format!(
        "losses are not independent (p {}){bursts}; the design assumes independence, so its costs and verdict are \
         not those of this link",
        readable(losses.p_value)
    )]
}

fn delays(figures: &Figures) -> Vec<String> {
    let Some(found) = figures.correlation_of_delays.filter(|found| found.p_value < LEVEL) else {
        return Vec::new();
    };
    vec![format!(
        "delays are not independent: those of neighbours correlate by {:.3} (independent: within {:.3} with 95 %); queues and \
         changing load do that, and the design assumes independence",
        found.correlation, found.band
    )]
}

fn drift(figures: &Figures) -> Vec<String> {
    let Some(drift) = figures.drift.filter(|drift| drift.p_value < LEVEL) else {
        return Vec::new();
    };
    vec![format!(
        "the link changed: from the first half to the second the mean delay went from {:.3} to {:.3} cycles, the loss from {:.4} \
         to {:.4} (p {}); log under the conditions of use, or see whether a clock drifts",
        drift.mean_delay[0],
        drift.mean_delay[1],
        drift.loss[0],
        drift.loss[1],
        readable(drift.p_value)
    )]
}

fn log(figures: &Figures) -> Vec<String> {
    let log = &figures.log;
    let missing = match log.missing_are_lost {
        true => {
            ("numbers missing in the sequence, counted as lost", "; --gaps ignore if they were never sent")
        }
        false => ("numbers missing in the sequence, not counted", "; --gaps lost if they were sent"),
    };
    let several = [
        (log.missing, missing),
        (log.duplicates, ("packets logged again, of which the first arrival counts", "")),
        (log.strays, ("packets received that the sender's log does not have, not counted", "")),
        (
            log.restarts,
            (
                "jumps of the sender's counter that are against the time",
                "; if the sender did restart, the log holds two runs: give one file per run",
            ),
        ),
        (log.late, ("packets later than --longest, counted as lost", "")),
    ];
    let dropped = (log.dropped > 0).then(|| {
        format!(
            "the logger itself dropped {} frames: whether they were packets of the link, nobody can tell from losses; log again with a \
             larger buffer (candump -r) or a filter",
            log.dropped
        )
    });
    let said = several.iter().filter(|(count, _)| *count > 0);
    dropped
        .into_iter()
        .chain(said.map(|(count, (what, advice))| format!("{what}: {count}{advice}")))
        .collect()
}
