//! Dropped CSV files become a bench folder.

use std::fs;

use serde_json::json;

use crate::bench;
use crate::running::Running;

fn log(name: &str) -> &'static str {
    let found = demo::FILES.into_iter().find(|(own, _)| *own == name);
    found.expect("a log of the demonstration").1
}

#[test]
fn dropped_logs_are_described_checked_and_become_a_bench() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("mine");
    let lab = Running::entered(None);
    for name in ["spin-up-0.4A.csv", "free-swing-20deg.csv"] {
        let answer = lab.ask("POST", &format!("/api/drop?name={name}"), log(name));
        assert_eq!(answer.status, 200, "{}", answer.body);
    }
    let found = lab.ask("GET", "/api/drop", "").json();
    let first_line = log("free-swing-20deg.csv").lines().next();
    assert_eq!(found["files"][1]["lines"][0].as_str(), first_line);
    let kinds = |index: usize| found["proposal"]["experiments"][index]["kind"].clone();
    assert_eq!(
        [kinds(0), kinds(1)],
        [json!("spin-up"), json!("free-swing")]
    );
    let text = found["proposal"]["text"].as_str().expect("a text");

    // A correction that is none is noticed as it is typed, and nothing is written.
    let wrong = text.replace("free-swing\"", "freeswing\"");
    let checked = lab.ask(
        "POST",
        "/api/drop/check",
        &json!({"text": wrong}).to_string(),
    );
    assert!(
        checked.json()["failure"]
            .as_str()
            .is_some_and(|said| said.contains("freeswing"))
    );
    let refused = lab.work(&json!({"task": "create", "folder": folder, "text": wrong}));
    assert_eq!(refused["bench"], json!(null));
    assert!(!folder.exists());

    // What a user fills in: without the torque constant nothing fixes the scale.
    let filled = format!("{text}\n[known]\ntorque_constant = 0.033\ngravity_torque = 0.238383\n");
    let filled = if text.contains("\n[known]") {
        text.replacen(
            "[known]",
            "[known]\ntorque_constant = 0.033\ngravity_torque = 0.238383",
            1,
        )
    } else {
        filled
    };
    let opened = lab.work(&json!({"task": "create", "folder": folder, "text": filled}));
    assert_eq!(opened["failure"], json!(null));
    assert_eq!(
        opened["bench"]["experiments"].as_array().map(Vec::len),
        Some(2)
    );
    // The bench is called after its folder, not after where the lab kept the files.
    assert!(filled.contains("name = \"my-bench\""), "{filled}");
    assert_eq!(opened["bench"]["name"], "mine");
    assert_eq!(
        fs::read_to_string(folder.join("bench.toml")).expect("written"),
        filled.replacen("my-bench", "mine", 1)
    );
    let written = fs::read_to_string(folder.join("free-swing-20deg.csv")).expect("written");
    assert_eq!(written, log("free-swing-20deg.csv"));
    assert_eq!(lab.ask("GET", "/api/drop", "").json()["files"], json!([]));

    // Nothing is written over.
    lab.ask(
        "POST",
        "/api/drop?name=free-swing-20deg.csv",
        log("free-swing-50deg.csv"),
    );
    let again = lab.work(&json!({"task": "create", "folder": folder, "text": filled}));
    assert!(again["failure"].as_str().is_some(), "{again}");
    let kept = fs::read_to_string(folder.join("free-swing-20deg.csv")).expect("kept");
    assert_eq!(kept, written);
}

#[test]
fn names_that_lead_elsewhere_and_files_that_are_no_logs_are_refused() {
    let lab = Running::entered(None);
    for name in [
        "..%2Fx.csv",
        "a%2Fb.csv",
        "a%5Cb.csv",
        ".x.csv",
        "x.exe",
        "x",
        "bench.toml",
        "%00.csv",
        "..",
        "",
    ] {
        let answer = lab.ask("POST", &format!("/api/drop?name={name}"), "t,a\n0,1\n");
        assert_eq!(answer.status, 422, "{name}: {}", answer.body);
    }
    // What is no table gets its message, without a word on where it lies.
    lab.ask("POST", "/api/drop?name=bad.csv", "hello\n\u{1F600}\n");
    let found = lab.ask("GET", "/api/drop", "").json();
    let said = found["failure"]
        .as_str()
        .or(found["proposal"]["open"].as_str());
    assert!(
        said.is_some_and(|said| !said.contains("flywheel-lab-")),
        "{found}"
    );
    assert_eq!(lab.ask("DELETE", "/api/drop", "").status, 204);
}

/// What is clicked comes back as bench.toml: a unit, a window, a constant; what stays unknown is said.
#[test]
fn a_click_writes_the_text_anew() {
    let lab = Running::entered(None);
    let name = "free-swing-20deg.csv";
    lab.ask("POST", &format!("/api/drop?name={name}"), log(name));
    let found = lab.ask("GET", "/api/drop", "").json();
    assert!(
        found["open_ends"]
            .to_string()
            .contains("per unit of inertia"),
        "{}",
        found["open_ends"]
    );
    let curve = &found["previews"][0]["curves"][0];
    assert!(
        curve["x"].as_array().is_some_and(|x| x.len() > 100),
        "{curve}"
    );
    let mut choices = found["proposal"]["experiments"][0]["choices"].clone();
    choices["until_s"] = json!(9.5);
    let corrections = json!({"known": {"gravity_torque": 0.238383}, "files": {name: choices}});
    let found = lab
        .ask("POST", "/api/drop/correct", &corrections.to_string())
        .json();
    let text = found["proposal"]["text"].as_str().expect("a text");
    assert!(
        text.contains("until = 9.5") && text.contains("gravity_torque  = 0.238383"),
        "{text}"
    );
    assert!(
        !found["open_ends"]
            .to_string()
            .contains("per unit of inertia")
    );
    let unknown = json!({"known": {}, "files": {}, "more": 1});
    assert_eq!(
        lab.ask("POST", "/api/drop/correct", &unknown.to_string())
            .status,
        422
    );
}

/// One file that is no log holds the others up only until it is left out.
#[test]
fn a_file_is_left_out_alone() {
    let lab = Running::entered(None);
    let name = "free-swing-20deg.csv";
    lab.ask("POST", &format!("/api/drop?name={name}"), log(name));
    lab.ask("POST", "/api/drop?name=bad.csv", "t,a\n0,1\n1\n");
    let found = lab.ask("GET", "/api/drop", "").json();
    assert!(found["failure"].as_str().is_some(), "{found}");
    assert_eq!(lab.ask("DELETE", "/api/drop?name=bad.csv", "").status, 204);
    let found = lab.ask("GET", "/api/drop", "").json();
    assert_eq!(found["files"].as_array().map(Vec::len), Some(1));
    assert_eq!(found["proposal"]["experiments"][0]["file"], name);
    // No bench is open to which it could be added.
    assert_eq!(found["bench"], json!(null));
    let task = json!({"task": "add-logs", "text": found["proposal"]["text"]});
    assert_eq!(lab.ask("POST", "/api/work", &task.to_string()).status, 409);
    lab.ask("DELETE", &format!("/api/drop?name={name}"), "");
    let found = lab.ask("GET", "/api/drop", "").json();
    assert_eq!(found["files"], json!([]));
}

/// The experiment that settles a question is added to the bench that is open; what this bench says already stays, and
/// nothing is written over.
#[test]
fn a_log_is_added_to_the_open_bench() {
    let folder = bench::folder();
    let lab = Running::entered(Some(folder.path()));
    lab.settled();
    let path = folder.path().join("bench.toml");
    let before = fs::read_to_string(&path).expect("a bench");
    let add = |name: &str| {
        lab.ask(
            "POST",
            &format!("/api/drop?name={name}"),
            log("free-swing-50deg.csv"),
        );
        let found = lab.ask("GET", "/api/drop", "").json();
        assert_eq!(found["bench"], "two logs");
        lab.work(&json!({"task": "add-logs", "text": found["proposal"]["text"]}))
    };
    let refused = add("free-swing-20deg.csv");
    assert!(
        refused["failure"]
            .as_str()
            .is_some_and(|said| said.contains("exists already")),
        "{refused}"
    );
    assert_eq!(fs::read_to_string(&path).expect("a bench"), before);
    lab.ask("DELETE", "/api/drop", "");
    let opened = add("another.csv");
    assert_eq!(opened["failure"], json!(null));
    assert_eq!(opened["bench"]["name"], "two logs");
    let experiments = opened["bench"]["experiments"].as_array().expect("a list");
    assert_eq!(experiments.len(), 3);
    assert_eq!(experiments[2]["name"], "another");
    let text = fs::read_to_string(&path).expect("a bench");
    assert!(text.starts_with(&before), "{text}");
    // The entry comes with the reasons for it, and without the explanation of every key that a new bench begins with.
    let added = &text[before.len()..];
    assert!(
        added.contains("# free-swing: ") && !added.contains("Every key"),
        "{added}"
    );
    assert_eq!(
        fs::read_to_string(folder.path().join("another.csv")).expect("a log"),
        log("free-swing-50deg.csv")
    );
    assert_eq!(lab.ask("GET", "/api/drop", "").json()["files"], json!([]));
}
