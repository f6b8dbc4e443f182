//! A viewer's connection, by a WebSocket client of another library than the server's.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::WebSocket;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::stream::MaybeTlsStream;

/// The connection of a viewer.
pub(crate) type Socket = WebSocket<MaybeTlsStream<TcpStream>>;

/// Connects as soon as somebody listens.
pub(crate) fn connected(port: u16) -> Socket {
    let began = Instant::now();
    loop {
        let address = format!("ws://127.0.0.1:{port}");
        let mut request = address.into_client_request().unwrap();
        let protocol = "foxglove.sdk.v1".parse().unwrap();
        request
            .headers_mut()
            .insert("Sec-WebSocket-Protocol", protocol);
        match tungstenite::connect(request) {
            Ok((socket, _)) => return socket,
            Err(error) => assert!(began.elapsed() < Duration::from_secs(20), "{error}"),
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}
