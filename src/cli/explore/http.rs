//! A strict HTTP/1.1 server for the one page that this computer's own browser looks at: bound to 127.0.0.1, reached under
//! a secret token only, and closed to the pages of other origins and other names of this address. What a request says is
//! read by [`head`], a pure function; a [`Server`] keeps the times and the order, and a handler answers. A request is
//! judged in this order: its form (400, 431, 505), who asks (403), the path with its token (404), the method (405), what
//! is never supported (417, 400), the type of the body (415), its length (411, 400, 413), then the body itself (408, 400).
//! Nothing is mended: after a refusal the connection is closed.
#![allow(clippy::disallowed_types, reason = "the one file that listens")]

use std::hint::black_box;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use httparse::{EMPTY_HEADER, Error, Header, Status};

/// Most bytes of a head.
const MAX_HEAD: usize = 16 * 1024;
/// Most bytes of a body.
const MAX_BODY: usize = 64 * 1024;
/// Most headers of a head.
const MAX_HEADERS: usize = 64;
/// Most connections that are served at once, and most that make room or hear at once that there are too many.
const MAX_CONNECTIONS: usize = 16;
/// How the two names of this computer are written in `Host` and `Origin`.
const NAMES: [&str; 2] = ["127.0.0.1", "localhost"];
/// What every response says of itself.
const FIXED: &str = "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\nX-Frame-Options: DENY\r\n";

/// What a request wants done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// To read.
    Get,
    /// To be given the answer to its body.
    Post,
}

/// A request that has kept every rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// What is wanted.
    pub method: Method,
    /// What is behind the token: nothing, or a word of the letters a to z.
    pub path: String,
    /// The body; empty without one.
    pub body: String,
}

/// What a handler answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Response {
    /// The status, of 200 to 599.
    pub status: u16,
    /// The `Content-Type`.
    pub kind: &'static str,
    /// The body.
    pub body: Vec<u8>,
    /// The `Content-Security-Policy`.
    pub policy: Option<String>,
}

impl Response {
    /// A short text of the server's own.
    fn plain(status: u16, text: &str) -> Response {
        Response { status, kind: "text/plain; charset=utf-8", body: format!("{text}\n").into_bytes(), policy: None }
    }

    /// Whether it can be written: a status with a body, and no line end in a header.
    fn is_sound(&self) -> bool {
        let visible = |text: &str| text.bytes().all(|b| matches!(b, b' '..=b'~'));
        matches!(self.status, 200..=599) && visible(self.kind) && self.policy.as_deref().is_none_or(visible)
    }

    /// As it is sent.
    fn encode(&self, keep_alive: bool) -> Vec<u8> {
        let (status, connection) = (self.status, if keep_alive { "keep-alive" } else { "close" });
        let mut head = format!(
            "HTTP/1.1 {status} {}\r\nContent-Length: {}\r\nContent-Type: {}\r\n{FIXED}Connection: {connection}\r\n",
            reason(status),
            self.body.len(),
            self.kind
        );
        if status == 405 {
            head += "Allow: GET, POST\r\n";
        }
        if let Some(policy) = &self.policy {
            head += &format!("Content-Security-Policy: {policy}\r\n");
        }
        head += "\r\n";
        [head.as_bytes(), &self.body].concat()
    }
}

/// The standard phrase of a status; a client needs none.
fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        411 => "Length Required",
        413 => "Content Too Large",
        415 => "Unsupported Media Type",
        417 => "Expectation Failed",
        431 => "Request Header Fields Too Large",
        500 => "Internal Server Error",
        503 => "Service Unavailable",
        505 => "HTTP Version Not Supported",
        _ => "",
    }
}

/// What the head of a request says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// What is wanted.
    pub method: Method,
    /// What is behind the token: nothing, or a word of the letters a to z.
    pub path: String,
    /// Bytes of the body.
    pub length: usize,
    /// Whether the connection stays open after the response.
    pub keep_alive: bool,
    /// Bytes of the head; the body begins there.
    pub size: usize,
}

/// Why a request is not answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused {
    /// The status.
    pub status: u16,
    /// The reason, in a few words.
    pub why: &'static str,
}

fn refuse<T>(status: u16, why: &'static str) -> Result<T, Refused> {
    Err(Refused { status, why })
}

/// What the first bytes of a connection say, sent to this port under this token; nothing as long as more bytes are needed.
///
/// # Errors
/// Where the request breaks a rule: the first in the order of the module's description.
pub fn head(bytes: &[u8], port: u16, token: &str) -> Result<Option<Head>, Refused> {
    let bytes = &bytes[..bytes.len().min(MAX_HEAD)];
    let mut headers = [EMPTY_HEADER; MAX_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let size = match parsed.parse(bytes) {
        Ok(Status::Complete(size)) => size,
        Ok(Status::Partial) if bytes.len() < MAX_HEAD => return Ok(None),
        Ok(Status::Partial) => return refuse(431, "the head is longer than 16 KiB"),
        Err(Error::TooManyHeaders) => return refuse(431, "there are more than 64 headers"),
        Err(Error::Version) => return refuse(505, "this is not HTTP/1.1"),
        Err(_) => return refuse(400, "this is not a request"),
    };
    // The parser takes a line feed alone for a line end too.
    let lines = bytes[..size].iter().filter(|b| **b == b'\n').count();
    if lines != bytes[..size].windows(2).filter(|pair| *pair == b"\r\n").count() {
        return refuse(400, "a line ends without a carriage return");
    }
    let headers = Headers(parsed.headers);
    headers.check_origin(port)?;
    let Some(path) = parsed.path.and_then(|target| word(target, token)) else {
        return refuse(404, "there is nothing here");
    };
    let method = match parsed.method {
        Some("GET") => Method::Get,
        Some("POST") => Method::Post,
        _ => return refuse(405, "only GET and POST are answered"),
    };
    let length = headers.body_length(method)?;
    let keep_alive = parsed.version == Some(1) && !headers.says_close();
    Ok(Some(Head { method, path: path.into(), length, keep_alive, size }))
}

/// The word behind the token of a request's target.
fn word<'a>(target: &'a str, token: &str) -> Option<&'a str> {
    let (given, word) = target.strip_prefix('/')?.split_once('/')?;
    // Both are looked at, whatever the first says.
    let known = is_same(given.as_bytes(), token.as_bytes()) & word.bytes().all(|b| b.is_ascii_lowercase());
    known.then_some(word)
}

/// Whether two texts are the same, in a time that depends on their lengths alone.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |differ, (a, b)| black_box(differ | (a ^ b))) == 0
}

/// The headers of a request.
struct Headers<'a>(&'a [Header<'a>]);

impl<'a> Headers<'a> {
    /// Every value that a header is given.
    fn all(&self, name: &str) -> impl Iterator<Item = &'a [u8]> {
        self.0.iter().filter(move |header| header.name.eq_ignore_ascii_case(name)).map(|header| header.value)
    }

    /// The value of a header that is given exactly once.
    fn one(&self, name: &str) -> Option<&'a [u8]> {
        let mut values = self.all(name);
        values.next().filter(|_| values.next().is_none())
    }

    /// Whether the request was sent to this server by name, and by nobody but its own page or the user.
    fn check_origin(&self, port: u16) -> Result<(), Refused> {
        let is_own = |value: &[u8]| {
            let is_at = |name: &str| {
                // What browsers write at HTTP's own port is the name alone.
                value.eq_ignore_ascii_case(format!("{name}:{port}").as_bytes())
                    || (port == 80 && value.eq_ignore_ascii_case(name.as_bytes()))
            };
            NAMES.into_iter().any(is_at)
        };
        if !self.one("Host").is_some_and(is_own) {
            return refuse(403, "this is not the server's name");
        }
        if !self.all("Origin").all(|value| value.strip_prefix(b"http://").is_some_and(is_own)) {
            return refuse(403, "the request is of another origin");
        }
        if !self.all("Sec-Fetch-Site").all(|site| site == b"same-origin" || site == b"none") {
            return refuse(403, "the request is of another site");
        }
        Ok(())
    }

    /// Bytes of the body of a request.
    fn body_length(&self, method: Method) -> Result<usize, Refused> {
        if self.all("Expect").next().is_some() {
            return refuse(417, "no expectation is met");
        }
        if self.all("Transfer-Encoding").next().is_some() {
            return refuse(400, "a body has a Content-Length and no Transfer-Encoding");
        }
        if method == Method::Post && !self.one("Content-Type").is_some_and(is_json) {
            return refuse(415, "a body is application/json");
        }
        if self.all("Content-Length").next().is_none() {
            return if method == Method::Post { refuse(411, "a Content-Length is needed") } else { Ok(0) };
        }
        let digits = self.one("Content-Length").filter(|value| value.iter().all(u8::is_ascii_digit));
        let Some(digits) = digits.and_then(|value| str::from_utf8(value).ok()).filter(|value| !value.is_empty()) else {
            return refuse(400, "the Content-Length is not one number");
        };
        // What does not fit into a number is too large as well.
        match digits.parse().unwrap_or(usize::MAX) {
            1.. if method == Method::Get => refuse(400, "GET has no body"),
            length if length > MAX_BODY => refuse(413, "the body is longer than 64 KiB"),
            length => Ok(length),
        }
    }

    /// Whether the client wants the connection closed.
    fn says_close(&self) -> bool {
        let mut options = self.all("Connection").flat_map(|value| value.split(|b| *b == b','));
        options.any(|option| option.trim_ascii().eq_ignore_ascii_case(b"close"))
    }
}

/// Whether a content type is JSON, with parameters or without.
fn is_json(value: &[u8]) -> bool {
    let kind = value.split(|b| *b == b';').next().unwrap_or_default();
    kind.trim_ascii().eq_ignore_ascii_case(b"application/json")
}

/// How long is waited for what.
#[derive(Debug, Clone, Copy)]
struct Times {
    /// For the first byte of a request.
    idle: Duration,
    /// For the rest of its head.
    head: Duration,
    /// For its body.
    body: Duration,
    /// Until a response is taken.
    write: Duration,
    /// Until a client that was refused ends the connection.
    close: Duration,
    /// After which a client that has not sent a request, or takes no response, makes room, where all places are taken.
    stall: Duration,
}

impl Times {
    /// What the program waits.
    const USUAL: Times = Times {
        idle: Duration::from_secs(10),
        head: Duration::from_secs(10),
        body: Duration::from_secs(10),
        write: Duration::from_secs(10),
        close: Duration::from_secs(1),
        stall: Duration::from_millis(500),
    };
    /// Between two questions whether to stop, where bytes are waited for.
    const READ: Duration = Duration::from_millis(100);
    /// Between two looks for a connection.
    const ACCEPT: Duration = Duration::from_millis(10);
    /// Between two looks for room in the way to a client.
    const FULL: Duration = Duration::from_millis(2);
    /// After a connection that could not be taken.
    const FAILED: Duration = Duration::from_millis(50);
}

/// A server that is bound to its port.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    port: u16,
    token: String,
    times: Times,
}

impl Server {
    /// Binds a port of 127.0.0.1, any free one for 0. The token is of letters, digits, `-` and `_`.
    ///
    /// # Errors
    /// Where the port cannot be bound, or the token is not one.
    pub fn bind(port: u16, token: String) -> io::Result<Server> {
        if token.is_empty() || !token.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-' || b == b'_') {
            return Err(io::Error::new(ErrorKind::InvalidInput, "a token is of letters, digits, `-` and `_`"));
        }
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        let port = listener.local_addr()?.port();
        Ok(Server { listener, port, token, times: Times::USUAL })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Serves until `stop` says true, which it then keeps saying. Requests that the handler is at are answered before.
    /// `tick` is called between connections, again and again.
    pub fn serve(
        &self,
        handler: &(dyn Fn(&Request) -> Response + Sync),
        tick: &dyn Fn(),
        stop: &(dyn Fn() -> bool + Sync),
    ) {
        let (served, refused) = (Places::default(), Places::default());
        thread::scope(|scope| {
            while !stop() {
                tick();
                let stream = match self.listener.accept() {
                    Ok((stream, _)) => stream,
                    Err(error) => {
                        let nobody = error.kind() == ErrorKind::WouldBlock;
                        thread::sleep(if nobody { Times::ACCEPT } else { Times::FAILED });
                        continue;
                    }
                };
                let builder = thread::Builder::new();
                let place = served.take().or_else(|| served.take_of_stalled(self.times.stall));
                let started = if let Some(place) = place {
                    let Ok(connection) = Connection::new(stream, self, stop, place) else { continue };
                    builder.spawn_scoped(scope, move || connection.serve(handler))
                } else if let Some(place) = refused.take() {
                    let Ok(connection) = Connection::new(stream, self, stop, place) else { continue };
                    builder.spawn_scoped(scope, move || connection.refuse())
                } else {
                    continue;
                };
                if started.is_err() {
                    thread::sleep(Times::FAILED);
                }
            }
        });
    }
}

/// The places for connections.
#[derive(Default)]
struct Places(Mutex<Vec<Arc<Seat>>>);

/// A place that is taken.
struct Seat {
    /// Since when a request, or that a response is taken, is waited for; nothing while the server is at a request.
    waits: Mutex<Option<Instant>>,
    /// True if it is to make room: its place belongs to another connection already.
    leaves: AtomicBool,
}

/// One of the places, until it is dropped.
struct Place<'a> {
    seat: Arc<Seat>,
    places: &'a Places,
}

impl Places {
    fn seats(&self) -> MutexGuard<'_, Vec<Arc<Seat>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place, where one is free.
    fn take(&self) -> Option<Place<'_>> {
        let mut seats = self.seats();
        let staying = seats.iter().filter(|seat| !seat.leaves.load(Ordering::Acquire)).count();
        // A connection that makes room takes a moment to end.
        let is_free = staying < MAX_CONNECTIONS && seats.len() < 2 * MAX_CONNECTIONS;
        is_free.then(|| {
            let seat = Arc::new(Seat { waits: Mutex::default(), leaves: AtomicBool::new(false) });
            seats.push(seat.clone());
            Place { seat, places: self }
        })
    }

    /// The place of the connection that has been stalled for the longest time, and for that of `stall` at least.
    fn take_of_stalled(&self, stall: Duration) -> Option<Place<'_>> {
        let since = |seat: &Arc<Seat>| {
            let waits = seat.waits.lock().unwrap_or_else(PoisonError::into_inner);
            waits.filter(|since| since.elapsed() >= stall && !seat.leaves.load(Ordering::Acquire))
        };
        {
            let seats = self.seats();
            let (_, seat) =
                seats.iter().filter_map(|seat| Some((since(seat)?, seat))).min_by_key(|(since, _)| *since)?;
            seat.leaves.store(true, Ordering::Release);
        }
        self.take()
    }
}

impl Place<'_> {
    /// The client is waited for.
    fn wait(&self) {
        *self.seat.waits.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    /// The server is at its request.
    fn work(&self) {
        *self.seat.waits.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// True if it is to make room.
    fn leaves(&self) -> bool {
        self.seat.leaves.load(Ordering::Acquire)
    }
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        self.places.seats().retain(|seat| !Arc::ptr_eq(seat, &self.seat));
    }
}

/// Why there is no request.
enum Missing {
    /// The client has gone or is silent, or the server stops: nothing is said.
    Gone,
    /// A rule is broken.
    Refused(Refused),
}

impl From<Refused> for Missing {
    fn from(refused: Refused) -> Missing {
        Missing::Refused(refused)
    }
}

/// A client that is connected.
struct Connection<'a> {
    stream: TcpStream,
    server: &'a Server,
    stop: &'a (dyn Fn() -> bool + Sync),
    place: Place<'a>,
    /// What has been read and not yet used.
    buffer: Vec<u8>,
}

impl<'a> Connection<'a> {
    fn new(
        stream: TcpStream,
        server: &'a Server,
        stop: &'a (dyn Fn() -> bool + Sync),
        place: Place<'a>,
    ) -> io::Result<Connection<'a>> {
        // On some systems it is as the listener is.
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(Times::READ))?;
        place.wait();
        Ok(Connection { stream, server, stop, place, buffer: Vec::new() })
    }

    /// True if it is to end, whatever its client does.
    fn ends(&self) -> bool {
        (self.stop)() || self.place.leaves()
    }

    /// Answers one request after the other.
    fn serve(mut self, handler: &(dyn Fn(&Request) -> Response + Sync)) {
        loop {
            let request = self.request();
            self.place.work();
            let (response, keep_alive) = match request {
                // What panics or makes a response that is none has failed; the connection ends, the server does not.
                Ok((request, keep_alive)) => match catch_unwind(AssertUnwindSafe(|| handler(&request))) {
                    Ok(response) if response.is_sound() => (response, keep_alive && !(self.stop)()),
                    _ => (Response::plain(500, "the server has failed at this request"), false),
                },
                Err(Missing::Refused(refused)) => (Response::plain(refused.status, refused.why), false),
                Err(Missing::Gone) => return,
            };
            self.place.wait();
            if self.send(&response.encode(keep_alive)).is_err() {
                return;
            }
            if !keep_alive {
                return self.close();
            }
        }
    }

    /// Says that there are too many connections.
    fn refuse(mut self) {
        if self.send(&Response::plain(503, "there are too many connections").encode(false)).is_ok() {
            self.close();
        }
    }

    /// The next request, and whether the connection stays open after its response.
    fn request(&mut self) -> Result<(Request, bool), Missing> {
        let Server { port, token, times, .. } = self.server;
        if self.buffer.is_empty() && !self.read(Instant::now() + times.idle)? {
            return Err(Missing::Gone);
        }
        let deadline = Instant::now() + times.head;
        let head = loop {
            if let Some(head) = head(&self.buffer, *port, token)? {
                break head;
            }
            if !self.read(deadline)? {
                refuse::<()>(408, "the head took too long")?;
            }
        };
        let deadline = Instant::now() + times.body;
        let end = head.size + head.length;
        while self.buffer.len() < end {
            if !self.read(deadline)? {
                refuse::<()>(408, "the body took too long")?;
            }
        }
        // What is behind the body is the next request's.
        let body = self.buffer.drain(..end).skip(head.size).collect();
        let Ok(body) = String::from_utf8(body) else {
            return Ok(refuse(400, "the body is not UTF-8")?);
        };
        Ok((Request { method: head.method, path: head.path, body }, head.keep_alive))
    }

    /// Waits for more bytes; false where none came in time.
    fn read(&mut self, deadline: Instant) -> Result<bool, Missing> {
        let mut bytes = [0; 8 * 1024];
        while !self.ends() {
            if Instant::now() >= deadline {
                return Ok(false);
            }
            match self.stream.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => {
                    self.buffer.extend_from_slice(&bytes[..count]);
                    return Ok(true);
                }
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
                Err(_) => break,
            }
        }
        Err(Missing::Gone)
    }

    /// Sends all of it in the time for that. A client that takes nothing more is left when the server stops.
    fn send(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        let deadline = Instant::now() + self.server.times.write;
        // Not with a timeout: how much was sent before one is not known on every system.
        self.stream.set_nonblocking(true)?;
        while !bytes.is_empty() {
            match self.stream.write(bytes) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => {
                    self.place.wait();
                    bytes = &bytes[count..];
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if e.kind() == ErrorKind::WouldBlock && Instant::now() < deadline && !self.ends() => {
                    thread::sleep(Times::FULL);
                }
                Err(error) => return Err(error),
            }
        }
        self.stream.set_nonblocking(false)
    }

    /// Ends the connection. What the client still sends is read, because a system may take back a response where a
    /// connection is dropped with bytes unread.
    fn close(mut self) {
        let deadline = Instant::now() + self.server.times.close;
        if self.stream.shutdown(Shutdown::Write).is_ok() {
            while let Ok(true) = self.read(deadline) {
                self.buffer.clear();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_methods, reason = "the tests are the browser")]

    use std::net::SocketAddr;
    use std::sync::atomic::AtomicBool;

    use super::*;

    const PORT: u16 = 4321;
    const TOKEN: &str = "s3cret";
    /// Long enough for a busy machine, short enough to wait for.
    const SHORT: Duration = Duration::from_millis(300);

    /// A request of these lines, to the port of the pure tests.
    fn lines(lines: &[&str]) -> String {
        lines.iter().flat_map(|line| [*line, "\r\n"]).chain(["\r\n"]).collect()
    }

    fn get_with(headers: &[&str]) -> String {
        lines(&[&["GET /s3cret/ HTTP/1.1", "Host: 127.0.0.1:4321"], headers].concat())
    }

    fn post_with(headers: &[&str]) -> String {
        lines(&[&["POST /s3cret/ask HTTP/1.1", "Host: localhost:4321"], headers].concat())
    }

    fn accepted(text: &str) -> Head {
        let head = head(text.as_bytes(), PORT, TOKEN).unwrap_or_else(|why| panic!("{why:?}\n{text}"));
        head.unwrap_or_else(|| panic!("more is needed\n{text}"))
    }

    /// The status of a refusal, 0 where there is none.
    fn status(text: &str) -> u16 {
        head(text.as_bytes(), PORT, TOKEN).map_or_else(|refused| refused.status, |_| 0)
    }

    #[test]
    fn a_head_says_what_is_wanted() {
        let text = get_with(&["Accept: */*", "Sec-Fetch-Site: none"]);
        let want = Head { method: Method::Get, path: String::new(), length: 0, keep_alive: true, size: text.len() };
        assert_eq!(accepted(&text), want);
        let text = post_with(&[
            "Content-Type: application/json",
            "CONTENT-LENGTH:  0012 ",
            "Origin: http://127.0.0.1:4321",
            "Sec-Fetch-Site: same-origin",
        ]);
        let want = Head { method: Method::Post, path: "ask".into(), length: 12, keep_alive: true, size: text.len() };
        assert_eq!(accepted(&(text + "{}")), want);
        let text = format!("\r\n{}", get_with(&[]));
        assert_eq!(accepted(&text).size, text.len(), "an empty line before a request belongs to it");
    }

    #[test]
    fn there_is_nothing_but_the_token_and_a_word() {
        for target in "/|/s3cret|/s3cret//|//s3cret/|/s3cre/|/s3cret1/|/S3CRET/|/x3cret/ask|//ask|/ask|/s3cret/ask/|\
            /s3cret/ask/x|/s3cret/Ask|/s3cret/a1|/s3cret/..|/s3cret/../s3cret/|/s3cret/.|/s3cret/%2e%2e|\
            /s3cret/%61sk|/s3cret/?|/s3cret/?q=1|/s3cret/ask?q|/s3cret/#a|/s3cret/a\\b|/s3cret?/|/./s3cret/|\
            /%733cret/|/s3cret/é|*|s3cret/|http://127.0.0.1:4321/s3cret/|127.0.0.1:4321|/s3cret/a;b|\
            /s3cret/a+b|/s3cret/index.html"
            .split('|')
        {
            assert_eq!(status(&lines(&[&format!("GET {target} HTTP/1.1"), "Host: localhost:4321"])), 404, "{target}");
        }
        for (target, path) in [("/s3cret/", ""), ("/s3cret/ask", "ask"), ("/s3cret/z", "z")] {
            let text = lines(&[&format!("GET {target} HTTP/1.1"), "Host: localhost:4321"]);
            assert_eq!(accepted(&text).path, path);
        }
        assert!(is_same(b"", b"") && is_same(b"ab", b"ab"));
        assert!(!is_same(b"ab", b"a") && !is_same(b"ab", b"aa") && !is_same(b"ab", b"bb") && !is_same(b"ab", b"ba"));
    }

    #[test]
    fn the_host_is_this_server_once() {
        let hosts = |hosts: &[&str]| {
            let hosts = hosts.iter().map(|host| format!("Host: {host}"));
            let all: Vec<String> = ["GET /s3cret/ HTTP/1.1".into()].into_iter().chain(hosts).collect();
            status(&lines(&all.iter().map(String::as_str).collect::<Vec<_>>()))
        };
        for good in ["127.0.0.1:4321", "localhost:4321", "LOCALHOST:4321"] {
            assert_eq!(hosts(&[good]), 0, "{good}");
            assert_eq!(hosts(&[good, good]), 403, "{good} twice");
        }
        for bad in "|127.0.0.1|localhost|127.0.0.1:4322|127.0.0.1:04321|evil.example:4321|127.0.0.2:4321|\
            localhost:4321.evil.example|localhost.:4321|x@localhost:4321|[::1]:4321|http://localhost:4321|\
            localhost:4321, localhost:4321|localhost: 4321"
            .split('|')
        {
            assert_eq!(hosts(&[bad]), 403, "{bad}");
        }
        assert_eq!(hosts(&[]), 403);
        for (port, host, good) in [(80, "localhost", true), (80, "127.0.0.1:80", true), (81, "localhost", false)] {
            let text = lines(&["GET /s3cret/ HTTP/1.1", &format!("Host: {host}")]);
            assert_eq!(head(text.as_bytes(), port, TOKEN).is_ok(), good, "{host} at {port}");
        }
    }

    #[test]
    fn the_origin_and_the_site_are_its_own() {
        for good in ["Origin: http://localhost:4321", "Origin: http://127.0.0.1:4321", "Sec-Fetch-Site: same-origin"] {
            assert_eq!(status(&get_with(&[good])), 0, "{good}");
        }
        for bad in "Origin: null|Origin:|Origin: https://localhost:4321|Origin: http://localhost:4322|\
            Origin: http://localhost|Origin: http://evil.example|Origin: http://localhost:4321/|\
            Origin: localhost:4321|Origin: http://localhost:4321 http://evil.example|\
            Sec-Fetch-Site: cross-site|Sec-Fetch-Site: same-site|Sec-Fetch-Site:|\
            Sec-Fetch-Site: none, cross-site"
            .split('|')
        {
            assert_eq!(status(&get_with(&[bad])), 403, "{bad}");
            let good = ["Origin: http://localhost:4321", "Sec-Fetch-Site: none"];
            assert_eq!(status(&get_with(&[&good, &[bad][..]].concat())), 403, "{bad} beside a good one");
        }
    }

    #[test]
    fn what_is_wrong_first_is_said() {
        let text = |host: &str, target: &str, method: &str, header: &str| {
            status(&lines(&[&format!("{method} {target} HTTP/1.1"), &format!("Host: {host}"), header]))
        };
        let (host, expect, other) = ("localhost:4321", "Expect: 100-continue", "Accept: */*");
        assert_eq!(text("evil", "/", "PUT", expect), 403);
        assert_eq!(text(host, "/", "PUT", expect), 404);
        assert_eq!(text(host, "/s3cret/", "PUT", expect), 405);
        assert_eq!(text(host, "/s3cret/", "POST", expect), 417);
        assert_eq!(text(host, "/s3cret/", "POST", "Transfer-Encoding: chunked"), 400);
        assert_eq!(text(host, "/s3cret/", "POST", other), 415);
        assert_eq!(text(host, "/s3cret/", "POST", "Content-Type: application/json"), 411);
        for method in ["HEAD", "OPTIONS", "PUT", "DELETE", "TRACE", "CONNECT", "get", "Post", "GETS"] {
            assert_eq!(text(host, "/s3cret/", method, other), 405, "{method}");
        }
    }

    #[test]
    fn a_body_is_json() {
        for good in ["application/json", "Application/JSON", "application/json; charset=utf-8", "application/json ;x"] {
            assert_eq!(status(&post_with(&[&format!("Content-Type: {good}"), "Content-Length: 2"])), 0, "{good}");
        }
        for bad in "|text/plain|text/plain; application/json|application/jsonp|application/json, text/plain|\
            application/x-www-form-urlencoded|multipart/form-data; boundary=x|*/*"
            .split('|')
        {
            assert_eq!(status(&post_with(&[&format!("Content-Type: {bad}"), "Content-Length: 2"])), 415, "{bad}");
        }
        let twice = ["Content-Type: application/json", "Content-Type: text/plain", "Content-Length: 2"];
        assert_eq!(status(&post_with(&twice)), 415);
    }

    #[test]
    fn a_length_is_one_number() {
        const JSON: &str = "Content-Type: application/json";
        for (value, want) in [
            ("0", 0),
            ("65536", 0),
            ("65537", 413),
            ("18446744073709551616", 413),
            ("99999999999999999999999", 413),
            ("", 400),
            ("+1", 400),
            ("-1", 400),
            ("0x10", 400),
            ("1 2", 400),
            ("1,1", 400),
            ("1.0", 400),
            ("1e1", 400),
            ("\u{661}", 400),
        ] {
            let header = format!("Content-Length: {value}");
            assert_eq!(status(&post_with(&[JSON, &header])), want, "{value}");
            assert_eq!(status(&get_with(&[&header])), if value == "0" { 0 } else { 400 }, "GET {value}");
        }
        let twice = ["Content-Length: 0", "content-length: 0"];
        assert_eq!(status(&get_with(&twice)), 400);
        assert_eq!(status(&post_with(&[&[JSON], &twice[..]].concat())), 400);
        for coding in ["chunked", "identity", "", "gzip, chunked", "xchunked", "\x0bchunked"] {
            let coding = format!("transfer-ENCODING: {coding}");
            assert_eq!(status(&get_with(&[&coding])), 400, "GET {coding}");
            assert_eq!(status(&post_with(&[JSON, "Content-Length: 2", &coding])), 400, "{coding}");
        }
    }

    #[test]
    fn a_head_has_a_form() {
        let good = get_with(&["A: b"]);
        assert_eq!(status(&good), 0);
        for (from, to, want) in [
            ("A: b", "A : b", 400),
            ("A: b", " A: b", 400),
            ("A: b", "A: b\r\n c", 400),
            ("A: b", "A", 400),
            ("A: b", ": b", 400),
            ("A: b", "A: b\0", 400),
            ("A: b", "A: b\rC: d", 400),
            ("A: b\r\n", "A: b\n", 400),
            ("1.1\r\n", "1.1\n", 400),
            ("\r\n\r\n", "\r\n\n", 400),
            ("\r\n\r\n", "\n\n", 400),
            ("GET", "\nGET", 400),
            ("GET ", "GET  ", 400),
            (" HTTP", "  HTTP", 505),
            ("GET", "G@T", 400),
            ("GET", " GET", 400),
            ("1.1", "1.2", 505),
            ("1.1", "2.0", 505),
            (" HTTP/1.1", "", 400),
            ("HTTP", "http", 505),
        ] {
            assert_eq!(status(&good.replacen(from, to, 1)), want, "{from:?} as {to:?}");
        }
        assert_eq!(status("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"), 505);
        assert_eq!(status("\x16\x03\x01\x02\0\x01\0"), 400, "TLS");
    }

    #[test]
    fn a_head_has_bounds() {
        let padded = |size: usize| {
            let pad = size - get_with(&["A: "]).len();
            get_with(&[&format!("A: {}", "x".repeat(pad))])
        };
        assert_eq!(accepted(&padded(MAX_HEAD)).size, MAX_HEAD);
        assert_eq!(accepted(&(padded(MAX_HEAD) + "what follows")).size, MAX_HEAD);
        assert_eq!(status(&padded(MAX_HEAD + 1)), 431);
        assert_eq!(status(&padded(MAX_HEAD + 1)[..MAX_HEAD]), 431);
        assert_eq!(head(&padded(MAX_HEAD).as_bytes()[..MAX_HEAD - 1], PORT, TOKEN), Ok(None));
        assert_eq!(status(&"\r\n".repeat(MAX_HEAD)), 431);
        // One of them is the host.
        assert_eq!(status(&get_with(&["A: b"; MAX_HEADERS - 1])), 0);
        assert_eq!(status(&get_with(&["A: b"; MAX_HEADERS])), 431);
    }

    #[test]
    fn a_connection_stays_open_where_both_can() {
        for (option, want) in [
            ("Connection: keep-alive", true),
            ("Connection: close", false),
            ("connection: Keep-Alive , CLOSE", false),
            ("Connection: closed", true),
            ("Connection:", true),
        ] {
            let text = get_with(&[option]);
            assert_eq!(accepted(&text).keep_alive, want, "{option}");
            assert!(!accepted(&text.replace("HTTP/1.1", "HTTP/1.0")).keep_alive, "1.0 {option}");
        }
        assert!(!accepted(&get_with(&["Connection: keep-alive", "Connection: close"])).keep_alive);
    }

    /// Numbers that look random.
    fn draws(mut seed: u64) -> impl FnMut(usize) -> usize {
        move |below| {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as usize % below
        }
    }

    #[test]
    fn noise_and_pieces_are_judged_alike() {
        let long = "x".repeat(5000);
        let parts = "GET |POST |/s3cret/|ask| HTTP/1.1| HTTP/1.0|\r\n|\r\n|\r\n\r\n|\n|\r| |:|\0|é|Host: localhost:4321\r\n|\
            Host: 127.0.0.1:4321\r\n|Content-Length: 3\r\n|Transfer-Encoding: x\r\n|Content-Type: application/json\r\n|\
            GET /s3cret/ HTTP/1.1\r\nHost: localhost:4321\r\n|POST /s3cret/ask HTTP/1.1\r\nHost: localhost:4321\r\n";
        let parts: Vec<&str> = parts.split('|').chain([long.as_str()]).collect();
        let mut draw = draws(1);
        let mut accepted = 0;
        for _ in 0..20_000 {
            let mut bytes: Vec<u8> = (0..draw(9)).flat_map(|_| parts[draw(parts.len())].bytes()).collect();
            if draw(2) == 0 {
                bytes.splice(0..0, post_with(&["Content-Type: application/json", "Content-Length: 7"]).into_bytes());
            }
            if !bytes.is_empty() && draw(4) == 0 {
                let at = draw(bytes.len());
                bytes[at] = draw(256) as u8;
            }
            let whole = head(&bytes, PORT, TOKEN);
            if let Ok(Some(head)) = &whole {
                accepted += 1;
                assert!(head.size <= bytes.len().min(MAX_HEAD) && head.length <= MAX_BODY);
                assert!(head.path.bytes().all(|b| b.is_ascii_lowercase()));
            }
            // What is decided by the first bytes is not decided otherwise when more have come.
            let piece = head(&bytes[..draw(bytes.len() + 1)], PORT, TOKEN);
            assert!(piece == Ok(None) || piece == whole, "{piece:?} {whole:?} {}", bytes.escape_ascii());
        }
        assert!(accepted > 1000, "{accepted}");
    }

    /// Stops the server, also where a test fails.
    struct Stop<'a>(&'a AtomicBool);

    impl Drop for Stop<'_> {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Release);
        }
    }

    /// What the tests' server answers: what it was asked; a panic; what cannot be sent; much.
    fn echo(request: &Request) -> Response {
        let Request { method, path, body } = request;
        let text = format!("{method:?} [{path}] {body}");
        let mut response = Response { status: 200, kind: "text/html", body: text.into(), policy: None };
        match path.as_str() {
            "panic" => panic!("asked for"),
            "split" => response.policy = Some("x\r\nSet-Cookie: y".into()),
            "status" => response.status = 100,
            "policy" => response.policy = Some("default-src 'none'".into()),
            "much" => response.body = vec![b'x'; 64 << 20],
            _ => {}
        }
        response
    }

    /// Runs a test against a server with these times: what it returns, and how long the server took to stop after it.
    fn serving<T>(times: Times, test: impl FnOnce(SocketAddr) -> T) -> (T, Duration) {
        let server = Server { times, ..Server::bind(0, TOKEN.into()).unwrap() };
        let (stop, address) = (AtomicBool::new(false), server.listener.local_addr().unwrap());
        thread::scope(|scope| {
            let running = scope.spawn(|| server.serve(&echo, &|| (), &|| stop.load(Ordering::Acquire)));
            let guard = Stop(&stop);
            let tested = test(address);
            let told = Instant::now();
            drop(guard);
            running.join().unwrap();
            (tested, told.elapsed())
        })
    }

    /// A client that fails rather than waits forever.
    fn connect(address: SocketAddr) -> TcpStream {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream
    }

    fn get(address: SocketAddr, path: &str) -> String {
        lines(&[&format!("GET /{TOKEN}/{path} HTTP/1.1"), &format!("Host: {address}")])
    }

    fn post(address: SocketAddr, body: &str) -> String {
        let (kind, length) = ("Content-Type: application/json", format!("Content-Length: {}", body.len()));
        lines(&[&format!("POST /{TOKEN}/ask HTTP/1.1"), &format!("Host: {address}"), kind, &length]) + body
    }

    /// The next response: its head and its body.
    fn response(stream: &mut TcpStream) -> (String, String) {
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap_or_else(|e| panic!("{e} after {}", head.escape_ascii()));
            head.push(byte[0]);
        }
        let head = String::from_utf8(head).unwrap();
        let (_, length) = head.split_once("Content-Length: ").unwrap();
        let mut body = vec![0; length.split_once("\r\n").unwrap().0.parse().unwrap()];
        stream.read_exact(&mut body).unwrap();
        (head, String::from_utf8(body).unwrap())
    }

    /// What comes until the server closes the connection.
    fn all(stream: &mut TcpStream) -> String {
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    }

    /// The status line of what comes to this, which is all that comes.
    fn refusal(address: SocketAddr, bytes: &[u8]) -> u16 {
        let mut stream = connect(address);
        stream.write_all(bytes).unwrap();
        let text = all(&mut stream);
        assert!(text.contains("\r\nConnection: close\r\n") && text.matches("HTTP/1.1 ").count() == 1, "{text}");
        text["HTTP/1.1 ".len()..][..3].parse().unwrap()
    }

    #[test]
    fn every_response_says_how_it_may_be_used() {
        serving(Times::USUAL, |address| {
            let mut stream = connect(address);
            stream.write_all(get(address, "policy").as_bytes()).unwrap();
            let (head, body) = response(&mut stream);
            let want = "HTTP/1.1 200 OK\r\nContent-Length: 13\r\nContent-Type: text/html\r\nCache-Control: no-store\r\n\
                X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
                Cross-Origin-Resource-Policy: same-origin\r\nX-Frame-Options: DENY\r\nConnection: keep-alive\r\n\
                Content-Security-Policy: default-src 'none'\r\n\r\n";
            assert_eq!((head.as_str(), body.as_str()), (want, "Get [policy] "));
            stream.write_all(get(address, "").replace("GET", "PUT").as_bytes()).unwrap();
            let want = "HTTP/1.1 405 Method Not Allowed\r\nContent-Length: 31\r\n\
                Content-Type: text/plain; charset=utf-8\r\n";
            let text = all(&mut stream);
            assert!(
                text.starts_with(want) && text.contains(FIXED) && text.contains("\r\nAllow: GET, POST\r\n"),
                "{text}"
            );
            assert!(text.ends_with("\r\n\r\nonly GET and POST are answered\n"), "{text}");
            assert!(!text.contains("Policy: default") && !text.contains("Access-Control"), "{text}");
        });
    }

    #[test]
    fn only_this_computer_is_served() {
        let server = Server::bind(0, TOKEN.into()).unwrap();
        let address = server.listener.local_addr().unwrap();
        assert_eq!(address.ip(), Ipv4Addr::LOCALHOST);
        assert_eq!(server.address(), format!("http://{address}/{TOKEN}/"));
        assert!(TcpStream::connect((Ipv4Addr::new(127, 0, 0, 2), address.port())).is_err());
        assert!(Server::bind(address.port(), TOKEN.into()).is_err(), "the port is taken");
        for token in ["", "a/b", "a b", "ä", "a.b", "a\r\n"] {
            assert_eq!(Server::bind(0, token.into()).unwrap_err().kind(), ErrorKind::InvalidInput, "{token}");
        }
    }

    #[test]
    fn requests_are_answered_in_order() {
        serving(Times::USUAL, |address| {
            let mut stream = connect(address);
            let one = post(address, "{\"é\": 1}");
            let last = get(address, "last").replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n");
            let text = one.clone() + &get(address, "b") + &one + &last + &get(address, "never");
            // Once as a whole, once cut anywhere.
            stream.write_all((one.clone() + &get(address, "a")).as_bytes()).unwrap();
            assert_eq!(response(&mut stream).1, "Post [ask] {\"é\": 1}");
            assert_eq!(response(&mut stream).1, "Get [a] ");
            for piece in text.as_bytes().chunks(29) {
                stream.write_all(piece).unwrap();
                thread::sleep(Duration::from_millis(2));
            }
            for want in ["Post [ask] {\"é\": 1}", "Get [b] ", "Post [ask] {\"é\": 1}"] {
                assert_eq!(response(&mut stream).1, want);
            }
            let rest = all(&mut stream);
            assert!(rest.ends_with("Get [last] ") && rest.contains("Connection: close"), "{rest}");
        });
    }

    #[test]
    fn a_refusal_ends_the_connection() {
        serving(Times::USUAL, |address| {
            let good = get(address, "");
            let evil = good.replace("127.0.0.1", "evil.example") + &good;
            assert_eq!(refusal(address, evil.as_bytes()), 403);
            assert_eq!(refusal(address, (get(address, "a/b") + &good).as_bytes()), 404);
            assert_eq!(refusal(address, good.replace("1.1\r\n", "1.1\r\nCookie: x\0\r\n").as_bytes()), 400);
            // What a client sends after it is too much does not take the response back.
            assert_eq!(refusal(address, post(address, &"x".repeat(MAX_BODY + 1)).as_bytes()), 413);
            assert_eq!(refusal(address, good.replace("\r\n\r\n", &"x".repeat(2 * MAX_HEAD)).as_bytes()), 431);
            let mut text = post(address, "12").into_bytes();
            let end = text.len();
            text[end - 2..].copy_from_slice(&[0xc3, 0x28]);
            assert_eq!(refusal(address, &text), 400);
            let mut stream = connect(address);
            stream.write_all(post(address, &"x".repeat(MAX_BODY)).as_bytes()).unwrap();
            assert_eq!(response(&mut stream).1.len(), MAX_BODY + "Post [ask] ".len());
        });
    }

    #[test]
    fn who_is_refused_may_end_what_he_says_but_not_go_on() {
        serving(Times { close: 2 * SHORT, ..Times::USUAL }, |address| {
            let mut stream = connect(address);
            let text = post(address, &"x".repeat(MAX_BODY + 1));
            let (head, body) = text.split_at(text.len() - MAX_BODY - 1);
            stream.write_all(head.as_bytes()).unwrap();
            assert!(all(&mut stream).starts_with("HTTP/1.1 413 "));
            let start = Instant::now();
            for piece in body.as_bytes().chunks(MAX_BODY / 5) {
                stream.write_all(piece).unwrap();
                thread::sleep(Duration::from_millis(20));
            }
            while stream.write_all(b"x").is_ok() {
                assert!(start.elapsed() < 20 * SHORT);
                thread::sleep(Duration::from_millis(20));
            }
        });
    }

    #[test]
    fn a_handler_that_fails_does_not_stop_the_server() {
        serving(Times::USUAL, |address| {
            for path in ["panic", "split", "status"] {
                assert_eq!(refusal(address, (get(address, path) + &get(address, "")).as_bytes()), 500, "{path}");
            }
            let mut stream = connect(address);
            stream.write_all(get(address, "on").as_bytes()).unwrap();
            assert_eq!(response(&mut stream).1, "Get [on] ");
        });
    }

    #[test]
    fn who_is_slow_is_left() {
        let times = Times { head: SHORT, body: SHORT, ..Times::USUAL };
        serving(times, |address| {
            for (text, begun) in [(get(address, ""), 0), (post(address, "12345"), post(address, "").len())] {
                let mut stream = connect(address);
                stream.write_all(&text.as_bytes()[..begun]).unwrap();
                // A byte every 50 ms, each well in time by itself.
                let start = Instant::now();
                let mut sender = stream.try_clone().unwrap();
                let slow: Vec<u8> = text.as_bytes()[begun..].iter().copied().cycle().take(20).collect();
                let slow = if begun == 0 { slow } else { vec![b'1'; 4] };
                let sending = thread::spawn(move || {
                    for byte in slow {
                        if sender.write_all(&[byte]).is_err() {
                            break;
                        }
                        thread::sleep(Duration::from_millis(50));
                    }
                });
                let text = all(&mut stream);
                assert!(text.starts_with("HTTP/1.1 408 ") && text.contains("Connection: close"), "{text}");
                assert!(start.elapsed() >= SHORT && start.elapsed() < 10 * SHORT, "{:?}", start.elapsed());
                sending.join().unwrap();
            }
        });
    }

    #[test]
    fn the_body_has_a_time_of_its_own() {
        let sent_late = |times: Times| {
            let send = |address| {
                let (mut stream, text) = (connect(address), post(address, "12"));
                let (first, rest) = text.split_at(text.len() - 1);
                stream.write_all(first.as_bytes()).unwrap();
                thread::sleep(2 * SHORT);
                // It may have been refused.
                let _ = stream.write_all(rest.as_bytes());
                response(&mut stream).0
            };
            serving(times, send).0
        };
        assert!(sent_late(Times { head: SHORT, ..Times::USUAL }).starts_with("HTTP/1.1 200 "));
        assert!(sent_late(Times { body: SHORT, ..Times::USUAL }).starts_with("HTTP/1.1 408 "));
    }

    #[test]
    fn small_responses_are_not_held_back() {
        let server = Server::bind(0, TOKEN.into()).unwrap();
        let client = connect(server.listener.local_addr().unwrap());
        let places = Places::default();
        let connection = Connection::new(client, &server, &|| false, places.take().unwrap()).unwrap();
        assert!(connection.stream.nodelay().unwrap());
        assert_eq!(connection.stream.read_timeout().unwrap(), Some(Times::READ));
    }

    #[test]
    fn who_is_silent_is_left_without_a_word() {
        serving(Times { idle: SHORT, ..Times::USUAL }, |address| {
            let (mut fresh, mut kept) = (connect(address), connect(address));
            let start = Instant::now();
            kept.write_all(get(address, "").as_bytes()).unwrap();
            response(&mut kept);
            assert_eq!(all(&mut fresh) + &all(&mut kept), "");
            assert!(start.elapsed() >= SHORT && start.elapsed() < 10 * SHORT, "{:?}", start.elapsed());
        });
    }

    #[test]
    fn who_does_not_read_is_left() {
        let times = Times { write: SHORT, ..Times::USUAL };
        serving(times, |address| {
            let mut stream = connect(address);
            stream.write_all(get(address, "much").as_bytes()).unwrap();
            thread::sleep(3 * SHORT);
            let mut bytes = Vec::new();
            // The end may come as a reset.
            let _ = stream.read_to_end(&mut bytes);
            assert!(bytes.len() < 64 << 20, "{}", bytes.len());
        });
        serving(Times::USUAL, |address| {
            let mut stream = connect(address);
            stream.write_all(get(address, "much").as_bytes()).unwrap();
            assert_eq!(response(&mut stream).1.len(), 64 << 20, "who reads gets all");
        });
    }

    #[test]
    fn who_goes_or_talks_nonsense_stops_nothing() {
        serving(Times { close: SHORT, ..Times::USUAL }, |address| {
            let mut draw = draws(2);
            for round in 0..60 {
                let mut stream = connect(address);
                let text = post(address, "{}");
                match round % 4 {
                    0 => stream.write_all(&text.as_bytes()[..draw(text.len())]).unwrap(),
                    1 => {
                        let noise: Vec<u8> = (0..draw(5000)).map(|_| draw(256) as u8).collect();
                        // The server may have ended the connection.
                        let _ = stream.write_all(&noise);
                    }
                    // What is dropped with a response unread is reset.
                    2 => {
                        stream.write_all(get(address, "much").as_bytes()).unwrap();
                        stream.read_exact(&mut [0; 100]).unwrap();
                    }
                    _ => {
                        stream.shutdown(Shutdown::Write).unwrap();
                        assert_eq!(all(&mut stream), "");
                    }
                }
                drop(stream);
                let mut good = connect(address);
                good.write_all(text.as_bytes()).unwrap();
                assert_eq!(response(&mut good).1, "Post [ask] {}", "round {round}");
            }
            // Half closed: the request is whole, so it is answered.
            let mut stream = connect(address);
            stream.write_all(get(address, "half").as_bytes()).unwrap();
            stream.shutdown(Shutdown::Write).unwrap();
            assert!(all(&mut stream).ends_with("Get [half] "));
        });
    }

    #[test]
    fn who_stalls_makes_room() {
        serving(Times { stall: Duration::ZERO, ..Times::USUAL }, |address| {
            // Silent from the beginning, half way in a head or a body, after an answer, or not taking one.
            let half = post(address, "12");
            let texts = ["", "GET /", &half[..half.len() - 1], &get(address, "a"), &get(address, "much")];
            let mut held = Vec::new();
            for k in 0..3 * MAX_CONNECTIONS {
                let mut stream = connect(address);
                // It may have had to make room already.
                let _ = stream.write_all(texts[k % texts.len()].as_bytes());
                held.push(stream);
                // All who stall stay connected. Who leaves is there for a moment, in which there may be too many.
                let mut answered = String::new();
                let start = Instant::now();
                while !answered.ends_with("Get [on] ") {
                    assert!(start.elapsed() < Duration::from_secs(5), "{k}: {answered}");
                    let mut good = connect(address);
                    let text = get(address, "on").replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n");
                    answered.clear();
                    let _ = good.write_all(text.as_bytes()).and_then(|()| good.read_to_string(&mut answered));
                }
            }
        });
    }

    #[test]
    fn sixteen_are_served_at_once() {
        serving(Times { stall: Duration::from_secs(3600), ..Times::USUAL }, |address| {
            let mut held: Vec<TcpStream> = (0..MAX_CONNECTIONS).map(|_| connect(address)).collect();
            for stream in &mut held {
                stream.write_all(get(address, "").as_bytes()).unwrap();
                response(stream);
            }
            assert_eq!(refusal(address, get(address, "").as_bytes()), 503);
            assert_eq!(refusal(address, b""), 503);
            // More than are told so.
            let more: Vec<TcpStream> = (0..3 * MAX_CONNECTIONS).map(|_| connect(address)).collect();
            for stream in &mut held {
                stream.write_all(get(address, "still").as_bytes()).unwrap();
                assert_eq!(response(stream).1, "Get [still] ");
            }
            drop((held.pop(), more));
            let start = Instant::now();
            let mut text = String::new();
            while !text.contains("200 OK") && start.elapsed() < Duration::from_secs(10) {
                thread::sleep(Duration::from_millis(20));
                let mut stream = connect(address);
                let last = get(address, "").replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n");
                text.clear();
                // It may be dropped.
                let _ = stream.write_all(last.as_bytes()).and_then(|()| stream.read_to_string(&mut text));
            }
            assert!(text.contains("200 OK"), "a place that is given back is free");
        });
    }

    #[test]
    fn it_stops_whoever_is_connected() {
        let (_held, stopping) = serving(Times::USUAL, |address| {
            let texts =
                [get(address, ""), get(address, "much"), "GET /".into(), post(address, "12").replace("12", "1")];
            let mut held = Vec::new();
            for text in texts.iter().map(String::as_str).chain([""]) {
                let mut stream = connect(address);
                stream.write_all(text.as_bytes()).unwrap();
                held.push(stream);
            }
            response(&mut held[0]);
            held[1].read_exact(&mut [0; 100]).unwrap();
            // They stay connected until the server has stopped.
            held
        });
        assert!(stopping < Duration::from_secs(1), "{stopping:?}");
    }

    #[test]
    fn a_request_is_answered_before_it_stops() {
        let server = Server::bind(0, TOKEN.into()).unwrap();
        let (stop, address) = (AtomicBool::new(false), server.listener.local_addr().unwrap());
        let slow = |request: &Request| {
            stop.store(true, Ordering::Release);
            thread::sleep(SHORT);
            echo(request)
        };
        thread::scope(|scope| {
            scope.spawn(|| server.serve(&slow, &|| (), &|| stop.load(Ordering::Acquire)));
            let _guard = Stop(&stop);
            let mut stream = connect(address);
            stream.write_all((get(address, "a") + &get(address, "b")).as_bytes()).unwrap();
            let text = all(&mut stream);
            assert!(text.ends_with("Get [a] ") && text.contains("Connection: close"), "{text}");
        });
    }
}
