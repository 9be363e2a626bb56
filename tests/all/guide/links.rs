//! Links lead to files that exist, and to headings that they have.

use super::{pages, text};

/// The targets of links and pictures in a text, outside of code.
fn targets(text: &str) -> Vec<String> {
    let mut found = vec![];
    let mut in_code = false;
    for line in text.lines() {
        if line.starts_with("```") {
            in_code = !in_code;
        }
        if in_code || line.starts_with("    ") {
            continue;
        }
        let mut rest = line;
        while let Some(at) = rest.find("](") {
            rest = &rest[at + 2..];
            if let Some(end) = rest.find(')') {
                found.push(rest[..end].to_owned());
            }
        }
    }
    found
}

/// The anchor of a heading, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    heading
        .trim_start_matches('#')
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

#[test]
fn links_lead_somewhere() {
    let mut broken = vec![];
    let mut count = 0;
    for page in pages() {
        for target in targets(&text(&page)) {
            if target.contains("://") {
                broken.push(format!(
                    "{}: leads out of the project: {target}",
                    page.display()
                ));
                continue;
            }
            count += 1;
            let (file, heading) = match target.split_once('#') {
                Some((file, heading)) => (file, Some(heading)),
                None => (target.as_str(), None),
            };
            let path = match file {
                "" => page.clone(),
                file => page.parent().expect("a folder").join(file),
            };
            if !path.exists() {
                broken.push(format!("{}: {target}", page.display()));
            } else if let Some(heading) = heading
                && !text(&path)
                    .lines()
                    .any(|line| line.starts_with('#') && anchor(line) == heading)
            {
                broken.push(format!("{}: no heading for {target}", page.display()));
            }
        }
    }
    assert!(count > 20, "only {count} links were found");
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// The guide is also a book and the lab's help. Neither has the files around it, so no page links to them.
#[test]
fn the_guide_links_to_itself_alone() {
    let guide = super::root().join("docs/guide");
    for page in pages().iter().filter(|page| page.starts_with(&guide)) {
        for target in targets(&text(page)) {
            assert!(
                !target.starts_with("../"),
                "{}: {target} leads out of the guide",
                page.display()
            );
        }
    }
}

/// Every page of the guide is in its table of contents.
#[test]
fn the_table_of_contents_is_complete() {
    let contents = text(&super::root().join("docs/guide/SUMMARY.md"));
    for page in pages() {
        let Ok(inside) = page.strip_prefix(super::root().join("docs/guide")) else {
            continue;
        };
        let name = inside.to_string_lossy();
        assert!(
            name == "SUMMARY.md" || contents.contains(&format!("({name})")),
            "{name} is not in SUMMARY.md"
        );
    }
}
