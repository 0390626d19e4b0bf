//! Reruns the recorded runs of the reference generator: every file and byte must be the same.
//!
//! The recordings and the reference's own templates are not part of this repository: without them
//! the test is skipped. It names itself as the command to run; called that way, it is the generator.

use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::Arc;

use dotgen_codegen::command::{Environment, generate};
use dotgen_codegen::template::console::StdConsole;
use dotgen_codegen::template::{Limits, find_tclsh};

#[path = "support/disk.rs"]
mod disk;
#[path = "support/processes.rs"]
mod processes;

const ROLE: &str = "DOTGEN_TEST_IS_GENERATOR";

fn main() -> ExitCode {
    if std::env::var_os(ROLE).is_some() {
        return generator();
    }
    // The test harness' options make no difference; listing must not run anything.
    if std::env::args().any(|it| it == "--list") {
        println!("golden: test");
        return ExitCode::SUCCESS;
    }
    let run = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/golden/run");
    let templates = std::env::var_os("DOTGEN_TEST_TEMPLATES");
    let (Ok(run), Some(templates)) = (run.canonicalize(), templates) else {
        eprintln!(
            "SKIPPED: golden runs need ../shared/golden beside the repository and \
             DOTGEN_TEST_TEMPLATES, the directory of the reference's own templates"
        );
        return ExitCode::SUCCESS;
    };
    if let Err(reason) = find_tclsh() {
        eprintln!("SKIPPED: {reason}");
        return ExitCode::SUCCESS;
    }
    let status = std::env::current_exe().and_then(|exe| {
        Command::new(run)
            .arg("-t")
            .arg(templates)
            .arg(exe)
            .env(ROLE, "1")
            .status()
    });
    match status {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cannot run the golden runs: {error}");
            ExitCode::FAILURE
        }
    }
}

fn generator() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut environment = Environment {
        name: "genom3",
        program: std::env::current_exe().unwrap_or_default(),
        variables: &|name| std::env::var(name).ok(),
        loader: Arc::new(disk::Disk),
        pictures: Arc::new(|_, component, owner, form| {
            {
                // What has no machine has no picture.
                let text = format!("{form} of {component}.{owner}");
                Ok(if owner == "reset" {
                    String::new()
                } else {
                    text
                })
            }
        }),
        console: &mut StdConsole,
        limits: Limits::default(),
        base: std::path::PathBuf::new(),
        sink: dotgen_codegen::template::OutputSink::Direct,
        processes: Arc::new(processes::Plain),
        confined: None,
        failed_at: None,
    };
    let status = generate(&arguments, &mut environment);
    ExitCode::from(u8::try_from(status & 0xff).unwrap_or(2))
}
