//! What must hold for any input whatever, as functions from bytes: fuzzing calls them with coverage
//! (`fuzz/`), the tests with the kept corpus and with random changes of it (`tests/fuzz.rs`).
//!
//! A function returns when all is well, and panics with what is wrong.

mod codels;
mod messages;
pub mod mutate;
mod scenario;
mod specification;

use std::path::PathBuf;

/// One thing that reads what others wrote.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A specification, from its bytes to diagnostics, their fixes, and what an editor asks at one place.
    Specification,
    /// The formatter: blanks only, and twice is once.
    Format,
    /// A source of codels beside a specification: comparison, and the edits of its repairs.
    Codels,
    /// A scenario: parser, formatter, completion.
    Scenario,
    /// Messages of a client, one in each line.
    Messages,
}

impl Target {
    /// All of them.
    pub const ALL: [Target; 5] =
        [Target::Specification, Target::Format, Target::Codels, Target::Scenario, Target::Messages];

    /// Its name on the command line, and of its folder in the corpus.
    pub fn name(self) -> &'static str {
        match self {
            Target::Specification => "specification",
            Target::Format => "format",
            Target::Codels => "codels",
            Target::Scenario => "scenario",
            Target::Messages => "messages",
        }
    }

    /// The target of that name.
    pub fn of(name: &str) -> Option<Target> {
        Target::ALL.into_iter().find(|target| target.name() == name)
    }

    /// Does with an input what users' programs do with it.
    ///
    /// # Panics
    ///
    /// When something does not hold.
    pub fn run(self, input: &[u8]) {
        match self {
            Target::Specification => specification::analyse(input),
            Target::Format => specification::format(input),
            Target::Codels => codels::compare(input),
            Target::Scenario => scenario::read(input),
            Target::Messages => messages::serve(input),
        }
    }

    /// Inputs that were kept: each found a fault, or reaches what no other reaches.
    pub fn corpus(self) -> PathBuf {
        crate::workspace_root().join("fuzz/corpus").join(self.name())
    }

    /// Texts to begin with: files of the project.
    pub fn seeds(self) -> Vec<Vec<u8>> {
        let examples = crate::workspace_root().join("examples");
        match self {
            Target::Specification | Target::Format => files(&examples, &["gen", "idl"]),
            Target::Codels => files(&examples, &["c"]),
            Target::Scenario => files(&examples, &["scn"]),
            Target::Messages => vec![messages::SESSION.as_bytes().to_vec()],
        }
    }

    /// Words that mean something in its language.
    pub fn words(self) -> &'static [&'static str] {
        match self {
            Target::Specification | Target::Format => mutate::SPECIFICATION,
            Target::Codels => mutate::CODE,
            Target::Scenario => mutate::SCENARIO,
            Target::Messages => mutate::MESSAGES,
        }
    }
}

/// The files below a folder that have one of these extensions, by path.
fn files(folder: &std::path::Path, extensions: &[&str]) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let extension = path.extension().and_then(|extension| extension.to_str());
            if path.is_dir() {
                open.push(path);
            } else if extension.is_some_and(|extension| extensions.contains(&extension)) {
                paths.push(path);
            }
        }
    }
    paths.sort();
    paths.iter().filter_map(|path| std::fs::read(path).ok()).collect()
}
