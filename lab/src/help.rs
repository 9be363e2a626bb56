//! The guide, as the pages of the lab's help: the files of `docs/guide/`, inside the program.

use axum::extract::Path;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{Html, IntoResponse, Redirect, Response};
use include_dir::{Dir, include_dir};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd, html};

use crate::html::escaped;

/// Pages in Markdown, and their pictures.
static GUIDE: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../docs/guide");

/// The list of the pages, as mdBook has it.
const CONTENTS: &str = "SUMMARY.md";

/// To the first page.
pub async fn first() -> Redirect {
    Redirect::to("/help/README.md")
}

/// A page or a picture of the guide.
pub async fn file(Path(path): Path<String>) -> Response {
    let Some(text) = GUIDE.get_file(&path).and_then(|file| file.contents_utf8()) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    if path.ends_with(".svg") {
        return ([(CONTENT_TYPE, "image/svg+xml")], text).into_response();
    }
    Html(page(&path, text)).into_response()
}

/// The page around a text in Markdown: all pages on the left, this one beside them.
fn page(path: &str, markdown: &str) -> String {
    let contents = GUIDE.get_file(CONTENTS);
    let contents = contents.and_then(|file| file.contents_utf8());
    let here = format!("href=\"{path}\"");
    let contents = to_html(contents.unwrap_or_default())
        .replace(&here, &format!("{here} aria-current=\"page\""));
    let title = markdown.lines().find_map(|line| line.strip_prefix("# "));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{} – flywheel</title>\n<link rel=\"stylesheet\" href=\"/assets/lab.css\">\n\
         <link rel=\"icon\" href=\"data:,\">\n</head>\n<body>\n<main id=\"guide\">\n\
         <nav aria-label=\"Pages of the guide\">{contents}</nav>\n<article>{}</article>\n</main>\n</body>\n</html>\n",
        escaped(title.unwrap_or(path)),
        to_html(markdown)
    )
}

/// The HTML of a text in Markdown. Its comments are notes to those who write the guide, and are left out. Links to files
/// outside of the guide become plain text: the program does not carry them.
fn to_html(markdown: &str) -> String {
    let mut events: Vec<Event<'_>> = Vec::new();
    let mut outside = false;
    // Where the heading begins that is being read.
    let mut heading = None;
    for event in Parser::new_ext(markdown, Options::ENABLE_TABLES) {
        match &event {
            Event::Html(_) | Event::InlineHtml(_) => continue,
            Event::Start(Tag::Link { dest_url, .. }) => {
                outside = dest_url.starts_with("../");
                if outside {
                    continue;
                }
            }
            Event::End(TagEnd::Link) if outside => {
                outside = false;
                continue;
            }
            Event::Start(Tag::Heading { .. }) => heading = Some(events.len()),
            Event::End(TagEnd::Heading(_)) => {
                if let Some(begin) = heading.take() {
                    let anchor = anchor(&events[begin..]);
                    if let Event::Start(Tag::Heading { id, .. }) = &mut events[begin] {
                        *id = Some(anchor.into());
                    }
                }
            }
            _ => {}
        }
        events.push(event);
    }
    let mut text = String::new();
    html::push_html(&mut text, events.into_iter());
    text
}

/// The anchor of a heading, as GitHub and mdBook make it.
fn anchor(heading: &[Event<'_>]) -> String {
    let words = heading.iter().filter_map(|event| match event {
        Event::Text(text) | Event::Code(text) => Some(text.as_ref()),
        _ => None,
    });
    words
        .collect::<String>()
        .trim()
        .to_lowercase()
        .chars()
        .filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
            _ => None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(path: &str) -> &'static str {
        let file = GUIDE.get_file(path);
        let file = file.unwrap_or_else(|| panic!("there is no {path}"));
        file.contents_utf8().expect("text")
    }

    fn values<'a>(html: &'a str, attribute: &str) -> Vec<&'a str> {
        let parts = html.split(attribute).skip(1);
        parts.filter_map(|part| part.split('"').next()).collect()
    }

    /// Every page is in the contents, every link of a page leads to a page and a heading that are there, and every
    /// picture is carried.
    #[test]
    fn every_link_of_the_help_leads_somewhere() {
        let contents = to_html(text(CONTENTS));
        let listed = values(&contents, "href=\"");
        let mut links = 0;
        for file in GUIDE.files() {
            let path = file.path().to_str().expect("a name in UTF-8");
            if !path.ends_with(".md") || path == CONTENTS {
                continue;
            }
            assert!(listed.contains(&path), "{path} is in no contents");
            let html = page(path, text(path));
            assert!(html.contains("<article><h1 id="), "{path} has no heading");
            for link in values(&html, "href=\"") {
                if link.starts_with('/') || link.starts_with("data:") {
                    continue;
                }
                links += 1;
                let (to, heading) = link.split_once('#').unwrap_or((link, ""));
                let to = if to.is_empty() { path } else { to };
                let there = to_html(text(to));
                let is_there = heading.is_empty() || values(&there, " id=\"").contains(&heading);
                assert!(is_there, "{path} links to {link}");
            }
            for picture in values(&html, "src=\"") {
                assert!(text(picture).contains("<svg"), "{path} shows {picture}");
            }
        }
        assert!(links > 100, "{links}");
    }

    /// Tables stay tables, comments are left out, and links out of the guide are words.
    #[test]
    fn markdown_becomes_html() {
        let html = to_html(
            "# A *b* `c`\n\n<!-- for the writer -->\n| x | y |\n|---|---|\n| 1 | <2 |\n\n[map](../../MAP.md) and [next](next.md#a-b)\n",
        );
        assert!(html.starts_with("<h1 id=\"a-b-c\">"), "{html}");
        assert!(
            html.contains("<td>1</td>") && html.contains("&lt;2"),
            "{html}"
        );
        assert!(!html.contains("writer") && !html.contains("MAP"), "{html}");
        assert!(
            html.contains("map and <a href=\"next.md#a-b\">next</a>"),
            "{html}"
        );
    }
}
