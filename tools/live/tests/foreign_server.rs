//! A bridge of another library, in another language, that sends the messages of another robot.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;
#[path = "../../recording/tests/external/python.rs"]
mod python;

use std::path::Path;
use std::time::{Duration, Instant};

use common::{LONG, assert_same, cart, hear_until, rows};
use slipstream_live::source::Bridge;
use slipstream_recording::read;

#[test]
fn the_messages_of_a_foreign_bridge_give_the_rows_of_its_bag() {
    let folder = tempfile::tempdir().unwrap();
    let port_file = folder.path().join("port.txt");
    let bag = cart();
    let whole = read(&bag).unwrap().recording;
    let expected = rows([&whole]);
    let count: usize = expected.values().map(Vec::len).sum();
    std::thread::scope(|scope| {
        let arguments = [bag.as_path(), &port_file, Path::new("10")];
        let server = scope.spawn(move || python::script("foreign_server.py", &arguments));
        let began = Instant::now();
        while !port_file.exists() {
            if server.is_finished() {
                // There is no Python environment, which was said.
                assert_eq!(server.join().unwrap(), None);
                return;
            }
            assert!(began.elapsed() < 5 * LONG);
            std::thread::sleep(Duration::from_millis(50));
        }
        let port = std::fs::read_to_string(&port_file).unwrap();
        let address = format!("ws://127.0.0.1:{port}");
        let mut bridge = Bridge::connect(&address, None, Vec::new()).unwrap();
        let mut heard = 0;
        let (pieces, said) = hear_until(&mut bridge, |pieces, _| {
            heard = rows(pieces).values().map(Vec::len).sum();
            heard >= count
        });
        assert_same(&rows(&pieces), &expected);
        assert_eq!(pieces[0].name, "cart");
        assert_eq!(
            said.iter().filter(|own| own.contains("guessed")).count(),
            1,
            "{said:?}"
        );
        let subscribed = server.join().unwrap().unwrap();
        assert_eq!(subscribed.trim(), "/cmd_vel /joint_states /mocap/cart/pose");
    });
}
