//! The project's own commands. `cargo xtask` lists them.
//!
//! | module | what |
//! | --- | --- |
//! | `demo` | the example workspace in VS Code |
//! | `test` | every test there is, as a list of suites |
//! | `dist` | all packages of a release |
//! | `docs` | the pictures of the documentation |
//! | `bench` | the measurements of `bench/`, a workspace of its own |
//! | `fuzz` | inputs that break something, looked for with coverage |
//! | `notices` | the licences of what is distributed |
//! | `package` | the extension as a platform `.vsix`, server inside |
//! | `prose` | patterns of English in what users read |
//! | `lines` | lines of Rust by crate |
//! | `release` | the commit and the tag of a release |
//! | `workbench` | the browser-served VS Code that the demo and its test use |

mod bench;
mod demo;
mod dist;
mod docs;
mod fuzz;
mod lines;
mod notices;
mod package;
mod prose;
mod release;
mod test;
mod workbench;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Commands of the dotgen project.
#[derive(Parser)]
#[command(bin_name = "cargo xtask", disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build everything and open the example workspace in VS Code.
    ///
    /// Uses `code` when it is installed, with a profile of its own; otherwise a VS Code served to
    /// the browser, set up from the npm registry.
    Demo(demo::Options),
    /// Install what the tests need and run all of them.
    Test(test::Options),
    /// Measure whole processes, and count instructions; draw what grows.
    Bench(bench::Rest),
    /// Count the instructions of what users do, and compare them with bench/budgets.txt.
    Budgets(bench::Rest),
    /// Measure if findings are right and edits leave nothing worse.
    Campaign(bench::Rest),
    /// Look for inputs that break something, led by coverage.
    Fuzz(fuzz::Options),
    /// Write the licences of what the program and the extension contain into THIRD-PARTY-NOTICES.txt.
    Notices(notices::Options),
    /// Make the .vsix for this system, with a release build of the server inside.
    Package,
    /// Make all packages of a release: archive, .deb, wheel, .vsix, checksums and bill of materials.
    Dist(dist::Options),
    /// List patterns of English that readers stumble over, in what users read.
    Prose,
    /// Print the lines of Rust of each crate, without tests.
    Lines,
    /// Bump the version, date the changelog, commit and tag.
    Release(release::Options),
    /// Draw the pictures in docs/pictures from the examples.
    Docs,
}

fn main() -> ExitCode {
    xtask::exit(match Cli::parse().command {
        Command::Demo(options) => demo::demo(&options),
        Command::Test(options) => test::test(&options),
        Command::Bench(rest) => bench::forward("bench", &rest),
        Command::Budgets(rest) => bench::forward("budgets", &rest),
        Command::Campaign(rest) => bench::forward("campaign", &rest),
        Command::Package => package::package().map(|_| true),
        Command::Fuzz(options) => fuzz::fuzz(&options),
        Command::Notices(options) => notices::notices(&options),
        Command::Dist(options) => dist::dist(&options).map(|()| true),
        Command::Prose => prose::prose(),
        Command::Lines => lines::lines(),
        Command::Release(options) => release::release(&options).map(|()| true),
        Command::Docs => docs::docs().map(|()| true),
    })
}
