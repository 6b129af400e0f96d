//! The socket for viewers: greeting, subscription, data; those who are slow or speak something else harm nobody.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test that cannot go on must fail"
)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};
use vibrissa::io::ros::{Kind, encode_text};
use vibrissa_live::view::{Encoding, ViewTopic, Viewer};

fn started() -> Viewer {
    let topic = |name: &str, encoding, latched| ViewTopic { name: name.to_owned(), encoding, latched };
    let topics =
        vec![topic("/map", Encoding::Ros(Kind::Text), true), topic("/vibrissa/estimate", Encoding::Json, false)];
    Viewer::start("127.0.0.1:0", topics).unwrap()
}

fn connected(viewer: &Viewer, protocol: &'static str) -> tungstenite::Result<WebSocket<MaybeTlsStream<TcpStream>>> {
    let mut request = format!("ws://{}", viewer.address()).into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", HeaderValue::from_static(protocol));
    tungstenite::connect(request).map(|(socket, response)| {
        assert!(protocol.contains(response.headers()["Sec-WebSocket-Protocol"].to_str().unwrap()));
        socket
    })
}

fn json(message: &Message) -> serde_json::Value {
    serde_json::from_str(message.to_text().unwrap()).unwrap()
}

#[test]
fn a_viewer_is_greeted_subscribes_and_sees() {
    let viewer = started();
    viewer.publish(0, 1.5, encode_text("the map"));
    for protocol in ["foxglove.sdk.v1", "foxglove.websocket.v1, other"] {
        let mut socket = connected(&viewer, protocol).unwrap();
        assert_eq!(json(&socket.read().unwrap())["op"], "serverInfo");
        let advertised = json(&socket.read().unwrap());
        assert_eq!(advertised["op"], "advertise");
        let channels = advertised["channels"].as_array().unwrap();
        assert_eq!((&channels[0]["topic"], &channels[0]["encoding"]), (&"/map".into(), &"cdr".into()));
        assert_eq!(
            (&channels[0]["schemaName"], &channels[1]["encoding"]),
            (&"std_msgs/msg/String".into(), &"json".into())
        );
        let subscribe = r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":1},{"id":9,"channelId":2}]}"#;
        socket.send(Message::text("no json")).unwrap();
        socket.send(Message::text(subscribe)).unwrap();
        // What was said before is said again.
        let first = socket.read().unwrap().into_data();
        assert_eq!(first[..13], [1, 7, 0, 0, 0, 0, 0x2f, 0x68, 0x59, 0, 0, 0, 0], "1.5e9 ns");
        assert_eq!(first[13..], encode_text("the map"));
        viewer.publish(1, 2.0, b"{\"t\":2}".to_vec());
        let second = socket.read().unwrap().into_data();
        assert_eq!((second[1], &second[13..]), (9, &b"{\"t\":2}"[..]));
        socket.send(Message::text(r#"{"op":"unsubscribe","subscriptionIds":[9]}"#)).unwrap();
        socket.close(None).unwrap();
    }
}

#[test]
fn strangers_are_refused_and_slow_viewers_wait_for_nobody() {
    let viewer = started();
    assert!(connected(&viewer, "chat").is_err());
    let mut stranger = TcpStream::connect(viewer.address()).unwrap();
    stranger.write_all(b"GET / HTTP/1.1\r\n\r\n\x00\xff garbage").unwrap();
    let mut rest = Vec::new();
    let _ = stranger.read_to_end(&mut rest);
    // One that subscribes and then reads nothing.
    let mut slow = connected(&viewer, "foxglove.sdk.v1").unwrap();
    slow.send(Message::text(r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":2}]}"#)).unwrap();
    while viewer.viewers() == 0 {
        std::thread::sleep(Duration::from_millis(5));
    }
    // Far more than the system's buffers hold, and every call returns.
    for _ in 0..600 {
        viewer.publish(1, 1.0, vec![b'x'; 100_000]);
    }
    assert!(viewer.missed() > 0);
    drop(slow);
    let mut late = connected(&viewer, "foxglove.sdk.v1").unwrap();
    assert_eq!(json(&late.read().unwrap())["op"], "serverInfo");
}
