//! A client over an in-memory pipe.

use std::collections::VecDeque;
use std::time::Duration;

use serde_json::{Value, json};
use tokio::io::{
    AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader, DuplexStream, ReadHalf, WriteHalf,
};
use tokio::task::JoinHandle;

/// Timeout of a test: a test that takes longer has lost a message.
const TEST_TIMEOUT: Duration = Duration::from_secs(30);

pub(super) struct Client {
    to: Option<WriteHalf<DuplexStream>>,
    from: BufReader<ReadHalf<DuplexStream>>,
    server: JoinHandle<bool>,
    next_id: i64,
    /// Notifications and responses that were not read yet.
    waiting: VecDeque<Value>,
    /// Answers to requests of the server, by method.
    answers: Vec<(&'static str, Value)>,
    /// Requests of the server that were answered.
    pub(super) asked: Vec<Value>,
}

impl Client {
    /// A server before `initialize`.
    pub(super) fn raw() -> Client {
        let (ours, theirs) = tokio::io::duplex(1 << 16);
        let (from, to) = tokio::io::split(ours);
        let (input, output) = tokio::io::split(theirs);
        Client {
            to: Some(to),
            from: BufReader::new(from),
            server: tokio::spawn(crate::session::server::serve(input, output)),
            next_id: 0,
            waiting: VecDeque::new(),
            answers: Vec::new(),
            asked: Vec::new(),
        }
    }

    /// An initialized server. `params` are those of `initialize`.
    pub(super) async fn start(params: Value) -> Client {
        Client::start_answering(params, Vec::new()).await
    }

    /// As [`Client::start`], for a server that sends requests itself.
    pub(super) async fn start_answering(
        mut params: Value,
        answers: Vec<(&'static str, Value)>,
    ) -> Client {
        let mut client = Client::raw();
        client.answers = answers;
        if params.get("capabilities").is_none() {
            params["capabilities"] = json!({});
        }
        client.ok("initialize", params).await;
        client.notify("initialized", json!({})).await;
        client
    }

    /// Changes the answer to a request of the server.
    pub(super) fn answer(&mut self, method: &'static str, answer: Value) {
        self.answers.retain(|answer| answer.0 != method);
        self.answers.push((method, answer));
    }

    pub(super) async fn send(&mut self, mut message: Value) {
        message["jsonrpc"] = json!("2.0");
        let text = message.to_string();
        let frame = format!("Content-Length: {}\r\n\r\n{text}", text.len());
        let to = self.to.as_mut().expect("the pipe is open");
        to.write_all(frame.as_bytes()).await.expect("the server reads");
    }

    pub(super) async fn notify(&mut self, method: &str, params: Value) {
        self.send(json!({ "method": method, "params": params })).await;
    }

    /// Sends a request without waiting for its answer.
    pub(super) async fn begin(&mut self, method: &str, params: Value) -> i64 {
        self.next_id += 1;
        let id = self.next_id;
        let mut message = json!({ "id": id, "method": method });
        if !params.is_null() {
            message["params"] = params;
        }
        self.send(message).await;
        id
    }

    /// The answer to a request begun before.
    pub(super) async fn end(&mut self, id: i64) -> Result<Value, Value> {
        let answer =
            self.wait(|message| message.get("method").is_none() && message["id"] == id).await;
        match answer.get("error") {
            Some(error) => Err(error.clone()),
            None => Ok(answer["result"].clone()),
        }
    }

    pub(super) async fn request(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        let id = self.begin(method, params).await;
        self.end(id).await
    }

    /// A request that must succeed.
    pub(super) async fn ok(&mut self, method: &str, params: Value) -> Value {
        let answer = self.request(method, params).await;
        answer.unwrap_or_else(|error| panic!("{method} failed: {error}"))
    }

    /// Codes of the diagnostics pulled for a document. Repeats the request if the server requires it.
    pub(super) async fn pulled(&mut self, uri: &str) -> Vec<String> {
        loop {
            match self.request("textDocument/diagnostic", document(uri)).await {
                Ok(report) => return codes(&report["items"]),
                Err(error) => assert_eq!(error["data"]["retriggerRequest"], true, "{error}"),
            }
        }
    }

    /// Parameters of the next notification of a method.
    pub(super) async fn notification(&mut self, method: &str) -> Value {
        self.wait(|message| message["method"] == method).await["params"].clone()
    }

    /// Diagnostics pushed for a document, skipping those of others.
    pub(super) async fn pushed(&mut self, uri: &str) -> Value {
        let published = |message: &Value| {
            message["method"] == "textDocument/publishDiagnostics"
                && message["params"]["uri"] == uri
        };
        self.wait(published).await["params"].clone()
    }

    async fn wait(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        loop {
            if let Some(at) = self.waiting.iter().position(&wanted) {
                return self.waiting.remove(at).expect("it is there");
            }
            let message = self.receive().await.expect("the server goes on");
            self.take(message).await;
        }
    }

    /// Answers a request, and stores other messages.
    async fn take(&mut self, message: Value) {
        if let (Some(method), Some(id)) = (message["method"].as_str(), message.get("id")) {
            let answer = self.answers.iter().find(|answer| answer.0 == method);
            let (_, result) = answer.unwrap_or_else(|| panic!("the server asks {message}"));
            let answer = json!({ "id": id, "result": result });
            self.asked.push(message.clone());
            self.send(answer).await;
        } else {
            self.waiting.push_back(message);
        }
    }

    async fn receive(&mut self) -> Option<Value> {
        let read = async {
            let mut length = 0;
            loop {
                let mut line = String::new();
                if self.from.read_line(&mut line).await.expect("UTF-8 headers") == 0 {
                    return None;
                }
                match line.trim_end().split_once(": ") {
                    Some(("Content-Length", value)) => {
                        length = value.parse().expect("a number");
                    }
                    Some(_) => {}
                    None => break,
                }
            }
            let mut body = vec![0; length];
            self.from.read_exact(&mut body).await.expect("a whole message");
            Some(serde_json::from_slice(&body).expect("JSON"))
        };
        tokio::time::timeout(TEST_TIMEOUT, read).await.expect("a message within the time limit")
    }

    pub(super) async fn open(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "gen", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document })).await;
    }

    pub(super) async fn change(&mut self, uri: &str, version: i32, changes: Value) {
        let params = json!({
            "textDocument": { "uri": uri, "version": version },
            "contentChanges": changes,
        });
        self.notify("textDocument/didChange", params).await;
    }

    /// As [`Client::finish`], but ignores remaining notifications of a method.
    pub(super) async fn finish_ignoring(mut self, method: &str) {
        self.ok("shutdown", Value::Null).await;
        self.notify("exit", Value::Null).await;
        while let Some(message) = self.receive().await {
            // The server may have sent a request that will not be answered.
            let question = message.get("id").is_some() && message.get("method").is_some();
            let expected = question || message["method"] == method;
            assert!(expected, "nobody asked for {message}");
        }
        self.ignore(method);
        assert!(self.waiting.is_empty(), "messages nobody asked for: {:#?}", self.waiting);
        assert!(self.ended().await, "shutdown was said");
    }

    /// Ends the session by the protocol; unread messages fail the test.
    pub(super) async fn finish(mut self) {
        self.ok("shutdown", Value::Null).await;
        self.notify("exit", Value::Null).await;
        while let Some(message) = self.receive().await {
            // The server may have sent a request that will not be answered.
            if message.get("id").is_none() || message.get("method").is_none() {
                self.waiting.push_back(message);
            }
        }
        let left = std::mem::take(&mut self.waiting);
        assert!(left.is_empty(), "messages nobody asked for: {left:#?}");
        assert!(self.ended().await, "shutdown was said");
    }

    /// Waits for the server to end while the pipe is open. Returns true if it received `shutdown`.
    pub(super) async fn ended(&mut self) -> bool {
        tokio::time::timeout(TEST_TIMEOUT, &mut self.server)
            .await
            .expect("the server ends")
            .expect("the server does not panic")
    }

    /// Closes the client's end of the pipe.
    pub(super) async fn disconnect(&mut self) {
        if let Some(mut to) = self.to.take() {
            to.shutdown().await.expect("the pipe closes");
        }
    }

    /// Messages that were not read yet.
    pub(super) fn all(&self) -> impl Iterator<Item = &Value> {
        self.waiting.iter()
    }

    /// Drops messages that do not matter to a test.
    pub(super) fn ignore(&mut self, method: &str) {
        self.waiting.retain(|waiting| waiting["method"] != method);
    }
}

/// `{ "textDocument": { "uri": … } }`
pub(super) fn document(uri: &str) -> Value {
    json!({ "textDocument": { "uri": uri } })
}

/// Capabilities of a client that pulls diagnostics, so that none are pushed.
pub(super) fn pulling() -> Value {
    json!({ "textDocument": { "diagnostic": {} } })
}

/// A directory with files.
pub(super) struct Folder {
    directory: tempfile::TempDir,
}

impl Folder {
    pub(super) fn new(files: &[(&str, &str)]) -> Folder {
        let directory =
            tempfile::Builder::new().prefix("a workspace é").tempdir().expect("a directory");
        let folder = Folder { directory };
        for (name, text) in files {
            folder.write(name, text);
        }
        folder
    }

    pub(super) fn write(&self, name: &str, text: &str) {
        self.write_bytes(name, text.as_bytes());
    }

    pub(super) fn write_bytes(&self, name: &str, text: &[u8]) {
        let path = self.directory.path().join(name);
        let parent = path.parent().expect("it has one");
        std::fs::create_dir_all(parent).expect("a directory");
        std::fs::write(path, text).expect("a file");
    }

    pub(super) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.directory.path().join(name)).expect("it is there")
    }

    pub(super) fn exists(&self, name: &str) -> bool {
        self.directory.path().join(name).exists()
    }

    pub(super) fn remove(&self, name: &str) {
        std::fs::remove_file(self.directory.path().join(name)).expect("it is there");
    }

    /// The URI of a file; of the folder itself for an empty name.
    pub(super) fn uri(&self, name: &str) -> String {
        let root = self.directory.path().canonicalize().expect("it is there");
        let path = match name {
            "" => root,
            _ => root.join(name),
        };
        let uri = crate::protocol::types::Uri::from_file_path(path).expect("absolute");
        uri.as_str().to_owned()
    }

    /// Parameters of `initialize` for this folder.
    pub(super) fn params(&self, capabilities: Value) -> Value {
        json!({
            "capabilities": capabilities,
            "workspaceFolders": [{ "uri": self.uri(""), "name": "test" }],
        })
    }

    /// A change on the disk: 1 created, 2 changed, 3 deleted.
    pub(super) fn event(&self, name: &str, kind: u8) -> Value {
        json!({ "changes": [{ "uri": self.uri(name), "type": kind }] })
    }
}

/// Codes of a list of diagnostics.
pub(super) fn codes(diagnostics: &Value) -> Vec<String> {
    let code = |json: &Value| json["code"].as_str().expect("a code").to_owned();
    diagnostics.as_array().expect("a list").iter().map(code).collect()
}
