//! What was seen at the sender and at the receiver becomes packets; two clocks are brought together.

use super::{
    about::About,
    clocks::{self, Relation, two_way},
    column::Column,
    counters::rounds::{Rounds, START},
    join::{Joined, join},
    logs::Selection,
    packets::Packets,
    time::{Nanoseconds, seconds},
    trace::{Gaps, Trace},
};

/// Fewer packets may all have taken no time by chance.
const FEW: u64 = 10;

/// Sightings of packets at both ends: in `sent` those at the sender of the link, whichever way they go.
pub(super) struct Way {
    pub(super) sent: Column,
    pub(super) received: Column,
    pub(super) modulus: u64,
}

/// What is known of the ends.
pub(super) struct Order {
    /// Which end is the sender's is to be told by the times.
    pub(super) may_swap: bool,
    /// The ends may have clocks of their own.
    pub(super) has_two_clocks: bool,
}

/// Pairs by number.
///
/// Whether the first and the last packets were lost cannot be told: the receiver's log may have begun later or ended
/// before they arrived. Those without arrival that were sent before the first arrival, or within the longest delay
/// before the last, are left out.
pub(super) fn pair(
    mut main: Way,
    others: Vec<Way>,
    order: Order,
    selection: &Selection<'_>,
    about: &mut About,
) -> Result<Trace, String> {
    if main.received.len == 0 {
        return Err("the receiver saw none of the packets: check which log is which".into());
    }
    (main.sent, main.received) = (main.sent.sorted(), main.received.sorted());
    if order.may_swap && is_swapped(&main) {
        std::mem::swap(&mut main.sent, &mut main.received);
        about.notes.push(
            "of the two interfaces the second one is the sender's: packets are seen there first".into(),
        );
    }
    let rounds = Rounds::of(&main.sent, main.modulus);
    let survey = rounds.survey(&main.sent);
    survey.check()?;
    about.restarts = survey.jumps;
    let span = main.received.span;
    let mut joined = join(&main.sent, main.received, &rounds, survey.highest);
    drop(main.sent);
    if joined.arrived == 0 {
        return Err(format!(
            "the receiver saw none of the packets that the sender's log has: it has {} others; check which log is which",
            joined.strays
        ));
    }
    check_delays(&joined, &rounds)?;
    let relation = match order.has_two_clocks {
        true => clock(&joined, others, selection)?,
        false => None,
    };
    let mut span = span.unwrap_or_default();
    if let Some(relation) = &relation {
        (joined, span) = corrected(joined, relation);
        about.notes.push(relation.to_string());
        about.clock = Some(relation.told());
    }
    if let Some((number, early)) = joined.first_early {
        return Err(apart(&joined, number.wrapping_sub(START) % main.modulus, early));
    }
    let longest = joined.delays.map_or(0, |(_, longest)| longest);
    let mut trace = Trace::of(
        joined.packets,
        Some((span.0, span.1.saturating_sub(longest))),
        selection.gaps.unwrap_or(Gaps::Ignore),
    )?;
    (trace.duplicates, trace.strays) = (joined.duplicates, joined.strays);
    Ok(trace)
}

/// Whether the first packets that both ends have are seen at the receiver first.
fn is_swapped(main: &Way) -> bool {
    const FIRST: usize = 10_000;
    let head = |column: &Column| column.iter().take(FIRST).collect::<Column>();
    let (sent, received) = (head(&main.sent), head(&main.received));
    let rounds = Rounds::of(&sent, main.modulus);
    let joined = all(&sent, received.clone(), &rounds);
    let turned = all(&received, sent, &rounds);
    2 * joined.early > joined.arrived || (rounds.is_narrow() && total(&turned) < total(&joined))
}

fn all(sent: &Column, received: Column, rounds: &Rounds) -> Joined {
    join(sent, received, rounds, rounds.survey(sent).highest)
}

/// Sum of delays, of packets that arrived.
fn total(joined: &Joined) -> i128 {
    joined.packets.iter().filter_map(|(_, sent, received)| Some(i128::from(received? - sent))).sum()
}

/// Refuses delays that no link has.
fn check_delays(joined: &Joined, rounds: &Rounds) -> Result<(), String> {
    match joined.delays {
        Some((0, 0)) if joined.arrived > FEW => Err(format!(
            "all {} packets arrive in the instant they are sent: is it the same log twice? give one of each end",
            joined.arrived
        )),
        Some((shortest, _)) if rounds.is_narrow() && shortest as f64 > rounds.round() / 2.0 => Err(format!(
            "every packet takes at least {} s, more than half of the {} s in which its counter goes round: the clocks of the two ends \
             are not synchronised, or the logs are in the wrong order (first the sender's)",
            seconds(shortest),
            rounds.round() / 1e9
        )),
        _ => Ok(()),
    }
}

/// How the receiver's clock is to the sender's, if they are apart.
fn clock(joined: &Joined, others: Vec<Way>, selection: &Selection<'_>) -> Result<Option<Relation>, String> {
    let ways = others.into_iter().filter(|way| way.sent.len > 0 && way.received.len > 0).map(|way| {
        let (sent, received) = (way.sent.sorted(), way.received.sorted());
        let rounds = Rounds::of(&sent, way.modulus);
        all(&sent, received, &rounds).packets
    });
    let ways: Vec<Packets> = ways.collect();
    two_way::relation(&joined.packets, &ways, selection.shortest_delay)
}

/// Packets of one way that a log has paired already; with a shortest delay, two clocks are brought together.
pub(super) fn of_one_way(joined: Joined, gaps: Gaps, selection: &Selection<'_>) -> Result<Trace, String> {
    let relation = match selection.shortest_delay {
        Some(_) => two_way::relation(&joined.packets, &[], selection.shortest_delay)?,
        None => None,
    };
    with_clock(joined, relation.as_ref(), gaps)
}

/// Packets that a log has paired already, by two clocks of which the relation may be known.
pub(super) fn with_clock(
    mut joined: Joined,
    relation: Option<&Relation>,
    gaps: Gaps,
) -> Result<Trace, String> {
    let mut about = About::default();
    if let Some(relation) = relation {
        (joined, _) = corrected(joined, relation);
        about.notes.push(relation.to_string());
        about.clock = Some(relation.told());
    }
    if let Some((number, early)) = joined.first_early {
        return Err(apart(&joined, number, early));
    }
    let mut trace = Trace::of(joined.packets, None, gaps)?;
    (trace.duplicates, trace.strays, trace.about) = (joined.duplicates, joined.strays, about);
    Ok(trace)
}

/// Packets with the times of arrival by the sender's clock, and the earliest and the latest of these.
fn corrected(joined: Joined, relation: &Relation) -> (Joined, (Nanoseconds, Nanoseconds)) {
    let mut all = Joined { duplicates: joined.duplicates, strays: joined.strays, ..Joined::default() };
    let mut span = (Nanoseconds::MAX, Nanoseconds::MIN);
    for (number, sent, received) in joined.packets.iter() {
        let Some(received) = received else {
            all.packets.push(number, sent, None);
            continue;
        };
        // Only a packet that is under way while a clock is set can seem to be early still.
        let received = relation.to_sender(received, sent).max(sent);
        span = (span.0.min(received), span.1.max(received));
        all.arrived(number, sent, received);
    }
    (all, span)
}

/// Why packets cannot have arrived before they were sent.
fn apart(joined: &Joined, number: u64, early: Nanoseconds) -> String {
    let order = match 10 * joined.early > 9 * joined.arrived {
        true => "or the logs are in the wrong order: give first the sender's, then the receiver's; ",
        false => "",
    };
    format!("{}; {order}{}", clocks::early(number, early), clocks::ADVICE)
}
