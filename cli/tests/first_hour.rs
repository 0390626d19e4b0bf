//! The outputs of a first hour, on terminals of 80 and of 120 columns: lines fit, and no word is broken.

#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Command, Stdio};

use crate::directory::{Directory, UNSET};
use crate::running::installed;

/// The examples that the commands use.
const EXAMPLES: [&str; 5] = ["class", "drift", "motor", "outdoor", "pump"];

/// Maximum width of lines of text, on any terminal.
const MAX_COLUMNS: usize = 100;

/// The lines of an output that may be wider than the terminal. A line of one word, such as a path or an
/// address, may always be.
#[derive(Clone, Copy, PartialEq)]
enum Wide {
    /// None may.
    Never,
    /// Excerpts of sources: numbered lines, and the marks below them.
    Excerpt,
    /// Sources in fences, and uses: a place, then its line.
    Source,
    /// Each token, with its text.
    Token,
}

use Wide::{Excerpt, Never, Source, Token};

/// The commands in their order, and how their lines may be too wide.
const COMMANDS: &[(&str, Wide)] = &[
    ("dotgen -h", Never),
    ("dotgen new arm", Never),
    ("dotgen check arm", Never),
    ("sed 's/codel<start>/codel<strat>/' arm/arm.gen > bad.gen; dotgen check bad.gen", Excerpt),
    ("dotgen check drift", Excerpt),
    ("dotgen check --fix drift", Excerpt),
    ("dotgen check -h", Never),
    ("dotgen explain fsm/busy-loop", Source),
    ("dotgen explain codel/missing-definition", Source),
    ("dotgen tree motor/motor.gen", Token),
    ("dotgen fmt motor", Never),
    ("dotgen fmt --check drift arm", Never),
    ("dotgen fmt -h", Never),
    ("dotgen verify class/class.scn", Never),
    ("dotgen verify --check 'response pump.control <= 1 ms' pump/pump.scn", Never),
    ("dotgen verify --check 'reaction eye.ball -> chase.wheels <= 20 ms' class/class.scn", Never),
    ("dotgen verify --explain --sensitivity pump/pump.scn", Never),
    ("dotgen verify --max-states 300 outdoor/stop.scn", Never),
    ("dotgen verify -h", Never),
    ("dotgen run --until 1s --simulate all --record run.mcap pump/pump.scn", Never),
    ("dotgen run --until 1s --simulate all --profile run.out pump/pump.scn", Never),
    ("dotgen run --until 1s --simulate all outdoor/stop.scn", Never),
    ("dotgen run -h", Never),
    ("dotgen monitor run.out pump/pump.scn", Never),
    ("dotgen replay run.mcap pump/pump.scn", Never),
    ("dotgen codels check drift", Excerpt),
    ("dotgen codels -h", Never),
    ("dotgen wcet stats run.out", Never),
    ("dotgen wcet import run.out pump/pump.gen", Never),
    ("dotgen wcet import --diff class/class.wcet class/class.scn", Never),
    ("dotgen wcet import -h", Never),
    ("dotgen generate --list", Never),
    ("dotgen generate -h", Never),
    ("dotgen diagram fsm --format mermaid --component pump pump/pump.gen", Never),
    ("dotgen diagram -h", Never),
    ("dotgen model -h", Never),
    ("dotgen query velocity motor/motor.gen", Source),
    ("dotgen deps outdoor", Never),
];

/// Runs a command in a folder, on a terminal of so many columns.
fn on_terminal(columns: usize, folder: &Path, command: &str) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_dotgen"));
    let first = program.parent().expect("a folder").to_owned();
    let known = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(first).chain(std::env::split_paths(&known));
    let mut script = Command::new("script");
    script.args(["-qec", &format!("stty cols {columns} rows 50; {command}"), "/dev/null"]);
    script.current_dir(folder).stdin(Stdio::null());
    for variable in UNSET {
        script.env_remove(variable);
    }
    // Without colours (a dumb terminal has them where `CI` is set), and without progress.
    script.env("SHELL", "/bin/sh").env("TERM", "dumb").env("NO_COLOR", "1");
    script.env("PATH", std::env::join_paths(folders).expect("no colons"));
    let output = script.output().expect("`script` runs");
    String::from_utf8(output.stdout).expect("UTF-8").replace("\r\n", "\n")
}

/// Returns the outputs of all commands on a terminal of so many columns.
fn outputs(columns: usize) -> Vec<String> {
    let folder = Directory::new(&[]);
    for name in EXAMPLES {
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
        let copied = Command::new("cp").arg("-r").args([&example, folder.path()]).status();
        assert!(copied.is_ok_and(|status| status.success()), "{name}");
    }
    COMMANDS.iter().map(|(command, _)| on_terminal(columns, folder.path(), command)).collect()
}

/// Returns the lines that are too wide and may not be.
fn too_wide(text: &str, columns: usize, wide: Wide) -> Vec<&str> {
    let mut in_fence = false;
    let is_wide = |line: &&str| {
        in_fence ^= line.starts_with("```");
        let may = match wide {
            Never => false,
            // Numbers of lines are right-aligned before the bar.
            Excerpt => line
                .trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit())
                .trim_start_matches("...")
                .starts_with(['|', '~', '+', '-']),
            Source => in_fence || line.split(' ').next().is_some_and(is_place),
            Token => line.trim_start().split(' ').next().is_some_and(|word| word.contains('@')),
        };
        let is_one_word = line.split_whitespace().count() < 2;
        line.chars().count() > columns.min(MAX_COLUMNS) && !may && !is_one_word
    };
    text.lines().filter(is_wide).collect()
}

/// `FILE:LINE:COLUMN:`
fn is_place(word: &str) -> bool {
    word.ends_with(':') && word.split(':').filter(|part| part.parse::<u32>().is_ok()).count() == 2
}

/// Returns true if a line has times and sizes of the verification itself.
fn is_measured(line: &str) -> bool {
    line.contains(" states in ") || line.contains("by analysis in ")
}

/// Returns the words, in alphabetical order: a wide cell of a table is below its row on a narrow terminal.
fn words(text: &str) -> Vec<&str> {
    let lines = text.lines().filter(|line| !is_measured(line));
    let mut words: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
    words.sort_unstable();
    words
}

/// Outputs of which the narrow form is kept, to be read.
const KEPT: [&str; 3] = [
    "dotgen verify --explain --sensitivity pump/pump.scn",
    "dotgen run --until 1s --simulate all outdoor/stop.scn",
    "dotgen wcet import --diff class/class.wcet class/class.scn",
];

#[test]
fn lines_fit_and_words_stay_whole() {
    if !installed(&["script"]) {
        return;
    }
    let (narrow, wide) = std::thread::scope(|scope| {
        let narrow = scope.spawn(|| outputs(80));
        let wide = outputs(120);
        (narrow.join().expect("no panic"), wide)
    });
    let (mut wrong, mut kept) = (String::new(), String::new());
    for ((command, may), (narrow, wide)) in COMMANDS.iter().zip(narrow.iter().zip(&wide)) {
        assert!(!narrow.trim().is_empty() || command.contains("fmt"), "{command} prints nothing");
        for (columns, text) in [(80, narrow), (120, wide)] {
            for line in too_wide(text, columns, *may) {
                wrong += &format!("$ {command}\n{columns} columns: {line}\n");
            }
        }
        if words(narrow) != words(wide) {
            wrong += &format!("$ {command}\nother words:\n{narrow}\n{wide}\n");
        }
        if KEPT.contains(command) {
            let lines = narrow.lines().filter(|line| !is_measured(line));
            let text: String = lines.map(|line| format!("{line}\n")).collect();
            kept += &format!("$ {command}\n{text}\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    insta::assert_snapshot!(kept);
}
