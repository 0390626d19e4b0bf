//! Codels: comparison of a specification with the C or C++ functions that it names, and repairs.
//!
//! Data flows in one direction. `source` reads a C or C++ text. `files` selects the texts of a component, and
//! `folder` the components that share them. `expected` derives the functions from the specification, and
//! `drift` compares both. `repair` turns a finding into text edits. `stub` writes missing functions.
//! `headers` writes the other files that a C compiler needs. `build` plans the compilation. `glue` and
//! `shared_object` generate the code that runs codels. `value` converts the data between both sides.
//! `command` implements the commands of the command line. Everything except `command` is a pure function of
//! texts and models.

mod allowances;
pub mod build;
pub mod cdr;
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
mod indentation;
pub mod links;
mod mapping;
pub mod origin;
pub mod reliability;
pub mod rename;
pub mod repair;
pub mod returns;
pub mod schema;
pub mod shared_object;
pub mod source;
pub mod stub;
pub mod value;
