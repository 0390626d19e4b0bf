//! The standard channels of a template run.

use std::io::{BufRead, IsTerminal as _, Read, Write};

use dotgen_analysis::terminal;

/// The output and input of a template.
pub trait Console {
    /// Standard output.
    fn out(&mut self, bytes: &[u8]);

    /// A line for the error output, without its newline.
    fn err(&mut self, line: &str);

    /// Reads at most `max` bytes of standard input; empty at its end.
    fn read(&mut self, max: usize) -> Vec<u8>;

    /// Reads a line of standard input without its newline; `None` at its end.
    fn read_line(&mut self) -> Option<String>;

    /// Returns true if the interpreter inherits the error output; otherwise it is captured and passed to
    /// [`Console::err`].
    fn is_terminal(&self) -> bool {
        false
    }
}

/// The standard channels of the process. On a terminal, control characters are shown escaped.
#[derive(Debug)]
pub struct StdConsole {
    /// The standard output, if it is a terminal.
    shown: Option<TerminalFilter>,
}

impl Default for StdConsole {
    fn default() -> StdConsole {
        let terminal = std::io::stdout().is_terminal();
        StdConsole { shown: terminal.then(TerminalFilter::default) }
    }
}

/// Bytes made safe for a terminal. An incomplete character at the end of a call is kept until the next one.
#[derive(Debug, Default)]
struct TerminalFilter {
    kept: Vec<u8>,
}

impl TerminalFilter {
    fn text(&mut self, bytes: &[u8]) -> String {
        let bytes = [&std::mem::take(&mut self.kept), bytes].concat();
        let mut whole = bytes.len();
        let cut = (1..=whole.min(3)).find(|count| {
            let last = std::str::from_utf8(&bytes[whole - count..]);
            last.is_err_and(|error| error.valid_up_to() == 0 && error.error_len().is_none())
        });
        whole -= cut.unwrap_or(0);
        self.kept = bytes[whole..].to_vec();
        terminal::text(&String::from_utf8_lossy(&bytes[..whole])).into_owned()
    }
}

impl Console for StdConsole {
    fn out(&mut self, bytes: &[u8]) {
        // A closed pipe does not stop the run.
        let mut out = std::io::stdout().lock();
        let text = self.shown.as_mut().map(|shown| shown.text(bytes));
        let bytes = text.as_deref().map_or(bytes, str::as_bytes);
        let _ = out.write_all(bytes).and_then(|()| out.flush());
    }

    fn err(&mut self, line: &str) {
        let line = terminal::text(line);
        let _ = writeln!(std::io::stderr().lock(), "{line}");
    }

    fn read(&mut self, max: usize) -> Vec<u8> {
        let mut stdin = std::io::stdin().lock();
        let mut bytes = match stdin.fill_buf() {
            Ok(bytes) => bytes[..bytes.len().min(max)].to_vec(),
            Err(_) => Vec::new(),
        };
        let _ = stdin.read_exact(&mut bytes);
        bytes
    }

    fn read_line(&mut self) -> Option<String> {
        let mut line = Vec::new();
        match std::io::stdin().lock().read_until(b'\n', &mut line) {
            Ok(length) if length > 0 => {}
            _ => return None,
        }
        if line.ends_with(b"\n") {
            line.pop();
        }
        Some(String::from_utf8_lossy(&line).into_owned())
    }

    fn is_terminal(&self) -> bool {
        true
    }
}

/// Keeps the output; standard input is a given text.
#[derive(Debug, Default)]
pub struct CapturedConsole {
    /// Printed on standard output.
    pub out: Vec<u8>,
    /// Printed on the error output.
    pub err: String,
    /// The answer to every question at the end of the input.
    pub answer: Option<String>,
    input: std::io::Cursor<Vec<u8>>,
}

impl Console for CapturedConsole {
    fn out(&mut self, bytes: &[u8]) {
        self.out.extend_from_slice(bytes);
    }

    fn err(&mut self, line: &str) {
        self.err.push_str(line);
        self.err.push('\n');
    }

    fn read(&mut self, max: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        let _ = (&mut self.input).take(max as u64).read_to_end(&mut bytes);
        bytes
    }

    fn read_line(&mut self) -> Option<String> {
        let mut line = String::new();
        match self.input.read_line(&mut line) {
            Ok(length) if length > 0 => {}
            _ => return self.answer.clone(),
        }
        if line.ends_with('\n') {
            line.pop();
        }
        Some(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_gets_no_control_characters() {
        let mut shown = TerminalFilter::default();
        assert_eq!(shown.text(b"a\x1b]0;x\x07\tb\r\n"), "a\\u{1b}]0;x\\u{7}\tb\\u{d}\n");
        // A character that comes in two parts.
        assert_eq!(shown.text(b"\xe2\x82"), "");
        assert_eq!(shown.text(b"\xac \xc2"), "\u{20ac} ");
        assert_eq!(shown.text(b"\x9b31m \x9b"), "\\u{9b}31m \u{fffd}");
    }
}
