//! Names in messages: the known ones, the nearest to a wrong one, and names cut to fit.

/// A fixed list of names, for messages that propose the nearest one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names(pub Vec<String>);

impl Names {
    pub(crate) fn new<T: AsRef<str>>(names: impl IntoIterator<Item = T>) -> Names {
        Names(
            names
                .into_iter()
                .map(|name| name.as_ref().to_string())
                .collect(),
        )
    }

    /// "did you mean X? Known are …"
    pub(super) fn advice(&self, wrong: &str) -> String {
        let known = format!("known are {}", list(&self.0));
        match nearest(wrong, &self.0) {
            Some(name) => format!("did you mean \"{}\"? ({known})", shortened(name)),
            None => known,
        }
    }
}

/// The name nearest to `wrong`, if it could be a typing error: at most a
/// third of its letters differ (edit distance with transpositions), or one contains the other.
fn nearest<'a>(wrong: &str, names: &'a [String]) -> Option<&'a str> {
    let wrong = wrong.to_lowercase();
    let plain = |name: &str| name.to_lowercase().replace(['-', ' '], "_");
    names
        .iter()
        .map(|name| {
            let distance = strsim::damerau_levenshtein(&plain(&wrong), &plain(name));
            (distance, name)
        })
        .filter(|(distance, name)| {
            3 * distance <= name.chars().count().max(3)
                || (wrong.len() >= 3 && plain(name).contains(&plain(&wrong)))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name.as_str())
}

/// Names in quotation marks, at most forty of them.
pub(super) fn list(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_string();
    }
    let mut text = names
        .iter()
        .take(40)
        .map(|name| format!("\"{}\"", shortened(name)))
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > 40 {
        text.push_str(&format!(" and {} more", names.len() - 40));
    }
    text
}

/// A text from a file, shortened to fit into a message.
pub(crate) fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if text.chars().count() > 60 {
        short.push('…');
    }
    short
}
