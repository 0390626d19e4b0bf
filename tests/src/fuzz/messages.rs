//! Messages of a client.

use std::time::Duration;

use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

/// A session to begin with: one message in each line.
pub(super) const SESSION: &str = r#"{"jsonrpc":"2.0","method":"initialized","params":{}}
{"jsonrpc":"2.0","method":"textDocument/didOpen","params":{"textDocument":{"uri":"file:///none/a.gen","languageId":"genom3","version":1,"text":"component c {\n  ids { long a; };\n  task t { period 5 ms; codel<start> f(ids out a) yield ether; };\n};\n"}}}
{"jsonrpc":"2.0","id":2,"method":"textDocument/hover","params":{"textDocument":{"uri":"file:///none/a.gen"},"position":{"line":1,"character":14}}}
{"jsonrpc":"2.0","id":3,"method":"textDocument/completion","params":{"textDocument":{"uri":"file:///none/a.gen"},"position":{"line":2,"character":11}}}
{"jsonrpc":"2.0","method":"textDocument/didChange","params":{"textDocument":{"uri":"file:///none/a.gen","version":2},"contentChanges":[{"range":{"start":{"line":0,"character":10},"end":{"line":0,"character":11}},"text":"d"}]}}
{"jsonrpc":"2.0","id":"four","method":"textDocument/documentSymbol","params":{"textDocument":{"uri":"file:///none/a.gen"}}}
{"jsonrpc":"2.0","id":5,"method":"dotgen/diagram","params":{"textDocument":{"uri":"file:///none/a.gen"},"kind":"system"}}
{"jsonrpc":"2.0","method":"$/cancelRequest","params":{"id":5}}
{"jsonrpc":"2.0","id":6,"method":"shutdown"}
{"jsonrpc":"2.0","method":"exit"}
"#;

/// A session that takes longer has lost a message.
const SESSION_TIMEOUT: Duration = Duration::from_mins(1);

/// A server is initialised and gets each line as one message; then its input ends. It must end too, and what
/// it wrote must be frames of JSON.
pub(super) fn serve(input: &[u8]) {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()
        .expect("a runtime");
    let output = runtime.block_on(async {
        let (ours, theirs) = tokio::io::duplex(1 << 20);
        let (mut from, mut to) = tokio::io::split(ours);
        let (read, write) = tokio::io::split(theirs);
        let server = tokio::spawn(dotgen_lsp_server::serve(read, write));
        let reader = tokio::spawn(async move {
            let mut output = Vec::new();
            // The pipe breaks when the server ends: that is its end.
            drop(from.read_to_end(&mut output).await);
            output
        });
        let hello = json!({ "jsonrpc": "2.0", "id": 1, "method": "initialize", "params": { "capabilities": {} } });
        let lines = input.split(|byte| *byte == b'\n');
        for line in std::iter::once(hello.to_string().as_bytes()).chain(lines) {
            let head = format!("Content-Length: {}\r\n\r\n", line.len());
            let sent = async {
                to.write_all(head.as_bytes()).await?;
                to.write_all(line).await
            };
            if sent.await.is_err() {
                // After `exit` nobody reads.
                break;
            }
        }
        drop(to.shutdown().await);
        let ended = tokio::time::timeout(SESSION_TIMEOUT, server).await;
        ended.expect("the server ends with its input").expect("the server does not panic");
        drop(to);
        tokio::time::timeout(SESSION_TIMEOUT, reader).await.expect("its output ends").expect("the reader reads")
    });
    runtime.shutdown_background();
    frames(&output);
}

/// Whether an output is complete frames, each a message.
fn frames(mut output: &[u8]) {
    while !output.is_empty() {
        let text = String::from_utf8_lossy(&output[..output.len().min(200)]).into_owned();
        let end = output.windows(4).position(|window| window == b"\r\n\r\n");
        let end = end.unwrap_or_else(|| panic!("no end of the header: {text}"));
        let head = String::from_utf8_lossy(&output[..end]);
        let length = head.lines().find_map(|line| line.strip_prefix("Content-Length: "));
        let length: usize = length.and_then(|length| length.parse().ok()).expect("a length");
        let body = output.get(end + 4..end + 4 + length).expect("a whole message");
        let message: Value = serde_json::from_slice(body).expect("JSON");
        assert_eq!(message["jsonrpc"], "2.0", "{message}");
        output = &output[end + 4 + length..];
    }
}
