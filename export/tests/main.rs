//! Tests of exported models.

mod bip;
mod checks;
mod examples;
mod fiacre;
mod import;
mod outside;
mod random_systems;
mod read_back;
mod systems;
