//! The files of the page, inside the program.

use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use plotly::Plot;

macro_rules! assets {
    ($($name:literal: $kind:expr),* $(,)?) => {
        &[$(($name, $kind, include_str!(concat!("../assets/", $name)))),*]
    };
}

const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Name, kind and text.
const FILES: &[(&str, &str, &str)] = assets![
    "index.html": "text/html; charset=utf-8",
    "lab.css": "text/css; charset=utf-8",
    "app.js": SCRIPT,
    "controller.js": SCRIPT,
    "curves.js": SCRIPT,
    "design.js": SCRIPT,
    "design-plots.js": SCRIPT,
    "dom.js": SCRIPT,
    "drop.js": SCRIPT,
    "errors.js": SCRIPT,
    "moving.js": SCRIPT,
    "open.js": SCRIPT,
    "plots.js": SCRIPT,
    "remainder.js": SCRIPT,
    "server.js": SCRIPT,
    "sketch.js": SCRIPT,
    "sliders.js": SCRIPT,
    "why.js": SCRIPT,
];

/// The file with this name.
pub fn file(name: &str) -> Option<Response> {
    let (_, kind, text) = FILES.iter().find(|(own, _, _)| *own == name)?;
    Some(([(CONTENT_TYPE, *kind)], *text).into_response())
}

/// The plots' library, which the crate `plotly` carries. It stays the same as long as the program does, and is
/// large: a browser may keep it.
pub fn plot_library() -> Response {
    let scripts = Plot::offline_js_sources();
    // The first script is the library; the second draws formulas, which the page has none of.
    let library = scripts
        .split_once('>')
        .and_then(|(_, rest)| rest.split_once("</script>"))
        .map_or("", |(library, _)| library);
    let headers = [
        (CONTENT_TYPE, SCRIPT),
        (CACHE_CONTROL, "private, max-age=31536000, immutable"),
    ];
    (headers, library.to_owned()).into_response()
}
