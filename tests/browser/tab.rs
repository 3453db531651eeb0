//! One tab: commands, and what happened in it.

use serde_json::{Value, json};
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket, connect};

/// Longest time for an answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// What is told of a tab.
const DOMAINS: [&str; 4] = ["Page", "Runtime", "Log", "Network"];

/// A tab and its events since it was opened.
pub struct Tab {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: Option<String>,
    last: u64,
    events: Vec<Value>,
}

impl Tab {
    pub fn open(browser: &str) -> Self {
        let mut tab = Self::connected(browser);
        let target = tab.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        let session = tab.call("Target.attachToTarget", attach);
        tab.session = session["sessionId"].as_str().map(str::to_owned);
        for domain in DOMAINS {
            tab.call(&format!("{domain}.enable"), json!({}));
        }
        tab
    }

    /// Ask the browser to end.
    pub fn close_browser(browser: &str) {
        let mut tab = Self::connected(browser);
        let close = json!({"id": 1, "method": "Browser.close"});
        let _ = tab.socket.send(Message::text(close.to_string()));
        let _ = tab.socket.read();
    }

    fn connected(browser: &str) -> Self {
        let (socket, _) = connect(browser).unwrap();
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
        }
        Self { socket, session: None, last: 0, events: vec![] }
    }

    /// Run a command of the protocol and return its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({"id": self.last, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let answer = self.read();
            if answer["id"] == json!(self.last) {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
        }
    }

    /// The next message; events are kept.
    fn read(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                let message: Value = serde_json::from_str(&text).unwrap();
                if message["method"].is_string() {
                    self.events.push(message.clone());
                }
                return message;
            }
        }
    }

    /// Load a file, from scratch, and wait until it is there.
    pub fn load(&mut self, file: &Path) {
        self.events.clear();
        let went = self.call("Page.navigate", json!({"url": url(file)}));
        assert!(went["errorText"].is_null(), "{went}");
        let loaded = |e: &Value| e["method"] == "Page.loadEventFired";
        while !self.events.iter().any(loaded) {
            self.read();
        }
    }

    /// The value of an expression in the page.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let how = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let answer = self.call("Runtime.evaluate", how);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Errors on the console, exceptions, and requests for anything but `file`.
    pub fn troubles(&mut self, file: &Path) -> Vec<String> {
        // What has happened so far is told before the answer.
        self.evaluate("0");
        let page = url(file);
        let trouble = |event: &Value| {
            let p = &event["params"];
            match event["method"].as_str().unwrap_or_default() {
                "Runtime.consoleAPICalled"
                    if ["error", "warning", "assert"].iter().any(|k| p["type"] == *k) =>
                {
                    Some(format!("console: {}", p["args"]))
                }
                "Runtime.exceptionThrown" => Some(format!("exception: {}", p["exceptionDetails"])),
                "Log.entryAdded" if p["entry"]["level"] == "error" => {
                    Some(format!("log: {}", p["entry"]["text"]))
                }
                "Network.requestWillBeSent" if p["request"]["url"] != page => {
                    Some(format!("request: {}", p["request"]["url"]))
                }
                _ => None,
            }
        };
        self.events.iter().filter_map(trouble).collect()
    }
}

/// The address of a file whose path has only signs that stand for themselves.
fn url(file: &Path) -> String {
    format!("file://{}", file.display())
}
