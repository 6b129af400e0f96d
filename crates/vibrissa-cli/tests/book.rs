//! The book keeps its word: its commands run, its links lead somewhere, and the command reference is what the commands say.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

mod common;

use common::{folder, vibrissa};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// All pages under `docs/`, by path from there.
fn pages() -> Vec<PathBuf> {
    let docs = root().join("docs");
    let mut found = Vec::new();
    let mut folders = vec![docs.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "md") {
                found.push(path.strip_prefix(&docs).unwrap().to_path_buf());
            }
        }
    }
    found.sort();
    found
}

/// A command line's words; double quotes hold words together.
fn words(line: &str) -> Vec<String> {
    let pieces = line.split('"').enumerate();
    pieces
        .flat_map(|(i, piece)| {
            if i % 2 == 1 { vec![piece.to_owned()] } else { piece.split_whitespace().map(str::to_owned).collect() }
        })
        .collect()
}

/// Writes the files that a page shows in a block after the words "This is" and their name.
fn write_files(text: &str, place: &Path) {
    for part in text.split("This is `").skip(1) {
        let Some((name, rest)) = part.split_once('`') else { continue };
        let block = rest.split("```").nth(1).unwrap_or_default();
        let content = block.strip_prefix("json\n").or(block.strip_prefix("toml\n"));
        fs::write(place.join(name), content.unwrap_or_else(|| panic!("{name} is not shown"))).unwrap();
    }
}

/// Runs every command of a page in `place`, where `scenarios/` lies; gives how many.
fn run_page(page: &str, place: &Path) -> usize {
    let text = fs::read_to_string(root().join("docs").join(page)).unwrap();
    write_files(&text, place);
    let commands: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("$ vibrissa ")).collect();
    for command in &commands {
        let run =
            Command::new(env!("CARGO_BIN_EXE_vibrissa")).args(words(command)).current_dir(place).output().unwrap();
        let told = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "docs/{page}: $ vibrissa {command}\n{told}");
    }
    commands.len()
}

/// The README's tour in an empty folder, as it stands.
#[test]
fn the_tour_of_the_readme_runs_in_an_empty_folder() {
    let (place, text) = (folder("book-readme"), fs::read_to_string(root().join("README.md")).unwrap());
    let tour = text.split("## A quick tour").nth(1).unwrap().split("With files of yours").next().unwrap();
    write_files(tour, &place);
    let commands: Vec<&str> = tour.lines().filter_map(|line| line.strip_prefix("    vibrissa ")).collect();
    for command in &commands {
        let run =
            Command::new(env!("CARGO_BIN_EXE_vibrissa")).args(words(command)).current_dir(&place).output().unwrap();
        let told = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "README: vibrissa {command}\n{told}");
    }
    assert!(commands.len() >= 14, "{}", commands.len());
    for file in ["result/localization.pdf", "result/localization.html", "found/localization.mcap", "paper/report.html"]
    {
        assert!(place.join(file).exists(), "{file}");
    }
}

fn place(name: &str) -> PathBuf {
    let place = folder(name);
    for part in ["scenarios", "scenarios/maps"] {
        fs::create_dir_all(place.join(part)).unwrap();
        for entry in fs::read_dir(root().join(part)).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_file() {
                fs::copy(&entry, place.join(part).join(entry.file_name().unwrap())).unwrap();
            }
        }
    }
    place
}

#[test]
fn the_tutorials_commands_run_one_after_the_other() {
    let place = place("book-tutorial");
    let chapters = ["1-sensor-log", "2-moment", "3-contact-set", "4-preimage", "5-state-set", "6-pose"];
    let run: usize = chapters.map(|chapter| run_page(&format!("tutorial/{chapter}.md"), &place)).iter().sum();
    assert!(run >= 8, "{run}");
    for file in ["demo/log.csv", "bent/beam.svg", "both/contact-set.csv", "strip/preimage.svg", "four/result.json"] {
        assert!(place.join(file).exists(), "{file}");
    }
}

#[test]
fn the_how_to_pages_commands_run() {
    let place = place("book-how-to");
    for page in pages().iter().filter(|page| page.starts_with("how-to")) {
        run_page(&page.to_string_lossy(), &place);
    }
    assert!(place.join("answer/result.json").exists());
    let found = fs::read_to_string(place.join("found/result.json")).unwrap();
    assert!(found.contains("\"status\": \"localized\""), "{found}");
}

#[test]
fn every_link_between_pages_leads_somewhere() {
    let docs = root().join("docs");
    let mut links = 0;
    let own = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(|page| root().join(page));
    for page in pages().into_iter().map(|page| docs.join(page)).chain(own) {
        let text = fs::read_to_string(&page).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap();
            if file.is_empty() || file.contains("://") || file.contains(char::is_whitespace) {
                continue;
            }
            links += 1;
            assert!(page.parent().unwrap().join(file).exists(), "{} links to {link}", page.display());
        }
    }
    assert!(links > 50, "{links}");
}

#[test]
fn every_page_is_in_the_table_of_contents() {
    let contents = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    for page in pages().iter().filter(|page| !page.ends_with("SUMMARY.md")) {
        assert!(contents.contains(&format!("({})", page.to_string_lossy())), "{} is not in SUMMARY.md", page.display());
    }
}

/// What `docs/reference/commands.md` must say: the help of every command.
fn reference() -> String {
    let all = vibrissa(&["--help"]).stdout;
    let commands = all.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let mut text = String::from("# Commands\n\nWhat `vibrissa --help` and `vibrissa COMMAND --help` say.\n\n");
    text.push_str(&format!("```text\n{}\n```\n", all.trim_end()));
    let mut add = |name: &str| {
        let words: Vec<&str> = name.split(' ').chain(["--help"]).collect();
        let help = vibrissa(&words);
        assert!(help.code == Some(0) && help.stderr.is_empty(), "{name}: {}", help.stderr);
        text.push_str(&format!("\n## {name}\n\n```text\n{}\n```\n", trimmed(&help.stdout)));
    };
    // A name stands behind two spaces; what follows it may go on further to the right.
    let names = commands.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    for command in names.filter_map(|line| line.split_whitespace().next()).filter(|&name| name != "help") {
        match command {
            "beam" => ["beam force", "beam point", "beam moment"].into_iter().for_each(&mut add),
            "sensor" => ["sensor design", "sensor head"].into_iter().for_each(&mut add),
            _ => add(command),
        }
    }
    text
}

fn trimmed(text: &str) -> String {
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim_end().to_owned()
}

#[test]
fn the_command_reference_is_what_the_commands_say() {
    let path = root().join("docs/reference/commands.md");
    let now = reference();
    if std::env::var_os("VIBRISSA_WRITE_REFERENCE").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, &now).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == now,
        "docs/reference/commands.md is not what the commands say; write it anew with \
         VIBRISSA_WRITE_REFERENCE=1 cargo test -p vibrissa-cli --test book"
    );
}
