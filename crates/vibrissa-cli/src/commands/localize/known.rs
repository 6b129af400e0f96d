//! The region that holds the first pose, as six numbers of the command line.

use std::ffi::OsString;
use vibrissa::config::Region;

/// The numbers of a text with commas or spaces between them; none if something else is in there.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split([',', ' ', '\t']).filter(|word| !word.is_empty());
    words.map(|word| word.parse().ok()).collect()
}

pub(super) fn region(text: &str) -> Result<Region, String> {
    let wanted = "six numbers are due, with commas or spaces between them: least x, largest x, least y, largest y (m), \
                  least heading, largest heading (rad)";
    match numbers(text).as_deref() {
        Some(&[a, b, c, d, e, f]) => Ok([[a, b], [c, d], [e, f]]),
        Some(other) => Err(format!("{wanted}; got {}", other.len())),
        None => Err(wanted.to_owned()),
    }
}

/// The command line with the numbers that follow `--within` joined to one argument, so that they may stand apart.
pub(crate) fn joined(args: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut joined: Vec<OsString> = Vec::new();
    let mut wanted = 0;
    for arg in args {
        let found = arg.to_str().and_then(numbers).filter(|found| !found.is_empty() && found.len() <= wanted);
        match (found, joined.last_mut()) {
            // The first numbers stand for themselves.
            (Some(found), Some(last)) if wanted < COUNT => {
                wanted -= found.len();
                last.push(",");
                last.push(&arg);
            }
            (found, _) => {
                wanted = if arg == "--within" { COUNT } else { found.map_or(0, |found| wanted - found.len()) };
                joined.push(arg);
            }
        }
    }
    joined
}

/// How many numbers make a region.
const COUNT: usize = 6;

#[cfg(test)]
mod tests {
    use super::joined;

    #[test]
    fn only_the_numbers_of_a_region_are_joined() {
        let cases = [
            ("a --within 0 1 -2 3 4 5 log.csv", "a|--within|0,1,-2,3,4,5|log.csv"),
            ("a --within 0,1,2,3,4,5 7 8", "a|--within|0,1,2,3,4,5|7|8"),
            ("a --within 0 1 2 3 4 5 6", "a|--within|0,1,2,3,4,5|6"),
            ("a --within 0, 1, 2,3 4,5 6", "a|--within|0,,1,,2,3,4,5|6"),
            ("a --within log.csv 1 2", "a|--within|log.csv|1|2"),
            ("a --within 1 2 --json 3 4", "a|--within|1,2|--json|3|4"),
            ("a --within=1,2,3,4,5,6 7", "a|--within=1,2,3,4,5,6|7"),
            ("a 1 2 --within", "a|1|2|--within"),
        ];
        for (line, expected) in cases {
            let args = joined(line.split(' ').map(Into::into));
            let words: Vec<&str> = args.iter().filter_map(|a| a.to_str()).collect();
            assert_eq!(words.join("|"), expected, "{line}");
        }
    }
}
