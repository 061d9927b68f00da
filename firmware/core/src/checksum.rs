//! The one checksum of frames, blobs and ids: CRC-32/ISCSI, `docs/wire-format.md`.

use crc::{CRC_32_ISCSI, Crc};

/// A static, so that its table of 1 KiB is there once.
pub(crate) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);
