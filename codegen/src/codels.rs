//! Codels: keeps a specification and the C or C++ functions it names in step.
//!
//! Data flows one way: `source` reads one C or C++ text, `files` says which texts belong to a component,
//! `folder` which components share them, `expected` says what the specification wants, `drift` compares the
//! two, `repair` turns a finding into text edits, `stub` writes missing functions, `headers` writes what a
//! C compiler needs beside them, `build` plans how they are compiled, `glue` and `hosted`
//! how they come to run, and `value` reads what crosses. `command` holds what the command line
//! does. Everything but `command` is a pure function of texts and models.

mod allow;
pub mod build;
pub mod cdr;
pub mod codes;
pub mod command;
pub mod coverage;
pub mod diagnostics;
pub mod drift;
pub mod edit;
pub mod expected;
pub mod files;
pub mod folder;
pub mod glue;
pub mod headers;
pub mod hosted;
pub mod links;
mod mapping;
pub mod origin;
pub mod rename;
pub mod repair;
pub mod schema;
pub mod source;
pub mod stub;
pub mod trust;
pub mod value;
