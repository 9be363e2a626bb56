//! Dropped files in a real browser: what cannot be read yet, and logs for the bench that is open.

use std::fs;

use serde_json::json;

use crate::bench;
use crate::browser::{settled, work};
use crate::running::Running;
use crate::webdriver::Browser;

/// Whether a button of the page can be clicked.
fn is_enabled(browser: &Browser, id: &str) -> bool {
    browser.script(&format!("return !document.getElementById('{id}').disabled")) == json!(true)
}

/// What cannot be read yet is not written, and nothing is promised about it. A file that is none is left out, a column is
/// chosen, and the log is added to the bench that is open, from the card that names the next experiment or from the top.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn logs_are_mended_and_added_to_the_open_bench() {
    let folder = bench::folder();
    let place = tempfile::tempdir().expect("a folder");
    // A column whose name says nothing, and a file that is no table.
    let text = fs::read_to_string(folder.path().join("free-swing-20deg.csv")).expect("a log");
    let (head, rest) = text.split_once('\n').expect("lines");
    let head = head.replace("angle_rad", "x1").replace("rate_rad_s", "x2");
    let logs = ["unnamed.csv", "bad.csv"].map(|name| place.path().join(name));
    fs::write(&logs[0], format!("{head}\n{rest}")).expect("written");
    fs::write(&logs[1], "t,a\n0,1\n1\n").expect("written");

    let lab = Running::start(Some(folder.path()));
    let browser = Browser::start(820, 1100);
    browser.go(&lab.once);
    browser.wait_for("document.body.dataset.ready");
    settled(&browser, 1);
    browser.click("#open-other");
    browser.wait_for("document.getElementById('drop-files')");
    // The report and undo are of the bench that is not seen now.
    assert_eq!(
        browser.script("return ['report', 'undo'].map((id) => document.getElementById(id).hidden)"),
        json!([true, true])
    );
    let paths = logs.map(|path| path.display().to_string()).join("\n");
    browser.type_into("#drop-files", &paths);
    browser.wait_for("document.getElementById('drop-failure')");
    assert!(browser.text("#drop-failure").contains("bad.csv:3"));
    browser.click("#dropped [aria-label='Leave it out: bad.csv']");
    browser.wait_for("document.getElementById('make-bench')");
    browser.wait_for("document.getElementById('open-questions').textContent");
    assert!(!is_enabled(&browser, "make-bench") && !is_enabled(&browser, "add-logs"));
    let panel = browser.text("#dropped");
    assert!(panel.contains("No column is chosen"), "{panel}");
    assert!(!panel.contains("every parameter"), "{panel}");
    assert_eq!(
        browser.script("return document.documentElement.scrollWidth <= innerWidth"),
        json!(true)
    );

    browser.script(
        "const choice = document.querySelector('[data-focus=\"unnamed.csv:angle-column\"]'); \
         choice.value = 'x1'; choice.dispatchEvent(new Event('change'))",
    );
    browser.wait_for("document.querySelector('.preview .scatterlayer path')");
    browser.script("document.querySelectorAll('.question input').forEach((box) => box.click())");
    browser.wait_for("!document.getElementById('add-logs').disabled");
    assert!(is_enabled(&browser, "make-bench"));
    // Two constants in quick succession: nothing is written before both are in the text, and what is half typed stays.
    let enabled_meanwhile = browser.script(
        "for (const [key, value] of [['gravity', 9.81], ['body_mass', 0.25]]) { \
           const field = document.getElementById(`known-${key}`); \
           field.value = value; field.dispatchEvent(new Event('change')); } \
         const half = document.getElementById('known-wheel_mass'); half.focus(); half.value = '0.1'; \
         return !document.getElementById('make-bench').disabled",
    );
    assert_eq!(enabled_meanwhile, json!(false));
    browser.wait_for("!document.getElementById('make-bench').disabled");
    let text = browser.script("return document.getElementById('bench-text').value");
    let text = text.as_str().expect("a text");
    assert!(
        text.contains("\ngravity         = 9.81") && text.contains("\nbody_mass       = 0.25"),
        "{text}"
    );
    assert_eq!(
        browser.script("return document.getElementById('known-wheel_mass').value"),
        json!("0.1")
    );
    work(&browser, || {
        browser.script("document.getElementById('add-logs').click()");
    });
    assert!(browser.text("#experiments").contains("unnamed"));
    let written = fs::read_to_string(folder.path().join("bench.toml")).expect("a bench");
    assert!(written.contains("file = \"unnamed.csv\""), "{written}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
