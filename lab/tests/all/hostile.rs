//! Who may not ask is refused: other pages, other users, other names for this machine.

use std::fs;

use serde_json::json;

use crate::bench;
use crate::http::send;
use crate::running::{Running, cookie_of};

/// The headers of a page of the lab, each replaced in turn.
#[test]
fn only_the_page_itself_may_ask() {
    let lab = Running::entered(None);
    let host = lab.host();
    let origin = format!("http://{host}");
    let other_port = format!("http://127.0.0.1:{}", lab.port ^ 1);
    let cookie = lab.cookie.as_str();
    let other = if cookie.ends_with('0') { '1' } else { '0' };
    let stale = format!("{}{other}", &cookie[..cookie.len() - 1]);
    let task = json!({"task": "diagnose"}).to_string();
    let ask = |method: &str, path: &str, host: &str, origin: Option<&str>, cookie: Option<&str>| {
        let mut headers = vec![("Host", host), ("Content-Type", "application/json")];
        headers.extend(origin.map(|origin| ("Origin", origin)));
        headers.extend(cookie.map(|cookie| ("Cookie", cookie)));
        let body = if method == "POST" { task.as_str() } else { "" };
        send(lab.port, method, path, &headers, body).status
    };
    // What the page itself does is answered: nothing is open yet, which is a conflict and no refusal.
    assert_eq!(ask("GET", "/", &host, None, Some(cookie)), 200);
    assert_eq!(
        ask("GET", "/api/state", &host, Some(&origin), Some(cookie)),
        200
    );
    assert_eq!(
        ask("POST", "/api/work", &host, Some(&origin), Some(cookie)),
        409
    );
    for path in [
        "/",
        "/assets/app.js",
        "/api/state",
        "/api/report",
        "/help/README.md",
        "/socket",
        "/no/such",
    ] {
        for (host, origin, cookie) in [
            ("evil.example", None, Some(cookie)),
            ("evil.example:80", Some("http://evil.example"), Some(cookie)),
            ("127.0.0.1", None, Some(cookie)),
            (host.as_str(), Some("http://evil.example"), Some(cookie)),
            (&host, Some("null"), Some(cookie)),
            (&host, Some(&other_port), Some(cookie)),
            (&host, None, None),
            (&host, None, Some("flywheel-lab=guess")),
            (&host, None, Some(&stale)),
        ] {
            let status = ask("GET", path, host, origin, cookie);
            assert_eq!(status, 403, "{path} {host} {origin:?} {cookie:?}");
        }
    }
    // What changes something must say that it comes from the page.
    for (origin, cookie) in [
        (None, Some(cookie)),
        (Some("http://evil.example"), Some(cookie)),
        (Some(origin.as_str()), None),
    ] {
        assert_eq!(ask("POST", "/api/work", &host, origin, cookie), 403);
        assert_eq!(ask("DELETE", "/api/work", &host, origin, cookie), 403);
    }
}

#[test]
fn the_socket_asks_for_origin_and_cookie() {
    let lab = Running::entered(None);
    let host = lab.host();
    let origin = format!("http://{host}");
    let upgrade = |origin: Option<&str>, cookie: Option<&str>| {
        let mut headers = vec![
            ("Host", host.as_str()),
            ("Upgrade", "websocket"),
            ("Sec-WebSocket-Version", "13"),
            ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
        ];
        headers.extend(origin.map(|origin| ("Origin", origin)));
        headers.extend(cookie.map(|cookie| ("Cookie", cookie)));
        send(lab.port, "GET", "/socket", &headers, "").status
    };
    assert_eq!(upgrade(Some("http://evil.example"), Some(&lab.cookie)), 403);
    assert_eq!(upgrade(None, Some(&lab.cookie)), 403);
    assert_eq!(upgrade(Some(&origin), None), 403);
}

#[test]
fn keys_open_once_or_from_the_owners_file_and_the_cookie_is_for_the_page_alone() {
    let lab = Running::start(None);
    let host = lab.host();
    let enter = |path: &str| send(lab.port, "GET", path, &[("Host", &host)], "");
    assert_eq!(enter("/enter?key=0").status, 403);
    assert_eq!(enter("/enter").status, 400);
    let once = lab
        .once
        .split_once(&lab.port.to_string())
        .expect("a path")
        .1;
    let answer = enter(once);
    assert_eq!(answer.status, 200);
    let set = answer.header("set-cookie").expect("a cookie");
    assert!(
        set.contains("HttpOnly") && set.contains("SameSite=Strict"),
        "{set}"
    );
    assert_eq!(enter(once).status, 403, "a second time");

    let page = fs::read_to_string(&lab.door).expect("the owner's file");
    let key = page
        .split("value=\"")
        .nth(1)
        .and_then(|rest| rest.split('"').next());
    let body = format!("key={}", key.expect("a key"));
    let form = [
        ("Host", host.as_str()),
        ("Origin", "null"),
        ("Content-Type", "application/x-www-form-urlencoded"),
    ];
    for _ in 0..2 {
        let answer = send(lab.port, "POST", "/enter", &form, &body);
        assert_eq!(answer.status, 200);
        let cookie = cookie_of(&answer);
        let headers = [("Host", host.as_str()), ("Cookie", &cookie)];
        assert_eq!(send(lab.port, "GET", "/", &headers, "").status, 200);
    }
    // No key is a cookie and no cookie is a key.
    let wrong = format!("flywheel-lab-{}={}", lab.port, key.expect("a key"));
    let headers = [("Host", host.as_str()), ("Cookie", &wrong)];
    assert_eq!(send(lab.port, "GET", "/", &headers, "").status, 403);
}

#[cfg(unix)]
#[test]
fn the_file_that_opens_the_page_is_for_its_owner_and_goes_with_the_lab() {
    use std::os::unix::fs::PermissionsExt;
    let lab = Running::start(None);
    let door = lab.door.clone();
    let mode = |path: &std::path::Path| {
        fs::metadata(path)
            .expect("it is there")
            .permissions()
            .mode()
            & 0o777
    };
    assert_eq!(mode(&door), 0o600);
    assert_eq!(mode(door.parent().expect("its folder")), 0o700);
    drop(lab);
    assert!(!door.exists());
}

#[test]
fn nothing_but_the_pages_own_files_is_served() {
    let lab = Running::entered(None);
    for path in [
        "/assets/../Cargo.toml",
        "/assets/..%2fCargo.toml",
        "/assets/..%2f..%2f..%2f..%2fetc%2fpasswd",
        "/assets/%2e%2e/%2e%2e/etc/passwd",
        "/assets//etc/passwd",
        "/etc/passwd",
    ] {
        assert_eq!(lab.ask("GET", path, "").status, 404, "{path}");
    }
    let page = lab.ask("GET", "/", "");
    let policy = page.header("content-security-policy").expect("a policy");
    assert!(
        policy.starts_with("default-src 'none'; script-src 'self';"),
        "{policy}"
    );
    assert_eq!(page.header("x-frame-options"), Some("DENY"));
    // Nothing that the page loads lies elsewhere.
    for file in ["/", "/assets/lab.css", "/assets/app.js", "/assets/plots.js"] {
        let text = lab.ask("GET", file, "").body;
        assert!(
            !text.contains("https://") && !text.contains("//cdn"),
            "{file}"
        );
    }
}

#[test]
fn bodies_are_bounded_and_what_is_no_task_is_refused() {
    let lab = Running::entered(None);
    let huge = format!(
        "{{\"task\": \"open\", \"path\": \"{}\"}}",
        "a".repeat(2_000_000)
    );
    assert_eq!(lab.ask("POST", "/api/work", &huge).status, 413);
    for body in [
        "",
        "{",
        "[]",
        "{\"task\": \"format-disk\"}",
        "{\"task\": \"open\"}",
    ] {
        let status = lab.ask("POST", "/api/work", body).status;
        assert!((400..500).contains(&status), "{body}: {status}");
    }
    assert_eq!(lab.settled()["bench"], json!(null));
}

/// A bench whose files lie elsewhere, by a path or by a symlink, is not opened.
#[test]
fn files_outside_the_bench_folder_are_refused() {
    let place = tempfile::tempdir().expect("a folder");
    let outside = place.path().join("swing.csv");
    let (_, swing) = demo::FILES
        .into_iter()
        .find(|(name, _)| *name == "free-swing-20deg.csv")
        .expect("a swing");
    fs::write(&outside, swing).expect("a log");
    let by_path = place.path().join("by-path");
    bench::write(&by_path, |text| {
        text.replace("free-swing-20deg.csv", "../swing.csv")
    });
    let mut benches = vec![by_path];
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        let log = place.path().join("log-by-link");
        bench::write(&log, str::to_owned);
        fs::remove_file(log.join("free-swing-20deg.csv")).expect("removed");
        symlink(&outside, log.join("free-swing-20deg.csv")).expect("a link");
        // The model is written: it must not be written through a link.
        let model = place.path().join("model-by-link");
        bench::write(&model, str::to_owned);
        symlink(
            place.path().join("elsewhere.toml"),
            model.join("model.toml"),
        )
        .expect("a link");
        let effect = place.path().join("effect-by-link");
        bench::write(&effect, str::to_owned);
        fs::create_dir(effect.join("effects")).expect("a folder");
        let (inside, own) = (
            effect.join("effects/mine.toml"),
            place.path().join("mine.toml"),
        );
        let text = "role = \"body\"\ntorque = \"-c*sign(rate)\"\n[parameters.c]\nunit = \"N m\"\nstart = 1e-4\n";
        fs::write(&own, text).expect("an effect");
        symlink(&own, &inside).expect("a link");
        benches.extend([log, model, effect]);
    }
    let lab = Running::entered(None);
    for bench in benches {
        let state = lab.work(&json!({"task": "open", "path": bench}));
        assert_eq!(state["bench"], json!(null), "{}", bench.display());
        let failure = state["failure"].as_str().expect("a reason");
        assert!(failure.contains("lies outside"), "{failure}");
    }
    assert!(!place.path().join("elsewhere.toml").exists());
}

/// The help carries the guide and nothing else.
#[test]
fn the_help_is_the_guide_alone() {
    let lab = Running::entered(None);
    let host = lab.host();
    let get = |path: &str| {
        let headers = [("Host", host.as_str()), ("Cookie", lab.cookie.as_str())];
        send(lab.port, "GET", path, &headers, "")
    };
    let first = get("/help");
    assert_eq!(first.status, 303);
    assert_eq!(first.header("location"), Some("/help/README.md"));
    let page = get("/help/README.md");
    assert_eq!(page.status, 200);
    assert!(
        page.body
            .contains("<nav aria-label=\"Pages of the guide\">")
    );
    assert_eq!(get("/help/effects/motor-lag.svg").status, 200);
    for path in [
        "/help/no-such.md",
        "/help/../Cargo.toml",
        "/help/..%2f..%2fCargo.toml",
        "/help/effects",
    ] {
        assert_eq!(get(path).status, 404, "{path}");
    }
}
