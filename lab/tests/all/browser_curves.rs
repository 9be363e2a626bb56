//! The curves of the page: what is marked on them, and how they follow a hand.

use std::fmt::Write;
use std::fs;

use serde_json::json;

use crate::bench;
use crate::browser::{move_slider, settled, work};
use crate::running::Running;
use crate::webdriver::Browser;

/// A logger that loses samples: the page marks them on the time axis and says how many they are.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn lost_samples_are_marked_on_the_time_axis() {
    let folder = bench::folder();
    let path = folder.path().join("free-swing-20deg.csv");
    let text = fs::read_to_string(&path).expect("a log");
    let mut times: Vec<f64> = Vec::new();
    let mut changed = String::new();
    for (number, line) in text.lines().enumerate() {
        let mut cells: Vec<&str> = line.split(',').collect();
        // The sensor says half a turn for one sample: no pendulum moves like that.
        if number == 500 || number == 1200 {
            times.push(cells[0].parse().expect("a time"));
            cells[1] = "3.1";
        }
        let _ = writeln!(changed, "{}", cells.join(","));
    }
    fs::write(&path, changed).expect("written");
    let lab = Running::start(Some(folder.path()));
    let browser = Browser::start(1280, 900);
    browser.go(&lab.once);
    browser.wait_for("document.body.dataset.ready");
    settled(&browser, 1);
    browser.script(
        "[...document.querySelectorAll('#experiments button')].find((one) => one.textContent.startsWith('swing')).click()",
    );
    browser.wait_for("document.getElementById('lost').textContent");
    let says = browser.text("#lost");
    assert!(
        says.contains("angle: 2 of ") && says.contains("2 places"),
        "{says}"
    );
    // Ticks on the axis: from the sample before to the one after.
    let ticks = browser.script(
        "return document.getElementById('curves').layout.shapes.filter((one) => one.y0 === 0 && one.y1 < 0.1) \
         .map((one) => [one.x0, one.x1])",
    );
    let ticks: Vec<[f64; 2]> = serde_json::from_value(ticks).expect("pairs of times");
    assert_eq!(ticks.len(), 2, "{ticks:?}");
    for time in times {
        assert!(
            ticks.iter().any(|[from, to]| *from < time && time < *to),
            "{time} {ticks:?}"
        );
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// While a hand moves a slider only the shown experiment follows; when the hand rests, the errors of all are those of
/// the moved parameters. Back again, everything is as it was.
#[test]
#[cfg_attr(not(have_chromium), ignore = "needs chromium")]
fn the_other_experiments_follow_when_the_hand_rests() {
    let folder = bench::folder();
    let lab = Running::start(Some(folder.path()));
    let browser = Browser::start(1280, 900);
    browser.go(&lab.once);
    browser.wait_for("document.body.dataset.ready");
    settled(&browser, 1);
    let errors = || {
        browser.script(
            "return [...document.querySelectorAll('#errors tbody tr')].map((row) => Number(row.cells[2].dataset.rmse))",
        )
    };
    let before: Vec<f64> = serde_json::from_value(errors()).expect("errors");
    // The motor drives the spin-up alone: the wheel of the swing is locked.
    move_slider(&browser, "torque_constant", 80);
    browser.wait_for("document.querySelectorAll('#errors tr.stale').length === 0");
    let after: Vec<f64> = serde_json::from_value(errors()).expect("errors");
    let series = browser.script(
        "return [...document.querySelectorAll('#errors tbody tr')].map((row) => row.cells[0].textContent)",
    );
    for ((name, before), after) in series
        .as_array()
        .expect("names")
        .iter()
        .zip(&before)
        .zip(&after)
    {
        let moved = (after / before - 1.0).abs() > 0.1;
        assert_eq!(moved, name == "spin-up", "{name}: {before} {after}");
    }
    browser.click("#slider-reset");
    browser.wait_for("!document.querySelector('.slider.moved')");
    browser.wait_for("document.querySelectorAll('#errors th').length === 6");
    let again: Vec<f64> = serde_json::from_value(errors()).expect("errors");
    assert_eq!(again, before);
    // The keyboard's way over the time axis: half of it, a quarter of that further, and all of it again.
    let view = || {
        let range = "return document.getElementById('curves').layout.xaxis.range.map(Number)";
        serde_json::from_value::<[f64; 2]>(browser.script(range)).expect("a range")
    };
    let press = |key: &str| {
        let before = browser.script("return document.body.dataset.drawn");
        browser.script(&format!(
            "document.getElementById('curves').dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}'}}))"
        ));
        browser.wait_for(&format!("document.body.dataset.drawn !== {before}"));
    };
    let [from, to] = view();
    press("+");
    press("ArrowRight");
    let moved = view();
    let wanted = [from + 0.375 * (to - from), from + 0.875 * (to - from)];
    let tolerance = 1e-6 * (to - from);
    assert!(
        (moved[0] - wanted[0]).abs() < tolerance && (moved[1] - wanted[1]).abs() < tolerance,
        "{moved:?} {wanted:?}"
    );
    press("0");
    let whole = view();
    assert!(
        whole[0] <= from + tolerance && whole[1] >= to - tolerance,
        "{whole:?}"
    );
    // A double click shows the whole log as well, with its curves and not only its axis.
    press("+");
    let drawn = browser.script("return document.body.dataset.drawn");
    browser.double_click("#curves .nsewdrag");
    browser.wait_for(&format!("document.body.dataset.drawn !== {drawn}"));
    let ends = browser.script(
        "const {x} = document.getElementById('curves').data[0]; return [x[0], x.at(-1)].map(Number)",
    );
    let ends: [f64; 2] = serde_json::from_value(ends).expect("the ends of a curve");
    // Of the samples within a pixel the least and the largest are drawn; the plot has more than a hundred pixels.
    let pixel_s = (to - from) / 100.0;
    assert!(
        ends[0] <= from + pixel_s && ends[1] >= to - pixel_s,
        "{ends:?} {from} {to}"
    );
    let hidden = browser.script(
        "return [...document.querySelectorAll('.scatterlayer .trace')].filter((one) => one.style.visibility === 'hidden').length",
    );
    assert_eq!(hidden, json!(0));

    // This bench states no sensors: the reason why no controller is emitted stays, also when the design is there again.
    browser.click("#tab-design");
    browser
        .wait_for("document.getElementById('design-generate') && document.body.dataset.designed");
    browser.script("document.getElementById('design-generate').click()");
    browser.wait_for(
        "document.body.dataset.working === 'no' && document.getElementById('tab-controller').ariaSelected === 'true'",
    );
    let message = browser.text("#message-text");
    assert!(message.contains("hardware is not stated"), "{message}");
    assert!(
        !message.contains("--preset"),
        "no word of the command line: {message}"
    );
    // The page offers what it can: to write it, or those of another bench, and it says which they are.
    browser.wait_for("document.getElementById('generate-assumed')");
    let offer = browser.text("#hardware-missing");
    assert!(
        offer.contains("[hardware.drive]") && offer.contains("ESCON 24/2"),
        "{offer}"
    );
    work(&browser, || browser.click("#generate-assumed"));
    browser.wait_for("document.getElementById('source').textContent.includes('pub fn control')");
    let panel = browser.text("#panel-controller");
    assert!(panel.contains("Taken from the thesis bench"), "{panel}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
