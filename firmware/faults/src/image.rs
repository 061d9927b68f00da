//! A node's program: where its functions, its variables and its stack are, and how its log names messages.

use crate::Error;
use object::{Object, ObjectSymbol, SymbolKind};
use std::{fs, ops::Range, path::Path};

/// What is known of a program.
pub(crate) struct Image {
    /// Entries of all functions.
    pub(crate) functions: Vec<u32>,
    /// Entry of the main loop: what is above its stack is the node itself.
    pub(crate) main_loop: Option<u32>,
    /// Static variables.
    pub(crate) variables: Range<u32>,
    /// Where the stack begins, which grows downwards.
    pub(crate) stack_start: u32,
    /// Numbers of the log's formats that tell that an end is lost, or that the program has failed.
    pub(crate) grave: Vec<u16>,
}

/// Beginnings of these formats.
const GRAVE: [&str; 4] = ["lost: ", "hard fault", "panic", "exception"];

impl Image {
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let bytes = fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let file = object::File::parse(&*bytes)?;
        let address = |name: &str| {
            let found = file.symbols().find(|symbol| symbol.name() == Ok(name));
            found
                .map(|symbol| symbol.address() as u32)
                .ok_or_else(|| format!("{}: no symbol {name}", path.display()))
        };
        let mut functions = Vec::new();
        let (mut main_loop, mut grave) = (None, Vec::new());
        for symbol in file.symbols() {
            let name = symbol.name().unwrap_or_default();
            if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
                // Without the bit that says Thumb.
                let entry = symbol.address() as u32 & !1;
                functions.push(entry);
                if name.contains("4bulk") && name.contains("3run") {
                    main_loop = Some(entry);
                }
            }
            if GRAVE.iter().any(|text| name.contains(&format!("\"data\":\"{text}"))) {
                grave.push(symbol.address() as u16);
            }
        }
        functions.sort_unstable();
        functions.dedup();
        Ok(Self {
            functions,
            main_loop,
            variables: address("__sdata")?..address("__sheap")?,
            stack_start: address("_stack_start")?,
            grave,
        })
    }
}
