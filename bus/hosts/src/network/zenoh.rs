//! The network over Zenoh. Scouting is off: the only connections are those to the address of the plant's host.
//!
//! Keys: `slipstream/hello` is asked to join, `slipstream/down/HOST` and `slipstream/up/HOST` carry frames,
//! `slipstream/alive/HOST` and `slipstream/alive` are tokens that vanish with their processes.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use slipstream_bus::InputError;
use slipstream_bus::transport::BusError;
use zenoh::key_expr::KeyExpr;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Query;
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use super::refusals;
use super::session::{endpoint, open};
use crate::address::{Address, Security};
use crate::carrier::{Event, HostCarrier, PlantCarrier};
use crate::frame::{MAX_BYTES, decode, encode};
use crate::hello::{Hello, Welcome};

/// Time to connect to the plant's host.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// Pause between two attempts to connect.
const CONNECT_PAUSE: Duration = Duration::from_millis(200);
/// Time after which Zenoh ends a silent connection (ms): never before `host_timeout_s`, which decides.
const LEASE_MS: u32 = 3_600_000;
/// Time for an answer of the plant's host once connected.
const HELLO_TIMEOUT: Duration = Duration::from_secs(3);
/// Pause between two attempts to be answered.
const HELLO_PAUSE: Duration = Duration::from_millis(100);

const HELLO: &str = "slipstream/hello";
const DOWN: &str = "slipstream/down/";
const UP: &str = "slipstream/up/";
const ALIVE: &str = "slipstream/alive/";
const PLANT_ALIVE: &str = "slipstream/plant";

/// Listens at an address for other hosts.
///
/// # Errors
/// It cannot be listened there, or the certificates cannot be used.
pub fn listen(
    address: &Address,
    security: &Security,
) -> Result<Box<dyn PlantCarrier + Send>, BusError> {
    let failed = failed(address);
    let endpoint = endpoint(address, security);
    let listen = format!("listen: {{ endpoints: [{endpoint:?}], exit_on_failure: true }}");
    let session = open(&listen, security, LEASE_MS).map_err(&failed)?;
    let (sender, events) = channel();
    refusals::tell(sender.clone());
    declare_all(&session, &sender).map_err(&failed)?;
    let token = session.liveliness().declare_token(PLANT_ALIVE).wait();
    Ok(Box::new(PlantSide {
        _token: token.map_err(&failed)?,
        session,
        events,
        publishers: BTreeMap::new(),
    }))
}

/// Connects the relay of the host `name` to the plant's host.
///
/// # Errors
/// Nobody listens there, or the certificates are refused.
pub fn connect(
    address: &Address,
    security: &Security,
    name: &str,
) -> Result<Box<dyn HostCarrier + Send>, BusError> {
    let failed = failed(address);
    let session = open_to(address, security, CONNECT_TIMEOUT).map_err(&failed)?;
    let (sender, events) = channel();
    let frames = sender.clone();
    let subscriber = session
        .declare_subscriber(format!("{DOWN}{name}"))
        .callback(move |sample: Sample| {
            let _ = frames.send(HostEvent::Frame(sample.payload().to_bytes().into_owned()));
        });
    subscriber.background().wait().map_err(&failed)?;
    let watched = session
        .liveliness()
        .declare_subscriber(PLANT_ALIVE)
        .callback(move |sample: Sample| {
            if sample.kind() == SampleKind::Delete {
                let _ = sender.send(HostEvent::Gone);
            }
        });
    watched.background().wait().map_err(&failed)?;
    let publishers = Publishers::new(&session, format!("{UP}{name}")).map_err(&failed)?;
    let token = session.liveliness().declare_token(format!("{ALIVE}{name}"));
    Ok(Box::new(HostSide {
        _token: token.wait().map_err(&failed)?,
        _session: session,
        publishers,
        events,
    }))
}

/// Asks the plant's host to join its run.
///
/// # Errors
/// Nobody listens there or answers, the certificates are refused, or the host may not join.
pub fn ask(address: &Address, security: &Security, hello: &Hello) -> Result<Welcome, InputError> {
    let invalid =
        |problem: String, remedy: &str| InputError::new(address.to_string(), problem, remedy);
    let session = first_contact(address, security).map_err(|error| match security {
        Security::Tls(folder) => invalid(
            format!(
                "does not answer with the certificates in {}: {}",
                folder.display(),
                cause(&error)
            ),
            "give both hosts the same folder of slipstream keys, and check the address",
        ),
        _ => invalid(
            format!("nobody answers there: {}", cause(&error)),
            "start slipstream run --listen there first, with the same --tls or --insecure, and check address and \
             firewall",
        ),
    })?;
    let payload = encode(hello).map_err(|error| invalid(error.to_string(), ""))?;
    let begin = Instant::now();
    while begin.elapsed() < HELLO_TIMEOUT {
        let replies = session.get(HELLO).payload(payload.clone());
        let replies = replies.timeout(HELLO_TIMEOUT).wait();
        let replies = replies.map_err(|error| invalid(error.to_string(), "try again"))?;
        if let Ok(reply) = replies.recv() {
            return match reply.result() {
                Ok(sample) => decode(&sample.payload().to_bytes()).map_err(|error| {
                    invalid(error.to_string(), "use the same build on both hosts")
                }),
                Err(refusal) => {
                    let reason = refusal.payload().try_to_string().unwrap_or_default();
                    Err(invalid(format!("refuses this host: {reason}"), ""))
                }
            };
        }
        std::thread::sleep(HELLO_PAUSE);
    }
    Err(invalid(
        "something listens there, but it is no run that waits for hosts".to_owned(),
        "check the address",
    ))
}

/// The first session of a host other than the plant's. A refused certificate is said at once, and else why the last
/// attempt failed.
fn first_contact(address: &Address, security: &Security) -> zenoh::Result<Session> {
    let begin = Instant::now();
    loop {
        let error = match open_to(address, security, Duration::ZERO) {
            Ok(session) => return Ok(session),
            Err(error) => error,
        };
        let is_refused = ["certificate", "alert"]
            .iter()
            .any(|word| cause(&error).contains(word));
        if is_refused || begin.elapsed() > CONNECT_TIMEOUT {
            return Err(error);
        }
        std::thread::sleep(CONNECT_PAUSE);
    }
}

/// The session of a host other than the plant's. `timeout`: zero for a single attempt.
fn open_to(address: &Address, security: &Security, timeout: Duration) -> zenoh::Result<Session> {
    let endpoint = endpoint(address, security);
    let timeout_ms = timeout.as_millis();
    let connect = format!(
        "connect: {{ endpoints: [{endpoint:?}], timeout_ms: {timeout_ms}, exit_on_failure: true, \
         retry: {{ period_init_ms: 200, period_max_ms: 200, period_increase_factor: 1 }} }}, \
         listen: {{ endpoints: [] }}"
    );
    open(&connect, security, LEASE_MS)
}

/// Publishers for frames to one host: at once and in order.
struct Publishers {
    /// Waits for room.
    sure: Publisher<'static>,
    /// Drops what there is no room for.
    fresh: Publisher<'static>,
}

impl Publishers {
    fn new(session: &Session, key: String) -> zenoh::Result<Self> {
        let publisher = |congestion: CongestionControl| {
            let publisher = session
                .declare_publisher(key.clone())
                .express(true)
                .priority(Priority::RealTime)
                .congestion_control(congestion);
            publisher.wait()
        };
        Ok(Self {
            sure: publisher(CongestionControl::Block)?,
            fresh: publisher(CongestionControl::Drop)?,
        })
    }
}

fn failed(address: &Address) -> impl Fn(zenoh::Error) -> BusError {
    let what = address.to_string();
    move |error| BusError::Failed {
        what: what.clone(),
        reason: cause(&error),
    }
}

/// The cause that an error gives, without the places in the library's source and what it was about to do.
fn cause(error: &zenoh::Error) -> String {
    let text = error.to_string();
    let text = text.split(" at /").next().unwrap_or(&text);
    for (said, meant) in [
        ("deadline has elapsed", "no answer in time"),
        ("early eof", "it closes the connection"),
    ] {
        if text.contains(said) {
            return meant.to_owned();
        }
    }
    let attempt = text.split_once(" link bound to ");
    let attempt = attempt.map_or(text, |(_, rest)| rest);
    let cause = ["): ", ": ["]
        .iter()
        .find_map(|end| attempt.split_once(end));
    let cause = cause.map_or(text, |(_, cause)| cause);
    cause.trim_start_matches('[').to_owned()
}

/// Declares what the plant's host listens to.
fn declare_all(session: &Session, sender: &Sender<Event>) -> zenoh::Result<()> {
    let events = sender.clone();
    let asked = move |query: Query| {
        let hello = query.payload().map(|own| own.to_bytes().into_owned());
        let answer = Box::new(move |answer: Result<&[u8], &str>| {
            // The host may be gone by now.
            let _ = match answer {
                Ok(welcome) => query.reply(query.key_expr(), welcome).wait(),
                Err(refusal) => query.reply_err(refusal).wait(),
            };
        });
        let hello = hello.unwrap_or_default();
        let _ = events.send(Event::Hello { hello, answer });
    };
    session
        .declare_queryable(HELLO)
        .callback(asked)
        .background()
        .wait()?;
    let events = sender.clone();
    let frame = move |sample: Sample| {
        let payload = sample.payload();
        if let Some(host) = host_of(sample.key_expr(), UP)
            && payload.len() <= MAX_BYTES
        {
            let bytes = payload.to_bytes().into_owned();
            let _ = events.send(Event::Frame { host, bytes });
        }
    };
    let subscriber = session.declare_subscriber(format!("{UP}*"));
    subscriber.callback(frame).background().wait()?;
    let events = sender.clone();
    let gone = move |sample: Sample| {
        if sample.kind() == SampleKind::Delete
            && let Some(host) = host_of(sample.key_expr(), ALIVE)
        {
            let _ = events.send(Event::Gone { host });
        }
    };
    let watched = session.liveliness().declare_subscriber(format!("{ALIVE}*"));
    watched.callback(gone).background().wait()
}

/// The host that a key names.
fn host_of(key: &KeyExpr<'_>, begin: &str) -> Option<String> {
    key.as_str().strip_prefix(begin).map(str::to_owned)
}

/// The plant's host.
struct PlantSide {
    events: Receiver<Event>,
    publishers: BTreeMap<String, Publishers>,
    _token: LivelinessToken,
    session: Session,
}

impl PlantSide {
    fn publishers(&mut self, host: &str) -> zenoh::Result<&Publishers> {
        if !self.publishers.contains_key(host) {
            let publishers = Publishers::new(&self.session, format!("{DOWN}{host}"))?;
            self.publishers.insert(host.to_owned(), publishers);
        }
        let known = self.publishers.get(host);
        known.ok_or_else(|| format!("no publisher for {host}").into())
    }
}

impl PlantCarrier for PlantSide {
    fn send(&mut self, host: &str, frame: &[u8]) -> Result<(), BusError> {
        let publishers = self.publishers(host);
        let sent = publishers.and_then(|own| own.sure.put(frame).wait());
        sent.map_err(|error| BusError::failed(format!("host {host}"), error))
    }

    fn offer(&mut self, host: &str, frame: &[u8]) -> Result<(), BusError> {
        let publishers = self.publishers(host);
        let sent = publishers.and_then(|own| own.fresh.put(frame).wait());
        sent.map_err(|error| BusError::failed(format!("host {host}"), error))
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Event>, BusError> {
        receive(&self.events, timeout)
    }
}

/// What happens on another host.
enum HostEvent {
    Frame(Vec<u8>),
    Gone,
}

/// Another host.
struct HostSide {
    events: Receiver<HostEvent>,
    publishers: Publishers,
    _token: LivelinessToken,
    _session: Session,
}

impl HostCarrier for HostSide {
    fn send(&mut self, frame: &[u8]) -> Result<(), BusError> {
        let sent = self.publishers.sure.put(frame).wait();
        sent.map_err(|error| BusError::failed("the plant's host", error))
    }

    fn offer(&mut self, frame: &[u8]) -> Result<(), BusError> {
        let sent = self.publishers.fresh.put(frame).wait();
        sent.map_err(|error| BusError::failed("the plant's host", error))
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Vec<u8>>, BusError> {
        match receive(&self.events, timeout)? {
            Some(HostEvent::Frame(bytes)) => Ok(Some(bytes)),
            Some(HostEvent::Gone) => Err(BusError::Failed {
                what: "the plant's host".to_owned(),
                reason: "its run is gone: killed, or its computer is down".to_owned(),
            }),
            None => Ok(None),
        }
    }
}

fn receive<T>(events: &Receiver<T>, timeout: Duration) -> Result<Option<T>, BusError> {
    match events.recv_timeout(timeout) {
        Ok(event) => Ok(Some(event)),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => {
            Err(BusError::failed("network", "its session has ended"))
        }
    }
}
