//! Text from files that neither steers a terminal nor a viewer.

use std::borrow::Cow;
use std::fmt::Write;
use vibrissa::error::is_steering;

/// The text with each character that [steers](is_steering) instead of being seen as `\\u001b`, as JSON writes it; line ends and
/// tabulators stay. JSON stays the same JSON.
pub(crate) fn plain(text: &str) -> Cow<'_, str> {
    let steers = |c: char| is_steering(c) && !matches!(c, '\n' | '\t');
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        if steers(character) {
            for unit in character.encode_utf16(&mut [0; 2]) {
                // Writing into a string cannot fail.
                let _ = write!(safe, "\\u{unit:04x}");
            }
        } else {
            safe.push(character);
        }
    }
    Cow::Owned(safe)
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn what_steers_is_written_as_json_does_and_means_the_same_there() {
        assert_eq!(plain("größe\n\tx"), "größe\n\tx");
        let name = "a\u{1b}[2J\u{202e}b\u{9b}\u{e0041}";
        assert_eq!(plain(name), "a\\u001b[2J\\u202eb\\u009b\\udb40\\udc41");
        let json = serde_json::to_string(name).unwrap();
        let back: String = serde_json::from_str(&plain(&json)).unwrap();
        assert_eq!(back, name);
    }
}
