//! A lab that runs in a thread, and a browser's part of the talk with it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use lab::{Lab, LabSettings};
use serde_json::Value;

use crate::http::{Answer, PATIENCE, send};

/// A lab; ends with this value.
pub struct Running {
    pub port: u16,
    pub door: std::path::PathBuf,
    /// The address that lets in once.
    pub once: String,
    /// `name=value`; empty until [`Running::enter`].
    pub cookie: String,
    ended: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Running {
    /// Starts a lab, with this bench or with none.
    pub fn start(bench: Option<&Path>) -> Running {
        let settings = LabSettings {
            bench: bench.map(Path::to_path_buf),
            port: None,
        };
        let lab = Lab::start(&settings).expect("a lab");
        let address = lab.address();
        let port = address
            .rsplit(':')
            .next()
            .and_then(|port| port.parse().ok());
        let (door, once) = (lab.door().to_path_buf(), lab.one_time_address());
        let ended = Arc::new(AtomicBool::new(false));
        let end = ended.clone();
        let thread =
            thread::spawn(move || lab.run(&|| end.load(Ordering::Relaxed)).expect("a run"));
        Running {
            port: port.expect("a port"),
            door,
            once,
            cookie: String::new(),
            ended,
            thread: Some(thread),
        }
    }

    /// As [`Running::start`], let in by the one-time address.
    pub fn entered(bench: Option<&Path>) -> Running {
        let mut lab = Running::start(bench);
        let path = lab
            .once
            .split_once(&lab.port.to_string())
            .expect("a path")
            .1;
        let answer = send(lab.port, "GET", path, &[("Host", &lab.host())], "");
        assert_eq!(answer.status, 200, "{answer:?}");
        lab.cookie = cookie_of(&answer);
        lab
    }

    pub fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// A request as the page sends it.
    pub fn ask(&self, method: &str, path: &str, body: &str) -> Answer {
        let host = self.host();
        let origin = format!("http://{host}");
        let headers = [
            ("Host", host.as_str()),
            ("Origin", &origin),
            ("Cookie", &self.cookie),
            ("Content-Type", "application/json"),
        ];
        send(self.port, method, path, &headers, body)
    }

    /// The state, once no work is under way.
    pub fn settled(&self) -> Value {
        let begun = Instant::now();
        loop {
            let state = self.ask("GET", "/api/state", "").json();
            if state["running"].is_null() {
                return state;
            }
            assert!(begun.elapsed() < PATIENCE, "{state}");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Begins a task and waits for its end.
    pub fn work(&self, task: &Value) -> Value {
        self.settled();
        let answer = self.ask("POST", "/api/work", &task.to_string());
        assert_eq!(answer.status, 202, "{task}: {answer:?}");
        self.settled()
    }
}

/// The cookie that an answer sets.
pub fn cookie_of(answer: &Answer) -> String {
    let header = answer.header("set-cookie").expect("a cookie");
    header.split(';').next().expect("a pair").to_owned()
}

impl Drop for Running {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // What went wrong in it is shown by the test's own failure.
            let _ = thread.join();
        }
    }
}
