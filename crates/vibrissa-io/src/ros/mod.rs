//! ROS 2 messages in MCAP recordings, both ways: the container, the bytes of the messages and their definitions.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `bag_reader` | the container: channels and messages, compressed or not, whole or cut |
//! | `bag_writer`, `bag_stream` | the same, written at once or piece by piece |
//! | `container`, `summary` | what both writers make, and its end |
//! | `growing_file` | where a stream goes |
//! | `chunk` | many messages together, with their index |
//! | `records` | what both are made of |
//! | `cdr` | the bytes of a message's fields |
//! | `map` | the map in a recording |
//! | `message` | the messages that we read and write |
//! | `definition` | their definitions as text, which go into the container |

mod bag_reader;
mod bag_stream;
mod bag_writer;
mod cdr;
mod chunk;
mod container;
mod definition;
mod drawing;
mod growing_file;
mod map;
mod message;
mod records;
mod summary;

pub use bag_reader::{BagSummary, Topic, read_bag};
pub use bag_stream::{BagStream, StreamTopic};
pub use bag_writer::{BagWriter, TopicId};
pub use definition::Kind;
pub use drawing::{Line, LineSet};
pub use growing_file::GrowingFile;
pub use map::{grid_in, read_grid};
pub use message::{
    Header, ImuReading, NamedNumbers, Stamp, decode_bytes, decode_field, decode_grid, decode_imu, decode_named,
    decode_odometry, decode_pose, decode_text, decode_wrench, encode_bytes, encode_cloud, encode_effort, encode_field,
    encode_grid, encode_imu, encode_lines, encode_named, encode_odometry, encode_path, encode_pose, encode_text,
    encode_wrench,
};
