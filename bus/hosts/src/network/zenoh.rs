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
use zenoh::{Config, Session, Wait};

use crate::address::{Address, Security};
use crate::carrier::{Event, HostCarrier, PlantCarrier};
use crate::frame::{MAX_BYTES, decode, encode};
use crate::hello::{Hello, Welcome};

/// Time to connect to the plant's host.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
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
    let mut config = config(security).map_err(&failed)?;
    let set = |config: &mut Config, key, value: &str| config.insert_json5(key, value);
    set(&mut config, "listen/endpoints", &format!("[{endpoint:?}]")).map_err(&failed)?;
    set(&mut config, "listen/exit_on_failure", "true").map_err(&failed)?;
    let session = zenoh::open(config).wait().map_err(&failed)?;
    let (sender, events) = channel();
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
    let session = open_to(address, security).map_err(&failed)?;
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
    let publisher = publisher(&session, format!("{UP}{name}")).map_err(&failed)?;
    let token = session.liveliness().declare_token(format!("{ALIVE}{name}"));
    Ok(Box::new(HostSide {
        _token: token.wait().map_err(&failed)?,
        _session: session,
        publisher,
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
    let session = open_to(address, security).map_err(|error| match security {
        Security::Tls(folder) => invalid(
            format!(
                "does not answer with the certificates in {}: {error}",
                folder.display()
            ),
            "give both hosts the same folder of slipstream keys, and check the address",
        ),
        _ => invalid(
            format!("nobody listens there: {error}"),
            "start slipstream run --listen there first, and check address and firewall",
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

/// The session of a host other than the plant's.
fn open_to(address: &Address, security: &Security) -> zenoh::Result<Session> {
    let mut config = config(security)?;
    let endpoint = endpoint(address, security);
    let timeout = CONNECT_TIMEOUT.as_millis().to_string();
    config.insert_json5("connect/endpoints", &format!("[{endpoint:?}]"))?;
    config.insert_json5("connect/timeout_ms", &timeout)?;
    config.insert_json5("connect/exit_on_failure", "true")?;
    config.insert_json5("listen/endpoints", "[]")?;
    zenoh::open(config).wait()
}

fn endpoint(address: &Address, security: &Security) -> String {
    let protocol = match security {
        Security::Tls(_) => "tls",
        Security::Loopback | Security::Insecure => "tcp",
    };
    format!("{protocol}/{}", address.place())
}

/// What both sides are configured with.
fn config(security: &Security) -> zenoh::Result<Config> {
    let mut config = Config::default();
    for (key, value) in [
        ("mode", "\"peer\""),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
        ("connect/retry/period_init_ms", "200"),
        ("connect/retry/period_max_ms", "200"),
    ] {
        config.insert_json5(key, value)?;
    }
    if let Security::Tls(folder) = security {
        for (key, file) in [
            ("root_ca_certificate", super::keys::AUTHORITY),
            ("listen_private_key", super::keys::KEY),
            ("listen_certificate", super::keys::CERTIFICATE),
            ("connect_private_key", super::keys::KEY),
            ("connect_certificate", super::keys::CERTIFICATE),
        ] {
            let path = folder.join(file).display().to_string();
            config.insert_json5(&format!("transport/link/tls/{key}"), &format!("{path:?}"))?;
        }
        config.insert_json5("transport/link/tls/enable_mtls", "true")?;
        // One certificate serves all hosts of a run, whatever their addresses.
        config.insert_json5("transport/link/tls/verify_name_on_connect", "false")?;
    }
    Ok(config)
}

/// A publisher for frames: at once, in order, and never dropped for want of room.
fn publisher(session: &Session, key: String) -> zenoh::Result<Publisher<'static>> {
    let publisher = session
        .declare_publisher(key)
        .express(true)
        .priority(Priority::RealTime)
        .congestion_control(CongestionControl::Block);
    publisher.wait()
}

fn failed(address: &Address) -> impl Fn(zenoh::Error) -> BusError {
    let what = address.to_string();
    move |error| BusError::Failed {
        what: what.clone(),
        reason: error.to_string(),
    }
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
    publishers: BTreeMap<String, Publisher<'static>>,
    _token: LivelinessToken,
    session: Session,
}

impl PlantCarrier for PlantSide {
    fn send(&mut self, host: &str, frame: &[u8]) -> Result<(), BusError> {
        let failed = |error| BusError::failed(format!("host {host}"), error);
        if !self.publishers.contains_key(host) {
            let publisher = publisher(&self.session, format!("{DOWN}{host}")).map_err(failed)?;
            self.publishers.insert(host.to_owned(), publisher);
        }
        match self.publishers.get(host) {
            Some(publisher) => publisher.put(frame).wait().map_err(failed),
            None => Ok(()),
        }
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
    publisher: Publisher<'static>,
    _token: LivelinessToken,
    _session: Session,
}

impl HostCarrier for HostSide {
    fn send(&mut self, frame: &[u8]) -> Result<(), BusError> {
        let failed = |error| BusError::failed("the plant's host", error);
        self.publisher.put(frame).wait().map_err(failed)
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
