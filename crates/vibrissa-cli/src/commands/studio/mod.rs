//! `vibrissa studio`: the page in the browser.

pub(crate) mod page;
pub(crate) mod server;

use crate::interrupt::{self, Heedful, stopped};
use crate::output::{print, write_bytes};
use serde_json::json;
use server::Server;
use std::path::{Path, PathBuf};
use vibrissa::{Error, Result};

/// Bend a whisker, drive a robot and watch the set of its places shrink, in the browser.
///
/// Serves one page to this machine only, at an address that nobody can guess; Ctrl-C ends it. With --out FILE the page is
/// written instead: one file that opens without a server and without a network. The page is built by `studio/build` in the
/// repository, which needs Node.js; it is looked for beside this program, and in `studio/dist`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Write the page as this one file (.html) and serve nothing
    #[arg(long, alias = "html", value_name = "FILE", conflicts_with = "port")]
    out: Option<PathBuf>,
    /// The page to take, as `studio/build` made it
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Port on 127.0.0.1; 0 is any that is free
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Print the address, or the file, as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let page = page::read(args.page.as_deref())?;
    if let Some(file) = &args.out {
        return write(file, &page, args.json);
    }
    let _heeds = Heedful::begin();
    let server = Server::start(args.port)?;
    let address = server.address();
    print(&if args.json {
        format!("{}\n", json!({ "url": address }))
    } else {
        format!("The studio is at {address}\nCtrl-C ends it.\n")
    })?;
    server.serve(&page, &stopped);
    // Ctrl-C is how it ends.
    interrupt::reset();
    Ok(())
}

fn write(file: &Path, page: &[u8], json: bool) -> Result<()> {
    let Some(name) = file.file_name().and_then(|name| name.to_str()).filter(|_| !file.is_dir()) else {
        return Err(Error::usage("--out").value(file.display()).allowed("a file, such as studio.html"));
    };
    let folder = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let written = write_bytes(folder, &[(name, page)])?;
    let path = written.first().map_or_else(|| file.display().to_string(), |path| path.display().to_string());
    print(&if json { format!("{}\n", json!({ "file": path })) } else { format!("Written: {path}\n") })
}
