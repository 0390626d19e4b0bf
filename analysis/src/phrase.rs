//! Words with names from a specification. Messages show the names in back-quotes; lines that are not
//! Markdown, such as lenses and comments, show them as they are.

use std::fmt::{self, Display, Formatter};

/// Words and names in order. Displays with the names in back-quotes; serialises as displayed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Phrase(Vec<Part>);

#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Words(String),
    Name(String),
}

impl Phrase {
    /// A phrase that begins with words.
    pub fn words(words: impl Into<String>) -> Phrase {
        Phrase::default().and(words)
    }

    /// A phrase that begins with a name.
    pub fn name(name: impl Into<String>) -> Phrase {
        Phrase::default().and_name(name)
    }

    /// The phrase, followed by words.
    #[must_use]
    pub fn and(mut self, words: impl Into<String>) -> Phrase {
        self.0.push(Part::Words(words.into()));
        self
    }

    /// The phrase, followed by a name.
    #[must_use]
    pub fn and_name(mut self, name: impl Into<String>) -> Phrase {
        self.0.push(Part::Name(name.into()));
        self
    }

    /// The phrase, followed by another one.
    #[must_use]
    pub fn and_phrase(mut self, other: &Phrase) -> Phrase {
        self.0.extend(other.0.iter().cloned());
        self
    }

    /// Phrases as one, with words between them.
    pub fn joined(phrases: &[Phrase], between: &str) -> Phrase {
        let mut out = Phrase::default();
        for (index, phrase) in phrases.iter().enumerate() {
            if index > 0 {
                out = out.and(between);
            }
            out = out.and_phrase(phrase);
        }
        out
    }

    /// The text without back-quotes.
    pub fn plain(&self) -> String {
        let parts = self.0.iter();
        parts
            .map(|part| match part {
                Part::Words(text) | Part::Name(text) => text.as_str(),
            })
            .collect()
    }
}

impl Display for Phrase {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|part| match part {
            Part::Words(words) => f.write_str(words),
            Part::Name(name) => write!(f, "`{name}`"),
        })
    }
}

impl serde::Serialize for Phrase {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::Phrase;

    #[test]
    fn a_phrase_shows_its_names_in_two_ways() {
        let port = Phrase::words("port ").and_name("pose");
        let both = Phrase::joined(&[port, Phrase::name("v.x").and(" of the ids")], " and ");
        assert_eq!(both.to_string(), "port `pose` and `v.x` of the ids");
        assert_eq!(both.plain(), "port pose and v.x of the ids");
    }
}
