//! What a loop's bus is like: load, fates and response times of all messages, and the delays that gains are designed with.

use crate::{monte_carlo::Outcome, output::columns};
use gain_gen::design::{Acknowledgement, DelayDistribution, Design, Link};
use serde::Serialize;
use slqg_links::{
    can::{Message, Origin, SECOND, Statistics},
    loop_bus::{LoopBus, Role},
};
use std::fmt::Write;

/// Fields of `host-sim bus --json`.
#[derive(Debug, Serialize)]
struct Json {
    name: String,
    seconds: f64,
    load: f64,
    error_load: f64,
    error_frames: u64,
    bus_offs: u64,
    links: Vec<LinkFigures>,
    messages: Vec<MessageFigures>,
}

#[derive(Debug, Serialize)]
struct LinkFigures {
    link: &'static str,
    identifier: u32,
    bytes: usize,
    delays: Vec<f64>,
    loss: f64,
}

#[derive(Debug, Serialize)]
struct MessageFigures {
    identifier: u32,
    node: u16,
    /// `controller_to_actuator` and so on; null for other traffic.
    link: Option<&'static str>,
    offered: u64,
    delivered: u64,
    refused: u64,
    aborted: u64,
    withdrawn: u64,
    duplicates: u64,
    retransmissions: u64,
    load: f64,
    response_min: Option<f64>,
    response_mean: Option<f64>,
    response_max: Option<f64>,
}

fn link_name(role: Role) -> &'static str {
    match role {
        Role::Measurement => "sensor_to_controller",
        Role::Control => "controller_to_actuator",
        Role::Acknowledgement => "acknowledgement",
    }
}

/// Links on the bus with their delays as found when the design was read.
fn links<'d>(design: &'d Design) -> Vec<(Role, &'d DelayDistribution)> {
    let network = &design.network;
    let told = match &network.acknowledgement {
        Acknowledgement::Over(link) => Some(link),
        Acknowledgement::Instant | Acknowledgement::None => None,
    };
    let all = [
        (Role::Measurement, Some(&network.sensor_to_controller)),
        (Role::Control, Some(&network.controller_to_actuator)),
        (Role::Acknowledgement, told),
    ];
    let on_bus = |(role, link): (Role, Option<&'d Link>)| {
        link.filter(|link| link.is_on_bus()).map(|link| (role, &link.delays))
    };
    all.into_iter().filter_map(on_bus).collect()
}

/// Time in seconds.
fn seconds(time: u64) -> f64 {
    time as f64 / SECOND as f64
}

/// The figures as one JSON object.
pub fn json(design: &Design, bus: &LoopBus) -> String {
    let statistics = bus.statistics();
    let time = statistics.time.max(1) as f64;
    let plan = bus.plan();
    let of_role = |message: &Message| {
        let own = |role: &Role| plan.message(*role).is_some_and(|own| own.id == message.id);
        Role::ALL.into_iter().find(own).filter(|_| message.source.is_none()).map(link_name)
    };
    let messages = statistics.messages.iter().map(|message| MessageFigures {
        identifier: message.id.value(),
        node: message.node.0,
        link: of_role(message),
        offered: message.offered,
        delivered: message.delivered,
        refused: message.refused,
        aborted: message.aborted,
        withdrawn: message.withdrawn,
        duplicates: message.duplicates,
        retransmissions: message.retransmissions,
        load: message.busy as f64 / time,
        response_min: message.response.min().map(seconds),
        response_mean: message.response.mean().map(|nanoseconds| nanoseconds / SECOND as f64),
        response_max: message.response.max().map(seconds),
    });
    let links = links(design).into_iter().filter_map(|(role, delays)| {
        let message = plan.message(role)?;
        Some(LinkFigures {
            link: link_name(role),
            identifier: message.id.value(),
            bytes: message.bytes,
            delays: delays.probabilities().to_vec(),
            loss: delays.loss(),
        })
    });
    let object = Json {
        name: design.name.clone(),
        seconds: seconds(statistics.time),
        load: statistics.load(),
        error_load: statistics.error_time as f64 / time,
        error_frames: statistics.error_frames,
        bus_offs: statistics.bus_offs,
        links: links.collect(),
        messages: messages.collect(),
    };
    serde_json::to_string_pretty(&object).expect("numbers and strings are always JSON")
}

/// The figures for people.
pub fn text(design: &Design, bus: &LoopBus, outcome: &Outcome) -> String {
    let statistics: Statistics = bus.statistics();
    let mut text =
        format!("{}: the loop's frames and the other traffic on the bus\n\n{statistics}\n", design.name);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "Delays in cycles, found by running the loop's frames on the bus; gains are designed with them:\n"
    );
    for (role, delays) in links(design) {
        let bytes = bus.plan().message(role).map_or(0, |message| message.bytes);
        let _ = writeln!(text, "# {bytes} bytes, {:.4} % lost", 100.0 * delays.loss());
        let _ = writeln!(text, "{} = {{ delays = {:?} }}", link_name(role), delays.probabilities());
    }
    let cost = columns::figure(outcome.costs.first().copied());
    let _ = writeln!(text, "\ncost of this run: {cost}");
    text
}

/// Every frame and its fate, one in a line, comma-separated.
pub fn frames(bus: &LoopBus) -> Option<String> {
    let mut text = "identifier,node,link,due_s,decided_s,tries,fate\n".to_string();
    for record in &bus.log()?.records {
        let link = match record.origin {
            Origin::Offered(tag) => link_name(Role::of(tag)),
            Origin::Source(_) => "",
        };
        let _ = writeln!(
            text,
            "0x{:x},{},{link},{:.9},{:.9},{},{}",
            record.id.value(),
            record.node.0,
            seconds(record.due),
            seconds(record.decided),
            record.tries,
            record.fate
        );
    }
    Some(text)
}
