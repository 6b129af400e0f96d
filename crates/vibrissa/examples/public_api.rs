//! Prints every public item of the libraries with its signature, one a line, as rustdoc sees it.
//!
//! `.ci/api` compares the list with docs/api.txt; it reads the pages that `cargo doc --no-deps` left. Items
//! without a sentence of documentation cannot be here: `missing_docs` is denied.

use std::path::Path;
use std::process::ExitCode;

/// The libraries.
const CRATES: [&str; 8] = [
    "vibrissa_beam",
    "vibrissa_head",
    "vibrissa_core",
    "vibrissa_io",
    "vibrissa_live",
    "vibrissa_sim",
    "vibrissa_figure",
    "vibrissa",
];

/// Modules that a library re-exports from another, where they are listed.
const ELSEWHERE: [&str; 15] = [
    "beam",
    "config",
    "contact",
    "error",
    "figure",
    "flow",
    "io",
    "linear_algebra",
    "localizer",
    "plane",
    "sensing",
    "sets",
    "sim",
    "world",
    "tasks",
];

/// Whether a module of a library is another's, re-exported.
fn is_elsewhere(name: &str, module: &str) -> bool {
    let first = module.split('/').next().unwrap_or(module);
    let own: &[&str] = match name {
        "vibrissa" => &["tasks"],
        "vibrissa_core" => &["config", "contact", "flow", "localizer", "world"],
        _ => return false,
    };
    ELSEWHERE.contains(&first) && !own.contains(&first)
}

/// Kinds of pages that stand for an item.
const KINDS: [&str; 8] = ["struct.", "enum.", "trait.", "fn.", "constant.", "type.", "macro.", "union."];

fn main() -> ExitCode {
    let target = std::env::var("CARGO_TARGET_DIR").unwrap_or(format!("{}/../../target", env!("CARGO_MANIFEST_DIR")));
    let found: std::io::Result<Vec<Vec<String>>> =
        CRATES.iter().map(|name| items(&Path::new(&target).join("doc").join(name), name)).collect();
    match found.map(|lists| lists.concat()) {
        Ok(mut lines) => {
            lines.sort();
            lines.dedup();
            lines.iter().for_each(|line| println!("{line}"));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {target}/doc: {error}; run `cargo doc --workspace --no-deps` first");
            ExitCode::FAILURE
        }
    }
}

/// Every item of the pages that the list of all items names; other pages may be left over from earlier builds.
fn items(root: &Path, name: &str) -> std::io::Result<Vec<String>> {
    let all = std::fs::read_to_string(root.join("all.html"))?;
    let mut lines: Vec<String> =
        between(&std::fs::read_to_string(root.join("index.html"))?, "<code>pub use ", "</code>")
            .map(|used| format!("{name}: pub use {}", plain(used)))
            .collect();
    for page in between(&all, "<a href=\"", "\"") {
        let (module, file) = page.rsplit_once('/').unwrap_or(("", page));
        if is_elsewhere(name, module) || !KINDS.iter().any(|kind| file.starts_with(kind)) {
            continue;
        }
        let path = if module.is_empty() { name.to_owned() } else { format!("{name}::{}", module.replace('/', "::")) };
        let html = std::fs::read_to_string(root.join(page))?;
        let owner = file.trim_end_matches(".html").rsplit('.').next().unwrap_or(file);
        let declared = between(&html, "<pre class=\"rust item-decl\"><code>", "</code></pre>").next();
        lines.extend(declared.map(|text| format!("{path}: {}", plain(text))));
        lines.extend(methods(&html).map(|text| format!("{path}::{owner}: {text}")));
        lines.extend(traits(&html).map(|text| format!("{path}::{owner}: {text}")));
    }
    Ok(lines)
}

/// The signatures of an item's own methods and constants.
fn methods(html: &str) -> impl Iterator<Item = String> {
    let own = |section: &&str| {
        let tag = section.split('>').next().unwrap_or("");
        tag.ends_with(" class=\"method\"") || tag.ends_with(" class=\"associatedconstant\"")
    };
    let sections = html.split("<section id=\"").skip(1).filter(own);
    sections.filter_map(|section| between(section, "<h4 class=\"code-header\">", "</h4>").next().map(plain))
}

/// The traits that an item implements, without those that every type has.
fn traits(html: &str) -> impl Iterator<Item = String> {
    let list = between(html, "id=\"trait-implementations-list\"", "id=\"synthetic-implementations\"");
    list.flat_map(|list| between(list, "<h3 class=\"code-header\">", "</h3>"))
        .map(plain)
        // The compiler's own mark of derived comparison.
        .filter(|text| !text.contains("StructuralPartialEq"))
}

/// The texts between `from` and `to`.
fn between<'a>(text: &'a str, from: &'a str, to: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(from).skip(1).filter_map(move |rest| rest.split(to).next())
}

/// The text of a piece of HTML on one line.
fn plain(html: &str) -> String {
    let mut text = String::new();
    for piece in html.split('<') {
        text.push_str(piece.split_once('>').map_or(piece, |(_, shown)| shown));
    }
    for (entity, shown) in
        [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&nbsp;", " "), ("&amp;", "&")]
    {
        text = text.replace(entity, shown);
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
