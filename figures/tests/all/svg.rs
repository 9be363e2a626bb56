//! Reading a figure back.

use figures::*;
use roxmltree::{Document, Node};

/// Parses, and checks what must hold of every figure.
pub fn parse(svg: &str) -> Document<'_> {
    let document = Document::parse(svg).expect("well-formed XML");
    let size = |name| -> f64 {
        let value = document.root_element().attribute(name).expect(name);
        value.parse().expect(name)
    };
    let (width, height) = (size("width"), size("height"));
    assert!(width > 0.0 && height > 0.0);
    for node in document.descendants().filter(Node::is_element) {
        for attribute in node.attributes() {
            let value = attribute.value();
            if attribute.name() != "data-series" {
                assert!(!value.contains("NaN") && !value.contains("inf"), "{value}");
            }
        }
        // Every text begins or ends on the page.
        if node.has_tag_name("text") {
            let at = |name| node.attribute(name).unwrap().parse::<f64>().unwrap();
            assert!((0.0..=width).contains(&at("x")), "{:?}", node.text());
            assert!((0.0..=height).contains(&at("y")), "{:?}", node.text());
        }
        if node.has_tag_name("path") {
            let data = node.attribute("d").unwrap();
            assert!(data.starts_with('M') && data.len() > 3, "{data}");
        }
    }
    document
}

pub fn texts(document: &Document) -> Vec<String> {
    let nodes = document.descendants().filter(|n| n.has_tag_name("text"));
    nodes.filter_map(|n| n.text().map(str::to_owned)).collect()
}

pub fn series_of<'a>(document: &'a Document, class: &str) -> Vec<Node<'a, 'a>> {
    let groups = document.descendants();
    groups
        .filter(|n| n.has_tag_name("g") && n.attribute("class") == Some(class))
        .collect()
}

/// The points of all paths below `node`, one list for each stretch.
pub fn stretches(node: &Node) -> Vec<Vec<(f64, f64)>> {
    let mut all: Vec<Vec<(f64, f64)>> = Vec::new();
    for path in node.descendants().filter(|n| n.has_tag_name("path")) {
        let mut at = (0.0, 0.0);
        let data = path.attribute("d").unwrap();
        let mut rest = data;
        while let Some(command) = rest.chars().next() {
            let end = rest[1..]
                .find(|c: char| c.is_ascii_alphabetic())
                .map_or(rest.len(), |i| i + 1);
            let numbers = numbers(&rest[1..end]);
            rest = &rest[end..];
            match (command, numbers.as_slice()) {
                ('M', [x, y]) => at = (*x, *y),
                ('m' | 'l', [x, y]) => at = (at.0 + x, at.1 + y),
                ('h', [x]) => at.0 += x,
                ('z', []) => continue,
                other => panic!("unexpected path command {other:?}"),
            }
            if command == 'M' || command == 'm' {
                all.push(Vec::new());
            }
            all.last_mut().expect("paths begin with a move").push(at);
        }
    }
    all
}

pub fn numbers(text: &str) -> Vec<f64> {
    let spaced = text.replace('-', " -");
    spaced
        .split_whitespace()
        .map(|n| n.parse().expect("a number"))
        .collect()
}

pub const ANGLE: Quantity = Quantity {
    name: "angle",
    unit: "rad",
};

pub fn one_channel<'a>(
    time_s: &'a [f64],
    channels: &'a [OverlayChannel<'a>],
    title: &'a str,
) -> Overlay<'a> {
    Overlay {
        title,
        time_s,
        channels,
        ..Overlay::default()
    }
}
