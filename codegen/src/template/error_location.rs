//! The place of an error in the sources of a template.

use std::path::Path;

use super::{TemplatePlace, marker};
use crate::disk::Disk;

/// A script read by the interpreter: its path in Tcl, the name to show, and the text.
#[derive(Debug, Clone)]
pub(crate) struct Script {
    pub(crate) path: String,
    pub(crate) name: String,
    pub(crate) text: String,
}

/// A command that was running when the error occurred.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frame {
    pub(crate) file: String,
    pub(crate) line: usize,
    pub(crate) command: String,
}

/// The innermost context of an error, from Tcl's trace of it.
#[derive(Debug, PartialEq)]
pub(crate) struct Innermost {
    /// The failed command; long ones are cut.
    pub(crate) command: String,
    /// The script around it, and the line in it.
    pub(crate) context: Context,
}

#[derive(Debug, PartialEq)]
pub(crate) enum Context {
    /// Body of a procedure.
    Procedure(String, usize),
    File(String, usize),
    /// Anything else: a loop body, an evaluated string.
    Other,
}

/// Reads the innermost context from `-errorinfo`.
pub(crate) fn innermost(message: &str, trace: &str) -> Option<Innermost> {
    let rest = trace.strip_prefix(message).unwrap_or(trace);
    // A command is "invoked" if it failed in another interpreter.
    let heads = ["\n    while executing\n\"", "\n    invoked from within\n\""];
    let found = heads.map(|head| rest.find(head).map(|at| at + head.len()));
    let start = found.into_iter().flatten().min()?;
    let rest = &rest[start..];
    let ends = ["\"\n    (", "\"\n    invoked from within"];
    let end =
        ends.iter().filter_map(|end| rest.find(end)).min().unwrap_or(rest.len().saturating_sub(1));
    let command = rest[..end].to_owned();
    let after = rest[end..].strip_prefix("\"\n    (").unwrap_or_default();
    let context = after.lines().next().unwrap_or_default();
    let named = |prefix: &str| -> Option<(String, usize)> {
        let rest = context.strip_prefix(prefix)?;
        let (name, line) = rest.rsplit_once("\" line ")?;
        let line = line.strip_suffix(')')?.parse().ok()?;
        Some((name.to_owned(), line))
    };
    let context = if let Some((name, line)) = named("procedure \"") {
        Context::Procedure(name, line)
    } else if let Some((path, line)) = named("file \"") {
        Context::File(path, line)
    } else {
        Context::Other
    };
    Some(Innermost { command, context })
}

/// The whole message of a failed source: `SOURCE:LINE: MESSAGE` and a line for each running command,
/// innermost first. `body` returns the body of a procedure.
pub(crate) fn explain(
    source: &str,
    message: &str,
    trace: &str,
    frames: &[Frame],
    scripts: &[Script],
    mut body: impl FnMut(&str) -> Option<String>,
) -> String {
    let shown = |path: &str| -> String {
        let script = scripts.iter().rev().find(|script| script.path == path);
        script.map_or_else(|| path.to_owned(), |script| script.name.clone())
    };
    let mut places: Vec<(String, usize, String)> = Vec::new();
    if let Some(found) = innermost(message, trace) {
        let place = match &found.context {
            Context::File(path, line) => Some((shown(path), *line)),
            Context::Procedure(name, line) => body(name).and_then(|body| {
                let (script, at) = scripts.iter().rev().find_map(|script| {
                    let at = script.text.find(&body)?;
                    Some((script, at))
                })?;
                let before = newlines(&script.text[..at]);
                Some((script.name.clone(), before + line))
            }),
            Context::Other => frames.first().and_then(|frame| {
                let text = found.command.strip_suffix("...").unwrap_or(&found.command);
                let at = frame.command.find(text).filter(|at| *at > 0)?;
                let before = newlines(&frame.command[..at]);
                Some((shown(&frame.file), frame.line + before))
            }),
        };
        places.extend(place.map(|(file, line)| (file, line, found.command)));
    }
    places
        .extend(frames.iter().map(|frame| (shown(&frame.file), frame.line, frame.command.clone())));
    let (file, line) = match places.first() {
        Some((file, line, _)) => (file.clone(), *line),
        None => (source.to_owned(), 1),
    };
    let mut out = format!("{file}:{line}: {message}");
    for (file, line, command) in &places {
        let command = command.split('\n').next().unwrap_or_default();
        let mut command: String = marker::restore(command);
        if command.chars().count() > 40 {
            command = command.chars().take(41).chain("...".chars()).collect();
        }
        out += &format!("\n called by: {file}:{line}: {command}");
    }
    out
}

/// The place of an error in the files of a template: the one its message begins with (`SOURCE:LINE: TEXT`),
/// otherwise the innermost one in Tcl's trace.
pub(crate) fn place(
    disk: &dyn Disk,
    dir: &Path,
    message: &str,
    trace: &str,
) -> Option<TemplatePlace> {
    let first = message.lines().next().unwrap_or_default();
    if let Some((name, rest)) = first.split_once(':') {
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        let file = dir.join(name);
        if let Ok(line) = rest[..digits].parse()
            && !name.is_empty()
            && disk.is_file(&file)
        {
            let message = rest[digits..].trim_start_matches([':', ' ']).to_owned();
            return Some(TemplatePlace { file, line, message });
        }
    }
    let (_, rest) = trace.split_once("(file \"")?;
    let (file, rest) = rest.split_once("\" line ")?;
    let (line, _) = rest.split_once(')')?;
    Some(TemplatePlace { file: file.into(), line: line.parse().ok()?, message: first.to_owned() })
}

fn newlines(text: &str) -> usize {
    text.bytes().filter(|byte| *byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scripts() -> Vec<Script> {
        vec![Script {
            path: "/tmp/p1".into(),
            name: "t.txt".into(),
            text: "set a 1\nproc inner {x} {\n  error \"no $x\"\n}\nforeach v {1 2} {\n  inner $v\n}\n"
                .into(),
        }]
    }

    #[test]
    fn procedures_count_from_their_source() {
        let trace = "no 1\n    while executing\n\"error \"no $x\"\"\n    (procedure \"inner\" line 2)\n    invoked from within\n\"inner $v\"";
        let frames = [Frame { file: "/tmp/p1".into(), line: 6, command: "inner $v".into() }];
        let text = explain("t.txt", "no 1", trace, &frames, &scripts(), |_| {
            Some("\n  error \"no $x\"\n".into())
        });
        assert_eq!(
            text,
            "t.txt:3: no 1\n called by: t.txt:3: error \"no $x\"\n called by: t.txt:6: inner $v"
        );
    }

    #[test]
    fn commands_of_the_file_itself() {
        let trace = "bad\n    while executing\n\"set a 1set b 2\"\n    (file \"/tmp/p1\" line 4)";
        let text = explain("t.txt", "bad", trace, &[], &scripts(), |_| None);
        assert_eq!(text, "t.txt:4: bad\n called by: t.txt:4: set a 1set b 2");
    }

    #[test]
    fn bodies_count_from_the_command_around_them() {
        let trace = "bad\n    while executing\n\"boom\"\n    (\"foreach\" body line 3)\n    invoked from within\n\"foreach v {1 2} {...\"";
        let frames = [Frame {
            file: "/tmp/p1".into(),
            line: 5,
            command: "foreach v {1 2} {\n\n  boom\n}".into(),
        }];
        let text = explain("t.txt", "bad", trace, &frames, &scripts(), |_| None);
        assert!(text.starts_with("t.txt:7: bad\n called by: t.txt:7: boom\n"), "{text}");
    }

    #[test]
    fn commands_that_fail_in_another_interpreter() {
        let trace = "no\n    invoked from within\n\"$co bad\"\n    (\"foreach\" body line 2)\n    invoked from within\n\"foreach co {1} {...\"";
        let frames = [Frame {
            file: "/tmp/p1".into(),
            line: 5,
            command: "foreach co {1} {\n  $co bad\n}".into(),
        }];
        let text = explain("t.txt", "no", trace, &frames, &scripts(), |_| None);
        assert!(text.starts_with("t.txt:6: no\n called by: t.txt:6: $co bad\n"), "{text}");
    }

    #[test]
    fn nothing_known_blames_the_source() {
        assert_eq!(explain("x", "m", "", &[], &[], |_| None), "x:1: m");
    }
}
