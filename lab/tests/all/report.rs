//! The report as one file.

use workbench::{Progress, Session};

use crate::bench;

/// Names are text in it, nothing is loaded from anywhere, and the numbers are the library's.
#[test]
fn the_report_stands_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    bench::write(folder.path(), |text| {
        text.replace(
            "name = \"swing\"",
            "name = \"<img src=x onerror=alert(1)>\"",
        )
        .replace("two logs", "<script>alert(1)</script>")
    });
    let mut session = Session::open(folder.path()).expect("a bench");
    let html = lab::report_of(&mut session, &Progress::silent()).expect("a report");
    assert!(!html.contains("<script") && !html.contains("<img src=x"));
    assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    for loads in ["src=\"http", "href=", "url(http", "@import"] {
        assert!(!html.contains(loads), "{loads}");
    }
    assert!(html.contains("body-coulomb-friction"));
    // The conclusion comes before the numbers.
    let verdict = html.find("class=\"c\"").expect("a conclusion");
    assert!(verdict < html.find("<h2>Parameters").expect("parameters"));
    assert_eq!(
        html.matches("<img alt=").count(),
        html.matches("src=\"data:image/svg+xml,").count()
    );
    assert!(html.matches("<img alt=").count() >= 4);
    let inertia = session
        .model()
        .and_then(|model| model.parameter("total_inertia"));
    let inertia = inertia.expect("an inertia");
    let text = workbench::numbers::with_uncertainty(inertia.value, inertia.std);
    assert!(html.contains(&text), "{text}");
}
