//! What the page keeps, and what it notices of the world around it.

use std::fs;

use serde_json::json;

use crate::bench;
use crate::browser::{move_slider, settled, work};
use crate::running::Running;
use crate::webdriver::Browser;

/// Moved sliders and weights outlive work that leaves the model as it is; a file that changes is noticed and read; a lab
/// that has ended is told.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn the_page_keeps_what_was_moved_and_notices_what_changes() {
    let folder = bench::folder();
    let lab = Running::start(Some(folder.path()));
    let browser = Browser::start(1280, 900);
    browser.go(&lab.once);
    browser.wait_for("document.body.dataset.ready");
    settled(&browser, 1);

    // A fingerprint changes nothing in the model: the slider stays where the hand has left it.
    move_slider(&browser, "total_inertia", 60);
    let slider =
        || browser.script("return document.getElementById('slider-total_inertia').valueAsNumber");
    let moved = slider();
    browser.click("#tab-design");
    browser.wait_for("document.getElementById('knob-weights-3')");
    let knob = || {
        browser.script("return document.querySelector('#knob-weights-3').closest('.slider').querySelector('[type=number]').valueAsNumber")
    };
    let before = knob();
    let designed = browser.script("return document.body.dataset.designed");
    browser.script(
        "const range = document.getElementById('knob-weights-3'); range.valueAsNumber += 100; \
         range.dispatchEvent(new Event('input', {bubbles: true}))",
    );
    browser.wait_for(&format!("document.body.dataset.designed !== {designed}"));
    let weight = knob();
    assert_ne!(weight, before);
    browser.click("#design-aside");
    browser.click("#tab-why");
    work(&browser, || browser.click("#panel-why button.main"));
    assert_eq!(slider(), moved);
    browser.wait_for("document.querySelector('.slider.moved')");
    browser.click("#tab-design");
    browser.wait_for("document.querySelectorAll('#design-numbers th').length === 3");
    assert_eq!(knob(), weight);

    // bench.toml is edited while the page is open.
    let path = folder.path().join("bench.toml");
    let text = fs::read_to_string(&path).expect("a bench");
    fs::write(&path, text.replace("two logs", "two renamed logs")).expect("written");
    browser.wait_for("document.getElementById('read-anew')");
    assert!(browser.text("#notice").contains("bench.toml"));
    work(&browser, || browser.click("#read-anew"));
    assert!(browser.text("#bench-name").contains("two renamed logs"));
    assert_eq!(
        browser.script("return document.getElementById('notice').hidden"),
        json!(true)
    );

    // The program ends while the page is open.
    drop(lab);
    browser.wait_for("document.getElementById('gone')");
    assert!(browser.text("#notice").contains("flywheel lab"));
    // It is in sight wherever the page is scrolled to.
    browser.script("document.getElementById('tab-sliders').click(); scrollTo(0, 1e6)");
    assert_eq!(
        browser.script(
            "const {top, bottom} = document.getElementById('notice').getBoundingClientRect(); \
             return scrollY > 0 && top >= 0 && bottom <= innerHeight"
        ),
        json!(true)
    );
    // A click says it no second time, and nothing seems to be under way.
    browser.script("document.getElementById('report').click()");
    browser.wait_for("!document.getElementById('report').disabled");
    assert_eq!(
        browser
            .script("return ['message', 'work'].map((id) => document.getElementById(id).hidden)"),
        json!([true, true])
    );
}
