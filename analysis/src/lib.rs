//! Names, types, component model, checks and editor features of GenoM3 specifications.

mod base;
pub mod check;
pub mod codes;
mod config;
pub mod deps;
pub mod diagnostic;
pub mod elab;
pub mod finding;
mod fixes;
pub mod host;
pub mod ide;
pub mod item_tree;
pub mod language;
pub mod lint;
pub mod lists;
mod loader;
pub mod markdown;
pub mod model;
pub mod model_json;
pub mod parallel;
pub mod phrase;
pub mod progress;
pub mod quantity;
mod queries;
pub mod release;
mod report;
mod requirement;
pub mod source_map;
pub mod spelling;
mod suppress;
pub mod terminal;
#[cfg(test)]
mod test_support;
#[cfg(test)]
mod tests;
mod unit;
mod unit_result;
