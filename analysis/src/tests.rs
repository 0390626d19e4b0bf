//! Tests of the database as a whole; those of single features are next to them.

mod cancellation;
mod consequences;
mod half_typed;
mod incremental;
mod random_edits;
mod releases;
mod units;
