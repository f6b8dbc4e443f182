//! A robot's bridge: a server of Foxglove's WebSocket protocol, such as `foxglove_bridge`, or a run that is shown live.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::json;
use slipstream_bag::Announced;
use slipstream_bus::InputError;
use slipstream_recording::{Follower, TopicMap, WheelJoints};
use tungstenite::Message;

use super::background::{Background, Outlet};
use super::connection::{Connection, host_and_port};
use super::frame::{self, Channel, Frame};
use super::heard::{Heard, Source};
use crate::server::{HEADER, HEADER_TEXT};

/// Pauses before the next trial to connect: the first one, and the longest one.
const PAUSES: [Duration; 2] = [Duration::from_millis(200), Duration::from_secs(5)];
/// How often what arrived is passed on.
const PASSING_ON: Duration = Duration::from_millis(500);
/// So long a text of a server is said at most (characters), and so many of them are.
const MOST_SAID: usize = 200;
const MOST_TEXTS: usize = 20;
/// So many topics that are of no use are named.
const MOST_NAMED: usize = 8;
/// So many topics of a connection are subscribed to.
const MOST_SUBSCRIPTIONS: usize = 4096;
/// After so long without a topic of use, this is said.
const TOPICS_WITHIN: Duration = Duration::from_secs(5);

/// A bridge.
pub struct Bridge {
    name: String,
    background: Background,
}

impl Bridge {
    /// Connects to `ws://HOST:PORT`. Afterwards, a connection that is lost is tried again until the source is dropped. `map`
    /// says which topic is which stream; without one it is guessed from the first seconds. `wheels` are the joints of wheels
    /// that descriptions of the robots name.
    ///
    /// # Errors
    /// If nobody listens there, or it speaks another protocol.
    pub fn connect(
        address: &str,
        map: Option<TopicMap>,
        wheels: Vec<WheelJoints>,
    ) -> Result<Self, InputError> {
        let place = host_and_port(address);
        let (host, port) =
            place.map_err(|(problem, remedy)| InputError::new(address, problem, remedy))?;
        let first = Connection::open(&host, port).map_err(|problem| {
            let remedy = "start the bridge first (ros2 launch foxglove_bridge foxglove_bridge_launch.xml), or give its \
                          address";
            InputError::new(address, problem, remedy)
        })?;
        let name = address.to_owned();
        let path = PathBuf::from(address);
        let background = Background::start(address, move |outlet| {
            let sink = |followed| outlet.followed(followed);
            let mut link = BridgeLink {
                host,
                port,
                outlet,
                follower: Follower::new(&path, map, wheels, sink),
                is_lost: false,
                pause: PAUSES[0],
                has_said_garbled: false,
                has_said_useless: false,
                useless: Vec::new(),
                texts: BTreeSet::new(),
            };
            link.run(first);
        })?;
        Ok(Self { name, background })
    }
}

impl Source for Bridge {
    fn name(&self) -> &str {
        &self.name
    }

    fn hear(&mut self, wait: Duration) -> Result<Heard, InputError> {
        self.background.hear(wait)
    }
}

/// The way to a server, over several connections.
struct BridgeLink<'a> {
    host: String,
    port: u16,
    outlet: &'a Outlet,
    follower: Follower<'a>,
    /// Whether it was said that the connection is lost.
    is_lost: bool,
    /// Before the next trial.
    pause: Duration,
    has_said_garbled: bool,
    has_said_useless: bool,
    /// Some of the topics that are of no use, with their types and encodings.
    useless: Vec<String>,
    /// What the server said.
    texts: BTreeSet<String>,
}

/// What is subscribed to on one connection.
#[derive(Default)]
struct Subscriptions {
    /// Topics as the follower numbers them, by the numbers of subscriptions.
    topics: BTreeMap<u32, u32>,
    /// Numbers of subscriptions by those of the server's channels.
    numbers: BTreeMap<u64, u32>,
    next: u32,
}

impl BridgeLink<'_> {
    fn run(&mut self, first: Connection) {
        let mut connection = Some(first);
        while !self.is_over() {
            let reason = match connection.take() {
                Some(open) => self.listen(open),
                None => None,
            };
            self.follower.idle();
            if let Some(reason) = reason
                && !self.is_lost
                && !self.is_over()
            {
                self.is_lost = true;
                self.say(&format!("connection lost ({reason}); trying again"));
            }
            self.outlet.wait(self.pause);
            self.pause = (self.pause * 2).min(PAUSES[1]);
            if !self.is_over() {
                connection = Connection::open(&self.host, self.port).ok();
            }
        }
    }

    fn is_over(&self) -> bool {
        self.outlet.is_closed() || self.follower.has_failed()
    }

    fn say(&self, text: &str) {
        let (host, port) = (&self.host, self.port);
        self.outlet.say(&format!("ws://{host}:{port}: {text}"));
    }

    /// Listens until the connection is lost; says why. Nothing, if nobody wants to hear more.
    fn listen(&mut self, mut connection: Connection) -> Option<String> {
        let began = Instant::now();
        let mut passed_on = Instant::now();
        let mut subscriptions = Subscriptions::default();
        while !self.is_over() {
            let heard = match connection.read() {
                Ok(Some(Message::Text(text))) => self.text(&text, &mut subscriptions),
                Ok(Some(Message::Binary(bytes))) => self.binary(&bytes, &subscriptions),
                Ok(_) => None,
                Err(reason) => return Some(reason),
            };
            if let Some(answer) = heard
                && let Err(reason) = connection.send(answer)
            {
                return Some(reason);
            }
            if passed_on.elapsed() >= PASSING_ON {
                self.follower.idle();
                passed_on = Instant::now();
            }
            if subscriptions.topics.is_empty()
                && began.elapsed() > TOPICS_WITHIN
                && !self.has_said_useless
            {
                self.has_said_useless = true;
                let named = match self.useless.as_slice() {
                    [] => String::new(),
                    names => format!(" (but {})", names.join(", ")),
                };
                self.say(&format!(
                    "announces no topic that tells of a robot's motion{named}; waiting for one"
                ));
            }
        }
        None
    }

    /// Takes a text; returns what is to be answered.
    fn text(&mut self, text: &str, subscriptions: &mut Subscriptions) -> Option<String> {
        match frame::text(text) {
            Ok(frame) => {
                self.is_back();
                match frame {
                    Frame::Server { name } if !name.is_empty() => self.follower.set_name(&name),
                    Frame::Advertised(channels) => return self.advertised(channels, subscriptions),
                    Frame::Withdrawn(ids) => subscriptions.withdraw(&ids),
                    Frame::Status(said) => self.status(&said),
                    _ => {}
                }
            }
            Err(garbled) => self.garbled(garbled),
        }
        None
    }

    /// Takes bytes. There is nothing to answer.
    fn binary(&mut self, bytes: &[u8], subscriptions: &Subscriptions) -> Option<String> {
        match frame::binary(bytes) {
            Ok(Frame::Message {
                subscription,
                log_ns,
                data,
            }) => {
                self.is_back();
                if let Some(topic) = subscriptions.topics.get(&subscription) {
                    self.follower.message(*topic, log_ns, data);
                }
            }
            Ok(_) => {}
            Err(garbled) => self.garbled(garbled),
        }
        None
    }

    /// The server was understood.
    fn is_back(&mut self) {
        self.pause = PAUSES[0];
        if std::mem::take(&mut self.is_lost) {
            self.say("connected again");
        }
    }

    /// Passes on what the server says, once.
    fn status(&mut self, said: &str) {
        let said: String = said.chars().take(MOST_SAID).collect();
        if self.texts.len() < MOST_TEXTS && self.texts.insert(said.clone()) {
            self.say(&format!("says: {said}"));
        }
    }

    fn garbled(&mut self, garbled: frame::Garbled) {
        if !self.has_said_garbled {
            self.has_said_garbled = true;
            let problem = garbled.in_words();
            self.say(&format!("sent a frame {problem}; such frames are left out"));
        }
    }

    /// Subscribes to the topics that are of use.
    fn advertised(
        &mut self,
        mut channels: Vec<Channel<'_>>,
        subscriptions: &mut Subscriptions,
    ) -> Option<String> {
        // What describes a run comes first, then what says which stream it is: then all others are known for what they are.
        channels.sort_by_key(|own| (!own.topic.starts_with(HEADER), own.metadata.is_empty()));
        let mut wished = Vec::new();
        for channel in &channels {
            let name = channel.topic.strip_prefix(HEADER);
            if let (Some(name), Some(text)) = (name, channel.metadata.get(HEADER_TEXT)) {
                self.follower.described(name, text);
                continue;
            }
            let announced = Announced {
                topic: &channel.topic,
                encoding: &channel.encoding,
                schema_name: &channel.schema_name,
                schema_encoding: schema_encoding(channel),
                schema: channel.schema.as_bytes(),
                metadata: &channel.metadata,
            };
            match self.follower.announced(&announced) {
                Some(topic) => {
                    let number = subscriptions.add(channel.id, topic);
                    wished.extend(number.map(|id| json!({"id": id, "channelId": channel.id})));
                }
                None if self.useless.len() < MOST_NAMED => {
                    let (topic, schema) = (&channel.topic, &channel.schema_name);
                    let text = format!("{topic}: {schema}, {}", channel.encoding);
                    self.useless.push(text);
                }
                None => {}
            }
        }
        let wish = json!({"op": "subscribe", "subscriptions": wished});
        (!wished.is_empty()).then(|| wish.to_string())
    }
}

/// The encoding of a definition: what old servers do not say follows from that of the messages.
fn schema_encoding<'a>(channel: &'a Channel<'_>) -> &'a str {
    match (&channel.schema_encoding, &*channel.encoding) {
        (Some(encoding), _) => encoding,
        (None, "cdr") => "ros2msg",
        (None, "ros1") => "ros1msg",
        (None, _) => "",
    }
}

impl Subscriptions {
    /// The number of a new subscription; none if the channel has one, or there are too many.
    fn add(&mut self, channel: u64, topic: u32) -> Option<u32> {
        let is_full = self.numbers.len() >= MOST_SUBSCRIPTIONS;
        if is_full || self.numbers.contains_key(&channel) {
            return None;
        }
        let number = self.next;
        self.next = self.next.checked_add(1)?;
        self.numbers.insert(channel, number);
        self.topics.insert(number, topic);
        Some(number)
    }

    /// Forgets channels that are no more.
    fn withdraw(&mut self, channels: &[u64]) {
        for channel in channels {
            if let Some(number) = self.numbers.remove(channel) {
                self.topics.remove(&number);
            }
        }
    }
}
