//! One page for one machine: as much of HTTP as a browser needs to load it.

use std::hash::{BuildHasher, RandomState};
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::Duration;
use vibrissa::{Error, Result};

/// How long a browser may take for a request or an answer, and how often Ctrl-C is looked for.
const PATIENCE: Duration = Duration::from_secs(5);
const TURN: Duration = Duration::from_millis(20);
/// The longest request (bytes).
const LONGEST: usize = 16 * 1024;
/// What the page may do: its own scripts and library, and the sockets of live runs on this machine.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; \
                      style-src 'unsafe-inline'; img-src data: blob:; \
                      connect-src ws://127.0.0.1:* ws://localhost:*; base-uri 'none'; form-action 'none'";

/// A page's server, on the loopback interface only.
pub(crate) struct Server {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
}

impl Server {
    pub(crate) fn start(port: u16) -> Result<Self> {
        let fault = |reason: std::io::Error| {
            Error::data(format!("cannot serve the page ({reason})"))
                .value(format!("127.0.0.1:{port}"))
                .remedy("choose another port, or 0 for any that is free: --port 0")
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fault)?;
        listener.set_nonblocking(true).map_err(fault)?;
        let address = listener.local_addr().map_err(fault)?;
        Ok(Self { listener, address, token: token() })
    }

    /// Where the page is.
    pub(crate) fn address(&self) -> String {
        format!("http://{}/{}/", self.address, self.token)
    }

    /// Serves the page until `stopped`.
    pub(crate) fn serve(&self, page: &[u8], stopped: &(dyn Fn() -> bool + Sync)) {
        std::thread::scope(|scope| {
            while !stopped() {
                match self.listener.accept() {
                    Ok((stream, _)) => drop(scope.spawn(move || answer(stream, page, &self.token))),
                    Err(error) if error.kind() == ErrorKind::WouldBlock => std::thread::sleep(TURN),
                    // A connection that broke before it began.
                    Err(_) => std::thread::sleep(TURN),
                }
            }
        });
    }
}

/// 128 bits that differ from run to run: the keys that the system gives to hash maps.
fn token() -> String {
    let half = || RandomState::new().hash_one("vibrissa studio");
    format!("{:016x}{:016x}", half(), half())
}

/// Answers one request; whoever does not speak HTTP is hung up on.
fn answer(mut stream: TcpStream, page: &[u8], token: &str) {
    let ready = stream.set_nonblocking(false).is_ok()
        && stream.set_read_timeout(Some(PATIENCE)).is_ok()
        && stream.set_write_timeout(Some(PATIENCE)).is_ok();
    let Some(request) = ready.then(|| request(&mut stream)).flatten() else { return };
    let (status, kind, body) = reply(&request, page, token);
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nContent-Security-Policy: {POLICY}\r\n\
         Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    );
    let whole = stream.write_all(head.as_bytes());
    // A browser that leaves early has seen enough.
    let _ = whole.and_then(|()| if request.starts_with("HEAD ") { Ok(()) } else { stream.write_all(body) });
}

/// The head of a request.
fn request(stream: &mut TcpStream) -> Option<String> {
    let (mut bytes, mut piece) = (Vec::new(), [0; 2048]);
    while !bytes.windows(4).any(|window| window == b"\r\n\r\n") {
        let count = stream.read(&mut piece).ok().filter(|&count| count > 0 && bytes.len() + count <= LONGEST)?;
        bytes.extend_from_slice(&piece[..count]);
    }
    String::from_utf8(bytes).ok()
}

/// Status, type and body for a request.
fn reply<'a>(request: &str, page: &'a [u8], token: &str) -> (&'static str, &'static str, &'a [u8]) {
    let mut words = request.split_whitespace();
    let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let plain = "text/plain; charset=utf-8";
    if method != "GET" && method != "HEAD" {
        return ("405 Method Not Allowed", plain, b"only GET\n");
    }
    let inside = path.strip_prefix('/').and_then(|path| path.split('?').next());
    match inside.and_then(|path| path.strip_suffix('/')) {
        Some(given) if given == token => ("200 OK", "text/html; charset=utf-8", page),
        _ => ("404 Not Found", plain, b"the address of the studio holds a token: copy all of it from the terminal\n"),
    }
}

#[cfg(test)]
mod tests {
    use super::{reply, token};

    #[test]
    fn only_the_whole_address_gives_the_page() {
        let status = |request: &str| reply(request, b"page", "0123").0;
        assert_eq!(status("GET /0123/ HTTP/1.1\r\n\r\n"), "200 OK");
        assert_eq!(status("HEAD /0123/?x=1 HTTP/1.1\r\n\r\n"), "200 OK");
        for path in ["/", "/0123", "/012/", "/0123/../", "//0123/", "0123/", "/0123/x", ""] {
            assert_eq!(status(&format!("GET {path} HTTP/1.1\r\n\r\n")), "404 Not Found", "{path}");
        }
        assert_eq!(status("POST /0123/ HTTP/1.1\r\n\r\n"), "405 Method Not Allowed");
    }

    #[test]
    fn tokens_differ_and_are_long() {
        let tokens = [token(), token()];
        assert_ne!(tokens[0], tokens[1]);
        assert!(tokens.iter().all(|token| token.len() == 32 && token.chars().all(|c| c.is_ascii_hexdigit())));
    }
}
