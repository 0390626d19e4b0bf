//! General options in the syntax of GenoM3: those before the template's name.

use std::path::{Path, PathBuf};

use dotgen_analysis::release::Release;

use crate::template::discover::absolute_text;

/// The general options and the remaining arguments.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    /// `-I`, unchanged.
    pub(crate) include_dirs: Vec<String>,
    /// `-D`: name and value.
    pub(crate) defines: Vec<(String, String)>,
    /// `-t`, unchanged.
    pub(crate) templates: Option<String>,
    /// `-C`: the start of relative input names; several are joined.
    pub(crate) directory: String,
    /// `--release`.
    pub(crate) release: Option<Release>,
    /// `-T`.
    pub(crate) tmpdir: Option<String>,
    /// `--confined`.
    pub(crate) confined: bool,
    /// `--allow`, unchanged.
    pub(crate) allowed: Vec<String>,
    pub(crate) verbose: bool,
    pub(crate) debug: bool,
    pub(crate) mode: Mode,
    /// The options in the form of `dotgen genom cmdline`.
    pub(crate) cmdline: String,
    /// Start of relative paths.
    here: PathBuf,
    /// The template and everything after it, or the inputs.
    pub(crate) rest: Vec<String>,
}

/// The requested action.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Run a template.
    #[default]
    Template,
    /// `-l`: list templates.
    List,
    /// `-n`: parse only.
    Parse,
    /// `-N`: parse and dump.
    Dump,
    /// `-E`: preprocess only.
    Preprocess,
    /// `--version`.
    Version,
    /// `-h`.
    Help,
}

#[derive(Debug, PartialEq, Eq)]
pub(crate) enum OptionError {
    /// The usage is printed after it; exit status 1.
    Usage(String),
    /// Exit status 2.
    Fatal(String),
}

const LONG: &[(&str, char)] = &[
    ("allow", 'A'),
    ("confined", 'F'),
    ("debug", 'd'),
    ("directory", 'C'),
    ("dump", 'N'),
    ("help", 'h'),
    ("list", 'l'),
    ("parse-only", 'n'),
    ("release", 'R'),
    ("sysdir", 's'),
    ("tmpdir", 'T'),
    ("tmpldir", 't'),
    ("verbose", 'v'),
    ("version", 'V'),
];

pub(crate) fn parse(args: &[String], here: &Path) -> Result<Options, OptionError> {
    let mut options = Options { here: here.to_owned(), ..Options::default() };
    let mut args = args.iter().peekable();
    while let Some(word) = args.peek() {
        let word = word.as_str();
        if word == "-" || !word.starts_with('-') {
            break;
        }
        let word = word.to_owned();
        args.next();
        if word == "--" {
            break;
        }
        if let Some(long) = word.strip_prefix("--") {
            let (name, value) = match long.split_once('=') {
                Some((name, value)) => (name, Some(value.to_owned())),
                None => (long, None),
            };
            let option = long_option(name)?;
            let value = match (takes_value(option), value) {
                (true, None) => Some(args.next().cloned().ok_or_else(|| missing(&word))?),
                (false, Some(_)) => {
                    return Err(OptionError::Usage(format!(
                        "option '--{name}' doesn't allow an argument"
                    )));
                }
                (_, value) => value,
            };
            options.apply(option, value.unwrap_or_default(), &word)?;
            continue;
        }
        // Letters may be joined; a value is the rest of the word or the next word.
        let letters = word.char_indices().skip(1);
        for (at, letter) in letters {
            let known = "CIDTtsElnNvdh".contains(letter);
            if !known {
                return Err(OptionError::Usage(format!("invalid option -- '{letter}'")));
            }
            if !takes_value(letter) {
                options.apply(letter, String::new(), &word)?;
                continue;
            }
            let attached = &word[at + letter.len_utf8()..];
            let value = if attached.is_empty() {
                args.next().cloned().ok_or_else(|| missing(&word))?
            } else {
                attached.to_owned()
            };
            options.apply(letter, value, &word)?;
            break;
        }
    }
    options.rest = args.cloned().collect();
    if !options.directory.is_empty() {
        let directory = absolute_text(&options.here, &options.directory);
        options.cmdline += &format!(" -C {directory}");
    }
    Ok(options)
}

fn missing(word: &str) -> OptionError {
    OptionError::Usage(format!("option '{word}' requires an argument"))
}

fn takes_value(option: char) -> bool {
    "ACIDTtsR".contains(option)
}

fn long_option(name: &str) -> Result<char, OptionError> {
    let exact = LONG.iter().find(|(long, _)| *long == name);
    let mut matches = LONG.iter().filter(|(long, _)| long.starts_with(name));
    match (exact, matches.next(), matches.next()) {
        (Some((_, option)), ..) | (None, Some((_, option)), None) => Ok(*option),
        (None, None, _) => Err(OptionError::Usage(format!("unrecognized option '--{name}'"))),
        _ => Err(OptionError::Usage(format!("option '--{name}' is ambiguous"))),
    }
}

impl Options {
    fn apply(&mut self, option: char, value: String, word: &str) -> Result<(), OptionError> {
        let mode = match option {
            'I' => {
                self.cmdline += &format!(" -I{}", absolute_text(&self.here, &value));
                self.include_dirs.push(value);
                return Ok(());
            }
            'D' => {
                self.cmdline += &format!(" -D{value}");
                let (name, body) = value.split_once('=').unwrap_or((&value, "1"));
                self.defines.push((name.to_owned(), body.to_owned()));
                return Ok(());
            }
            't' => {
                self.cmdline += &format!(" -t {}", absolute_text(&self.here, &value));
                self.templates = Some(value);
                return Ok(());
            }
            'T' => {
                self.cmdline += &format!(" -T {}", absolute_text(&self.here, &value));
                self.tmpdir = Some(value);
                return Ok(());
            }
            'A' => {
                self.allowed.push(value);
                return Ok(());
            }
            'C' => {
                if !self.directory.is_empty() {
                    self.directory.push('/');
                }
                self.directory += &value;
                return Ok(());
            }
            'R' => {
                let release = value.parse::<Release>();
                let release = release.map_err(|error| OptionError::Fatal(error.to_string()))?;
                self.release = Some(release);
                return Ok(());
            }
            // The engine is part of this program: no other one can be selected.
            's' => {
                self.cmdline += &format!(" -s {}", absolute_text(&self.here, &value));
                return Ok(());
            }
            'v' => {
                self.verbose = true;
                return Ok(());
            }
            'F' => {
                self.confined = true;
                return Ok(());
            }
            'd' => {
                self.debug = true;
                return Ok(());
            }
            'l' => Mode::List,
            'n' => Mode::Parse,
            'N' => Mode::Dump,
            'E' => Mode::Preprocess,
            'V' => Mode::Version,
            _ => Mode::Help,
        };
        self.select(mode, word)
    }

    /// Selects what to do, which must agree with earlier options.
    fn select(&mut self, mode: Mode, word: &str) -> Result<(), OptionError> {
        let exclusive =
            |mode| matches!(mode, Mode::List | Mode::Parse | Mode::Dump | Mode::Preprocess);
        if exclusive(mode) && exclusive(self.mode) && mode != self.mode {
            return Err(OptionError::Fatal(format!("mutually exclusive options near '{word}'")));
        }
        // Help and version take precedence over all later options.
        if !matches!(self.mode, Mode::Version | Mode::Help) {
            self.mode = mode;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<Options, OptionError> {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        parse(&words, Path::new("/here"))
    }

    #[test]
    fn values_are_attached_or_separate() {
        let options = read("-Iinc -I more -DA -D B=2 -t x:y --tmpdir=/t skeleton -l c x.gen");
        let options = options.unwrap();
        assert_eq!(options.include_dirs, ["inc", "more"]);
        let define = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        assert_eq!(options.defines, [define("A", "1"), define("B", "2")]);
        assert_eq!(options.templates.as_deref(), Some("x:y"));
        assert_eq!(options.tmpdir.as_deref(), Some("/t"));
        assert_eq!(options.rest, ["skeleton", "-l", "c", "x.gen"]);
        assert_eq!(options.mode, Mode::Template);
    }

    #[test]
    fn the_command_line_names_absolute_directories() {
        let options = read("-I /inc -DA=1 -t /a:/b x").unwrap();
        assert_eq!(options.cmdline, " -I/inc -DA=1 -t /a:/b");
    }

    #[test]
    fn modes_exclude_each_other() {
        assert_eq!(read("-vl").unwrap().mode, Mode::List);
        assert_eq!(read("--parse x.gen").unwrap().mode, Mode::Parse);
        assert!(matches!(read("-n -E"), Err(OptionError::Fatal(_))));
        assert!(matches!(read("-q"), Err(OptionError::Usage(_))));
        assert!(matches!(read("--t=x"), Err(OptionError::Usage(_))));
        assert!(matches!(read("-t"), Err(OptionError::Usage(_))));
    }
}
