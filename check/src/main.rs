//! The program `dotgen-check`.

use std::io::{Read, Write};
use std::process::ExitCode;

use dotgen_check::{MOST_BYTES, Outcome, check};

const HELP: &str = include_str!("help.txt");

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let [argument] = &arguments[..] else {
        eprint!("{HELP}");
        return ExitCode::from(2);
    };
    let result = match argument.to_str() {
        Some("-h" | "--help") => Ok((HELP.to_owned(), 0)),
        _ => read(argument.as_ref()).and_then(|text| report(&text)),
    };
    let written = result.and_then(|(text, status)| {
        let written = std::io::stdout().write_all(text.as_bytes());
        written
            .map_err(|error| format!("was checked, and the answers cannot be written: {error}"))?;
        Ok(status)
    });
    ExitCode::from(written.unwrap_or_else(|error| {
        eprintln!("error: `{}` {error}", argument.display());
        2
    }))
}

/// Returns the text of a file, and one byte more than a certificate may have.
fn read(path: &std::path::Path) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let file = std::fs::File::open(path);
    let read = file.and_then(|file| file.take(MOST_BYTES as u64 + 1).read_to_end(&mut out));
    (read.map(|_| out)).map_err(|error| format!("cannot be read: {error}"))
}

/// Returns the answers in words, and the exit status.
fn report(text: &[u8]) -> Result<(String, u8), String> {
    let mut out = String::new();
    let (mut accepted, mut refused) = (0, 0);
    for answer in check(text)? {
        match answer.outcome {
            Outcome::Accepted(_) => accepted += 1,
            Outcome::Refused(_) => refused += 1,
            Outcome::NotCertified(_) => {}
        }
        // Names cannot begin a line of their own.
        let line = format!("{}: {}", answer.check, answer.outcome);
        out += &line.replace(char::is_control, "\u{fffd}");
        out.push('\n');
    }
    let status = match (accepted, refused) {
        (_, 1..) => 1,
        (0, 0) => 2,
        _ => 0,
    };
    out += if status == 2 { "nothing is certified\n" } else { "" };
    Ok((out, status))
}
