//! As much of WebDriver (W3C) as the tests need: chromedriver, one headless chromium.

use std::io::{BufRead, BufReader, Lines};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::http::{PATIENCE, send};

/// A browser; ends with this value.
pub struct Browser {
    driver: Child,
    /// Kept open: the driver may write to it.
    _output: Lines<BufReader<ChildStdout>>,
    port: u16,
    session: String,
}

/// Starts chromedriver on a port that the system chooses, and gives it with that port. The driver then asks for the
/// same port a second time, for IPv6, and ends where another program has it: it is started anew, with another port.
fn start_driver() -> (Child, Lines<BufReader<ChildStdout>>, u16) {
    const TRIES: usize = 5;
    let mut said = String::new();
    for _ in 0..TRIES {
        let mut driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver");
        let mut output = BufReader::new(driver.stdout.take().expect("its output")).lines();
        for line in output.by_ref().map_while(Result::ok) {
            let port = line.split("started successfully on port ").nth(1);
            if let Some(port) = port.and_then(|rest| rest.trim_end_matches('.').parse().ok()) {
                return (driver, output, port);
            }
            said.push_str(&line);
            said.push('\n');
        }
        let ended = driver.wait().expect("how the driver ended");
        said.push_str(&format!("{ended}\n"));
    }
    panic!("chromedriver started none of {TRIES} times:\n{said}")
}

/// The key of an element in WebDriver's JSON.
const ELEMENT: &str = "element-6066-11e4-a52e-4f735466cecf";

impl Browser {
    /// Starts chromedriver and a window of this size.
    pub fn start(width: u32, height: u32) -> Browser {
        let (driver, output, port) = start_driver();
        let mut browser = Browser {
            driver,
            _output: output,
            port,
            session: String::new(),
        };
        let size = format!("--window-size={width},{height}");
        // Tests may run as root, in a container with little shared memory.
        let arguments = [
            "--headless=new",
            "--no-sandbox",
            "--disable-dev-shm-usage",
            "--disable-gpu",
            &size,
        ];
        let milliseconds = 1000 * PATIENCE.as_secs();
        let wanted = json!({"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": {"args": arguments},
            "goog:loggingPrefs": {"browser": "ALL"},
            "timeouts": {"script": milliseconds, "pageLoad": milliseconds},
        }}});
        let begun = browser.send("POST", "/session", &wanted);
        browser.session = begun["sessionId"].as_str().expect("a session").to_owned();
        browser
    }

    fn send(&self, method: &str, path: &str, body: &Value) -> Value {
        let host = format!("127.0.0.1:{}", self.port);
        let body = if method == "POST" {
            body.to_string()
        } else {
            String::new()
        };
        let headers = [
            ("Host", host.as_str()),
            ("Content-Type", "application/json"),
        ];
        let answer = send(self.port, method, path, &headers, &body);
        assert_eq!(answer.status, 200, "{method} {path}: {}", answer.body);
        answer.json()["value"].clone()
    }

    fn command(&self, method: &str, path: &str, body: &Value) -> Value {
        self.send(method, &format!("/session/{}{path}", self.session), body)
    }

    /// Opens an address.
    pub fn go(&self, address: &str) {
        self.command("POST", "/url", &json!({"url": address}));
    }

    /// Loads the page anew.
    pub fn reload(&self) {
        self.command("POST", "/refresh", &json!({}));
    }

    /// Runs a script in the page and gives what it returns.
    pub fn script(&self, script: &str) -> Value {
        self.command(
            "POST",
            "/execute/sync",
            &json!({"script": script, "args": []}),
        )
    }

    /// Runs a script that ends when it calls `arguments[0]`, and gives what it is called with.
    pub fn script_until_called(&self, script: &str) -> Value {
        self.command(
            "POST",
            "/execute/async",
            &json!({"script": script, "args": []}),
        )
    }

    /// Waits until a script returns true.
    pub fn wait_for(&self, condition: &str) {
        let begun = Instant::now();
        while self.script(&format!("return Boolean({condition})")) != json!(true) {
            let message = || self.script("return document.body.innerText.slice(0, 2000)");
            assert!(begun.elapsed() < PATIENCE, "{condition}\n{}", message());
            thread::sleep(Duration::from_millis(30));
        }
    }

    fn find(&self, css: &str) -> String {
        let found = self.command(
            "POST",
            "/element",
            &json!({"using": "css selector", "value": css}),
        );
        found[ELEMENT].as_str().expect("an element").to_owned()
    }

    /// Clicks an element as a user would: it must be there, seen and not covered.
    pub fn click(&self, css: &str) {
        let element = self.find(css);
        self.command("POST", &format!("/element/{element}/click"), &json!({}));
    }

    /// Clicks the middle of an element twice, as quickly as a double click.
    pub fn double_click(&self, css: &str) {
        let element = self.find(css);
        let button = |kind: &str| json!({"type": kind, "button": 0});
        let click = ["pointerDown", "pointerUp", "pointerDown", "pointerUp"].map(button);
        let mut actions = vec![json!({
            "type": "pointerMove", "duration": 0, "x": 0, "y": 0, "origin": {ELEMENT: element},
        })];
        actions.extend(click);
        let mouse = json!({"type": "pointer", "id": "mouse", "actions": actions});
        self.command("POST", "/actions", &json!({"actions": [mouse]}));
    }

    /// Types into an element.
    pub fn type_into(&self, css: &str, text: &str) {
        let element = self.find(css);
        self.command(
            "POST",
            &format!("/element/{element}/value"),
            &json!({"text": text}),
        );
    }

    /// The text of an element.
    pub fn text(&self, css: &str) -> String {
        let element = self.find(css);
        let text = self.command("GET", &format!("/element/{element}/text"), &Value::Null);
        text.as_str().expect("a text").to_owned()
    }

    /// What the page has complained of to the console.
    pub fn complaints(&self) -> Vec<String> {
        let log = self.command("POST", "/se/log", &json!({"type": "browser"}));
        let entries = log.as_array().cloned().unwrap_or_default();
        let severe = entries.iter().filter(|entry| entry["level"] == "SEVERE");
        severe.map(|entry| entry["message"].to_string()).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        if !self.session.is_empty() {
            let host = format!("127.0.0.1:{}", self.port);
            let path = format!("/session/{}", self.session);
            // The browser goes with its session, also where a test has failed.
            let _ = std::panic::catch_unwind(|| {
                send(self.port, "DELETE", &path, &[("Host", &host)], "")
            });
        }
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
