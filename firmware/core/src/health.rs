//! How an end of the loop is: what an application reads in each cycle, and acts upon.
//!
//! A ground room: both ends tell it, and it stands on nothing.

/// How an end of the loop is, after the cycle that ran last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Health {
    /// Nothing is known to be wrong.
    #[default]
    Nominal,
    /// The loop goes on with less than it was designed for.
    Degraded(Cause),
    /// The loop is open: what this end does does not follow from the plant any more. The controller sends nothing, and the actuator
    /// applies the safe input.
    Lost(Cause),
}

/// What is wrong with an end of the loop; of several, the gravest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cause {
    /// No measurement came that was believed, for longer than the link explains.
    NotMeasured,
    /// This output has been measured, and not believed.
    Implausible(u8),
    /// This output is measured, and its reading has not changed by a bit for too long.
    Stuck(u8),
    /// The estimate was of no use, or contradicted by the measurements, and began anew.
    BegunAnew,
    /// No finite sequence could be computed.
    NotFinite,
    /// The buffer has run out: the default input is applied.
    RunOut,
    /// Memory has changed by itself, [`crate::integrity`]: what this end would do may follow from wrong numbers.
    Memory,
}

impl Health {
    /// Whether nothing is known to be wrong.
    pub const fn is_nominal(self) -> bool {
        matches!(self, Self::Nominal)
    }

    /// Whether the loop is open.
    pub const fn is_lost(self) -> bool {
        matches!(self, Self::Lost(_))
    }

    /// What is wrong, if anything is.
    pub const fn cause(self) -> Option<Cause> {
        match self {
            Self::Nominal => None,
            Self::Degraded(cause) | Self::Lost(cause) => Some(cause),
        }
    }
}

impl core::fmt::Display for Health {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Nominal => f.write_str("nominal"),
            Self::Degraded(cause) => write!(f, "degraded: {cause}"),
            Self::Lost(cause) => write!(f, "lost: {cause}"),
        }
    }
}

impl core::fmt::Display for Cause {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotMeasured => f.write_str("no measurement that could be believed for too long"),
            Self::Implausible(output) => write!(f, "output {output} does not fit the estimate"),
            Self::Stuck(output) => write!(f, "output {output} reads the same for too long"),
            Self::BegunAnew => f.write_str("the estimate began anew"),
            Self::NotFinite => f.write_str("no finite sequence could be computed"),
            Self::RunOut => f.write_str("the buffer has run out"),
            Self::Memory => f.write_str("memory has changed by itself"),
        }
    }
}
