//! What an XML text costs, counted before it is parsed.

use crate::config::budgets::{MOST_ELEMENT_ATTRIBUTES, MOST_XML_ATTRIBUTES, MOST_XML_NODES, XML_ENTITY_BYTES};
use crate::text::{beyond, line_at};
use crate::{Error, Result};

/// Most prefixes of namespaces: each element looks for its own among them.
const MOST_PREFIXES: usize = 1 << 10;

/// Refuses a text with more nodes, attributes or entities than a drawing has.
///
/// Signs are counted, without regard to where they stand, so that nothing that the parser meets is missed.
pub(super) fn check(text: &str) -> Result<()> {
    let (mut nodes, mut attributes, mut own, mut at) = (0, 0, 0, 0);
    let bytes = text.as_bytes();
    while let Some(found) = bytes[at..].iter().position(|byte| matches!(byte, b'<' | b'=')) {
        at += found;
        let rest = &text[at..];
        if bytes[at] == b'=' {
            (attributes, own) = (attributes + 1, own + 1);
        } else {
            (nodes, own) = (nodes + 1, 0);
        }
        // What stands in comments and in raw text is neither; without an end it is for the parser to say so.
        let raw = [("<!--", "-->"), ("<![CDATA[", "]]>")].into_iter().find(|(begin, _)| rest.starts_with(begin));
        let over = raw.and_then(|(_, end)| rest.find(end));
        at += over.unwrap_or(1);
        let too_many = |what: &str, count: usize, most: usize| {
            let remedy = "save it as plain SVG with the map's outlines alone";
            Err(beyond(what, format!("{count} or more"), most, remedy).at_line(line_at(bytes, at)))
        };
        if nodes > MOST_XML_NODES {
            return too_many("the drawing has too many elements", nodes, MOST_XML_NODES);
        }
        if attributes > MOST_XML_ATTRIBUTES {
            return too_many("the drawing has too many attributes", attributes, MOST_XML_ATTRIBUTES);
        }
        if own > MOST_ELEMENT_ATTRIBUTES {
            return too_many("an element has too many attributes", own, MOST_ELEMENT_ATTRIBUTES);
        }
    }
    let prefixes = text.matches("xmlns:").count();
    if prefixes > MOST_PREFIXES {
        let remedy = "save it as plain SVG with the map's outlines alone";
        return Err(beyond("the drawing has too many namespaces", prefixes, MOST_PREFIXES, remedy));
    }
    entities(text)
}

/// Refuses entities that stand for far more than the text, and those made of others.
fn entities(text: &str) -> Result<()> {
    let remedy = "write the values themselves in the place of the entities, or save it as plain SVG";
    let mut largest = 0;
    for (at, _) in text.match_indices("<!ENTITY") {
        let Some((value, _)) = quoted(&text[at..]) else { continue };
        if references(value) > 0 {
            return Err(Error::data("an entity is made of other entities")
                .at_line(line_at(text.as_bytes(), at))
                .allowed("entities of plain text")
                .remedy(remedy));
        }
        largest = largest.max(value.len());
    }
    if largest == 0 {
        return Ok(());
    }
    let bytes = references(text).saturating_mul(largest);
    if bytes > XML_ENTITY_BYTES {
        let value = format!("up to {bytes} bytes");
        return Err(beyond("the drawing's entities stand for too much", value, XML_ENTITY_BYTES, remedy));
    }
    Ok(())
}

/// What stands in the first quotes, and what follows.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let start = text.find(['"', '\''])?;
    let quote = text[start..].chars().next()?;
    text[start + 1..].split_once(quote)
}

/// How many entities are referred to, beside characters and the five that XML has.
fn references(text: &str) -> usize {
    const OWN: [&str; 6] = ["#", "amp;", "lt;", "gt;", "quot;", "apos;"];
    text.match_indices('&').filter(|(at, _)| !OWN.iter().any(|own| text[at + 1..].starts_with(own))).count()
}

#[cfg(test)]
mod tests {
    use super::check;
    use crate::config::budgets::{MOST_ELEMENT_ATTRIBUTES, MOST_XML_NODES};

    fn told(text: &str) -> String {
        check(text).unwrap_err().to_string()
    }

    #[test]
    fn drawings_as_programs_write_them_pass() {
        let namespaces = "<!DOCTYPE svg [<!ENTITY ns_svg \"http://www.w3.org/2000/svg\">]>";
        let used = format!("{namespaces}\n<svg xmlns=\"&ns_svg;\">{}</svg>", "<g a=\"&amp;&#65;\"/>".repeat(5000));
        assert!(check(&used).is_ok());
        let raw =
            format!("<svg><style><![CDATA[{}]]></style><!-- {} --></svg>", "a=b;".repeat(5000), "<=".repeat(5000));
        assert!(check(&raw).is_ok());
    }

    #[test]
    fn what_would_take_much_more_than_the_text_is_refused() {
        let quadratic =
            format!("<!DOCTYPE svg [<!ENTITY a '{}'>]><svg>{}</svg>", "x".repeat(20_000), "&a;".repeat(1000));
        assert!(told(&quadratic).contains("stand for too much: up to 20000000 bytes (allowed: up to 16777216)"));
        assert!(
            told("<!DOCTYPE svg [<!ENTITY a 'x'>\n<!ENTITY b '&a;&a;'>]><svg/>")
                .starts_with("line 2: an entity is made")
        );
        assert!(told(&"<g/>".repeat(MOST_XML_NODES + 1)).contains("too many elements"));
        let attributes = " a='>'".repeat(MOST_ELEMENT_ATTRIBUTES + 1);
        assert!(
            told(&format!("<svg>\n<g{attributes}/></svg>")).starts_with("line 2: an element has too many attributes")
        );
        assert!(told(&"<a xmlns:b=''/>".repeat(2000)).contains("too many namespaces"));
    }
}
