//! The bytes of messages against the codec of recordings, which was checked by hand and by other readers.

#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test that cannot go on must fail")]

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;
use vibrissa_core::plane::Pose2;
use vibrissa_io::ros;
use vibrissa_ros2::messages::{
    BondStatus, Float64MultiArray, Header, JointState, Odometry, PoseWithCovariance, PoseWithCovarianceStamped, State,
    Time, Transition, covariance_of_plane,
};

fn bytes<M: Serialize>(message: &M) -> Vec<u8> {
    cdr_encoding::to_vec::<M, LittleEndian>(message).unwrap()
}

fn read<M: DeserializeOwned>(bytes: &[u8]) -> M {
    cdr_encoding::from_bytes::<M, LittleEndian>(bytes).unwrap().0
}

fn header(frame: &str) -> (ros::Header<'_>, Header) {
    let stamp = ros::Stamp { sec: 17, nanosec: 250_000_000 };
    (ros::Header { stamp, frame }, Header { stamp: Time { sec: 17, nanosec: 250_000_000 }, frame_id: frame.to_owned() })
}

#[test]
fn odometry_is_read_as_recordings_have_it() {
    let pose = Pose2::new(0.25, -1.5, 2.0);
    let (theirs, ours) = header("odom");
    let recorded = ros::encode_odometry(theirs, "base_link", pose);
    let message: Odometry = read(&recorded[4..]);
    assert_eq!((message.header, message.child_frame_id.as_str()), (ours, "base_link"));
    let read = message.pose.pose.plane().unwrap();
    assert!((read.x, read.y) == (0.25, -1.5) && (read.theta - 2.0).abs() < 1e-15);
}

#[test]
fn poses_are_written_as_recordings_have_them() {
    let (pose, covariance) = (Pose2::new(3.0, 4.0, -0.7), [[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]]);
    let (theirs, ours) = header("map");
    let message = PoseWithCovarianceStamped {
        header: ours,
        pose: PoseWithCovariance { pose: pose.into(), covariance: covariance_of_plane(&covariance) },
    };
    assert_eq!(bytes(&message), ros::encode_pose(theirs, pose, Some(&covariance))[4..]);
}

#[test]
fn readings_are_read() {
    let (theirs, _) = header("");
    let recorded = ros::encode_effort(theirs, &["left".into(), "right".into()], &[1e-3, -2e-3]);
    let message: JointState = read(&recorded[4..]);
    assert_eq!((message.name.len(), message.effort), (2, vec![1e-3, -2e-3]));
    // One dimension "w" of two, no offset, two numbers; by hand.
    let by_hand: Vec<u8> = [
        &[1, 0, 0, 0, 2, 0, 0, 0, b'w', 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0][..],
        &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0],
    ]
    .concat();
    assert_eq!(read::<Float64MultiArray>(&by_hand).data, [1.0, -2.0]);
}

#[test]
fn small_messages_stand_as_by_hand() {
    assert_eq!(bytes(&State { id: 3, label: "up".into() }), [3, 0, 0, 0, 3, 0, 0, 0, b'u', b'p', 0]);
    assert_eq!(read::<Transition>(&[1, 0, 0, 0, 1, 0, 0, 0, 0]), Transition { id: 1, label: String::new() });
    let bond = BondStatus { active: true, heartbeat_timeout: 4.0, heartbeat_period: 0.5, ..BondStatus::default() };
    let by_hand: Vec<u8> = [
        &[0, 0, 0, 0, 0, 0, 0, 0][..],               // stamp
        &[1, 0, 0, 0, 0, 0, 0, 0],                   // frame "", padding
        &[1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], // id "", instance "", active
        &[0, 0, 0, 0, 0x80, 0x40, 0, 0, 0, 0x3f],    // padding, 4.0, 0.5
    ]
    .concat();
    assert_eq!(bytes(&bond), by_hand);
}
