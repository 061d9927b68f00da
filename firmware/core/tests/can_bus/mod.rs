//! A classic CAN frame, as a driver would have it, and a loop's compact form on it.

mod frame;

use embedded_can::{Id, StandardId};
use nalgebra::SVector;
use slqg::blob::DesignId;
use slqg::wire::can::{Compact, Grid, Identifiers, LARGEST_COUNT, LARGEST_OF_FULL_FRAME};
use slqg::{Scalar, nalgebra};

pub(crate) use frame::BusFrame;

pub(crate) fn standard(id: u16) -> Id {
    Id::Standard(StandardId::new(id).expect("11 bits"))
}

pub(crate) fn identifiers() -> Identifiers {
    Identifiers {
        measurement: standard(0x120),
        control: standard(0x121),
        acknowledgement: standard(0x122), //
    }
}

pub(crate) fn grid<T: Scalar, const D: usize>(steps: [f64; D]) -> Grid<T, D> {
    Grid { step: SVector::from(steps.map(T::nearest)), largest_count: LARGEST_COUNT }
}

/// The plant that frames are of.
pub(crate) const DESIGN: DesignId = DesignId(0x1122_3344);

/// One input in steps of 12/4095, of which three fit a frame; two outputs in steps of 1/4 and 1/1024.
#[allow(dead_code)]
pub(crate) fn compact<T: Scalar>() -> Compact<T, 1, 2> {
    compact_of(DESIGN)
}

/// The same of another plant.
#[allow(dead_code)]
pub(crate) fn compact_of<T: Scalar>(design: DesignId) -> Compact<T, 1, 2> {
    let step = T::nearest(12.0) / T::nearest(f64::from(LARGEST_OF_FULL_FRAME));
    let full_scale = Grid { step: SVector::from([step]), largest_count: LARGEST_OF_FULL_FRAME };
    Compact::new(design, identifiers(), full_scale, grid([0.25, 1.0 / 1024.0])).expect("a valid form")
}
