//! `[network.can]`: the CAN bus that links share which are given as `{ can = { identifier = .. } }`.
//!
//! What such a link does to packets is found by running the loop's frames on the bus, [`slqg_links::loop_bus`].

use super::DesignError;
use super::document::{Field, Section};
use slqg_links::{
    can::{
        Attempts, Background, Errors, Format, Id, NodeId, Pattern, Phase, Rates, Recovery, SECOND, Settings,
        Source, Time,
    },
    loop_bus::{LoopPlan, Message, Role},
};

/// Nodes that other traffic without a node of its own is spread over.
const OTHER_NODES: u16 = 8;
/// When in a cycle the controller sends and the actuator applies, as parts of the cycle, unless the design says.
const CONTROLLER_AT: f64 = 0.25;
const ACTUATOR_AT: f64 = 0.5;

const KEYS: [&str; 12] = [
    "bit_rate",
    "data_bit_rate",
    "background_load",
    "background",
    "bit_error_rate",
    "error_bursts",
    "controller_at",
    "actuator_at",
    "queue",
    "attempts",
    "replace",
    "recovery",
];

/// `{ identifier = 0x123, extended = false }` of one link.
pub(super) fn identifier(table: &Section<'_>) -> Result<Id, DesignError> {
    let meaning = "{ identifier = 0x120 }, and the bus as [network.can]";
    let link = table.required("can", meaning)?.section(&["identifier", "extended"])?;
    id_of(&link)
}

fn id_of(section: &Section<'_>) -> Result<Id, DesignError> {
    let extended = match section.optional("extended", "true for an identifier of 29 bits, or false") {
        Some(field) => field.truth()?,
        None => false,
    };
    let (meaning, most) = match extended {
        false => ("an identifier of 11 bits, 0 to 0x7ff; with extended = true one of 29 bits", 0x7ff),
        true => ("an identifier of 29 bits, 0 to 0x1fffffff", 0x1fff_ffff),
    };
    let value = section.required("identifier", meaning)?.whole_number(0..=most)? as u32;
    let id = if extended { Id::extended(value) } else { Id::base(value as u16) };
    Ok(id.expect("within the range"))
}

/// The bus, with the identifiers of the loop's own messages by role. How many bytes they have is not known yet.
pub(super) fn read(
    field: &Field<'_>,
    own: [Option<Id>; Role::COUNT],
    sample_time: f64,
) -> Result<LoopPlan, DesignError> {
    let bus = field.section(&KEYS)?;
    let rate = "bits per second, as 500000: a bit must last a whole number of nanoseconds";
    let bit_rate_field = bus.required("bit_rate", rate)?;
    let bit_rate = bit_rate_field.whole_number(1..=100_000_000)? as u32;
    let data =
        bus.optional("data_bit_rate", "bits per second of the data phase of CAN FD, at least bit_rate");
    let data_bit_rate = data.as_ref().map(|field| field.whole_number(1..=100_000_000)).transpose()?;
    let data_bit_rate = data_bit_rate.map(|rate| rate as u32);
    Rates::new(bit_rate, data_bit_rate)
        .map_err(|error| data.as_ref().unwrap_or(&bit_rate_field).reject(error.to_string()))?;

    let cycle = nanoseconds(sample_time);
    let phase = |name, default: f64, after: Time| {
        let meaning = "a time within the cycle in seconds: the controller acts after its begin, the actuator after that";
        let Some(field) = bus.optional(name, meaning) else { return Ok(nanoseconds(default * sample_time)) };
        let seconds = field.number()?;
        let at = nanoseconds(seconds);
        let is_within = seconds > 0.0 && at > after && at < cycle;
        if is_within { Ok(at) } else { Err(field.reject(format!("found the number {seconds}"))) }
    };
    let controller_at = phase("controller_at", CONTROLLER_AT, 0)?;
    let actuator_at = phase("actuator_at", ACTUATOR_AT, controller_at)?;
    if actuator_at <= controller_at {
        let found = format!(
            "found {} s, but the actuator acts at {} s",
            seconds(controller_at),
            seconds(actuator_at)
        );
        let allowed = "give actuator_at too: the actuator acts after the controller".into();
        return Err(bus.reject("network.can.controller_at", found, allowed));
    }

    let mut settings = Settings::new(bit_rate, Role::FIRST_FREE_NODE + OTHER_NODES);
    settings.data_bit_rate = data_bit_rate;
    settings.identifiers =
        Role::ALL.iter().filter_map(|&role| Some((own[role as usize]?, role.node()))).collect();
    settings.errors = errors(&bus)?;
    if let Some(field) = bus.optional("queue", "frames that wait in each node, 1 to 1000") {
        settings.queue = field.whole_number(1..=1000)?;
    }
    if let Some(field) = bus.optional("recovery", "\"automatic\" or \"never\"") {
        settings.recovery =
            field.choice(&[("automatic", Recovery::Automatic), ("never", Recovery::Never)])?;
    }
    settings.sources = background(&bus, bit_rate, &own)?;
    // Identifiers that clash, and all else that only shows when everything is known.
    slqg_links::can::Bus::new(settings.clone(), rand_chacha::rand_core::SeedableRng::seed_from_u64(0))
        .map_err(|error| {
            field.reject_with(
                format!("found a bus that cannot be: {error}"),
                "give every message an identifier of its own".into(),
            )
        })?;

    let attempts = match bus.optional("attempts", "\"unlimited\", \"until-error\" or \"once\"") {
        None => Attempts::Unlimited,
        Some(field) => field.choice(&[
            ("unlimited", Attempts::Unlimited),
            ("until-error", Attempts::UntilError),
            ("once", Attempts::Once),
        ])?,
    };
    let replaces = bus.optional("replace", "true if a new frame takes the place of one that waits, or false");
    Ok(LoopPlan {
        settings,
        sample_time: cycle,
        controller_at,
        actuator_at,
        messages: own.map(|id| id.map(|id| Message { id, bytes: 0 })),
        format: Format::Classic,
        attempts,
        replaces: replaces.map(|field| field.truth()).transpose()?.unwrap_or(false),
    })
}

fn nanoseconds(seconds: f64) -> Time {
    (seconds * SECOND as f64).round() as Time
}

fn seconds(time: Time) -> f64 {
    time as f64 / SECOND as f64
}

fn errors(bus: &Section<'_>) -> Result<Errors, DesignError> {
    let rate = |field: &Field<'_>| {
        let rate = field.number()?;
        if (0.0..1.0).contains(&rate) {
            Ok(rate)
        } else {
            Err(field.reject(format!("found the number {rate}")))
        }
    };
    let meaning = "the probability that a bit is disturbed, at least 0 and below 1";
    let alone = bus.optional("bit_error_rate", meaning);
    let table = "{ good = [mean seconds, bit error rate], bad = [mean seconds, bit error rate] }";
    let Some(bursts) = bus.optional("error_bursts", table) else {
        let Some(field) = alone else { return Ok(Errors::None) };
        return Ok(Errors::Independent { probability: rate(&field)? });
    };
    if let Some(field) = alone {
        return Err(field.reject_with("found beside error_bursts".into(), "give one of the two".into()));
    }
    let phases = bursts.section(&["good", "bad"])?;
    let phase = |name| {
        let field = phases.required(name, "[mean length in seconds, bit error rate]")?;
        match field.numbers()?[..] {
            [mean, probability] if mean >= 1e-6 && (0.0..1.0).contains(&probability) => {
                Ok(Phase { mean, probability })
            }
            ref other => Err(field.reject(format!("found {other:?}"))),
        }
    };
    Ok(Errors::Bursts { good: phase("good")?, bad: phase("bad")? })
}

fn background(
    bus: &Section<'_>,
    bit_rate: u32,
    own: &[Option<Id>; Role::COUNT],
) -> Result<Vec<Source>, DesignError> {
    let others = Role::FIRST_FREE_NODE..Role::FIRST_FREE_NODE + OTHER_NODES;
    let load = bus
        .optional("background_load", "the part of the bus that other traffic takes, at least 0 and below 1");
    let meaning =
        "a list of messages: { identifier = 0x100, bytes = 8, period = 0.01, jitter = 0.001 }, times in s";
    let Some(list) = bus.optional("background", meaning) else {
        let Some(field) = load else { return Ok(Vec::new()) };
        let reserved: Vec<Id> = own.iter().flatten().copied().collect();
        let traffic = Background::load(field.number()?, bit_rate, &reserved, others);
        return Ok(traffic.map_err(|error| field.reject(error.to_string()))?.sources);
    };
    if let Some(field) = load {
        return Err(field.reject_with("found beside background".into(), "give one of the two".into()));
    }
    list.entries()?
        .iter()
        .zip(others.clone().cycle())
        .map(|(entry, node)| message(entry, NodeId(node)))
        .collect()
}

/// One message of other traffic; each is sent by the next of the other nodes.
fn message(entry: &Field<'_>, node: NodeId) -> Result<Source, DesignError> {
    let table = entry.section(&[
        "identifier",
        "extended",
        "bytes",
        "fd",
        "period",
        "offset",
        "jitter",
        "sporadic",
    ])?;
    let id = id_of(&table)?;
    let time = |name| {
        let field = table.optional(name, "a time in seconds, at least 0 and at most 3600");
        let Some(field) = field else { return Ok(None) };
        let seconds = field.number()?;
        let is_time = (0.0..=3600.0).contains(&seconds);
        if is_time { Ok(Some(nanoseconds(seconds))) } else { Err(field.reject(format!("found {seconds}"))) }
    };
    let fd = table.optional("fd", "true for CAN FD with the data bit rate, or false");
    let format = match fd.map(|field| field.truth()).transpose()? {
        Some(true) => Format::Fd { bit_rate_switch: true },
        _ => Format::Classic,
    };
    let bytes = table.required("bytes", "0 to 8, with fd = true also 12, 16, 20, 24, 32, 48 or 64")?;
    let count = bytes.whole_number(0..=64)?;
    format.dlc(count).map_err(|error| bytes.reject(error.to_string()))?;
    let (period, offset, jitter) = (time("period")?, time("offset")?, time("jitter")?);
    let pattern = match (period, time("sporadic")?) {
        (Some(period), None) => {
            Pattern::Periodic { period, offset: offset.unwrap_or(0), jitter: jitter.unwrap_or(0) }
        }
        (Some(minimum), Some(extra)) => Pattern::Sporadic { minimum, extra },
        (None, _) => return Err(table.reject(&format!("{}.period", table.key()), "missing".into(), "give the time in seconds from one frame to the next; with sporadic = mean seconds beyond it, the least time".into())),
    };
    Ok(Source { node, id, format, bytes: count, pattern, attempts: Attempts::Unlimited })
}
