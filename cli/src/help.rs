//! The layout of `--help`: commands and options by purpose. `-h` has the options of the first hour, `--help`
//! has all.

use clap::{Arg, Command, CommandFactory as _};

use super::Cli;
use super::width::wrapped;

/// Commands by purpose, those of the first hour first.
const COMMANDS: &[(&str, &[&str])] = &[
    ("First steps", &["new", "check", "codels", "verify", "run"]),
    (
        "Specifications",
        &["fmt", "explain", "query", "deps", "diagram", "generate", "scenario", "export", "trace"],
    ),
    ("Running components", &["call", "watch", "write", "play"]),
    ("Recordings and times", &["monitor", "replay", "wcet"]),
    ("For tools", &["lsp", "mcp", "model", "tree", "completions", "man"]),
];

/// A heading of options, the options below it, and those of them that `-h` leaves out.
type Heading = (&'static str, &'static [&'static str], &'static [&'static str]);

const RUN: &[Heading] = &[
    (
        "Run",
        &["clock", "simulate", "until", "inputs", "runs", "debug"],
        &["width", "shard", "seed", "durations", "weights", "on_violation", "stop_within"],
    ),
    ("Real clock", &[], &["params", "engine_within", "host_within", "systemd"]),
    (
        "Network",
        &["zenoh_listen"],
        &["socket", "listen", "listen_anyone", "zenoh_connect", "zenoh_reads"],
    ),
    ("ROS 2", &["ros2"], &["ros_domain", "remaps"]),
    ("Model", &["cores", "checks"], &["semantics", "policy", "bounds"]),
    ("Output", &["record"], &["trace", "profile", "format"]),
];

const VERIFY: &[Heading] = &[
    ("Model", &["cores", "policy", "durations", "checks"], &["semantics", "without", "xta"]),
    ("Limits", &["timeout"], &["max_states", "max_memory", "threads"]),
    ("Output", &["sensitivity", "trace"], &["explain", "certificate", "format"]),
];

/// Options of many commands.
const SHARED: Heading = ("Reading specifications", &[], &["include_paths", "defines", "release"]);

/// The command line, with its layout.
pub(super) fn command() -> Command {
    let command = Cli::command()
        .mut_subcommand("run", |run| run.mut_args(|option| placed(option, RUN)))
        .mut_subcommand("verify", |verify| verify.mut_args(|option| placed(option, VERIFY)));
    let list = commands(&command);
    command
        .help_template("{about}\n\n{usage-heading} {usage}{after-help}\n\nOptions:\n{options}")
        .after_help(list)
}

fn placed(option: Arg, headings: &[Heading]) -> Arg {
    let id = option.get_id().as_str();
    let all = headings.iter().chain([&SHARED]);
    let mut all = all.filter(|(_, shown, others)| shown.contains(&id) || others.contains(&id));
    let Some((heading, _, others)) = all.next() else {
        return option;
    };
    let is_hidden = others.contains(&id);
    option.help_heading(*heading).hide_short_help(is_hidden)
}

/// The list of commands.
fn commands(command: &Command) -> String {
    const NAME: usize = 11;
    let mut out = String::new();
    for (heading, names) in COMMANDS {
        out += &format!("\n{heading}:\n");
        for name in *names {
            let about = command.find_subcommand(name).and_then(Command::get_about);
            if let Some(about) = about {
                let about = wrapped(&about.to_string(), NAME + 4, NAME + 4);
                out += &format!("  {name:<NAME$}  {about}\n");
            }
        }
    }
    out.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_and_option_has_its_place() {
        let command = command();
        for subcommand in command.get_subcommands() {
            let name = subcommand.get_name();
            let places =
                COMMANDS.iter().flat_map(|group| group.1).filter(|listed| **listed == name);
            assert_eq!(places.count(), 1, "{name}");
        }
        for name in ["run", "verify"] {
            let subcommand = command.find_subcommand(name).expect("the command");
            for option in subcommand.get_opts() {
                assert!(option.get_help_heading().is_some(), "{name} {}", option.get_id());
            }
        }
    }

    #[test]
    fn short_help_is_short() {
        let mut command = command();
        let lines = |text: clap::builder::StyledStr| text.to_string().lines().count();
        assert!(lines(command.render_help()) <= 45);
        for name in ["new", "check", "codels", "verify", "run"] {
            let subcommand = command.find_subcommand_mut(name).expect("the command");
            let count = lines(subcommand.render_help());
            assert!(count <= 45, "{name}: {count}");
        }
    }
}
