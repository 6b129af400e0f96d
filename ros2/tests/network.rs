//! The node on the network: another participant in this process tells it a map, odometry and readings and hears where the robot is.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::dds::{Context, Node, Publisher, Subscription};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{Message, MessageTypeName, Name, NodeName, NodeOptions, QosProfile};
use std::net::{IpAddr, Ipv4Addr};
use std::time::{Duration, Instant};
use vibrissa::tasks::demo;
use vibrissa::tasks::plan::PlanOptions;
use vibrissa_ros2::grid;
use vibrissa_ros2::messages::{
    DiagnosticArray, Header, JointState, OccupancyGrid, Odometry, PoseWithCovariance, PoseWithCovarianceStamped,
    TFMessage, Time,
};
use vibrissa_ros2::node::start;
use vibrissa_ros2::parameters::{Parameters, ReadingsType};

/// How long whatever is waited for may take: discovery on a busy machine, a search of the map.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time of the first row (s).
const BEGAN: f64 = 1_700_000_000.0;
/// Rows for each message of odometry.
const ODOMETRY_EVERY: usize = 6;

fn reliable() -> QosProfile {
    QosProfile::publisher_default().reliability_reliable(WhenFull::Fail).history(History::KeepLast { depth: 100 })
}

fn latched() -> QosProfile {
    reliable().durability(Durability::TransientLocal).history(History::KeepLast { depth: 1 })
}

/// Another participant on the loopback.
struct Other {
    node: Node,
    // Kept for as long as the node.
    _context: Context,
}

impl Other {
    fn new(domain: u16) -> Self {
        let participant = DomainParticipantBuilder::new(domain)
            .with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)])
            .build()
            .unwrap();
        let context = Context::from_domain_participant(participant).unwrap();
        let name = NodeName::new("/", "other").unwrap();
        let node = context.new_node(name, NodeOptions::new().enable_rosout(false)).unwrap();
        Self { node, _context: context }
    }

    fn publisher<M: Message>(&mut self, name: &str, kind: (&str, &str), qos: &QosProfile) -> Publisher<M> {
        let name = Name::parse(name).unwrap();
        let topic = self.node.create_topic(&name, MessageTypeName::new(kind.0, kind.1), qos).unwrap();
        self.node.create_publisher(&topic, None).unwrap()
    }

    fn subscription<M: Message + 'static>(
        &mut self,
        name: &str,
        kind: (&str, &str),
        qos: &QosProfile,
    ) -> Subscription<M> {
        let name = Name::parse(name).unwrap();
        let topic = self.node.create_topic(&name, MessageTypeName::new(kind.0, kind.1), qos).unwrap();
        self.node.create_subscription(&topic, None).unwrap()
    }
}

/// Messages until one is as it should be.
#[track_caller]
fn heard<M: Message + 'static>(subscription: &Subscription<M>, wanted: impl Fn(&M) -> bool) -> M {
    let began = Instant::now();
    while began.elapsed() < PATIENCE {
        match subscription.take() {
            Ok(Some((message, _))) if wanted(&message) => return message,
            Ok(Some(_)) => {}
            _ => std::thread::sleep(Duration::from_millis(5)),
        }
    }
    panic!("nothing of the kind was heard");
}

#[test]
fn a_map_odometry_and_readings_go_in_and_the_pose_comes_out() {
    // A domain that no other test of this machine has.
    let domain = 100 + (std::process::id() % 100) as u16;
    let parameters = Parameters {
        map_topic: Some("map".to_owned()),
        readings_type: ReadingsType::Joints,
        readings: vec!["moment".to_owned()],
        domain,
        localhost: true,
        ..Parameters::default()
    };
    let running = start(&parameters).unwrap();
    let mut other = Other::new(domain);
    let diagnostics =
        other.subscription::<DiagnosticArray>("/diagnostics", ("diagnostic_msgs", "DiagnosticArray"), &reliable());
    // Without a map it says what is missing.
    let told = heard(&diagnostics, |message| message.status[0].message.contains("no map"));
    assert_eq!(told.status[0].level, 2);
    assert!(running.engine().plan().unwrap_err().to_string().contains("no place is known"));

    let arena = demo::arena().unwrap();
    let maps = other.publisher::<OccupancyGrid>("/map", ("nav_msgs", "OccupancyGrid"), &latched());
    maps.publish(grid::message(&arena, "map")).unwrap();
    heard(&diagnostics, |message| !message.status[0].message.contains("no map"));
    let odometry = other.publisher::<Odometry>("/odom", ("nav_msgs", "Odometry"), &reliable());
    let readings = other.publisher::<JointState>("/readings", ("sensor_msgs", "JointState"), &reliable());
    let poses = other.subscription::<PoseWithCovarianceStamped>(
        "/amcl_pose",
        ("geometry_msgs", "PoseWithCovarianceStamped"),
        &reliable(),
    );
    let transforms = other.subscription::<TFMessage>("/tf", ("tf2_msgs", "TFMessage"), &reliable());

    let sweep = demo::sweep(1).unwrap();
    let rows = &sweep.log.rows;
    let say = |index: usize| {
        let row = &rows[index];
        let stamp = Time::from_seconds(BEGAN + row.t);
        let header = Header { stamp, frame_id: "odom".to_owned() };
        if index.is_multiple_of(ODOMETRY_EVERY) || index + 1 == rows.len() {
            let pose = PoseWithCovariance { pose: row.odom_from_robot.into(), ..PoseWithCovariance::default() };
            let _ = odometry.publish(Odometry { header: header.clone(), pose, ..Odometry::default() });
        }
        let (name, position) = (vec!["moment".to_owned()], vec![row.readings[0]]);
        let _ = readings.publish(JointState { header, name, position, ..JointState::default() });
    };
    // Until the first is heard, the first row again and again: repeated rows are dropped.
    let began = Instant::now();
    while running.engine().pulse().sources.iter().any(|source| source.1.frames == 0) {
        assert!(began.elapsed() < PATIENCE, "the node hears nothing");
        say(0);
        std::thread::sleep(Duration::from_millis(50));
    }
    let mut last = None;
    for index in 1..rows.len() {
        say(index);
        std::thread::sleep(Duration::from_millis(3));
        while let Ok(Some((message, _))) = poses.take() {
            last = Some(message);
        }
    }
    let end = rows[rows.len() - 1].t;
    let near = |message: &PoseWithCovarianceStamped| message.header.stamp.seconds().unwrap() > BEGAN + end - 0.1;
    let last = last.filter(near).unwrap_or_else(|| heard(&poses, near));
    let t = last.header.stamp.seconds().unwrap() - BEGAN;
    let truth = sweep.truth.iter().min_by(|a, b| (a.t - t).abs().total_cmp(&(b.t - t).abs())).unwrap();
    let pose = last.pose.pose.plane().unwrap();
    let off = pose.position().distance(truth.map_from_robot.position());
    // A grid tells walls to a fraction of its cells of half a millimetre.
    assert!(off < 3e-3, "{off} m off at {t} s");
    // Where it goes next, by the same places.
    let plan = running.engine().plan().unwrap();
    assert!(
        plan.places >= 1 && plan.looked_at[0] > 10 && plan.readings <= PlanOptions::default().budget + 64,
        "{plan:?}"
    );
    let transform = heard(&transforms, |message| !message.transforms.is_empty());
    assert_eq!((transform.transforms[0].header.frame_id.as_str(), last.header.frame_id.as_str()), ("map", "map"));
    running.stop();
}
