//! Where a run listens, and whom it serves there.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Write as _};

use crate::directory::{status, stderr};
use crate::running::{Listening, with_body};

const REAL: &[&str] = &["run", "good/good.gen", "--clock", "real", "--socket", "s"];

#[test]
fn nothing_listens_beyond_a_private_socket_unless_told_to() {
    let directory = with_body("");
    let arguments = [REAL, &["--simulate", "all"]].concat();
    let listening = |run: &Listening| {
        let links = std::fs::read_dir(format!("/proc/{}/fd", run.0.id())).expect("it is mine");
        let links = links.flatten().filter_map(|link| std::fs::read_link(link.path()).ok());
        let sockets = links.filter_map(|link| {
            let name = link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?;
            Some(name.to_owned())
        });
        let sockets: Vec<String> = sockets.collect();
        let mut found = Vec::new();
        for table in ["tcp", "tcp6", "udp", "udp6"] {
            let text = std::fs::read_to_string(format!("/proc/net/{table}")).unwrap_or_default();
            for line in text.lines().skip(1) {
                let words: Vec<&str> = line.split_whitespace().collect();
                if words.get(9).is_some_and(|word| sockets.iter().any(|own| own == word)) {
                    found.push((table, words[1].to_owned()));
                }
            }
        }
        found
    };
    let run = Listening::start(&directory, &arguments);
    assert_eq!(listening(&run), []);
    drop(run);
    let started = |more: &[&str]| {
        let mut command = directory.command(&[&arguments[..], more].concat());
        Listening::begin(command.env("XDG_RUNTIME_DIR", directory.path()))
    };
    let mut run = started(&["--listen", "0"]);
    let found = listening(&run);
    let [(table, address)] = found.as_slice() else {
        panic!("{found:?}");
    };
    let (host, port) = address.split_once(':').expect("an address");
    // 127.0.0.1, as this machine has its bytes.
    let loopback = format!("{:08X}", u32::from_ne_bytes([127, 0, 0, 1]));
    assert_eq!((*table, host), ("tcp", loopback.as_str()));
    let port = u16::from_str_radix(port, 16).expect("a number");
    let says = |port: u16, requests: &str| {
        let client = std::net::TcpStream::connect(("127.0.0.1", port)).expect("it listens");
        (&client).write_all(requests.as_bytes()).expect("it reads");
        let mut said = String::new();
        let line = BufReader::new(&client).read_line(&mut said);
        line.map(|_| said).expect("it answers")
    };
    let describe = "{\"id\": 1, \"describe\": null}\n";
    let refused = says(port, describe);
    assert!(refused.contains("first send") && !refused.contains("\"good\""), "{refused}");
    let file = directory.path().join(format!("dotgen/{port}.token"));
    let mode = std::os::unix::fs::MetadataExt::mode(&file.metadata().expect("a file"));
    assert_eq!(mode & 0o777, 0o600);
    let token = std::fs::read_to_string(&file).expect("a token");
    let wrong = says(port, &format!("{{\"token\": \"{token}0\"}}\n{describe}"));
    assert!(!wrong.contains("\"good\""), "{wrong}");
    let said = says(port, &format!("{{\"token\": \"{token}\"}}\n{describe}"));
    assert!(said.contains("\"good\""), "{said}");
    // What a browser says is let go before a request can stand in it.
    let browser = std::net::TcpStream::connect(("127.0.0.1", port)).expect("it listens");
    let page = b"POST / HTTP/1.1\r\n\r\n{\"id\": 1, \"describe\": null}\n";
    // It may hang up in the middle.
    let _ = (&browser).write_all(page);
    let mut said = Vec::new();
    let _ = std::io::Read::read_to_end(&mut &browser, &mut said);
    assert!(!String::from_utf8_lossy(&said).contains("description"));
    // Somebody listens there already.
    let taken = [&arguments[..3], &["real", "--simulate", "all", "--socket", "t"]].concat();
    let port = port.to_string();
    let taken = [&taken[..], &["--listen", &port]].concat();
    let taken = directory.run(&taken);
    assert_eq!(status(&taken), 2);
    assert!(stderr(&taken).contains("cannot listen at 127.0.0.1"), "{}", stderr(&taken));
    assert!(!directory.path().join("t").exists());
    run.signal("-INT");
    run.0.wait().expect("it ends");
    assert!(!file.exists());
    let run = started(&["--listen", &port, "--listen-anyone"]);
    let port = port.parse().expect("a number");
    assert!(says(port, describe).contains("\"good\""));
    drop(run);
}
