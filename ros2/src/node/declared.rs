//! The parameters as other nodes read them.

use crate::parameters::Parameters;
use ros2_client::{NodeOptions, ParameterValue};

/// The parameters as others read them; they are set at the start.
pub(super) fn options(parameters: &Parameters) -> NodeOptions {
    let text = |text: &str| ParameterValue::String(text.to_owned());
    let path = |path: &std::path::Path| ParameterValue::String(path.display().to_string());
    let [x, y, yaw] = parameters.initial_pose;
    let declared = [
        ("map", path(&parameters.map)),
        ("map_topic", text(parameters.map_topic.as_deref().unwrap_or_default())),
        ("publish_map", ParameterValue::Boolean(parameters.publish_map)),
        ("robot", path(parameters.robot.as_deref().unwrap_or(std::path::Path::new("")))),
        ("method", text(parameters.method.name())),
        ("delay", ParameterValue::Double(parameters.delay)),
        ("rate", ParameterValue::Double(parameters.rate)),
        ("global_frame_id", text(&parameters.global_frame_id)),
        ("odom_frame_id", text(&parameters.odom_frame_id)),
        ("tf_broadcast", ParameterValue::Boolean(parameters.tf_broadcast)),
        ("transform_tolerance", ParameterValue::Double(parameters.transform_tolerance)),
        ("set_initial_pose", ParameterValue::Boolean(parameters.set_initial_pose)),
        ("initial_pose.x", ParameterValue::Double(x)),
        ("initial_pose.y", ParameterValue::Double(y)),
        ("initial_pose.yaw", ParameterValue::Double(yaw)),
        ("use_sim_time", ParameterValue::Boolean(parameters.use_sim_time)),
    ];
    let options = declared.iter().fold(NodeOptions::new().enable_rosout(false), |options, (name, value)| {
        options.declare_parameter(name, value.clone())
    });
    options.parameter_validator(Box::new(move |name, value| {
        let unchanged = declared.iter().any(|(known, old)| *known == name && old == value);
        match unchanged || name == "use_sim_time" {
            true => Ok(()),
            false => Err("set at the start of the node: --ros-args -p NAME:=VALUE".to_owned()),
        }
    }))
}
