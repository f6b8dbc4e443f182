//! A WebSocket connection to a server of Foxglove's protocol.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::{Duration, Instant};

use tungstenite::client::{IntoClientRequest as _, client_with_config};
use tungstenite::handshake::HandshakeError;
use tungstenite::http::HeaderValue;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

/// The protocols that are understood: that of Foxglove's own libraries, and the one before it, which bridges speak.
const PROTOCOLS: &str = "foxglove.sdk.v1, foxglove.websocket.v1";
/// Port of a bridge where the address has none.
const PORT: u16 = 8765;
/// A server has so long to accept a connection, and to answer.
const ANSWER_WITHIN: Duration = Duration::from_secs(5);
/// A read returns after so long, so that other things can be done.
const LOOKING: Duration = Duration::from_millis(100);
/// After so long without a word, the server is asked whether it is there; after three times that, it is not.
const SILENCE: Duration = Duration::from_secs(5);
/// Longest frame (bytes): a description of a robot, or what a server with thousands of topics announces.
const MOST_BYTES: usize = 16 << 20;

/// A connection.
pub(super) struct Connection {
    socket: WebSocket<DeadlineStream>,
    /// When the server was heard last, and whether it was asked for a word since.
    heard: Instant,
    was_asked: bool,
}

/// The host and the port of an address such as `ws://robot.local:8765`.
///
/// # Errors
/// The problem and the remedy.
pub(super) fn host_and_port(address: &str) -> Result<(String, u16), (String, String)> {
    let remedy = || "give ws://HOST:PORT, such as ws://127.0.0.1:8765".to_owned();
    if address.starts_with("wss://") {
        let problem = "is an encrypted address, which is not supported".to_owned();
        return Err((problem, remedy()));
    }
    let rest = address.strip_prefix("ws://").unwrap_or(address);
    let own = rest.split(['/', '?']).next().unwrap_or_default();
    // A port stands after the last colon, unless that is one of an IPv6 address in brackets.
    let parts = own
        .rsplit_once(':')
        .filter(|(_, port)| !port.ends_with(']'));
    let (host, port) = match parts {
        None => (own, Some(PORT)),
        Some((host, port)) => (host, port.parse().ok()),
    };
    let is_name = !host.is_empty() && !host.contains(|c: char| c.is_whitespace() || c == '/');
    match port {
        Some(port) if is_name => Ok((host.to_owned(), port)),
        _ => Err(("is not an address".to_owned(), remedy())),
    }
}

impl Connection {
    /// Connects.
    ///
    /// # Errors
    /// Why there is no connection, in words that continue the address.
    pub(super) fn open(host: &str, port: u16) -> Result<Self, String> {
        let stream = stream(host, port).map_err(|e| format!("cannot be connected to: {e}"))?;
        let wire = DeadlineStream {
            stream,
            until: Some(Instant::now() + ANSWER_WITHIN),
        };
        let request = format!("ws://{host}:{port}").into_client_request();
        let mut request = request.map_err(|e| format!("is not an address: {e}"))?;
        let protocols = HeaderValue::from_static(PROTOCOLS);
        let headers = request.headers_mut();
        headers.insert("Sec-WebSocket-Protocol", protocols);
        let config = WebSocketConfig::default()
            .max_message_size(Some(MOST_BYTES))
            .max_frame_size(Some(MOST_BYTES));
        let (mut socket, _) = client_with_config(request, wire, Some(config)).map_err(refusal)?;
        socket.get_mut().until = None;
        Ok(Self {
            socket,
            heard: Instant::now(),
            was_asked: false,
        })
    }

    /// The next frame; none if there is none for a moment.
    ///
    /// # Errors
    /// Why the connection is lost, in a few words.
    pub(super) fn read(&mut self) -> Result<Option<Message>, String> {
        match self.socket.read() {
            Ok(message) => {
                self.heard = Instant::now();
                self.was_asked = false;
                Ok(Some(message))
            }
            Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => {
                self.ask()?;
                Ok(None)
            }
            Err(error) => Err(lost(&error)),
        }
    }

    /// Sends a text.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub(super) fn send(&mut self, text: String) -> Result<(), String> {
        self.socket
            .send(Message::text(text))
            .map_err(|error| lost(&error))
    }

    /// Asks a server that is silent whether it is there.
    fn ask(&mut self) -> Result<(), String> {
        let silence = self.heard.elapsed();
        if silence > 3 * SILENCE {
            return Err("the server is silent".to_owned());
        }
        if silence > SILENCE && !self.was_asked {
            self.was_asked = true;
            let asked = self.socket.send(Message::Ping(Vec::new().into()));
            asked.map_err(|error| lost(&error))?;
        }
        Ok(())
    }
}

/// A stream to the first address of a host that answers.
fn stream(host: &str, port: u16) -> io::Result<TcpStream> {
    let mut last = io::Error::from(ErrorKind::AddrNotAvailable);
    for address in format!("{host}:{port}").to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, ANSWER_WITHIN) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(LOOKING))?;
                stream.set_write_timeout(Some(ANSWER_WITHIN))?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Why a server refuses, in words that continue its address.
fn refusal<T: tungstenite::handshake::HandshakeRole>(error: HandshakeError<T>) -> String {
    let other = "speaks another protocol";
    match error {
        HandshakeError::Failure(Error::Http(response)) => {
            format!(
                "{other}: it answers as a web server ({})",
                response.status()
            )
        }
        HandshakeError::Failure(Error::Io(error)) if error.kind() == ErrorKind::TimedOut => {
            let within = ANSWER_WITHIN.as_secs();
            format!("{other}, or none: no answer of a WebSocket within {within} s")
        }
        HandshakeError::Failure(error) => format!("{other}: {error}"),
        HandshakeError::Interrupted(_) => format!("{other}, or none"),
    }
}

/// Why a connection is lost.
fn lost(error: &Error) -> String {
    match error {
        Error::ConnectionClosed | Error::AlreadyClosed => "the server ended it".to_owned(),
        Error::Io(error) if error.kind() == ErrorKind::WouldBlock => {
            "the server takes nothing".to_owned()
        }
        error => error.to_string(),
    }
}

/// A stream whose reads wait until a time, if there is one.
struct DeadlineStream {
    stream: TcpStream,
    until: Option<Instant>,
}

impl Read for DeadlineStream {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            if self.until.is_some_and(|until| Instant::now() > until) {
                return Err(ErrorKind::TimedOut.into());
            }
            match self.stream.read(bytes) {
                Err(error) if is_wait(&error) && self.until.is_some() => {}
                // Windows calls the end of the time so.
                Err(error) if is_wait(&error) => return Err(ErrorKind::WouldBlock.into()),
                read => return read,
            }
        }
    }
}

fn is_wait(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

impl Write for DeadlineStream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_a_host_and_may_have_a_port() {
        let read = |address| host_and_port(address).ok();
        let own = |host: &str, port| Some((host.to_owned(), port));
        assert_eq!(read("ws://robot.local:9000/"), own("robot.local", 9000));
        assert_eq!(read("ws://robot"), own("robot", 8765));
        assert_eq!(read("127.0.0.1:80"), own("127.0.0.1", 80));
        assert_eq!(read("ws://[::1]:80"), own("[::1]", 80));
        assert_eq!(read("ws://[::1]"), own("[::1]", 8765));
        for wrong in [
            "",
            "ws://",
            "ws://:1",
            "ws://a:b",
            "ws://a:70000",
            "wss://a",
            "a b:1",
        ] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }
}
