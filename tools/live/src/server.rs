//! A WebSocket server to which viewers connect.

use std::collections::BTreeMap;
use std::net::{SocketAddr, ToSocketAddrs as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use foxglove::websocket::{ChannelView, Client, ServerListener};
use foxglove::{
    ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServer,
    WebSocketServerHandle,
};
use slipstream_bag::{Announced, Listener};
use slipstream_bus::InputError;

/// Messages that are kept for a viewer that is slow: more than a run of some minutes has in a second.
const BACKLOG: usize = 1 << 16;
/// Topics without messages whose metadata have a text that describes the recording: `/slipstream/recording.toml`.
pub(crate) const HEADER: &str = "/slipstream/";
/// The key of that text.
pub(crate) const HEADER_TEXT: &str = "text";
/// How long a viewer has to take the last messages before the server ends.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// A server and its channels.
pub struct Server {
    handle: Option<WebSocketServerHandle>,
    context: Arc<Context>,
    channels: BTreeMap<String, Arc<RawChannel>>,
    subscriptions: Arc<ViewerCount>,
}

/// Counts what viewers subscribed to.
#[derive(Default)]
struct ViewerCount(AtomicUsize);

impl ServerListener for ViewerCount {
    fn on_subscribe(&self, _client: Client, _channel: ChannelView) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

impl Server {
    /// Listens at `address`, such as `127.0.0.1:8765`.
    ///
    /// # Errors
    /// An address that is none, or that another program uses.
    pub fn start(address: &str, name: &str) -> Result<Self, InputError> {
        let own = parsed(address)?;
        let context = Context::new();
        let subscriptions = Arc::new(ViewerCount::default());
        let listener: Arc<dyn ServerListener> = Arc::<ViewerCount>::clone(&subscriptions);
        let started = WebSocketServer::new()
            .name(name)
            .bind(own.ip().to_string(), own.port())
            .context(&context)
            .message_backlog_size(BACKLOG)
            .listener(listener)
            .start_blocking();
        let handle = started.map_err(|error| {
            let problem = format!("cannot be listened at: {error}");
            InputError::new(address, problem, "give another port")
        })?;
        Ok(Self {
            handle: Some(handle),
            context,
            channels: BTreeMap::new(),
            subscriptions,
        })
    }

    /// The port at which it listens.
    pub fn port(&self) -> u16 {
        self.handle.as_ref().map_or(0, WebSocketServerHandle::port)
    }

    /// How often viewers have subscribed to a topic.
    pub fn subscriptions(&self) -> usize {
        self.subscriptions.0.load(Ordering::Relaxed)
    }

    /// Announces a topic.
    pub fn announce(&mut self, own: &Announced<'_>) {
        if self.channels.contains_key(own.topic) {
            return;
        }
        let schema = Schema::new(own.schema_name, own.schema_encoding, own.schema.to_vec());
        let built = ChannelBuilder::new(own.topic)
            .context(&self.context)
            .message_encoding(own.encoding)
            .schema(schema)
            .metadata(own.metadata.clone())
            .build_raw();
        // a topic that the viewer cannot have is left out of what is shown
        if let Ok(channel) = built {
            self.channels.insert(own.topic.to_owned(), channel);
        }
    }

    /// Sends a message with its time (ns) to whoever subscribed to its topic.
    pub fn send(&self, topic: &str, t_ns: u64, data: &[u8]) {
        if let Some(channel) = self.channels.get(topic) {
            let meta = PartialMetadata {
                log_time: Some(t_ns),
            };
            channel.log_with_meta(data, meta);
        }
    }

    /// Ends, after viewers had time to take the last messages; nothing is sent any more.
    pub fn end(&mut self) {
        if let Some(handle) = self.handle.take() {
            std::thread::sleep(LAST_WORDS);
            handle.stop().wait_blocking();
        }
    }
}

impl Listener for Server {
    fn announced(&mut self, channel: &Announced<'_>) {
        self.announce(channel);
    }

    fn described(&mut self, name: &str, text: &str) {
        self.announce(&Announced {
            topic: &format!("{HEADER}{name}"),
            encoding: "json",
            schema_name: "slipstream/header",
            schema_encoding: "jsonschema",
            schema: b"{\"type\":\"object\"}",
            metadata: &BTreeMap::from([(HEADER_TEXT.to_owned(), text.to_owned())]),
        });
    }

    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        self.send(topic, t_ns, data);
    }
}

fn parsed(address: &str) -> Result<SocketAddr, InputError> {
    let resolved = address
        .to_socket_addrs()
        .ok()
        .and_then(|mut all| all.next());
    resolved.ok_or_else(|| {
        let remedy = "give a host and a port, such as 127.0.0.1:8765";
        InputError::new(address, "is not an address", remedy)
    })
}
