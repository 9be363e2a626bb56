//! The page in a real browser, as a user goes through it.

use std::fs;

use serde_json::{Value, json};

use crate::bench;
use crate::magnet;
use crate::running::Running;
use crate::webdriver::Browser;

/// Waits until the page shows the state after the work under way.
pub fn settled(browser: &Browser, ready: u64) {
    browser.wait_for(&format!(
        "document.body.dataset.working === 'no' && Number(document.body.dataset.ready) >= {ready} \
         && document.body.dataset.drawn"
    ));
}

fn ready(browser: &Browser) -> u64 {
    let count = browser.script("return Number(document.body.dataset.ready ?? 0)");
    count.as_u64().expect("a count")
}

/// Does something that begins work, and waits for its end.
pub fn work(browser: &Browser, act: impl FnOnce()) {
    let before = ready(browser);
    act();
    settled(browser, before + 1);
}

/// The RMSE that the page shows for a series, SI units.
fn rmse(browser: &Browser, experiment: &str, channel: &str) -> f64 {
    let found = browser.script(&format!(
        "return [...document.querySelectorAll('#errors tbody tr')].filter((row) => \
         row.cells[0].textContent === {experiment} && row.cells[1].textContent === {channel}) \
         .map((row) => Number(row.cells[2].dataset.rmse))[0]",
        experiment = json!(experiment),
        channel = json!(channel),
    ));
    found.as_f64().expect("an error")
}

fn stairs(browser: &Browser) -> Value {
    browser.script("return document.getElementById('staircase').data[0].y.length")
}

/// Moves a slider as a hand does, and gives the time in ms until the curves are drawn anew.
pub fn move_slider(browser: &Browser, name: &str, step: i64) -> f64 {
    let milliseconds = browser.script_until_called(&format!(
        "const done = arguments[0]; const range = document.getElementById('slider-{name}'); \
         const before = document.body.dataset.drawn; const begun = performance.now(); \
         range.valueAsNumber += {step}; range.dispatchEvent(new Event('input', {{bubbles: true}})); \
         const look = () => document.body.dataset.drawn === before ? requestAnimationFrame(look) \
         : done(performance.now() - begun); look();"
    ));
    milliseconds.as_f64().expect("a time")
}

/// Open, move a slider, diagnose, add the hidden effect, take it back, reload.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn from_opening_to_the_missing_effect() {
    let folder = bench::folder();
    let lab = Running::start(None);
    let browser = Browser::start(1280, 900);
    // As the desktop opens it: by the owner's file.
    browser.go(&format!("file://{}", lab.door.display()));
    browser.wait_for("document.getElementById('bench-path')");
    browser.type_into("#bench-path", &folder.path().display().to_string());
    work(&browser, || browser.click("#opening form button"));
    // Who works with the keyboard goes on at the tabs, and not at the top of the page.
    let focus = || browser.script("return document.activeElement.id");
    assert_eq!(focus(), json!("tab-sliders"));

    // A slider changes the picture and the numbers, and nothing in the folder.
    let model = || fs::read_to_string(folder.path().join("model.toml")).expect("a model");
    let written = model();
    let before = rmse(&browser, "swing", "angle");
    move_slider(&browser, "total_inertia", 60);
    assert!(rmse(&browser, "swing", "angle") > 1.5 * before);
    browser.click("#slider-reset");
    browser.wait_for("!document.querySelector('.slider.moved')");
    browser.wait_for("document.querySelectorAll('#errors th').length === 6");
    assert_eq!(rmse(&browser, "swing", "angle"), before);
    assert_eq!(model(), written);

    // Why? The button that asks goes with its panel; the focus stays with what it has opened.
    work(&browser, || browser.click("#ask-why"));
    assert_eq!(focus(), json!("tab-why"));
    assert!(browser.text("#verdict").contains("body-coulomb-friction"));
    assert_eq!(stairs(&browser), json!(1));
    work(&browser, || browser.click("#panel-why button.main"));
    assert!(rmse(&browser, "swing", "angle") < 0.5 * before);
    assert_eq!(stairs(&browser), json!(2));
    assert!(model().contains("body-coulomb-friction"));

    // What was kept is there after a reload; it can be taken back.
    browser.reload();
    settled(&browser, 1);
    assert!(rmse(&browser, "swing", "angle") < 0.5 * before);
    browser.click("#tab-why");
    assert!(
        browser
            .text("#model-effects")
            .contains("body-coulomb-friction")
    );
    work(&browser, || browser.click("#undo"));
    assert!((rmse(&browser, "swing", "angle") / before - 1.0).abs() < 1e-3);
    assert_eq!(stairs(&browser), json!(1));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A bench that cannot be read gets its message, with file, line and column; names are text.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn messages_and_names_are_text() {
    let place = tempfile::tempdir().expect("a folder");
    let (broken, named) = (place.path().join("broken"), place.path().join("named"));
    bench::write(&broken, |text| text.replace("free-swing\"", "freeswing\""));
    bench::write(&named, |text| {
        text.replace(
            "name = \"swing\"",
            "name = \"<img src=x onerror=document.hurt=1>\"",
        )
    });
    let lab = Running::start(None);
    let browser = Browser::start(820, 1100);
    browser.go(&lab.once);
    browser.wait_for("document.getElementById('bench-path')");
    let open = |path: &std::path::Path| {
        browser.script("document.getElementById('bench-path').value = ''");
        browser.type_into("#bench-path", &path.display().to_string());
        browser.click("#opening form button");
    };
    open(&broken);
    browser.wait_for("!document.getElementById('message').hidden");
    let message = browser.text("#message-text");
    assert!(
        message.contains("bench.toml:") && message.contains("freeswing"),
        "{message}"
    );
    browser.wait_for("document.body.dataset.working === 'no'");
    open(&named);
    settled(&browser, 1);
    browser.click("#tab-why");
    assert!(
        browser
            .text("#experiments")
            .contains("<img src=x onerror=document.hurt=1>")
    );
    assert_eq!(
        browser.script("return [document.hurt ?? null, document.images.length]"),
        json!([null, 0])
    );
    // Nothing is wider than a tablet.
    assert_eq!(
        browser.script("return document.documentElement.scrollWidth <= innerWidth"),
        json!(true)
    );
}

/// CSV files are chosen, the proposal is corrected by typing, and the folder is written on a click.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn logs_become_a_bench() {
    let place = bench::folder();
    let logs = ["spin-up-0.4A.csv", "free-swing-20deg.csv"].map(|name| place.path().join(name));
    let folder = place.path().join("mine");
    let lab = Running::start(None);
    let browser = Browser::start(1280, 900);
    browser.go(&lab.once);
    browser.wait_for("document.getElementById('drop-files')");
    let paths = logs.map(|path| path.display().to_string()).join("\n");
    browser.type_into("#drop-files", &paths);
    browser.wait_for("document.getElementById('bench-text')");
    browser.script(
        "const text = document.getElementById('bench-text'); \
         const known = '[known]\\ntorque_constant = 0.033\\ngravity_torque = 0.238383\\n'; \
         text.value = text.value.replace(/^\\[known\\].*$/m, known); text.dispatchEvent(new Event('input'))",
    );
    browser.script("document.getElementById('new-folder').value = ''");
    browser.type_into("#new-folder", &folder.display().to_string());
    work(&browser, || browser.click("#make-bench"));
    assert!(folder.join("bench.toml").is_file());
    assert!(rmse(&browser, "free-swing-20deg", "angle") > 0.0);
}

/// Noise of the angle in the bench with a magnet, see `magnet`.
const NOISE_RAD: f64 = 1.2e-3;

/// What no effect explains is drawn; it is learned as a curve, and an effect of one's own takes its place. The
/// editor says what is wrong while one types.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn what_no_effect_explains() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in magnet::files() {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    let lab = Running::start(Some(folder.path()));
    let browser = Browser::start(1280, 900);
    browser.go(&lab.once);
    browser.wait_for("document.body.dataset.ready");
    settled(&browser, 1);
    let error = || rmse(&browser, "swing 20 deg", "angle");
    let before = error();
    assert!(before > 2.0 * NOISE_RAD, "{before}");
    browser.click("#tab-why");
    work(&browser, || browser.click("#panel-why button.main"));
    browser.wait_for("document.getElementById('missing-torque')?.data?.length === 3");
    assert!(
        browser
            .text("#verdict")
            .contains("learned curve can be added")
    );
    work(&browser, || browser.click("#add-learned"));
    assert!(error() < 1.5 * NOISE_RAD, "{before} {}", error());
    let model = || fs::read_to_string(folder.path().join("model.toml")).expect("a model");
    assert!(model().contains("[learned.angle]"));
    work(&browser, || browser.click("#undo"));
    assert!(!model().contains("[learned.angle]"));

    // An effect of one's own: the editor begins with one that can be read, and names what cannot.
    browser.click("#write-own");
    browser.wait_for("document.getElementById('own-says').className.includes('good')");
    browser.script(
        "const text = document.getElementById('own-text'); text.value = text.value.replace('exp(', 'expp('); \
         text.dispatchEvent(new Event('input'))",
    );
    browser.wait_for("document.getElementById('own-says').className.includes('bad')");
    let says = browser.text("#own-says");
    assert!(says.contains("line 2, column"), "{says}");
    assert_eq!(
        browser.script("return document.getElementById('own-add').disabled"),
        json!(true)
    );
    browser.script(
        "const text = document.getElementById('own-text'); text.value = text.value.replace('expp(', 'exp('); \
         text.dispatchEvent(new Event('input'))",
    );
    browser.wait_for("!document.getElementById('own-add').disabled");
    work(&browser, || browser.click("#own-add"));
    assert!(folder.path().join("effects/mine.toml").is_file());
    assert!(error() < 1.5 * NOISE_RAD, "{before} {}", error());
    assert!(browser.text("#model-effects").contains("own:mine"));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
