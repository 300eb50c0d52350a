//! Words behind a unit that say what a number refers to: `[N*m/A rms]` in the header of a table, `"1.48 N*m/A rms"` in
//! TOML.
//!
//! The one idea: what a number refers to stands next to its unit. Which words a column takes is said by its reader; the
//! unit never has such a word in it, so the two cannot be confused.

/// The words that the unit of a number may be followed by, each from its own list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Words {
    /// In which convention it is given: `rms`, `line_to_line`.
    pub convention: &'static [&'static str],
    /// On which side of a gear: `motor`, `output`.
    pub side: &'static [&'static str],
}

/// What was stated; `None` where nothing was.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Stated {
    /// In which convention the number is given.
    pub convention: Option<&'static str>,
    /// On which side of a gear.
    pub side: Option<&'static str>,
}

impl Words {
    /// A number that needs no more than its unit.
    pub const NONE: Words = Words { convention: &[], side: &[] };

    /// All of them, those of conventions first.
    pub fn all(self) -> impl Iterator<Item = &'static str> + Clone {
        self.convention.iter().chain(self.side).copied()
    }

    /// Takes the words off the end of a text: the rest, which is the unit, and what they state.
    ///
    /// # Errors
    /// In words, where two conventions or two sides are stated.
    pub fn split(self, text: &str) -> Result<(&str, Stated), String> {
        let (mut rest, mut stated) = (text.trim(), Stated::default());
        loop {
            let (before, last) = rest.rsplit_once(char::is_whitespace).unwrap_or(("", rest));
            let find = |words: &'static [&'static str]| words.iter().find(|word| **word == last).copied();
            let (place, what, word) = match (find(self.convention), find(self.side)) {
                (Some(word), _) => (&mut stated.convention, "conventions", word),
                (None, Some(word)) => (&mut stated.side, "sides", word),
                (None, None) => return Ok((rest, stated)),
            };
            if let Some(other) = place.replace(word) {
                return Err(format!("two {what} are stated, `{word}` and `{other}`"));
            }
            rest = before.trim_end();
        }
    }

    /// The word that was probably meant by the last one of a text whose unit cannot be read.
    pub fn meant(self, text: &str) -> Option<&'static str> {
        crate::words::nearest(text.split_whitespace().next_back()?, self.all())
    }
}

impl Stated {
    /// The words as they stand behind the unit.
    pub fn words(self) -> impl Iterator<Item = &'static str> {
        self.convention.into_iter().chain(self.side)
    }

    /// A unit followed by the words.
    pub fn after(self, unit: &str) -> String {
        let mut parts: Vec<&str> = self.words().collect();
        if !unit.is_empty() {
            parts.insert(0, unit);
        }
        parts.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: Words = Words { convention: &["rms", "dc"], side: &["motor", "output"] };

    #[test]
    fn words_are_taken_off_the_unit() {
        let split = |text| WORDS.split(text).unwrap();
        let stated = |convention, side| Stated { convention, side };
        assert_eq!(split("N*m/A"), ("N*m/A", Stated::default()));
        assert_eq!(split(" N m/A  rms "), ("N m/A", stated(Some("rms"), None)));
        assert_eq!(split("N*m/A output rms"), ("N*m/A", stated(Some("rms"), Some("output"))));
        assert_eq!(split("rms"), ("", stated(Some("rms"), None)));
        assert_eq!(split(""), ("", Stated::default()));
        assert_eq!(Words::NONE.split("N*m/A rms").unwrap().0, "N*m/A rms");
        for (text, after) in [("N*m/A", "N*m/A"), ("N*m/A rms output", "N*m/A rms output"), ("rms", "rms")] {
            let (unit, stated) = split(text);
            assert_eq!(stated.after(unit), after);
        }
    }

    #[test]
    fn two_of_one_list_contradict_each_other() {
        assert_eq!(WORDS.split("A rms dc").unwrap_err(), "two conventions are stated, `rms` and `dc`");
        assert_eq!(WORDS.split("kg motor motor").unwrap_err(), "two sides are stated, `motor` and `motor`");
        assert_eq!((WORDS.meant("N*m/A rsm"), WORDS.meant("N*m/A"), WORDS.meant("")), (Some("rms"), None, None));
    }
}
