//! The pieces of an HTML file, as text.

use std::fmt::Write;

use workbench::OutputFile;

pub(crate) fn put(page: &mut String, html: &str) {
    page.push_str(html);
}

pub(crate) fn section(page: &mut String, title: &str) {
    put(page, &format!("<h2>{}</h2>\n", escaped(title)));
}

pub(crate) fn paragraph(page: &mut String, text: &str) {
    put(page, &format!("<p>{}</p>\n", escaped(text)));
}

pub(crate) fn list(page: &mut String, lines: impl Iterator<Item = String>) {
    let lines: String = lines
        .map(|line| format!("<li>{}</li>", escaped(&line)))
        .collect();
    if !lines.is_empty() {
        put(page, &format!("<ul>{lines}</ul>\n"));
    }
}

pub(crate) fn table(page: &mut String, heads: &[&str], rows: impl Iterator<Item = Vec<String>>) {
    let rows: Vec<Vec<String>> = rows.collect();
    let is_number =
        |cell: &str| cell.starts_with(|c: char| c.is_ascii_digit() || "-(–".contains(c));
    let class = |cell: &str| if is_number(cell) { "" } else { " class=\"l\"" };
    page.push_str("<table><thead><tr>");
    for (column, head) in heads.iter().enumerate() {
        // A head stands over its column as its cells do.
        let first = rows.first().and_then(|row| row.get(column));
        let class = class(first.map_or("", String::as_str));
        put(
            page,
            &format!("<th scope=\"col\"{class}>{}</th>", escaped(head)),
        );
    }
    page.push_str("</tr></thead><tbody>\n");
    for row in &rows {
        page.push_str("<tr>");
        for cell in row {
            put(page, &format!("<td{}>{}</td>", class(cell), escaped(cell)));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table>\n");
}

/// Each figure as a separate image, so that identifiers inside the figures cannot collide.
pub(crate) fn figures<'a>(page: &mut String, files: impl Iterator<Item = &'a OutputFile>) {
    for file in files.filter(|file| file.is_figure()) {
        let name = file.name.trim_end_matches(".svg").replace('-', " ");
        put(
            page,
            &format!(
                "<p><img alt=\"{}\" src=\"data:image/svg+xml,{}\"></p>\n",
                escaped(&name),
                in_address(&file.text)
            ),
        );
    }
}

/// Text that HTML takes for text.
pub(crate) fn escaped(text: &str) -> String {
    let mut html = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => html.push_str("&amp;"),
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '"' => html.push_str("&quot;"),
            '\'' => html.push_str("&#39;"),
            c => html.push(c),
        }
    }
    html
}

/// Text, escaped for an address (RFC 3986): characters that could end it, and all beyond ASCII, as %XX.
fn in_address(text: &str) -> String {
    let mut address = String::with_capacity(text.len() + text.len() / 4);
    for byte in text.bytes() {
        let plain = byte.is_ascii_alphanumeric() || b" -._~!$()*+,;=:@/?".contains(&byte);
        if plain {
            address.push(char::from(byte));
        } else {
            // Writing to a String cannot fail.
            let _ = write!(address, "%{byte:02X}");
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text() {
        assert_eq!(
            escaped("<img onerror='x'>&\""),
            "&lt;img onerror=&#39;x&#39;&gt;&amp;&quot;"
        );
        assert_eq!(
            in_address("<svg a=\"#1\">µ"),
            "%3Csvg a=%22%231%22%3E%C2%B5"
        );
    }
}
