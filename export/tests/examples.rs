//! Exported models of the examples.

use std::path::Path;

use dotgen_export::{Format, export};

use crate::systems::System;

fn example(path: &str) -> System {
    System::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(path))
}

fn files(path: &str, format: Format) -> String {
    let files = export(&example(path).prepared(), format).expect("the example can be exported");
    let texts = files.iter().map(|file| format!("===== {} =====\n{}", file.name, file.text));
    texts.collect()
}

#[test]
fn pump_for_uppaal() {
    insta::assert_snapshot!(files("pump/pump.scn", Format::Uppaal));
}

#[test]
fn pump_for_tchecker() {
    insta::assert_snapshot!(files("pump/pump.scn", Format::TChecker));
}
