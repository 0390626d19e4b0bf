//! Expansion of MiniJinja texts, in this process or in a separate one that can be limited.
//!
//! The number of steps is limited, but a single step can double the length of a string. Texts of users are
//! therefore expanded by another process ([`Remote`], [`serve`]), which the system confines and limits. Both
//! processes exchange lines of JSON.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::ChildStdout;
use std::sync::atomic::AtomicU8;
use std::sync::{Arc, Mutex, PoisonError, mpsc};

use minijinja::value::Value;
use minijinja::{Environment, Error, ErrorKind, context};
use serde::{Deserialize, Serialize};

use crate::process::{Process, Processes};
use crate::template::{Limits, host};

/// Maximum number of steps in a text.
const FUEL: u64 = 50_000_000;
/// Default limit on the address space of the other process, in bytes.
const MEMORY: u64 = 1 << 30;

/// Calls a function that texts use, by name and arguments.
pub(super) type Ask = dyn Fn(&str, &[String]) -> Result<String, String> + Send + Sync;

/// Expands texts over shared data and data of their own.
pub(super) trait Expand {
    /// Expands a text. The error contains its name and line.
    fn expand(&mut self, name: &str, text: &str, own: &Value) -> Result<String, String>;
}

/// Expands texts in this process.
pub(super) struct Local {
    pub(super) shared: Value,
    pub(super) ask: Arc<Ask>,
}

impl Expand for Local {
    fn expand(&mut self, name: &str, text: &str, own: &Value) -> Result<String, String> {
        let data = context! { ..own.clone(), ..self.shared.clone() };
        let mut jinja = Environment::new();
        let function = |name: &'static str| {
            let ask = Arc::clone(&self.ask);
            move |arguments: &[String]| {
                let answer = ask(name, arguments);
                answer.map_err(|error| Error::new(ErrorKind::InvalidOperation, error))
            }
        };
        let diagram = function("diagram");
        jinja.add_function("diagram", move |component: String, owner: String, form: String| {
            diagram(&[component, owner, form])
        });
        let schema = function("json_schema");
        jinja.add_function("json_schema", move |component: String| schema(&[component]));
        let stub = function("python_stub");
        jinja.add_function("python_stub", move |component: String| stub(&[component]));
        jinja.add_filter("duration", duration);
        jinja.set_trim_blocks(true);
        jinja.set_lstrip_blocks(true);
        jinja.set_keep_trailing_newline(true);
        jinja.set_fuel(Some(FUEL));
        jinja.set_auto_escape_callback(|_| minijinja::AutoEscape::None);
        let explain = |error: Error| {
            let line = error.line().map(|line| format!(":{line}")).unwrap_or_default();
            format!("{name}{line}: {error:#}")
        };
        let template = jinja.template_from_named_str(name, text).map_err(explain)?;
        template.render(data).map_err(explain)
    }
}

/// Seconds in a suitable unit.
pub(super) fn duration(seconds: f64) -> String {
    let (number, unit) = match seconds {
        number if number >= 1.0 || number == 0.0 => (number, "s"),
        number if number >= 1e-3 => (number * 1e3, "ms"),
        number => (number * 1e6, "µs"),
    };
    let rounded = (number * 1e6).round() / 1e6;
    format!("{rounded} {unit}")
}

/// A message to the expanding process, after a line with the shared data.
#[derive(Debug, Serialize, Deserialize)]
struct Job {
    name: String,
    text: String,
    own: serde_json::Value,
}

/// A message from the expanding process.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WorkerMessage {
    Done(String),
    Failed(String),
    /// A call of a function with its arguments; the reply is a line with a `Result`.
    Ask(String, Vec<String>),
}

/// Expands texts in another process.
pub(super) struct Remote {
    process: Arc<Mutex<Process>>,
    to: std::process::ChildStdin,
    from: BufReader<ChildStdout>,
    ask: Arc<Ask>,
    ended: Arc<AtomicU8>,
    /// Ends the thread that limits the time, when dropped.
    _watch: Option<mpsc::Sender<()>>,
    memory: u64,
    line_limit: u64,
}

impl Remote {
    /// Starts the process; `None` if no program for it is available.
    pub(super) fn start(
        processes: &dyn Processes,
        limits: &Limits,
        shared: &Value,
        ask: Arc<Ask>,
    ) -> Result<Option<Remote>, String> {
        let mut resources = limits.resources();
        let memory = *resources.memory.get_or_insert(MEMORY);
        let Some(started) = processes.renderer(resources) else { return Ok(None) };
        let mut process = started.map_err(|error| format!("cannot start the renderer: {error}"))?;
        // The error output is not read: it has at most one line.
        let (Some(to), Some(from)) = (process.child.stdin.take(), process.child.stdout.take())
        else {
            return Err("cannot talk to the renderer".into());
        };
        let process = Arc::new(Mutex::new(process));
        let ended = Arc::default();
        let watch = host::watch(limits, None, &process, &ended);
        let mut remote = Remote {
            process,
            to,
            from: BufReader::new(from),
            ask,
            ended,
            _watch: watch,
            memory,
            // A character may become six characters in JSON.
            line_limit: limits.output.unwrap_or(MEMORY).saturating_mul(6).saturating_add(1 << 20),
        };
        remote.send(shared)?;
        Ok(Some(remote))
    }

    fn send(&mut self, message: &impl Serialize) -> Result<(), String> {
        let mut line = serde_json::to_vec(message).map_err(|error| error.to_string())?;
        line.push(b'\n');
        let sent = self.to.write_all(&line).and_then(|()| self.to.flush());
        sent.map_err(|_| self.why_ended())
    }

    fn receive(&mut self) -> Result<WorkerMessage, String> {
        let mut line = Vec::new();
        let read = (&mut self.from).take(self.line_limit).read_until(b'\n', &mut line);
        if read.is_err() || !line.ends_with(b"\n") {
            return Err(self.why_ended());
        }
        serde_json::from_slice(&line)
            .map_err(|error| format!("the renderer said what cannot be read: {error}"))
    }

    fn why_ended(&mut self) -> String {
        if let Some(why) = host::why_stopped(&self.ended) {
            return why.to_owned();
        }
        let mut process = self.process.lock().unwrap_or_else(PoisonError::into_inner);
        process.kill();
        let status = process.wait().map_or_else(|error| error.to_string(), |wait| wait.to_string());
        format!(
            "stopped: rendering took more than {} MiB of memory, or failed in a way that it could not tell \
             ({status})",
            self.memory >> 20
        )
    }
}

impl Expand for Remote {
    fn expand(&mut self, name: &str, text: &str, own: &Value) -> Result<String, String> {
        let own = serde_json::to_value(own).map_err(|error| error.to_string())?;
        self.send(&Job { name: name.to_owned(), text: text.to_owned(), own })
            .map_err(|error| format!("{name}: {error}"))?;
        loop {
            match self.receive().map_err(|error| format!("{name}: {error}"))? {
                WorkerMessage::Done(text) => return Ok(text),
                WorkerMessage::Failed(message) => return Err(message),
                WorkerMessage::Ask(function, arguments) => {
                    let answer = (self.ask)(&function, &arguments);
                    self.send(&answer)?;
                }
            }
        }
    }
}

/// Both ends of a connection.
struct Channel {
    from: Box<dyn BufRead + Send>,
    to: Box<dyn Write + Send>,
}

impl Channel {
    /// The next line; `None` at the end.
    fn receive<T: for<'de> Deserialize<'de>>(&mut self) -> Result<Option<T>, String> {
        let mut line = Vec::new();
        let read = self.from.read_until(b'\n', &mut line).map_err(|error| error.to_string())?;
        if read == 0 {
            return Ok(None);
        }
        serde_json::from_slice(&line).map(Some).map_err(|error| error.to_string())
    }

    fn send(&mut self, message: &impl Serialize) -> Result<(), String> {
        let mut line = serde_json::to_vec(message).map_err(|error| error.to_string())?;
        line.push(b'\n');
        let sent = self.to.write_all(&line).and_then(|()| self.to.flush());
        sent.map_err(|error| error.to_string())
    }
}

/// Expands the texts that arrive on one channel and answers on the other, up to the end of the input. It runs
/// in the renderer that [`Processes::renderer`] starts.
///
/// # Errors
/// A failure to read or write.
pub fn serve(
    from: impl BufRead + Send + 'static,
    to: impl Write + Send + 'static,
) -> Result<(), String> {
    let channel = Arc::new(Mutex::new(Channel { from: Box::new(from), to: Box::new(to) }));
    fn lock(channel: &Mutex<Channel>) -> std::sync::MutexGuard<'_, Channel> {
        channel.lock().unwrap_or_else(PoisonError::into_inner)
    }
    let Some(shared) = lock(&channel).receive::<serde_json::Value>()? else {
        return Ok(());
    };
    let asked = Arc::clone(&channel);
    let ask = move |function: &str, arguments: &[String]| {
        let mut channel = lock(&asked);
        channel.send(&WorkerMessage::Ask(function.to_owned(), arguments.to_vec()))?;
        let answer: Option<Result<String, String>> = channel.receive()?;
        answer.unwrap_or_else(|| Err("nobody answers".to_owned()))
    };
    let mut local = Local { shared: Value::from_serialize(&shared), ask: Arc::new(ask) };
    loop {
        let Some(job) = lock(&channel).receive::<Job>()? else {
            return Ok(());
        };
        let said = match local.expand(&job.name, &job.text, &Value::from_serialize(&job.own)) {
            Ok(text) => WorkerMessage::Done(text),
            Err(message) => WorkerMessage::Failed(message),
        };
        lock(&channel).send(&said)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_expanded_and_functions_asked() {
        let lines = [
            r#"{"a": 1, "n": [1.5, null]}"#,
            r#"{"name": "x", "text": "{{ a }}{{ b }}{{ diagram('c', 'o', 'dot') }}", "own": {"b": "é"}}"#,
            r#"{"Ok": "a\nb"}"#,
            r#"{"name": "y", "text": "\n{{ nope() }}", "own": {}}"#,
            r#"{"name": "z", "text": "{{ json_schema('c') }}", "own": {}}"#,
            r#"{"Err": "no such"}"#,
        ]
        .join("\n");
        #[derive(Clone, Default)]
        struct Shared(Arc<Mutex<Vec<u8>>>);
        impl Write for Shared {
            fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
                self.0.lock().unwrap().write(bytes)
            }
            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let out = Shared::default();
        serve(std::io::Cursor::new(lines), out.clone()).unwrap();
        let out = String::from_utf8(out.0.lock().unwrap().clone()).unwrap();
        let said: Vec<&str> = out.lines().collect();
        assert_eq!(said[0], r#"{"ask":["diagram",["c","o","dot"]]}"#);
        assert_eq!(said[1], r#"{"done":"1éa\nb"}"#);
        assert!(said[2].starts_with(r#"{"failed":"y:2: "#), "{}", said[2]);
        assert_eq!(said[3], r#"{"ask":["json_schema",["c"]]}"#);
        assert!(said[4].contains("no such"), "{}", said[4]);
    }
}
