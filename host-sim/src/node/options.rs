//! Options of `host-sim node`.

use clap::{Args, Subcommand, ValueEnum};
use std::{
    net::{IpAddr, SocketAddr, ToSocketAddrs},
    ops::RangeInclusive,
    path::PathBuf,
    time::Duration,
};

/// Options of the command line.
#[derive(Debug, Args)]
pub struct Options {
    #[command(subcommand)]
    pub(super) role: Role,
}

#[derive(Debug, Subcommand)]
pub(super) enum Role {
    /// The controller: takes measurements and acknowledgements, sends a sequence in every cycle.
    Controller(Controller),
    /// The actuator: takes sequences, plays them out, tells the plant what it applies and the controller where that came from.
    Actuator(Actuator),
    /// The plant, simulated with its noise; held still until it is controlled.
    Plant(Plant),
    /// Passes datagrams on, with the delays and losses of a link of the design, or with others.
    Relay(Relay),
}

#[derive(Debug, Args)]
pub(super) struct Common {
    /// Design file (TOML), the same for all nodes.
    pub(super) design: PathBuf,
    /// Also take packets from this host; otherwise only from those named as addresses. May be repeated.
    #[arg(long, value_name = "HOST", value_parser = host)]
    pub(super) from: Vec<IpAddr>,
    /// End after so many cycles; the plant counts from when it is let go.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..), conflicts_with = "seconds")]
    pub(super) cycles: Option<u64>,
    /// End after so long.
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(super) seconds: Option<Duration>,
    /// Print the statistics as one JSON object instead of a table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Debug, Args)]
pub(super) struct Pace {
    /// A node that wakes up later than this after its phase counts a miss; in sample times.
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = tolerance)]
    pub(super) tolerance: f64,
    /// Cycles missing in a row after which a node begins anew instead of catching up.
    #[arg(long, value_name = "CYCLES", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(super) begin_anew_after: u64,
}

#[derive(Debug, Args)]
pub(super) struct Phases {
    /// When the controller acts, in sample times after the cycle began; between 0 and --actuator-at.
    #[arg(long, value_name = "PHASE", default_value_t = 0.3, value_parser = phase)]
    pub(super) controller_at: f64,
    /// When the actuator acts, in sample times after the cycle began; between --controller-at and 1.
    #[arg(long, value_name = "PHASE", default_value_t = 0.6, value_parser = phase)]
    pub(super) actuator_at: f64,
}

#[derive(Debug, Args)]
pub(super) struct Carrier {
    /// Address to bind, as 0.0.0.0:5001.
    #[arg(long, value_name = "BIND", value_parser = bind, required_unless_present = "can")]
    pub(super) udp: Option<SocketAddr>,
    /// CAN FD interface for frames, instead of UDP (Linux).
    #[arg(long, value_name = "IFACE", conflicts_with = "udp")]
    pub(super) can: Option<String>,
    /// CAN identifiers of measurements, control frames and acknowledgements, hexadecimal; above 7ff they have 29 bits.
    #[arg(long, value_name = "M,C,A", default_value = "100,101,102", value_parser = identifiers)]
    pub(super) identifiers: [u32; 3],
}

#[derive(Debug, Args)]
pub(super) struct Controller {
    #[command(flatten)]
    pub(super) common: Common,
    #[command(flatten)]
    pub(super) pace: Pace,
    #[command(flatten)]
    pub(super) phases: Phases,
    #[command(flatten)]
    pub(super) carrier: Carrier,
    /// Address of the actuator, or of the relay in between.
    #[arg(long, value_name = "ADDR", value_parser = address, required_unless_present = "can")]
    pub(super) actuator: Option<SocketAddr>,
    /// How much larger the initial covariance is than the design's: 1 for a controller that begins with the loop, 2 for one that
    /// joins in the middle; docs/real-time.md says what is added.
    #[arg(long, value_name = "SCALE", default_value_t = 1.0, value_parser = scale)]
    pub(super) initial_covariance_scale: f64,
}

#[derive(Debug, Args)]
pub(super) struct Actuator {
    #[command(flatten)]
    pub(super) common: Common,
    #[command(flatten)]
    pub(super) pace: Pace,
    #[command(flatten)]
    pub(super) phases: Phases,
    #[command(flatten)]
    pub(super) carrier: Carrier,
    /// Address of the controller, or of the relay in between.
    #[arg(long, value_name = "ADDR", value_parser = address, required_unless_present = "can")]
    pub(super) controller: Option<SocketAddr>,
    /// Address of the plant; UDP even if frames travel over CAN.
    #[arg(long, value_name = "ADDR", value_parser = address, required_unless_present = "can")]
    pub(super) plant: Option<SocketAddr>,
}

#[derive(Debug, Args)]
pub(super) struct Plant {
    #[command(flatten)]
    pub(super) common: Common,
    #[command(flatten)]
    pub(super) pace: Pace,
    /// Address to bind, as 0.0.0.0:5000.
    #[arg(long, value_name = "BIND", value_parser = bind)]
    pub(super) udp: SocketAddr,
    /// Address of the controller, or of the relay in between.
    #[arg(long, value_name = "ADDR", value_parser = address)]
    pub(super) controller: SocketAddr,
    /// Address of the actuator, whose inputs are taken.
    #[arg(long, value_name = "ADDR", value_parser = address)]
    pub(super) actuator: SocketAddr,
    /// Seed of initial state and noise.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(super) seed: u64,
}

#[derive(Debug, Args)]
pub(super) struct Relay {
    #[command(flatten)]
    pub(super) common: Common,
    /// Address to bind, as 0.0.0.0:5003.
    #[arg(long, value_name = "BIND", value_parser = bind)]
    pub(super) udp: SocketAddr,
    /// Address to pass packets on to.
    #[arg(long, value_name = "ADDR", value_parser = address)]
    pub(super) to: SocketAddr,
    /// Link of the design whose delays and losses packets meet.
    #[arg(long, value_enum, default_value_t = Link::ControllerToActuator, conflicts_with_all = ["loss", "delay_ms"])]
    pub(super) link: Link,
    /// Probability that a packet is lost, instead of the design's link; without --delay-ms the others are not delayed.
    #[arg(long, value_name = "P", value_parser = probability)]
    pub(super) loss: Option<f64>,
    /// Bounds of the delay in ms, any delay between them as likely, instead of the design's link.
    #[arg(long, value_name = "A..B", value_parser = delays)]
    pub(super) delay_ms: Option<RangeInclusive<Duration>>,
    /// Probability that a packet is passed on twice.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = probability)]
    pub(super) duplicate: f64,
    /// Seed of delays and losses; each link has numbers of its own.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(super) seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(super) enum Link {
    ControllerToActuator,
    SensorToController,
    Acknowledgement,
}

fn number(text: &str, allowed: RangeInclusive<f64>, what: &str) -> Result<f64, String> {
    text.parse().ok().filter(|number| allowed.contains(number)).ok_or_else(|| format!("give {what}"))
}

fn tolerance(text: &str) -> Result<f64, String> {
    number(text, 0.0..=1.0, "a number within 0 and 1")
}

fn probability(text: &str) -> Result<f64, String> {
    number(text, 0.0..=1.0, "a probability, within 0 and 1")
}

fn phase(text: &str) -> Result<f64, String> {
    let inside = f64::MIN_POSITIVE..=1.0 - f64::EPSILON;
    number(text, inside, "a number between 0 and 1, the part of the cycle that is over then")
}

fn scale(text: &str) -> Result<f64, String> {
    number(text, 1.0..=1e6, "a number within 1 and 1e6")
}

fn seconds(text: &str) -> Result<Duration, String> {
    number(text, 1e-3..=1e9, "a positive number of seconds").map(Duration::from_secs_f64)
}

fn delays(text: &str) -> Result<RangeInclusive<Duration>, String> {
    let wrong = || "give two numbers of milliseconds, the smaller first, as 2..15".to_string();
    let (from, to) = text.split_once("..").ok_or_else(wrong)?;
    let bound = |text: &str| number(text, 0.0..=1e7, "").map_err(|_| wrong());
    let (from, to) = (bound(from)?, bound(to.trim_start_matches('='))?);
    if from > to {
        return Err(wrong());
    }
    Ok(Duration::from_secs_f64(from / 1e3)..=Duration::from_secs_f64(to / 1e3))
}

fn bind(text: &str) -> Result<SocketAddr, String> {
    let found = text.to_socket_addrs().ok().and_then(|mut addresses| addresses.next());
    found.ok_or_else(|| "give an address of this machine and a port, as 127.0.0.1:5001".into())
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let found = bind(text).map_err(|_| "give a host and a port, as 192.168.1.7:5001".to_string())?;
    if found.port() == 0 {
        return Err("port 0 is nobody's; give the port that the other node binds".into());
    }
    if found.ip().is_unspecified() {
        return Err(format!(
            "{} is a place to listen, not to send to; give the other node's host",
            found.ip()
        ));
    }
    Ok(found)
}

fn host(text: &str) -> Result<IpAddr, String> {
    let found = (text, 0).to_socket_addrs().ok().and_then(|mut addresses| addresses.next());
    found.map(|address| address.ip()).ok_or_else(|| "give a host, as 192.168.1.7".into())
}

fn identifiers(text: &str) -> Result<[u32; 3], String> {
    let wrong = || "give three different identifiers up to 1fffffff, as 100,101,102".to_string();
    let parsed = |text: &str| u32::from_str_radix(text.trim().trim_start_matches("0x"), 16).ok();
    let found: Option<Vec<_>> = text.split(',').map(parsed).collect();
    let [m, c, a]: [u32; 3] = found.and_then(|found| found.try_into().ok()).ok_or_else(wrong)?;
    if m == c || c == a || a == m || [m, c, a].into_iter().any(|identifier| identifier > 0x1fff_ffff) {
        return Err(wrong());
    }
    Ok([m, c, a])
}
