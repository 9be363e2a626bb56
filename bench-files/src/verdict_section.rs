//! The section `[tool.flywheel]` of a model: the verdict of the last diagnosis, if something remains unexplained.
//!
//! A design reads it, so that a controller is not made from a model that failed without a word.

use toml_edit::{Item, Table, Value};

use crate::toml_writing::{set, table_in};

/// The table below `tool`.
const TOOL: &str = "flywheel";
/// The key of the sentence.
const UNEXPLAINED: &str = "unexplained";

/// The sentence, if the file has it.
pub(crate) fn read(root: &Table) -> Option<String> {
    let own = root.get("tool")?.as_table_like()?.get(TOOL)?;
    let sentence = own.as_table_like()?.get(UNEXPLAINED)?.as_str()?;
    Some(sentence.to_owned())
}

/// Writes the sentence, or removes it. Other keys and the sections of other tools stay as they are.
pub(crate) fn write(root: &mut Table, sentence: Option<&str>) {
    if let Some(sentence) = sentence {
        let tool = table_in(root, "tool", true);
        set(
            table_in(tool, TOOL, false),
            UNEXPLAINED,
            Value::from(sentence),
        );
        return;
    }
    let Some(tool) = root.get_mut("tool").and_then(Item::as_table_like_mut) else {
        return;
    };
    let Some(own) = tool.get_mut(TOOL).and_then(Item::as_table_like_mut) else {
        return;
    };
    if own.remove(UNEXPLAINED).is_some() && own.is_empty() {
        tool.remove(TOOL);
        if tool.is_empty() {
            root.remove("tool");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml_edit::DocumentMut;

    #[test]
    fn the_sentence_comes_back_and_goes_again() {
        let before = "[design]\nsample_time = 0.001\n\n[tool.other]\nkey = 1\n";
        let mut document: DocumentMut = before.parse().expect("TOML");
        write(document.as_table_mut(), Some("an error remains"));
        let again: DocumentMut = document.to_string().parse().expect("TOML");
        assert_eq!(read(again.as_table()).as_deref(), Some("an error remains"));
        write(document.as_table_mut(), None);
        assert_eq!(document.to_string(), before);
        assert_eq!(read(document.as_table()), None);
    }

    #[test]
    fn a_section_of_another_form_is_no_verdict() {
        for text in [
            "tool = 1",
            "[tool]\nflywheel = 2",
            "[tool.flywheel]\nunexplained = 3",
        ] {
            let mut document: DocumentMut = text.parse().expect("TOML");
            assert_eq!(read(document.as_table()), None, "{text}");
            write(document.as_table_mut(), None);
        }
    }
}
