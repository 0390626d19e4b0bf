//! Components that run with codels of their own: what tests of that need.

#![allow(dead_code, reason = "no test file needs all of it")]

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::directory::{Directory, stderr, stdout};

/// True if the compilers are installed; otherwise the test is recorded as skipped.
pub(crate) fn compilers() -> bool {
    installed(&["cc", "c++"])
}

/// True if these programs are installed; otherwise the test is recorded as skipped.
pub(crate) fn installed(programs: &[&str]) -> bool {
    programs.iter().all(|program| {
        let mut command = Command::new(program);
        command.arg("--version").stdout(Stdio::null());
        let known = command.status().is_ok_and(|status| status.success());
        if !known {
            dotgen_loaders::skip(format_args!("there is no `{program}`"));
        }
        known
    })
}

/// A component whose activity does something in its codel, beside one that does no harm.
pub(crate) fn with_body(body: &str) -> Directory {
    let gen_of = |name: &str| {
        format!(
            "component {name} {{ version \"1\"; lang \"c\"; ids {{ long n; }};
               task main {{ period 10 ms;
                 codel<start> {name}_first(inout n) yield pause::go wcet 1 ms;
                 codel<go> {name}_again(inout n) yield pause::go, stop wcet 1 ms;
                 codel<stop> {name}_last(inout n) yield ether wcet 1 ms; }}; }};\n"
        )
    };
    let source = |name: &str, body: &str| {
        format!(
            "#include \"ac{name}.h\"
#include <stdlib.h>
#include <unistd.h>
#include \"{name}_c_types.h\"
genom_event {name}_first(int32_t *n, const genom_context self) {{ *n = 0; return {name}_pause_go; }}
genom_event {name}_again(int32_t *n, const genom_context self) {{
  if (++*n == 5) {{ {body} }}
  return {name}_pause_go;
}}
genom_event {name}_last(int32_t *n, const genom_context self) {{ return {name}_ether; }}
"
        )
    };
    let directory = Directory::new(&[]);
    for (name, body) in [("bad", body), ("good", "")] {
        directory.write(&format!("{name}/{name}.gen"), gen_of(name).as_bytes());
        let path = format!("{name}/codels/{name}.c");
        directory.write(&path, source(name, body).as_bytes());
    }
    directory
}

pub(crate) fn json_of(output: &Output) -> Value {
    let text = stdout(output);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}{}", stderr(output)))
}

/// Processes whose words name something of a directory.
pub(crate) fn processes(directory: &Directory) -> Vec<String> {
    let hosts = hosts(directory).into_iter();
    let words = hosts.filter_map(|host| std::fs::read(format!("/proc/{host}/cmdline")).ok());
    words.map(|word| String::from_utf8_lossy(&word).replace('\0', " ")).collect()
}

/// Process numbers of the hosts of a run of something in a directory.
pub(crate) fn hosts(directory: &Directory) -> Vec<u32> {
    let path = directory.path().to_str().expect("it is text");
    let all = std::fs::read_dir("/proc").expect("Linux has it").flatten();
    let numbers = all.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let is_host = |number: &u32| {
        let words = std::fs::read(format!("/proc/{number}/cmdline")).unwrap_or_default();
        let words = String::from_utf8_lossy(&words).into_owned();
        words.contains("-run.so") && words.contains(path)
    };
    numbers.filter(is_host).collect()
}

pub(crate) fn violation<'r>(report: &'r Value, kind: &str) -> &'r Value {
    let all = report["violations"].as_array().expect("a list");
    let found = all.iter().find(|violation| violation["kind"] == kind);
    found.unwrap_or_else(|| panic!("no {kind}: {report:#}"))
}

/// A run on the real clock, from when it listens, and its error output.
pub(crate) struct Listening(pub(crate) Child, pub(crate) Lines);

/// Lines with the times at which they were read.
pub(crate) type Lines = Arc<Mutex<Vec<(Instant, String)>>>;

impl Listening {
    pub(crate) fn start(directory: &Directory, arguments: &[&str]) -> Listening {
        Listening::begin(&mut directory.command(arguments))
    }

    pub(crate) fn begin(command: &mut Command) -> Listening {
        Listening::begin_with_output(command, Stdio::null())
    }

    pub(crate) fn begin_with_output(command: &mut Command, output: Stdio) -> Listening {
        command.stdout(output).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        let output = child.stderr.take().expect("it is piped");
        let mut output = BufReader::new(output);
        let lines = Lines::default();
        let keep = |lines: &Lines, line: String| {
            let line = (Instant::now(), line);
            lines.lock().expect("it is whole").push(line);
        };
        loop {
            let mut line = String::new();
            let read = output.read_line(&mut line).expect("it is text");
            assert_ne!(read, 0, "it has ended: {lines:?}");
            let listens = line.contains("listening at");
            keep(&lines, line);
            if listens {
                break;
            }
        }
        let rest = lines.clone();
        std::thread::spawn(move || {
            let all = output.split(b'\n').map_while(Result::ok);
            all.for_each(|line| keep(&rest, String::from_utf8_lossy(&line).into_owned()));
        });
        Listening(child, lines)
    }

    /// Waits for a line with a text. Returns the time at which the first one was read.
    pub(crate) fn told(&self, text: &str) -> Instant {
        soon(text, || {
            let lines = self.1.lock().expect("it is whole");
            let found = lines.iter().find(|line| line.1.contains(text));
            found.map(|line| line.0)
        })
    }

    pub(crate) fn signal(&self, name: &str) {
        signal(name, self.0.id());
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// How long something may take that ends at once.
const EXIT_TIMEOUT: Duration = Duration::from_secs(20);

/// Waits until something is so, and fails where that does not come soon.
pub(crate) fn soon<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(ask) = ask() {
            return ask;
        }
        assert!(begin.elapsed() < EXIT_TIMEOUT, "not in time: {what}");
        std::thread::yield_now();
    }
}

/// Waits for the end of a process that ends soon; else it is ended, and the test has failed.
pub(crate) fn ended(child: &mut Child) -> ExitStatus {
    let begin = Instant::now();
    loop {
        if let Some(wait) = child.try_wait().expect("it is a child") {
            return wait;
        }
        if begin.elapsed() > EXIT_TIMEOUT {
            let _ = child.kill();
            let _ = child.wait();
            panic!("it does not end");
        }
        std::thread::yield_now();
    }
}

/// Sends a signal to a process.
pub(crate) fn signal(name: &str, process: u32) {
    let mut kill = Command::new("kill");
    let status = kill.args([name, &process.to_string()]).status();
    assert!(status.is_ok_and(|status| status.success()));
}

/// Runs a script of `tests/hosted` with the Python client. The run listens at `s` in the directory.
pub(crate) fn talk(directory: &Directory, script: &str) {
    let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new("python3");
    command.arg(here.join("tests/hosted").join(script)).arg("s");
    command.current_dir(directory.path());
    command.env("PYTHONPATH", here.join("../clients/python"));
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    let output = command.output().expect("it runs");
    assert!(output.status.success(), "{script}: {}", stderr(&output));
}
