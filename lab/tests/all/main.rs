//! The lab from outside: requests over TCP, and the page in a browser.

mod bench;
mod browser;
mod browser_design;
mod drop;
mod hostile;
mod http;
mod report;
mod running;
mod tasks;
mod webdriver;
