//! The tutorials of the manual, typed command by command: each command prints what the page says.

#![cfg(target_os = "linux")]

use std::fs::File;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group, test_kill_process_group};

use crate::directory::{Directory, UNSET};
use crate::running::{compilers, installed};

const PAGE: &str = include_str!("../../docs/ten-minutes.md");

/// The longest time that a command may take.
const LIMIT: Duration = Duration::from_mins(1);

/// A command of the page, and the lines that the page shows below the command.
struct Step {
    command: String,
    expected: Vec<String>,
}

/// The steps in the `console` blocks of a page. A command with a here-document ends with its `EOF`.
fn steps(page: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if line != "```console" {
            continue;
        }
        while let Some(line) = lines.next().filter(|line| *line != "```") {
            let Some(first) = line.strip_prefix("$ ") else {
                let step = steps.last_mut().expect("a command before its output");
                step.expected.push(line.to_owned());
                continue;
            };
            let mut command = first.to_owned();
            if first.contains("<<'EOF'") {
                for line in lines.by_ref() {
                    command.push('\n');
                    command.push_str(line);
                    if line == "EOF" {
                        break;
                    }
                }
            }
            steps.push(Step { command, expected: Vec::new() });
        }
    }
    steps
}

/// True if the lines are as expected. An expected line `...` stands for any number of lines.
fn lines_fit(expected: &[String], lines: &[&str]) -> bool {
    let Some((first, rest)) = expected.split_first() else {
        return lines.is_empty();
    };
    if first.as_str() == "..." {
        return (0..=lines.len()).any(|from| lines_fit(rest, &lines[from..]));
    }
    lines
        .split_first()
        .is_some_and(|(line, others)| text_fits(first, line) && lines_fit(rest, others))
}

/// True if a text is as expected. Each `...` in an expected text stands for any text.
fn text_fits(expected: &str, text: &str) -> bool {
    let Some((start, rest)) = expected.split_once("...") else {
        return expected == text;
    };
    let Some(text) = text.strip_prefix(start) else {
        return false;
    };
    let starts = text.char_indices().map(|(at, _)| at);
    starts.chain([text.len()]).any(|at| text_fits(rest, &text[at..]))
}

/// A shell for the commands of the page.
struct Shell {
    folder: Directory,
    /// Holds what the page does not show: the sockets of runs, the output of the current command.
    own: Directory,
    /// Groups with processes in the background. They end with the test.
    groups: Vec<Pid>,
    /// Number of columns.
    columns: &'static str,
}

impl Shell {
    fn new() -> Shell {
        let (folder, own) = (Directory::new(&[]), Directory::new(&[]));
        Shell { folder, own, groups: Vec::new(), columns: "100" }
    }

    /// Links folders of the repository into the folder of the page.
    fn link(&self, folders: &[&str]) {
        for folder in folders {
            let there = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
            let here = self.folder.path().join(folder);
            std::os::unix::fs::symlink(there, here).expect("a link");
        }
    }

    /// Runs the commands of a page, each of which must print what the page says.
    fn follow(&mut self, page: &str, steps: &[Step]) {
        for Step { command, expected } in steps {
            let output = self.run(command);
            let lines: Vec<&str> = output.lines().collect();
            // A later command may wait for what this one did not do.
            assert!(
                lines_fit(expected, &lines),
                "{page}: $ {command}\n\nexpected:\n{}\n\nactual:\n{output}",
                expected.join("\n")
            );
        }
    }

    /// Runs a command, and returns its standard output and errors, in order.
    fn run(&mut self, command: &str) -> String {
        let path = self.own.path().join("output");
        let output = File::create(&path).expect("a file");
        let errors = output.try_clone().expect("a second handle");
        let mut shell = Command::new("bash");
        shell.args(["-c", command]).current_dir(self.folder.path());
        shell.stdin(Stdio::null()).stdout(output).stderr(errors);
        shell.process_group(0);
        for variable in UNSET {
            shell.env_remove(variable);
        }
        let program = Path::new(env!("CARGO_BIN_EXE_dotgen"));
        let first = program.parent().expect("a folder").to_owned();
        let known = std::env::var_os("PATH").unwrap_or_default();
        let folders = std::iter::once(first).chain(std::env::split_paths(&known));
        shell.env("PATH", std::env::join_paths(folders).expect("no colons"));
        let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/python");
        shell.env("PYTHONPATH", client);
        shell.env("PYTHONDONTWRITEBYTECODE", "1");
        shell.env("COLUMNS", self.columns);
        shell.env("XDG_RUNTIME_DIR", self.own.path());

        let mut child = shell.spawn().expect("bash starts");
        let group = Pid::from_child(&child);
        let begin = Instant::now();
        let ended = loop {
            if child.try_wait().expect("a child").is_some() {
                break true;
            }
            if begin.elapsed() > LIMIT {
                break false;
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        if test_kill_process_group(group).is_ok() {
            self.groups.push(group);
        }
        let bytes = std::fs::read(&path).expect("the output");
        let output = String::from_utf8(bytes).expect("UTF-8");
        if !ended {
            let _ = kill_process_group(group, Signal::KILL);
            let _ = child.wait();
            panic!("more than {LIMIT:?}: $ {command}\n{output}");
        }
        output
    }
}

impl Drop for Shell {
    fn drop(&mut self) {
        for group in &self.groups {
            // Fails if all processes of the group have ended.
            let _ = kill_process_group(*group, Signal::KILL);
        }
    }
}

#[test]
fn each_command_of_the_tutorial_prints_what_the_page_says() {
    if !installed(&["bash", "git", "python3"]) || !compilers() {
        return;
    }
    let steps = steps(PAGE);
    assert!(steps.len() > 20, "the commands are found");
    Shell::new().follow("docs/ten-minutes.md", &steps);
}

/// The page has lines of up to 100 columns. On a narrower terminal the words are the same, in shorter lines.
#[test]
fn a_narrow_terminal_gets_the_same_words_in_lines_that_fit() {
    const COLUMNS: usize = 80;
    if !installed(&["bash", "git", "python3"]) || !compilers() {
        return;
    }
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut shell = Shell::new();
    shell.columns = "80";
    // The first lines of a text depend on the width.
    let steps = steps(PAGE).into_iter().filter(|step| !step.command.contains("| head"));
    for Step { command, expected } in steps {
        let output = shell.run(&command);
        let expected = words(&expected.join(" ")).replace(" ... ", "...");
        let said = words(&output);
        assert!(text_fits(&expected, &said), "$ {command}\n{expected}\n\nactual:\n{output}");
        let texts = ["verify", "run", "explain", "deps"];
        let is_text = texts.iter().any(|name| command.starts_with(&format!("dotgen {name} ")));
        // Notes, on standard error, are wrapped for terminals only. A line of one word cannot be broken.
        let long = output.lines().find(|line| {
            line.chars().count() > COLUMNS
                && !line.starts_with("note:")
                && line.split_whitespace().count() > 1
        });
        assert_eq!(long.filter(|_| is_text), None, "$ {command}");
    }
}

#[test]
fn each_command_of_the_first_robot_prints_what_the_page_says() {
    if !installed(&["bash", "git"]) || !compilers() {
        return;
    }
    let mut steps = steps(include_str!("../../docs/first-robot.md"));
    // The last verdict is about times that were measured here, where a codel may wait for the machine.
    steps.retain(|step| !step.command.contains("grep drive.speed"));
    assert!(steps.len() > 20, "the commands are found");
    Shell::new().follow("docs/first-robot.md", &steps);
}

#[test]
fn each_command_of_the_lesson_prints_what_the_page_says() {
    if !installed(&["bash", "git", "python3"]) || !compilers() {
        return;
    }
    let mut steps = steps(include_str!("../../docs/lesson.md"));
    // Without a script, `tclsh` reads commands until the end of its input.
    if Command::new("tclsh").stdin(Stdio::null()).status().is_err() {
        dotgen_loaders::skip(format_args!("there is no `tclsh`"));
        steps.retain(|step| !step.command.contains("tclsh"));
    }
    assert!(steps.len() > 20, "the commands are found");
    let mut shell = Shell::new();
    shell.link(&["examples", "clients"]);
    shell.follow("docs/lesson.md", &steps);
}

/// Flights take too long here: `flight.rs` has a shorter one.
#[test]
fn each_command_about_the_robot_prints_what_the_page_says() {
    if !installed(&["bash"]) {
        return;
    }
    let mut steps = steps(include_str!("../../docs/robot.md"));
    steps.retain(|step| !["fly.py", "flight."].iter().any(|flight| step.command.contains(flight)));
    assert!(steps.len() > 4, "the commands are found");
    let mut shell = Shell::new();
    shell.link(&["examples"]);
    shell.follow("docs/robot.md", &steps);
}

#[test]
fn dots_stand_for_any_text_and_any_lines() {
    for (expected, text, fits) in [
        ("a", "a", true),
        ("a", "ab", false),
        ("a...c", "abc", true),
        ("a...c", "ac", true),
        ("a...c", "acb", false),
        ("...b...", "äbc", true),
    ] {
        assert_eq!(text_fits(expected, text), fits, "{expected}: {text}");
    }
    let expected = ["a", "...", "d"].map(str::to_owned);
    assert!(lines_fit(&expected, &["a", "b", "c", "d"]));
    assert!(lines_fit(&expected, &["a", "d"]));
    assert!(!lines_fit(&expected, &["a", "d", "e"]));
    let page = "text\n```console\n$ cat <<'EOF'\n$ x\nEOF\n$ x\n```\n```\n$ y\n```\n";
    let steps = steps(page);
    let commands: Vec<&str> = steps.iter().map(|step| step.command.as_str()).collect();
    assert_eq!(commands, ["cat <<'EOF'\n$ x\nEOF", "x"]);
}

#[test]
fn each_command_about_formal_models_prints_what_the_page_says() {
    if !installed(&["bash"]) {
        return;
    }
    let steps = steps(include_str!("../../docs/formal.md"));
    assert!(steps.len() > 5, "the commands are found");
    let mut shell = Shell::new();
    shell.link(&["examples"]);
    let trace = include_str!("../../export/tests/tank.dot");
    std::fs::write(shell.folder.path().join("miss.dot"), trace).expect("the folder is writable");
    shell.follow("docs/formal.md", &steps);
}
