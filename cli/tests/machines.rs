//! Two machines: a run in each of two network namespaces with a link between them. Needs root.
#![cfg(all(target_os = "linux", feature = "zenoh"))]

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{Listening, compilers, ended, soon};

/// Maximum time until another machine is reported as gone: a second by the manual, and as much for a slow
/// machine.
const GONE_TIMEOUT: Duration = Duration::from_secs(2);

/// Maximum time until a run ends: less than the 10 s for which Zenoh would try to connect again.
const END_TIMEOUT: Duration = Duration::from_secs(5);

/// Two network namespaces, which are removed with their link when they are dropped.
struct Machines([String; 2]);

fn ip(arguments: &[&str]) -> bool {
    let mut ip = Command::new("ip");
    let status = ip.args(arguments).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}

impl Machines {
    /// Returns `None` if the system does not permit network namespaces.
    fn new() -> Option<Machines> {
        let machines =
            Machines(["one", "two"].map(|name| format!("dotgen-{}-{name}", std::process::id())));
        let [one, two] = &machines.0;
        if !ip(&["netns", "add", one]) || !ip(&["netns", "add", two]) {
            dotgen_loaders::skip(
                "`ip netns add` is not permitted; the test needs root and iproute2",
            );
            return None;
        }
        let link = "link add name veth0 type veth peer name veth0 netns".split(' ');
        let link: Vec<&str> = ["-n", one].into_iter().chain(link).chain([&two[..]]).collect();
        assert!(ip(&link), "a pair of veth");
        for (machine, address) in [(one, "10.77.0.1/24"), (two, "10.77.0.2/24")] {
            assert!(ip(&["-n", machine, "addr", "add", address, "dev", "veth0"]));
            assert!(ip(&["-n", machine, "link", "set", "veth0", "up"]));
        }
        Some(machines)
    }

    /// Starts a run on a machine, which has the name `one` or `two`.
    fn run(&self, machine: usize, directory: &Directory, file: &str, more: &[&str]) -> Listening {
        let mut arguments = vec!["run", file, "--clock", "real", "--bounds", "none"];
        arguments.extend(["--socket", "s"]);
        arguments.extend(more);
        let inner = directory.command(&arguments);
        let name = ["one", "two"][machine];
        let script = format!("echo {name} > /proc/sys/kernel/hostname && exec \"$@\"");
        let mut outer = Command::new("ip");
        outer.args(["netns", "exec", &self.0[machine], "unshare", "--uts"]);
        outer.args(["sh", "-c", &script, "sh"]);
        outer.arg(inner.get_program()).args(inner.get_args());
        outer.current_dir(directory.path());
        for (key, value) in inner.get_envs() {
            match value {
                Some(value) => outer.env(key, value),
                None => outer.env_remove(key),
            };
        }
        Listening::begin(&mut outer)
    }
}

impl Drop for Machines {
    fn drop(&mut self) {
        for machine in &self.0 {
            ip(&["netns", "del", machine]);
        }
    }
}

/// A component that adds one to what the other one has written.
fn player(name: &str, other: &str) -> Directory {
    let specification = format!(
        "module m {{ typedef long turn; }};
         component {name} {{ version \"1\"; lang \"c\";
           port in m::turn of_{other}; port out m::turn of_{name};
           task main {{ period 10 ms;
             codel<start> {name}_play(port in of_{other}, port out of_{name}) yield pause::start; }};
           function same(in long number, out long back) {{
             codel {name}_same(in number, out back); }}; }};\n"
    );
    let source = format!(
        "#include \"ac{name}.h\"
#include \"{name}_c_types.h\"
genom_event {name}_play(const {name}_of_{other} *in, const {name}_of_{name} *out,
                        const genom_context self) {{
  in->read(self);
  *out->data(self) = 1 + (in->data(self) ? *in->data(self) : 0);
  out->write(self);
  return {name}_pause_start;
}}
genom_event {name}_same(int32_t number, int32_t *back, const genom_context self) {{
  *back = number;
  return genom_ok;
}}
"
    );
    Directory::new(&[
        (&format!("{name}.gen") as &str, &specification as &str),
        (&format!("codels/{name}.c"), &source),
    ])
}

/// The newest number of a port.
fn newest(directory: &Directory, port: &str) -> i64 {
    let output = directory.run(&["watch", "--socket", "s", port, "-n", "1"]);
    stdout(&output).trim().parse().unwrap_or(0)
}

#[test]
fn ports_cross_between_machines_and_a_cut_link_ends_nothing_else() {
    if !compilers() {
        return;
    }
    let Some(machines) = Machines::new() else {
        return;
    };
    let (ping, pong) = (player("ping", "pong"), player("pong", "ping"));
    let listen = ["--zenoh-listen", "tcp/10.77.0.1:7447"];
    let mut first = machines.run(0, &ping, "ping.gen", &listen);
    let connect = ["--zenoh-connect", "tcp/10.77.0.1:7447"];
    let mut second = machines.run(1, &pong, "pong.gen", &connect);
    first.told("`pong` of the machine `two` has appeared");
    second.told("`ping` of the machine `one` has appeared");
    // The numbers grow only if they cross both ways.
    soon("ten times", || (newest(&ping, "ping/of_ping") > 10).then_some(()));
    let cut = Instant::now();
    assert!(ip(&["-n", &machines.0[0], "link", "set", "veth0", "down"]));
    let told = [
        first.told("`pong` of the machine `two` has disappeared"),
        second.told("`ping` of the machine `one` has disappeared"),
    ];
    for told in told {
        let took = told.duration_since(cut);
        eprintln!("a cut link was reported after {took:?}");
        assert!(took < GONE_TIMEOUT, "{took:?}");
    }
    for (directory, run, name) in [(&ping, &mut first, "ping"), (&pong, &mut second, "pong")] {
        // The last data stays.
        assert!(newest(directory, &format!("{name}/of_{name}")) > 10);
        let called = directory.run(&["call", "--socket", "s", name, "same", "{\"number\": 7}"]);
        assert_eq!(status(&called), 0, "{}", stderr(&called));
        assert_eq!(stdout(&called), "{\"back\":7}\n");
        let interrupted = Instant::now();
        run.signal("-INT");
        // Interrupted; on a busy machine also with a missed deadline.
        let code = ended(&mut run.0).code();
        assert!(matches!(code, Some(1 | 3)), "{code:?}");
        let took = interrupted.elapsed();
        eprintln!("`{name}` ended after {took:?}");
        assert!(took < END_TIMEOUT, "{took:?}");
    }
}
