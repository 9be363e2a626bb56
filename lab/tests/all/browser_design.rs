//! The design desk, the emitted source and the proof in a real browser.

use std::fs;

use serde_json::json;

use crate::browser::{settled, work};
use crate::running::Running;
use crate::webdriver::Browser;

/// Weights are moved, a design is set aside, excursions take the place of weights, and the controller is generated; its
/// proof fills claim by claim. On a tablet.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn a_design_is_moved_compared_generated_and_proved() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in demo::FILES {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    let lab = Running::start(Some(folder.path()));
    let browser = Browser::start(820, 1100);
    browser.go(&lab.once);
    settled(&browser, 1);
    browser.click("#tab-design");
    browser.wait_for("document.getElementById('knob-weights-3')");
    assert!(browser.text("#design-numbers").contains("Phase margin"));
    let gain = |column: u32| {
        browser.script(&format!(
            "return Number(document.querySelector('#design-numbers tbody tr').cells[{column}].textContent.split(',')[0])"
        ))
    };
    let before = gain(1).as_f64().expect("a gain");
    // A screen reader goes by heads of tables, none of which is empty, and by headings, none of which leaves a level out.
    assert_eq!(
        browser.script(
            "const seen = (one) => one.offsetParent !== null; \
             const levels = [...document.querySelectorAll('h1, h2, h3')].filter(seen).map((one) => Number(one.tagName[1])); \
             return [[...document.querySelectorAll('th')].filter((one) => seen(one) && !one.textContent).length, \
                     levels.filter((level, index) => level > (index ? levels[index - 1] : 0) + 1).length]"
        ),
        json!([0, 0])
    );
    browser.click("#design-aside");
    browser.wait_for("document.querySelectorAll('#design-numbers th').length === 3");
    // A dearer current: a gentler loop; the design that was set aside stays.
    browser.script(
        "const range = document.getElementById('knob-weights-3'); range.valueAsNumber += 100; \
         range.dispatchEvent(new Event('input', {bubbles: true}))",
    );
    browser.wait_for(&format!(
        "Math.abs(Number(document.querySelector('#design-numbers tbody tr').cells[1].textContent.split(',')[0])) < 0.99 * {}",
        before.abs()
    ));
    assert_eq!(gain(2).as_f64(), Some(before));
    // Every figure is drawn when it is scrolled to.
    for index in 0..6 {
        browser.script(&format!(
            "document.querySelectorAll('.plots .plot')[{index}].scrollIntoView()"
        ));
        browser.wait_for(&format!("document.querySelectorAll('.plots .plot')[{index}].querySelector('.trace, .scatterlayer path')"));
    }
    browser.script("document.getElementById('by-excursions').click()");
    browser.wait_for("document.getElementById('knob-excursions-0')");
    assert_eq!(
        browser.script("return document.documentElement.scrollWidth <= innerWidth"),
        json!(true)
    );
    browser.script("scrollTo(0, 0)");
    work(&browser, || {
        browser.script("document.getElementById('design-generate').click()");
    });
    browser.wait_for("document.getElementById('source').textContent.includes('pub fn control')");
    browser.script("document.getElementById('prove').click()");
    browser.wait_for("document.querySelectorAll('#claims tr[data-result]').length >= 3");
    assert_eq!(
        browser.script("return document.querySelectorAll('#claims tr[data-result=failed]').length"),
        json!(0)
    );
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
