//! The controllers that can be named: what each is, where it is from. `docs/controllers.md` has them side by side.

use std::str::FromStr;

/// The controllers that can be named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Sequence-based LQG on the design's network, with all that the design asks for. Thesis chapters 3 to 5.
    Slqg,
    /// The same, but it sends in every cycle, worth it or not.
    SlqgAlways,
    /// The same with a packet in every p-th cycle, worth it or not, and the law that is optimal for that; p is the design's, or the
    /// cheapest. THEORY 15.
    SlqgPeriodic,
    /// The same, but it takes the reference of the moment for all that is to come.
    SlqgNoPreview,
    /// The same, told the state of the channel to the actuator one cycle late, with gains for each of its states.
    SlqgChannel,
    /// The same as the first, which learns its link and solves its own gains when that changes. `slqg::tuning`.
    SlqgTuning,
    /// The same as the first, told when its link changes and what it becomes: no controller that has to find out does better.
    SlqgTold,
    /// Sequence-based LQG with the time-varying law of a task that ends with the run.
    SlqgTask,
    /// The same as the first, without any acknowledgement. Thesis 3.6.2, THEORY 8.
    SlqgUdp,
    /// The same, with the mean age rounded as the thesis has it, (3.43).
    SlqgUdpRounded,
    /// LQG at the plant, without a network: in the long run no controller on any network costs less in the mean.
    Lqg,
    /// The LQR gain, one input per packet, held until the next packet is in time: what is built today.
    HoldLast,
    /// The LQR law applied to its own predicted loop, all of it sent. Thesis (2.2).
    Nominal,
    /// The same, predicted with the inputs that are to be expected. Thesis 2.4.2, virtual control inputs.
    ExpectedInput,
    /// Sequence-based LQG for a link that loses packets and delays none.
    LqgLoss,
    /// Model predictive control, the whole plan sent; within the design's input limits if it has some. Thesis (2.4), (2.5).
    Mpc,
    /// The sequences of `Nominal`, sent if they have changed enough or the actuator may run dry. Thesis (5.20).
    Deadband,
}

impl Kind {
    /// Every controller there is.
    pub const ALL: [Self; 17] = [
        Self::Slqg,
        Self::SlqgAlways,
        Self::SlqgPeriodic,
        Self::SlqgNoPreview,
        Self::SlqgChannel,
        Self::SlqgTuning,
        Self::SlqgTold,
        Self::SlqgTask,
        Self::SlqgUdp,
        Self::SlqgUdpRounded,
        Self::Lqg,
        Self::HoldLast,
        Self::Nominal,
        Self::ExpectedInput,
        Self::LqgLoss,
        Self::Mpc,
        Self::Deadband,
    ];

    /// As on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slqg => "slqg",
            Self::SlqgAlways => "slqg-always",
            Self::SlqgPeriodic => "slqg-periodic",
            Self::SlqgNoPreview => "slqg-no-preview",
            Self::SlqgChannel => "slqg-channel",
            Self::SlqgTuning => "slqg-tuning",
            Self::SlqgTold => "slqg-told",
            Self::SlqgTask => "slqg-task",
            Self::SlqgUdp => "slqg-udp",
            Self::SlqgUdpRounded => "slqg-udp-rounded",
            Self::Lqg => "lqg",
            Self::HoldLast => "hold-last",
            Self::Nominal => "nominal",
            Self::ExpectedInput => "expected-input",
            Self::LqgLoss => "lqg-loss",
            Self::Mpc => "mpc",
            Self::Deadband => "deadband",
        }
    }

    /// Whether it is what it is for any length of the sequences.
    pub const fn ignores_length(self) -> bool {
        matches!(self, Self::Lqg | Self::HoldLast)
    }

    /// Whether it sends only what is worth a packet, where the design prices packets.
    pub(super) const fn weighs_packets(self) -> bool {
        matches!(self, Self::Slqg | Self::SlqgNoPreview | Self::SlqgUdp | Self::SlqgUdpRounded)
    }
}

impl FromStr for Kind {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let known: Vec<_> = Self::ALL.iter().map(|kind| kind.name()).collect();
            format!("no controller is called `{name}`; there are: {}", known.join(", "))
        })
    }
}
