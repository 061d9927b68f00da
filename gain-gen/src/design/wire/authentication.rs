//! Whether the nodes' frames are sealed. Keys are none of the design's: a design file is copied, printed and committed.

use super::{KEYS, WireSettings};
use crate::design::DesignError;
use crate::design::document::Section;

/// How a receiver knows whose frame it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Authentication {
    /// It does not: whoever can write to the carrier can drive the plant.
    #[default]
    None,
    /// By a tag of AES-128-CMAC: docs/wire-format.md, sealed frames.
    Cmac,
}

impl Authentication {
    /// As in the design file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Cmac => "cmac",
        }
    }

    /// Bytes that it adds to each frame.
    pub const fn bytes(self) -> usize {
        match self {
            Self::None => 0,
            Self::Cmac => 9,
        }
    }

    pub(in crate::design) fn read(root: &Section<'_>, wire: &WireSettings) -> Result<Self, DesignError> {
        let Some(table) = root.optional("wire", "") else { return Ok(Self::None) };
        let wire_table = table.section(&KEYS)?;
        let Some(field) = wire_table.optional("authentication", "\"none\" or \"cmac\"") else {
            return Ok(Self::None);
        };
        let chosen = field.choice(&[("none", Self::None), ("cmac", Self::Cmac)])?;
        if chosen == Self::Cmac && matches!(wire, WireSettings::CanClassic(_)) {
            let found = "found \"cmac\" with format = \"can-classic\", whose frames of 8 bytes have no room for a tag";
            let allowed = "give format = \"can-fd\" or \"bytes\", or authentication = \"none\"";
            return Err(field.reject_with(found.into(), allowed.into()));
        }
        Ok(chosen)
    }
}
