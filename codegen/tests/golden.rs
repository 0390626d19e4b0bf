//! Reruns the recorded runs of the reference generator: every file and byte must be the same.
//!
//! The recordings and the reference's own templates are not part of this repository. Run it where they are:
//! `cargo test -p dotgen-codegen --test golden`. It names itself as the command to run; called that way, it
//! is the generator.

use std::process::{Command, ExitCode};
use std::sync::Arc;

use dotgen_codegen::command::{Environment, Ros2Packages, generate};
use dotgen_codegen::template::console::StdConsole;
use dotgen_codegen::template::{Limits, find_tclsh};
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs::{PackageConfig, Vfs};
use dotgen_platform::process;

/// The releases that were recorded: the manifest of each, and the variable that names its templates.
const RELEASES: [(&str, &str, &str); 2] = [
    ("2.99.39", "manifest.json", "DOTGEN_TEST_TEMPLATES"),
    ("2.99.41", "manifest-2.99.41.json", "DOTGEN_TEST_TEMPLATES_2_99_41"),
];

const ROLE: &str = "DOTGEN_TEST_IS_GENERATOR";

fn main() -> ExitCode {
    if std::env::var_os(ROLE).is_some() {
        return generator();
    }
    // The test harness' options make no difference; listing must not run anything.
    if std::env::args().any(|argument| argument == "--list") {
        println!("golden: test");
        return ExitCode::SUCCESS;
    }
    let golden = dotgen_loaders::shared("golden");
    let mut failed = false;
    for (release, manifest, variable) in RELEASES {
        let templates = std::env::var_os(variable);
        let (Some(golden), Some(templates)) = (&golden, templates) else {
            dotgen_loaders::skip(format_args!(
                "no data: golden runs of {release} need `golden` of the shared test data and {variable}, \
                 the directory of that release's own templates"
            ));
            continue;
        };
        if let Err(reason) = find_tclsh() {
            dotgen_loaders::skip(format_args!("{reason}"));
            continue;
        }
        let status = std::env::current_exe().and_then(|exe| {
            Command::new(golden.join("run"))
                .arg("-t")
                .arg(templates)
                .arg("-m")
                .arg(golden.join(manifest))
                .arg(exe)
                .env(ROLE, "1")
                .env("DOTGEN_GENOM_RELEASE", release)
                .status()
        });
        match status {
            Ok(status) => failed |= !status.success(),
            Err(error) => {
                eprintln!("cannot run the golden runs of {release}: {error}");
                failed = true;
            }
        }
    }
    match failed {
        true => ExitCode::FAILURE,
        false => ExitCode::SUCCESS,
    }
}

fn generator() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut environment = Environment {
        name: "genom3",
        program: std::env::current_exe().unwrap_or_default(),
        variables: &|name| std::env::var(name).ok(),
        disk: Arc::new(SystemDisk),
        loader: Arc::new(Vfs::new(PackageConfig { may_run: true, ..PackageConfig::default() })),
        ros2: Arc::new(|_| Ok(Ros2Packages::default())),
        pictures: Arc::new(|_, component, owner, form| {
            // What has no machine has no picture.
            let text = format!("{form} of {component}.{owner}");
            Ok(if owner == "reset" { String::new() } else { text })
        }),
        console: &mut StdConsole::default(),
        limits: Limits::default(),
        base: std::path::PathBuf::new(),
        sink: dotgen_codegen::template::OutputSink::DIRECT,
        processes: process::system(),
        confined: None,
        failed_at: None,
        project_templates: None,
        release: None,
    };
    let status = generate(&arguments, &mut environment);
    ExitCode::from(u8::try_from(status & 0xff).unwrap_or(2))
}
