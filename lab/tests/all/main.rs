//! The lab from outside: requests over TCP, and the page in a browser.

mod bench;
mod browser;
mod browser_curves;
mod browser_design;
mod browser_drop;
mod browser_latency;
mod browser_states;
mod drop;
mod hostile;
mod http;
#[path = "../../../workbench/tests/all/magnet.rs"]
mod magnet;
mod report;
mod running;
mod tasks;
mod webdriver;
