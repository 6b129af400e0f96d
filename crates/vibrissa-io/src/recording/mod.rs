//! Recordings with ROS 2 messages (MCAP) of what was simulated or found, for `RViz`, Foxglove, Rerun and `ros2 bag play`.
//!
//! | topic | kind | what |
//! | --- | --- | --- |
//! | `/map` | `nav_msgs/OccupancyGrid` | the map as cells |
//! | `/vibrissa/map` | `sensor_msgs/PointCloud2` | its boundaries as points |
//! | `/odom` | `nav_msgs/Odometry` | the log's odometry (simulated logs) |
//! | `/whisker/NAME/wrench` | `geometry_msgs/WrenchStamped` | moments: the torque about z |
//! | `/whisker/NAME/magnetic_field` | `sensor_msgs/MagneticField` | flux densities |
//! | `/vibrissa/pose` | `geometry_msgs/PoseWithCovarianceStamped` | the best hypothesis |
//! | `/vibrissa/robot` | `geometry_msgs/PoseStamped` | the same, for viewers that draw no covariance |
//! | `/vibrissa/path` | `nav_msgs/Path` | the same as one line |
//! | `/vibrissa/states` | `sensor_msgs/PointCloud2` | the states that explain the log so far |
//! | `/vibrissa/whisker` | `sensor_msgs/PointCloud2` | the whiskers' shapes as points |
//! | `/vibrissa/lines` | `visualization_msgs/MarkerArray` | boundaries, whiskers and the way as lines |
//! | `/vibrissa/moment` | `sensor_msgs/JointState` | the moments as efforts, which viewers plot |
//! | `/vibrissa/event` | `std_msgs/String` | what happened |
//! | `/truth` | `geometry_msgs/PoseStamped` | the true pose, where known |
//!
//! All is in the frame `map`, readings in `NAME_base` of their whiskers; times are those of the log, or since its first row where no
//! recording can hold them ([`clock_origin`]).

mod clock;
mod localization;
pub mod parts;
mod picture;

pub use clock::{clock_origin, clock_warning, shifted_log};
pub use localization::{StampedStates, StatesWatch, localization_mcap};
