//! The messages of the node, field by field as ROS 2 defines them; `ros2_client` makes CDR of them.

use ros2_client::Message;
use serde::{Deserialize, Serialize};
use vibrissa_core::plane::Pose2;

/// Defines messages: plain fields in the order of their definition.
macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct $name { $(#[allow(missing_docs)] pub $field: $kind),* }
        impl Message for $name {}
    )*};
}

/// A matrix of six coordinates, x y z and the turns about them; 36 numbers on the wire.
pub type Covariance = [[f64; 6]; 6];

messages! {
    /// `builtin_interfaces/Time`.
    Time { sec: i32, nanosec: u32 }
    /// `rosgraph_msgs/Clock`.
    Clock { clock: Time }
    /// `std_msgs/Header`.
    Header { stamp: Time, frame_id: String }
    /// `geometry_msgs/Point` and `geometry_msgs/Vector3` (m).
    Vector { x: f64, y: f64, z: f64 }
    /// `geometry_msgs/Quaternion`.
    Quaternion { x: f64, y: f64, z: f64, w: f64 }
    /// `geometry_msgs/Pose`.
    Pose { position: Vector, orientation: Quaternion }
    /// `geometry_msgs/PoseWithCovariance`.
    PoseWithCovariance { pose: Pose, covariance: Covariance }
    /// `geometry_msgs/PoseWithCovarianceStamped`.
    PoseWithCovarianceStamped { header: Header, pose: PoseWithCovariance }
    /// `geometry_msgs/PoseArray`.
    PoseArray { header: Header, poses: Vec<Pose> }
    /// `geometry_msgs/Twist` (m/s, rad/s).
    Twist { linear: Vector, angular: Vector }
    /// `geometry_msgs/TwistWithCovariance`.
    TwistWithCovariance { twist: Twist, covariance: Covariance }
    /// `nav_msgs/Odometry`.
    Odometry { header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance }
    /// `geometry_msgs/Wrench` (N, N m).
    Wrench { force: Vector, torque: Vector }
    /// `geometry_msgs/WrenchStamped`.
    WrenchStamped { header: Header, wrench: Wrench }
    /// `sensor_msgs/JointState`.
    JointState { header: Header, name: Vec<String>, position: Vec<f64>, velocity: Vec<f64>, effort: Vec<f64> }
    /// `std_msgs/MultiArrayDimension`.
    MultiArrayDimension { label: String, size: u32, stride: u32 }
    /// `std_msgs/MultiArrayLayout`.
    MultiArrayLayout { dim: Vec<MultiArrayDimension>, data_offset: u32 }
    /// `std_msgs/Float64MultiArray`.
    Float64MultiArray { layout: MultiArrayLayout, data: Vec<f64> }
    /// `nav_msgs/MapMetaData`: side of a cell (m), cells, and where the outer corner of the first cell is.
    MapMetaData { map_load_time: Time, resolution: f32, width: u32, height: u32, origin: Pose }
    /// `nav_msgs/OccupancyGrid`: by rows from the least y, 0 free to 100 solid, -1 unknown.
    OccupancyGrid { header: Header, info: MapMetaData, data: Vec<i8> }
    /// `geometry_msgs/Transform`.
    Transform { translation: Vector, rotation: Quaternion }
    /// `geometry_msgs/TransformStamped`.
    TransformStamped { header: Header, child_frame_id: String, transform: Transform }
    /// `tf2_msgs/TFMessage`.
    TFMessage { transforms: Vec<TransformStamped> }
    /// `diagnostic_msgs/KeyValue`.
    KeyValue { key: String, value: String }
    /// `diagnostic_msgs/DiagnosticStatus`: level 0 is in order, 1 a warning, 2 an error.
    DiagnosticStatus { level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue> }
    /// `diagnostic_msgs/DiagnosticArray`.
    DiagnosticArray { header: Header, status: Vec<DiagnosticStatus> }
    /// `bond/Status`: the sign of life that lifecycle managers wait for.
    BondStatus {
        header: Header,
        id: String,
        instance_id: String,
        active: bool,
        heartbeat_timeout: f32,
        heartbeat_period: f32,
    }
    /// A request or an answer without fields: one byte on the wire.
    Empty { structure_needs_at_least_one_member: u8 }
    /// Answer of `std_srvs/Trigger`.
    TriggerResponse { success: bool, message: String }
    /// `lifecycle_msgs/State`.
    State { id: u8, label: String }
    /// `lifecycle_msgs/Transition`.
    Transition { id: u8, label: String }
    /// `lifecycle_msgs/TransitionDescription`.
    TransitionDescription { transition: Transition, start_state: State, goal_state: State }
    /// `lifecycle_msgs/TransitionEvent`.
    TransitionEvent { timestamp: u64, transition: Transition, start_state: State, goal_state: State }
    /// Request of `lifecycle_msgs/ChangeState`.
    ChangeStateRequest { transition: Transition }
    /// Answer of `lifecycle_msgs/ChangeState`.
    ChangeStateResponse { success: bool }
    /// Answer of `lifecycle_msgs/GetState`.
    GetStateResponse { current_state: State }
    /// Answer of `lifecycle_msgs/GetAvailableStates`.
    GetAvailableStatesResponse { available_states: Vec<State> }
    /// Answer of `lifecycle_msgs/GetAvailableTransitions`, also of the service `get_transition_graph`.
    GetAvailableTransitionsResponse { available_transitions: Vec<TransitionDescription> }
}

impl Time {
    /// The stamp nearest to a time (s), within what a stamp can hold.
    #[must_use]
    pub fn from_seconds(t: f64) -> Self {
        let stamp = vibrissa_io::ros::Stamp::from_seconds(t);
        Self { sec: stamp.sec, nanosec: stamp.nanosec }
    }

    /// The time (s); none for a stamp that was not filled in.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        let stamp = vibrissa_io::ros::Stamp { sec: self.sec, nanosec: self.nanosec };
        (stamp != vibrissa_io::ros::Stamp::default()).then(|| stamp.seconds())
    }
}

impl From<Pose2> for Pose {
    fn from(pose: Pose2) -> Self {
        let (z, w) = (0.5 * pose.theta).sin_cos();
        Self { position: Vector { x: pose.x, y: pose.y, z: 0.0 }, orientation: Quaternion { x: 0.0, y: 0.0, z, w } }
    }
}

impl Pose {
    /// The pose in the plane: heading about z, whatever the tilt; none for a quaternion of no length or numbers that are not finite.
    #[must_use]
    pub fn plane(&self) -> Option<Pose2> {
        let Quaternion { x, y, z, w } = self.orientation;
        let length = x * x + y * y + z * z + w * w;
        let finite = length.is_finite() && self.position.x.is_finite() && self.position.y.is_finite();
        let heading = (2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z);
        (finite && length > 1e-6).then(|| Pose2::new(self.position.x, self.position.y, heading))
    }
}

/// A covariance of (x, y, heading) in the place that six coordinates have.
#[must_use]
pub fn covariance_of_plane(covariance: &[[f64; 3]; 3]) -> Covariance {
    const PLACE: [usize; 3] = [0, 1, 5];
    let mut all = Covariance::default();
    for (i, row) in covariance.iter().enumerate() {
        for (k, value) in row.iter().enumerate() {
            all[PLACE[i]][PLACE[k]] = *value;
        }
    }
    all
}
