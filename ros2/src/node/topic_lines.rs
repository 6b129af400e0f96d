//! A topic as lines on standard output, for `vibrissa live`.

use super::inputs::each;
use super::maker::{Maker, dds, sensor_data};
use super::{ended, join_domain};
use crate::lines::{Joints, array, odometry, wrench};
use crate::messages::{Float64MultiArray, JointState, Odometry, WrenchStamped};
use crate::parameters::Parameters;
use ros2_client::dds::ServiceMapping;
use ros2_client::{NodeName, NodeOptions};
use smol::LocalExecutor;
use smol::channel::Sender;
use std::cell::{Cell, RefCell};
use std::io::{Read, Write};
use std::rc::Rc;
use vibrissa_core::Result;
use vibrissa_live::source::{HostClock, Ros2Message};

/// Tells each message of a topic as a line, until standard input closes or nobody reads the lines any more.
///
/// # Errors
///
/// A network that cannot be used, a name that is none of a topic.
pub fn tell_lines(parameters: &Parameters, message: Ros2Message, topic: &str) -> Result<()> {
    let context = join_domain(parameters)?;
    // Several of them run side by side.
    let name =
        NodeName::new("/", &format!("vibrissa_lines_{}", std::process::id())).map_err(|e| dds("name the node", e))?;
    let node = context.new_node(name, NodeOptions::new().enable_rosout(false)).map_err(|e| dds("make the node", e))?;
    let mut maker = Maker { node, parameters, mapping: ServiceMapping::Enhanced };
    let (stop, stopped) = smol::channel::bounded::<()>(1);
    let executor = LocalExecutor::new();
    let clock = HostClock::new();
    let say = lines_to(stop.clone());
    let qos = sensor_data();
    match message {
        Ros2Message::Odometry => {
            let taken = maker.subscription::<Odometry>(topic, ("nav_msgs", "Odometry"), &qos)?;
            each(&executor, taken, move |message| say(&odometry(&message, clock.now())));
        }
        Ros2Message::Wrench => {
            let taken = maker.subscription::<WrenchStamped>(topic, ("geometry_msgs", "WrenchStamped"), &qos)?;
            each(&executor, taken, move |message| say(&wrench(&message, clock.now())));
        }
        Ros2Message::Array => {
            let taken = maker.subscription::<Float64MultiArray>(topic, ("std_msgs", "Float64MultiArray"), &qos)?;
            each(&executor, taken, move |message| say(&array(&message)));
        }
        Ros2Message::Joints => {
            let taken = maker.subscription::<JointState>(topic, ("sensor_msgs", "JointState"), &qos)?;
            let known: RefCell<Option<Joints>> = RefCell::new(None);
            each(&executor, taken, move |message| {
                let mut known = known.borrow_mut();
                if known.is_none() {
                    *known = Joints::of(&message);
                    known.iter().for_each(|joints| say(&joints.header()));
                }
                known.iter().for_each(|joints| say(&joints.line(&message, clock.now())));
            });
        }
    }
    let spinner = maker.node.spinner().map_err(|e| dds("follow the network", e))?;
    executor.spawn(async move { spinner.spin().await }).detach();
    std::thread::spawn(move || until_input_closes(&stop));
    smol::block_on(executor.run(ended(stopped)));
    Ok(())
}

/// Writes lines to standard output, each at once; the first that cannot be written ends it all.
fn lines_to(stop: Sender<()>) -> Rc<dyn Fn(&str)> {
    let is_open = Cell::new(true);
    Rc::new(move |line: &str| {
        let mut out = std::io::stdout().lock();
        if is_open.get() && writeln!(out, "{line}").and_then(|()| out.flush()).is_err() {
            is_open.set(false);
            stop.close();
        }
    })
}

/// Whoever started the program holds its standard input open.
fn until_input_closes(stop: &Sender<()>) {
    let mut piece = [0; 64];
    while std::io::stdin().read(&mut piece).is_ok_and(|count| count > 0) {}
    stop.close();
}
