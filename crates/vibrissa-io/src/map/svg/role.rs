//! The role of an element, from its class, id or Inkscape label.

use crate::world::Role;
use roxmltree::Node;

const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// The role that the element itself names.
pub(super) fn of(node: Node<'_, '_>) -> Option<Role> {
    let classes = node.attribute("class").into_iter().flat_map(str::split_whitespace);
    classes.chain(node.attribute("id")).chain(label(node)).find_map(starting)
}

/// The name shown in Inkscape's objects and layers panels.
pub(super) fn label<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    node.attribute((INKSCAPE, "label"))
}

/// The role whose word the name starts with, in any case.
fn starting(name: &str) -> Option<Role> {
    let lower = name.trim().to_lowercase();
    Role::WORDS.into_iter().find(|word| lower.starts_with(word)).and_then(Role::from_word)
}
