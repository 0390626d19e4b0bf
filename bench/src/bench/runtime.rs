//! Components on the real clock: the way from codel to codel, entries of a task next to other programs,
//! missed ticks, ports, and requests at the socket. The components are in `runtime/`.

mod clients;
mod components;
mod samples;

use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};

use self::components::Component;
use self::samples::{Samples, header};
use xtask::run::{self, step};
use xtask::target;

/// Bytes of the values of a port.
const SIZES: [usize; 3] = [64, 1 << 16, 1 << 20];
/// Entries of codels of a chain that are further apart, in nanoseconds, belong to different ticks.
const SAME_TICK_NANOS: u64 = 5_000_000;

/// Measures everything and prints a table. Each measurement lasts `seconds`, that of two tasks
/// `task_seconds`.
///
/// # Errors
/// A component does not compile or run.
pub(super) fn runtime(dotgen: &Path, seconds: f64, task_seconds: f64) -> Result<()> {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let cores = std::thread::available_parallelism()?;
    step(&format!(
        "{cores} cores, load averages {}; each measurement lasts {seconds} s",
        load.split(' ').take(3).collect::<Vec<_>>().join(" ")
    ));
    let folder = target().join("bench-runtime");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    let bench = Bench { dotgen, folder: &folder, seconds };
    println!("{}", header());
    bench.chain()?;
    bench.entries()?;
    bench.pair(task_seconds)?;
    bench.ports()?;
    bench.clients()?;
    Ok(std::fs::remove_dir_all(&folder)?)
}

struct Bench<'a> {
    dotgen: &'a Path,
    /// The folder of the components.
    folder: &'a Path,
    seconds: f64,
}

impl Bench<'_> {
    fn component(&self, name: &str, specification: &str, source: &str) -> Result<Component> {
        Component::new(self.dotgen, &self.folder.join(name), specification, source)
    }

    /// From the entry of a codel to that of the next one.
    fn chain(&self) -> Result<()> {
        let chain = self.component(
            "chain",
            include_str!("runtime/chain.gen"),
            include_str!("runtime/chain.c"),
        )?;
        chain.run(self.seconds, &[])?;
        let entries = chain.numbers()?;
        let apart = entries.windows(2).map(|two| two[1] - two[0]);
        let samples = apart.filter(|&nanos| nanos < SAME_TICK_NANOS).collect();
        Samples::new(samples).print("codel to codel of a chain");
        Ok(())
    }

    /// From the tick of a task to the entry of its codel, next to programs that sleep until each millisecond.
    fn entries(&self) -> Result<()> {
        let ticks = self.component(
            "ticks",
            include_str!("runtime/ticks.gen"),
            include_str!("runtime/ticks.c"),
        )?;
        // So that the measured run begins at once, without compilers.
        ticks.run(0.01, &[])?;
        ticks.numbers()?;
        let sleeper = self.sleeper()?;
        let cyclictest = cyclictest(self.seconds);
        ticks.run(self.seconds, &["--profile", "profile"])?;
        let profile = std::fs::read_to_string(ticks.folder().join("profile"))?;
        let (entries, unknown) = lateness(&ticks.numbers()?, &profile)?;
        entries.print(&format!(
            "1 kHz: tick to entry of the codel, known to {:.0} µs",
            unknown as f64 / 1e3
        ));
        sleeper.finish()?.print("1 kHz: `clock_nanosleep`, same seconds");
        match cyclictest {
            Some(child) => histogram(child)?.print("1 kHz: `cyclictest`, same seconds"),
            None => eprintln!("cyclictest is not installed (Debian: rt-tests)"),
        }
        Ok(())
    }

    /// Starts the program that sleeps.
    fn sleeper(&self) -> Result<Sleeper> {
        let folder = self.folder.join("sleeper");
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join("sleeper.c"), include_str!("runtime/sleeper.c"))?;
        run::capture(run::command(&folder, "cc", &["-O2", "-o", "sleeper", "sleeper.c"]))?;
        let numbers = folder.join("numbers");
        let program = folder.join("sleeper");
        let mut command = Command::new(program);
        command.arg(self.seconds.to_string()).arg(&numbers);
        let child = command.spawn().context("cannot run the sleeper")?;
        Ok(Sleeper { child, numbers })
    }

    /// Two tasks of 1 kHz: ticks without a job, and responses.
    fn pair(&self, seconds: f64) -> Result<()> {
        let pair = self.component(
            "pair",
            include_str!("runtime/pair.gen"),
            include_str!("runtime/pair.c"),
        )?;
        let report = pair.run(seconds, &["--profile", "profile"])?;
        let profile = std::fs::read_to_string(pair.folder().join("profile"))?;
        let lines = lines(&profile)?;
        let responses = lines.iter().map(|(asked, ended)| ended - asked).collect();
        let tasks = report["tasks"].as_array().context("no tasks")?;
        let jobs: u64 = tasks.iter().filter_map(|task| task["jobs"].as_u64()).sum();
        let due = (seconds * 1e3) as u64 * tasks.len() as u64;
        let without = due.saturating_sub(jobs);
        Samples::new(responses).print(&format!(
            "two tasks of 1 kHz, {seconds} s: tick to end; {without} of {due} ticks without a job"
        ));
        Ok(())
    }

    /// The age of values of a port when another component reads them, and the values that arrive.
    fn ports(&self) -> Result<()> {
        for size in SIZES {
            let shown = format!("port of {size} bytes");
            let (writer, reader) = self.link("local", "writer", "reader", size)?;
            let both = Component::scenario(&writer, &reader)?;
            both.run(self.seconds, &[])?;
            self.ages(&reader, size, &format!("{shown}, local"))?;
            for (name, more) in [("Zenoh", &[][..]), ("ROS 2", &["--ros2"])] {
                // A topic has the name of its component.
                let names = match more.is_empty() {
                    true => ["writer", "reader"],
                    false => ["node", "node"],
                };
                let (writer, reader) = self.link(name, names[0], names[1], size)?;
                let endpoint = endpoint()?;
                let listen = ["--zenoh-listen", &endpoint];
                let connect = ["--zenoh-connect", &endpoint];
                let writes = writer.start(f64::MAX, &[&listen[..], more].concat())?;
                reader.run(self.seconds, &[&connect[..], more].concat())?;
                drop(writes);
                self.ages(&reader, size, &format!("{shown}, {name}"))?;
            }
        }
        Ok(())
    }

    fn link(&self, way: &str, from: &str, to: &str, size: usize) -> Result<(Component, Component)> {
        let types = include_str!("runtime/value.idl").replace("SIZE", &size.to_string());
        let component = |role: &str, name: &str, specification: &str, source: &str| {
            let folder = format!("{way}-{size}-{role}/{name}");
            let specification = specification.replace(role, name);
            let component = self.component(&folder, &specification, &source.replace(role, name))?;
            std::fs::write(component.folder().join("value.idl"), &types)?;
            anyhow::Ok(component)
        };
        let (specification, source) =
            (include_str!("runtime/writer.gen"), include_str!("runtime/writer.c"));
        let writer = component("writer", from, specification, source)?;
        let (specification, source) =
            (include_str!("runtime/reader.gen"), include_str!("runtime/reader.c"));
        Ok((writer, component("reader", to, specification, source)?))
    }

    fn ages(&self, reader: &Component, size: usize, name: &str) -> Result<()> {
        let ages = reader.numbers()?;
        let values = ages.len() as f64 / self.seconds;
        let megabytes = values * size as f64 / 1e6;
        Samples::new(ages)
            .print(&format!("{name}: {values:.0} values/s, {megabytes:.1} MB/s; write to read"));
        Ok(())
    }

    /// Round trips of requests, for a growing number of clients.
    fn clients(&self) -> Result<()> {
        let server = self.component(
            "server",
            include_str!("runtime/server.gen"),
            include_str!("runtime/server.c"),
        )?;
        let port = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()?.port();
        let listen = ["--listen", &port.to_string(), "--listen-anyone"];
        let serves = server.start(f64::MAX, &listen)?;
        for clients in [1, 10, 100] {
            let trips = clients::round_trips(&server.socket(), port, clients, self.seconds)?;
            let rate = trips.len() as f64 / self.seconds;
            Samples::new(trips)
                .print(&format!("{clients} clients: {rate:.0} requests/s; request to reply"));
        }
        drop(serves);
        Ok(())
    }
}

/// A running program that sleeps, and the file of its numbers.
struct Sleeper {
    child: Child,
    numbers: std::path::PathBuf,
}

impl Sleeper {
    fn finish(mut self) -> Result<Samples> {
        if !self.child.wait()?.success() {
            bail!("the sleeper failed");
        }
        Ok(Samples::new(components::numbers(&self.numbers)?))
    }
}

/// Starts `cyclictest`, if it is installed.
fn cyclictest(seconds: f64) -> Option<Child> {
    let seconds = format!("{:.0}", seconds.ceil());
    let arguments = ["-q", "-m", "-p", "48", "-i", "1000", "-h", "100000", "-D"];
    let mut command = Command::new("cyclictest");
    command.args(arguments).arg(seconds).stdout(Stdio::piped());
    command.stderr(Stdio::null()).spawn().ok()
}

/// Returns the samples of the histogram that `cyclictest` prints, of one thread, in microseconds.
fn histogram(child: Child) -> Result<Samples> {
    let output = child.wait_with_output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let mut nanos = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let mut words = line.split_whitespace().map(str::parse::<u64>);
        if let (Some(Ok(micros)), Some(Ok(count))) = (words.next(), words.next()) {
            nanos.extend(std::iter::repeat_n(micros * 1_000, count as usize));
        }
    }
    Ok(Samples::new(nanos))
}

/// Returns the times of each line of a profile, in nanoseconds since the start: locks requested, and ended.
fn lines(profile: &str) -> Result<Vec<(u64, u64)>> {
    let lines = profile.lines().filter(|line| !line.starts_with('#'));
    let times = lines.map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let time = |column: usize| -> Result<u64> {
            let word: f64 = words.get(column).context("a line is short")?.parse()?;
            Ok((word * 1e9).round() as u64)
        };
        Ok((time(0)?, time(2)?))
    });
    times.collect()
}

/// Returns the lateness of entries, and its uncertainty in nanoseconds. An entry is on the system's clock.
/// Its tick and its end are in the profile, from an unknown start, which is before every entry less its tick,
/// and after every entry less its end. The earliest possible start gives the greatest lateness.
fn lateness(entries: &[u64], profile: &str) -> Result<(Samples, u64)> {
    let lines = lines(profile)?;
    let both = || std::iter::zip(entries, &lines);
    let latest = both().map(|(entry, (tick, _))| entry - tick).min();
    let earliest = both().map(|(entry, (_, end))| entry - end).max();
    let (Some(earliest), Some(latest)) = (earliest, latest) else {
        bail!("no codel ran");
    };
    if earliest > latest {
        bail!("the profile has other executions than the codel noted");
    }
    let late = both().map(|(entry, (tick, _))| entry - tick - earliest);
    Ok((Samples::new(late.collect()), latest - earliest))
}

/// Returns an endpoint of Zenoh at which nothing listens.
fn endpoint() -> Result<String> {
    let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    Ok(format!("tcp/{}", free.local_addr()?))
}
