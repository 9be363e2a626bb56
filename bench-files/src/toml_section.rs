//! A table of a TOML text: values by key, each of the right type or refused with its place.

use std::ops::Range;

use toml_edit::{Array, Document, Item, Key, TableLike, Value};

use crate::error::{Error, Names, Problem};
use crate::toml_source::{Located, TomlSource};

/// A table of a TOML text: a section, an inline table or the whole document.
pub(crate) struct Section<'a> {
    source: &'a TomlSource,
    /// Its name in messages, for example `[known]`.
    name: String,
    table: &'a (dyn TableLike + Sync),
    span: Range<usize>,
}

/// The table of an item, of either kind.
fn table_of(item: &Item) -> Option<&(dyn TableLike + Sync)> {
    match item {
        Item::Table(table) => Some(table),
        Item::Value(Value::InlineTable(table)) => Some(table),
        _ => None,
    }
}

impl TomlSource {
    /// The document as a section.
    pub fn root<'a>(&'a self, document: &'a Document<&str>) -> Section<'a> {
        Section {
            source: self,
            name: "the file".to_string(),
            table: document.as_table(),
            span: 0..0,
        }
    }
}

impl<'a> Section<'a> {
    /// Where the section begins.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// An error at the section's head.
    pub fn error(&self, problem: Problem) -> Error {
        self.source.error(self.span(), problem)
    }

    /// An error at the value of a key, or at the section's head if the key is missing.
    pub fn error_at(&self, key: &str, problem: Problem) -> Error {
        let span = match self.table.get_key_value(key) {
            Some((key, item)) => item_span(key, item),
            None => self.span(),
        };
        self.source.error(span, problem)
    }

    /// An error at a part of a value, given by its range of bytes.
    pub fn error_in_value(&self, span: Range<usize>, problem: Problem) -> Error {
        self.source.error(span, problem)
    }

    /// Refuses keys that are not in the list.
    pub fn allow_only(&self, known: &[&str]) -> Result<(), Error> {
        for (name, item) in self.table.iter() {
            if !known.contains(&name) {
                let span = match self.table.get_key_value(name) {
                    Some((key, _)) => key.span().unwrap_or_else(|| item_span(key, item)),
                    None => self.span(),
                };
                return Err(self.source.error(
                    span,
                    Problem::UnknownKey {
                        key: name.to_string(),
                        section: self.name.clone(),
                        names: Names::new(known),
                    },
                ));
            }
        }
        Ok(())
    }

    /// Whether the key is there.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// The keys and where they stand.
    pub fn keys(&self) -> Vec<Located<String>> {
        self.table
            .iter()
            .filter_map(|(name, item)| {
                let (key, _) = self.table.get_key_value(name)?;
                Some(Located {
                    value: name.to_string(),
                    span: key.span().unwrap_or_else(|| item_span(key, item)),
                })
            })
            .collect()
    }

    /// The table under this key.
    pub fn section(&self, key: &str) -> Result<Option<Section<'a>>, Error> {
        let Some((found, item)) = self.table.get_key_value(key) else {
            return Ok(None);
        };
        match table_of(item) {
            Some(table) => Ok(Some(Section {
                source: self.source,
                name: self.name_of(key, item),
                table,
                span: item_span(found, item),
            })),
            None => Err(self.wrong_type(key, item, &format!("a table, [{key}]"))),
        }
    }

    fn name_of(&self, key: &str, item: &Item) -> String {
        if item.is_table() {
            match self
                .name
                .strip_prefix('[')
                .and_then(|n| n.strip_suffix(']'))
            {
                Some(parent) if !parent.starts_with('[') => format!("[{parent}.{key}]"),
                _ => format!("[{key}]"),
            }
        } else {
            format!("\"{key}\"")
        }
    }

    /// The tables under this key: `[[key]]`, or an array of inline tables.
    pub fn sections(&self, key: &str) -> Result<Vec<Section<'a>>, Error> {
        let Some((found, item)) = self.table.get_key_value(key) else {
            return Ok(Vec::new());
        };
        let expected = format!("a list of tables, each under [[{key}]]");
        let name = format!("[[{key}]]");
        if let Some(tables) = item.as_array_of_tables() {
            return Ok(tables
                .iter()
                .map(|table| Section {
                    source: self.source,
                    name: name.clone(),
                    span: table.span().unwrap_or_else(|| item_span(found, item)),
                    table,
                })
                .collect());
        }
        let Some(array) = item.as_array() else {
            return Err(self.wrong_type(key, item, &expected));
        };
        array
            .iter()
            .map(|value| match value.as_inline_table() {
                Some(table) => Ok(Section {
                    source: self.source,
                    name: name.clone(),
                    span: value.span().unwrap_or_else(|| item_span(found, item)),
                    table,
                }),
                None => Err(self.wrong_type(key, item, &expected)),
            })
            .collect()
    }

    /// The text under this key.
    pub fn text(&self, key: &str) -> Result<Option<Located<String>>, Error> {
        let Some((found, item)) = self.table.get_key_value(key) else {
            return Ok(None);
        };
        match item.as_str() {
            Some(text) => Ok(Some(Located {
                value: text.to_string(),
                span: item_span(found, item),
            })),
            None => Err(self.wrong_type(key, item, "a text in quotation marks")),
        }
    }

    /// The text under a required key; it must not be blank.
    pub fn required_text(
        &self,
        key: &str,
        example: &'static str,
    ) -> Result<Located<String>, Error> {
        match self.text(key)? {
            Some(text) if !text.value.trim().is_empty() => Ok(text),
            _ => Err(self.error_at(key, self.missing(key, example))),
        }
    }

    /// The problem of a missing key.
    pub fn missing(&self, key: &str, example: &'static str) -> Problem {
        Problem::MissingKey {
            section: self.name.clone(),
            key: key.to_string(),
            example,
        }
    }

    /// The finite number under this key; an integer will do.
    pub fn number(&self, key: &str) -> Result<Option<Located<f64>>, Error> {
        let Some((found, item)) = self.table.get_key_value(key) else {
            return Ok(None);
        };
        let Some(value) = item.as_value().and_then(as_number) else {
            return Err(self.wrong_type(key, item, "a number"));
        };
        let number = Located {
            value,
            span: item_span(found, item),
        };
        self.require(key, &number, value.is_finite(), "a finite number")?;
        Ok(Some(number))
    }

    /// The number under this key, which must be above zero.
    pub fn positive_number(&self, key: &str) -> Result<Option<Located<f64>>, Error> {
        let number = self.number(key)?;
        if let Some(number) = &number {
            self.require(key, number, number.value > 0.0, "positive")?;
        }
        Ok(number)
    }

    /// The positive number under a required key.
    pub fn required_positive_number(&self, key: &str, example: &'static str) -> Result<f64, Error> {
        match self.positive_number(key)? {
            Some(number) => Ok(number.value),
            None => Err(self.error(self.missing(key, example))),
        }
    }

    fn require(
        &self,
        key: &str,
        number: &Located<f64>,
        holds: bool,
        must_be: &'static str,
    ) -> Result<(), Error> {
        if holds {
            return Ok(());
        }
        Err(self.source.error(
            number.span.clone(),
            Problem::OutOfRange {
                key: key.to_string(),
                value: number.value,
                must_be: must_be.to_string(),
            },
        ))
    }

    /// The list of texts under this key, each with its place.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<Located<String>>>, Error> {
        let Some((found, item)) = self.table.get_key_value(key) else {
            return Ok(None);
        };
        let wrong = || self.wrong_type(key, item, "a list of texts in quotation marks");
        let list = item.as_array().ok_or_else(wrong)?;
        let texts = texts_of(list, &item_span(found, item));
        Ok(Some(texts.ok_or_else(wrong)?))
    }

    /// The lists of texts in a list under this key, each text with its place.
    pub fn lists_of_texts(&self, key: &str) -> Result<Option<Vec<Vec<Located<String>>>>, Error> {
        let Some((found, item)) = self.table.get_key_value(key) else {
            return Ok(None);
        };
        let wrong = || self.wrong_type(key, item, "a list of lists of texts in quotation marks");
        let span = item_span(found, item);
        let lists = item.as_array().ok_or_else(wrong)?.iter();
        let lists = lists.map(|value| texts_of(value.as_array()?, &span));
        let lists = lists.collect::<Option<Vec<Vec<Located<String>>>>>();
        Ok(Some(lists.ok_or_else(wrong)?))
    }

    /// The number under a required key.
    pub fn required_number(&self, key: &str) -> Result<f64, Error> {
        match self.number(key)? {
            Some(number) => Ok(number.value),
            None => Err(self.error(self.missing(key, "a number"))),
        }
    }

    /// Finite numbers in nested lists of this shape, flattened. A 0 in the shape allows any length.
    pub fn numbers(
        &self,
        key: &str,
        shape: &[usize],
        expected: &str,
    ) -> Result<Option<Vec<f64>>, Error> {
        let Some((_, item)) = self.table.get_key_value(key) else {
            return Ok(None);
        };
        let mut numbers = Vec::new();
        let fits = item
            .as_value()
            .is_some_and(|value| flatten(value, shape, &mut numbers));
        if !fits {
            return Err(self.wrong_type(key, item, expected));
        }
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(self.error_at(
                key,
                Problem::OutOfRange {
                    key: key.to_string(),
                    value: f64::NAN,
                    must_be: "finite numbers".to_string(),
                },
            ));
        }
        Ok(Some(numbers))
    }

    /// A square matrix of finite numbers under this key, each with its place.
    pub fn square_matrix(
        &self,
        key: &str,
        size: usize,
    ) -> Result<Option<Vec<Vec<Located<f64>>>>, Error> {
        let expected = format!("{size} rows of {size} numbers, [[…], …]");
        let Some(numbers) = self.numbers(key, &[size, size], &expected)? else {
            return Ok(None);
        };
        let items = self.table.get(key).and_then(Item::as_array);
        let spans = items.into_iter().flatten().filter_map(Value::as_array);
        let spans: Vec<_> = spans.flatten().filter_map(Value::span).collect();
        let located = |(index, value)| Located {
            value,
            span: spans.get(index).cloned().unwrap_or_else(|| self.span()),
        };
        let entries: Vec<_> = numbers.into_iter().enumerate().map(located).collect();
        Ok(Some(
            entries.chunks(size.max(1)).map(<[_]>::to_vec).collect(),
        ))
    }

    /// Three finite numbers under this key, in the order of the state: angle, rate, wheel speed.
    pub fn three_numbers(&self, key: &str) -> Result<Option<Located<[f64; 3]>>, Error> {
        let Some((found, item)) = self.table.get_key_value(key) else {
            return Ok(None);
        };
        let expected = "a list of three numbers, for angle, rate and wheel speed";
        let wrong = || self.wrong_type(key, item, expected);
        let numbers = item
            .as_array()
            .ok_or_else(wrong)?
            .iter()
            .map(as_number)
            .collect::<Option<Vec<f64>>>()
            .ok_or_else(wrong)?;
        let value: [f64; 3] = numbers.try_into().map_err(|_| wrong())?;
        let span = item_span(found, item);
        for number in value {
            let number = Located {
                value: number,
                span: span.clone(),
            };
            self.require(key, &number, number.value.is_finite(), "finite numbers")?;
        }
        Ok(Some(Located { value, span }))
    }

    /// As [`Section::three_numbers`], for a required key.
    pub fn required_three_numbers(
        &self,
        key: &str,
        example: &'static str,
    ) -> Result<Located<[f64; 3]>, Error> {
        match self.three_numbers(key)? {
            Some(numbers) => Ok(numbers),
            None => Err(self.error(self.missing(key, example))),
        }
    }

    fn wrong_type(&self, key: &str, item: &Item, expected: &str) -> Error {
        self.error_at(
            key,
            Problem::WrongType {
                key: key.to_string(),
                expected: expected.to_string(),
                found: describe(item),
            },
        )
    }
}

/// Collects the numbers of nested lists. Returns `false` if they do not have the shape.
fn flatten(value: &Value, shape: &[usize], numbers: &mut Vec<f64>) -> bool {
    match (shape, value.as_array()) {
        ([], None) => as_number(value)
            .map(|number| numbers.push(number))
            .is_some(),
        ([length, inner @ ..], Some(list)) => {
            (*length == 0 || list.len() == *length)
                && list.iter().all(|value| flatten(value, inner, numbers))
        }
        _ => false,
    }
}

/// The texts of a list, each with its place (`otherwise` if it has none); `None` if an element is not a text.
fn texts_of(list: &Array, otherwise: &Range<usize>) -> Option<Vec<Located<String>>> {
    let texts = list.iter().map(|value| {
        Some(Located {
            value: value.as_str()?.to_string(),
            span: value.span().unwrap_or_else(|| otherwise.clone()),
        })
    });
    texts.collect()
}

fn as_number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|integer| integer as f64))
}

/// A description of a value, in words.
fn describe(item: &Item) -> String {
    match item {
        Item::Value(Value::Array(array)) => match array.len() {
            0 => "an empty list".to_string(),
            1 => "a list of one value".to_string(),
            n => format!("a list of {n} values"),
        },
        Item::Value(Value::String(text)) => {
            format!("the text \"{}\"", crate::error::shortened(text.value()))
        }
        Item::Value(Value::Integer(number)) => format!("the number {}", number.value()),
        Item::Value(Value::Float(number)) => format!("the number {}", number.value()),
        Item::Value(Value::Boolean(value)) => format!("the truth value {}", value.value()),
        Item::Value(Value::Datetime(value)) => format!("the date or time {}", value.value()),
        Item::Value(Value::InlineTable(_)) | Item::Table(_) => "a table".to_string(),
        Item::ArrayOfTables(_) => "a list of tables".to_string(),
        Item::None => "nothing".to_string(),
    }
}

fn item_span(key: &Key, item: &Item) -> Range<usize> {
    item.span().or_else(|| key.span()).unwrap_or(0..0)
}
