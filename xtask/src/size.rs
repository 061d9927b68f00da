//! How much memory the images take.

use std::fs;
use std::path::Path;

use object::{Object, ObjectSection, SectionFlags, SectionKind, elf};

use crate::process::print;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{Result, firmware};

/// Bytes by where they go, as GNU `size` counts them.
#[derive(Default, Debug, PartialEq)]
struct Size {
    /// Code and constants: flash.
    text: u64,
    /// Variables with an initial value: flash and RAM.
    data: u64,
    /// Variables that start as zero, or as nothing: RAM.
    bss: u64,
}

/// `cargo xtask size`.
pub(crate) fn size(workspace: &Workspace) -> Result<()> {
    let images = firmware::build(workspace, &Toolchain::find(workspace)?)?.binaries;
    print(format_args!("{:>10} {:>8} {:>8} {:>10} {:>8}   image", "text", "data", "bss", "flash", "RAM"))?;
    for image in &images {
        let Size { text, data, bss } = of(image)?;
        let name = image.file_name().unwrap_or_default().to_string_lossy();
        print(format_args!("{text:>10} {data:>8} {bss:>8} {:>10} {:>8}   {name}", text + data, data + bss))?;
    }
    print("bytes; RAM without the stack")?;
    Ok(())
}

/// Bytes of flash that an image takes.
pub(crate) fn flash(image: &Path) -> Result<u64> {
    of(image).map(|Size { text, data, .. }| text + data)
}

fn of(image: &Path) -> Result<Size> {
    let bytes = fs::read(image).map_err(|error| format!("cannot read {}: {error}", image.display()))?;
    let file = object::File::parse(&*bytes).map_err(|error| format!("{}: {error}", image.display()))?;
    Ok(sum(file.sections().filter_map(|section| match section.flags() {
        SectionFlags::Elf { sh_flags } => Some((sh_flags, section.kind(), section.size())),
        _ => None,
    })))
}

/// Adds up sections given as flags, kind and size.
fn sum(sections: impl Iterator<Item = (u64, SectionKind, u64)>) -> Size {
    let mut total = Size::default();
    for (flags, kind, size) in sections {
        if flags & u64::from(elf::SHF_ALLOC) == 0 {
            continue;
        }
        if kind == SectionKind::UninitializedData {
            total.bss += size;
        } else if flags & u64::from(elf::SHF_WRITE) != 0 {
            total.data += size;
        } else {
            total.text += size;
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_counted_by_where_they_go() {
        let (alloc, write) = (u64::from(elf::SHF_ALLOC), u64::from(elf::SHF_WRITE));
        let sections = [
            (alloc, SectionKind::Text, 1000),
            (alloc, SectionKind::ReadOnlyData, 200),
            (alloc | write, SectionKind::Data, 30),
            (alloc | write, SectionKind::UninitializedData, 4),
            (0, SectionKind::Debug, 1_000_000),
        ];
        assert_eq!(sum(sections.into_iter()), Size { text: 1200, data: 30, bss: 4 });
    }
}
