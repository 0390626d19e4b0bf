//! Tests of exported models.

mod examples;
mod outside;
mod systems;
