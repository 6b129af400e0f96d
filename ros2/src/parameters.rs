//! The node's parameters, named as those of Nav2's AMCL where they mean the same, and what `--ros-args` says.

use crate::config::TRANSFORM_TOLERANCE;
use crate::engine::{Region, region_around};
use crate::parameters_file;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vibrissa::tasks::plan::PlanOptions;
use vibrissa_core::flow::sensor_log::{Channel, Quantity};
use vibrissa_core::localizer::Method;
use vibrissa_core::plane::Pose2;
use vibrissa_core::world::Robot;
use vibrissa_core::{Error, Result};
use vibrissa_io::text::did_you_mean;
use vibrissa_live::config::ESTIMATE_RATE;

/// The kinds of messages that readings come in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReadingsType {
    /// `std_msgs/Float64MultiArray`: the readings in the order of the parameter `readings`; timed by their arrival.
    #[default]
    Array,
    /// `sensor_msgs/JointState`: readings by name.
    Joints,
    /// `geometry_msgs/WrenchStamped`: the torque about z of one whisker.
    Wrench,
}

/// What the node is told at its start.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// The map's file; empty where it comes as a message.
    pub map: PathBuf,
    /// The topic that the map comes on.
    pub map_topic: Option<String>,
    /// Whether the map of the file is told to viewers.
    pub publish_map: bool,
    /// The robot's file; none for the paper's whisker.
    pub robot: Option<PathBuf>,
    /// The estimator.
    pub method: Method,
    /// What readings come in.
    pub readings_type: ReadingsType,
    /// The readings of a message, named as in a log; empty for the moment of each whisker.
    pub readings: Vec<String>,
    /// How much older readings are than their stamps say (s).
    pub delay: f64,
    /// Estimates a second (Hz).
    pub rate: f64,
    /// Frames.
    pub global_frame_id: String,
    /// The odometry's frame, the child of the transform.
    pub odom_frame_id: String,
    /// Whether `map -> odom` is told.
    pub tf_broadcast: bool,
    /// By how much that transform is dated ahead (s).
    pub transform_tolerance: f64,
    /// Whether the robot starts near `initial_pose`.
    pub set_initial_pose: bool,
    /// Where (m, m, rad).
    pub initial_pose: [f64; 3],
    /// What the robot can do, for the service `plan`.
    pub plan: PlanOptions,
    /// Whether the clock is that of the topic `/clock`.
    pub use_sim_time: bool,
    /// Whether the node configures and activates itself; otherwise a lifecycle manager does.
    pub autostart: bool,
    /// The node's name and namespace.
    pub name: String,
    /// Begins with a slash.
    pub namespace: String,
    /// Other names of topics.
    pub remaps: BTreeMap<String, String>,
    /// The DDS domain.
    pub domain: u16,
    /// Whether only this machine is listened to.
    pub localhost: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            map: PathBuf::new(),
            map_topic: None,
            publish_map: false,
            robot: None,
            method: Method::default(),
            readings_type: ReadingsType::default(),
            readings: Vec::new(),
            delay: 0.0,
            rate: ESTIMATE_RATE,
            global_frame_id: "map".to_owned(),
            odom_frame_id: "odom".to_owned(),
            tf_broadcast: true,
            transform_tolerance: TRANSFORM_TOLERANCE,
            set_initial_pose: false,
            initial_pose: [0.0; 3],
            plan: PlanOptions { sideways: false, ..PlanOptions::default() },
            use_sim_time: false,
            autostart: true,
            name: "vibrissa".to_owned(),
            namespace: "/".to_owned(),
            remaps: BTreeMap::new(),
            domain: 0,
            localhost: false,
        }
    }
}

/// Every parameter and what it takes, for `--help` and for messages.
pub const NAMES: [(&str, &str); 24] = [
    ("map", "the map's file: .svg, .geojson, .dxf, .yaml (due, or map_topic)"),
    ("map_topic", "takes the map from this topic instead (nav_msgs/OccupancyGrid, transient local), such as map"),
    ("publish_map", "whether the map of the file is told as an OccupancyGrid on the topic map (false)"),
    ("robot", "the robot's file; the paper's whisker without it"),
    ("method", "probabilistic (default), possibilistic, deterministic"),
    (
        "readings_type",
        "array (std_msgs/Float64MultiArray, default), joints (sensor_msgs/JointState), wrench (geometry_msgs/WrenchStamped)",
    ),
    (
        "readings",
        "names of the readings, with commas: moment, NAME.moment, NAME.bx, ...; the moment of each whisker without it",
    ),
    ("delay", "how much older readings are than their stamps say (s), -10 to 10"),
    ("rate", "estimates a second (Hz), 0.1 to 1000"),
    ("global_frame_id", "the map's frame (map)"),
    ("odom_frame_id", "the odometry's frame (odom)"),
    ("tf_broadcast", "whether map -> odom is told (true)"),
    ("transform_tolerance", "by how much that transform is dated ahead (s), 0 to 10 (1)"),
    ("set_initial_pose", "whether the robot starts near initial_pose (false)"),
    ("initial_pose.x", "m"),
    ("initial_pose.y", "m"),
    ("initial_pose.yaw", "rad"),
    (
        "plan.footprint",
        "for the service plan: radius of the robot around its origin that stays clear of all boundaries (m), 0 to 10 (0.01)",
    ),
    ("plan.longest", "the longest motion (m), 0.02 to 10 (0.24)"),
    ("plan.sideways", "whether the robot goes in any direction without turning (false)"),
    ("plan.turns", "whether it turns on the spot (true)"),
    ("plan.largest_moment", "the largest moment that a whisker may feel (N m), 1e-9 to 100 (2 EI / L)"),
    ("use_sim_time", "whether time is that of /clock (false)"),
    ("autostart", "whether the node activates itself, without a lifecycle manager (true)"),
];

/// One argument of ROS.
enum Argument<'a> {
    Parameter(&'a str, &'a str),
    Remap(&'a str, &'a str),
    File(&'a str),
}

/// The arguments of ROS among those of the command.
fn arguments(args: &[String]) -> Result<Vec<Argument<'_>>> {
    let mut found = Vec::new();
    let mut rest = args.iter().map(String::as_str);
    while let Some(arg) = rest.next() {
        let mut value = || {
            rest.next()
                .ok_or_else(|| Error::usage(format!("{arg} stands at the end")).remedy("give its value after it"))
        };
        let pair = |text: &'_ str| -> Result<(usize, usize)> {
            let at = text
                .find(":=")
                .ok_or_else(|| Error::usage(format!("{arg} takes NAME:=VALUE")).value(format!("\"{text}\"")))?;
            Ok((at, at + 2))
        };
        match arg {
            "--ros-args" | "--" => {}
            "-p" | "--param" | "-r" | "--remap" => {
                let text = value()?;
                let (end, begin) = pair(text)?;
                let (name, value) = (&text[..end], &text[begin..]);
                let is_parameter = matches!(arg, "-p" | "--param");
                found.push(if is_parameter { Argument::Parameter(name, value) } else { Argument::Remap(name, value) });
            }
            "--params-file" => found.push(Argument::File(value()?)),
            "--log-level" | "--log-config-file" | "--log-file-name" | "--enclave" | "-e" => {
                value()?;
            }
            other if other.starts_with("--enable-") || other.starts_with("--disable-") => {}
            other => {
                return Err(Error::usage("unknown argument")
                    .value(other)
                    .allowed("--ros-args, -p NAME:=VALUE, -r FROM:=TO, --params-file FILE")
                    .remedy("vibrissa-ros2 --help lists the parameters"));
            }
        }
    }
    Ok(found)
}

impl Parameters {
    /// What environment variables say: the domain, and whether only this machine is listened to.
    ///
    /// # Errors
    ///
    /// A domain that is none.
    pub fn from_environment(variable: &dyn Fn(&str) -> Option<String>) -> Result<Self> {
        let mut parameters = Self::default();
        if let Some(text) = variable("ROS_DOMAIN_ID").filter(|text| !text.is_empty()) {
            let domain = text.parse().ok().filter(|domain| *domain <= 232);
            parameters.domain =
                domain.ok_or_else(|| Error::usage("ROS_DOMAIN_ID is no domain").value(&text).allowed("0 to 232"))?;
        }
        parameters.localhost = variable("ROS_LOCALHOST_ONLY").is_some_and(|text| text == "1")
            || variable("ROS_AUTOMATIC_DISCOVERY_RANGE").is_some_and(|text| text == "LOCALHOST");
        Ok(parameters)
    }

    /// The parameters that command arguments say; `variable` gives environment variables. What was left out is told, too.
    ///
    /// | argument | what |
    /// | --- | --- |
    /// | `-p NAME:=VALUE`, `--param` | a parameter; `NODE:NAME:=VALUE` is for the node of that name alone |
    /// | `--params-file FILE` | parameters as ROS 2 writes them, see [`crate::parameters_file`] |
    /// | `-r FROM:=TO`, `--remap` | another name of a topic; `__node` and `__ns` are those of the node |
    /// | `--log-level L`, `--log-config-file F`, `--enclave E`, `--enable-…`, `--disable-…` | taken as `ros2 launch` gives them; without effect |
    ///
    /// What stands later wins, as in ROS 2.
    ///
    /// # Errors
    ///
    /// Unknown arguments and names, values out of range, files that cannot be read.
    pub fn from_args(args: &[String], variable: &dyn Fn(&str) -> Option<String>) -> Result<(Self, Vec<String>)> {
        let (mut parameters, mut left_out) = (Self::from_environment(variable)?, Vec::new());
        // The node's name says which parameters of a file are its own.
        let arguments = arguments(args)?;
        for argument in &arguments {
            if let Argument::Remap(from, to) = argument {
                parameters.remap(from, to);
            }
        }
        for argument in arguments {
            match argument {
                Argument::Remap(..) => {}
                Argument::Parameter(name, value) => match name.split_once(':') {
                    Some((node, name)) if node.trim_start_matches('/') == parameters.name => {
                        parameters.set(name, value)?;
                    }
                    Some((node, _)) => {
                        left_out.push(format!("-p {name}: this node is {}, not {node}", parameters.name))
                    }
                    None => parameters.set(name, value)?,
                },
                Argument::File(path) => {
                    for entry in parameters_file::read(Path::new(path))? {
                        if !entry.is_for(&parameters.namespace, &parameters.name) {
                            continue;
                        }
                        if NAMES.iter().any(|(name, _)| *name == entry.name) {
                            parameters
                                .set(&entry.name, &entry.value)
                                .map_err(|error| error.into_data().in_file(path).at_line(entry.line))?;
                        } else {
                            left_out
                                .push(format!("{path}:{}: {} is no parameter of this node", entry.line, entry.name));
                        }
                    }
                }
            }
        }
        match (&parameters.map_topic, parameters.map.as_os_str().is_empty()) {
            (None, true) => Err(Error::usage("no map is given")
                .remedy("add --ros-args -p map:=arena.svg, or -p map_topic:=map for the map of map_server")),
            (Some(topic), false) => Err(Error::usage("the map is given twice")
                .value(format!("map {}, map_topic {topic}", parameters.map.display()))
                .remedy("leave one of them out")),
            (Some(topic), true) if parameters.publish_map => Err(Error::usage("publish_map tells the map of a file")
                .value(format!("map_topic {topic}"))
                .remedy("leave publish_map out: whoever tells that topic tells viewers, too")),
            _ => Ok((parameters, left_out)),
        }
    }

    /// Sets a parameter from its text.
    ///
    /// # Errors
    ///
    /// No such parameter; a value out of its range.
    pub fn set(&mut self, name: &str, text: &str) -> Result<()> {
        let text = text.trim().trim_matches(['"', '\'']);
        let wrong =
            |allowed: &str| Error::usage(format!("the parameter {name}")).value(format!("\"{text}\"")).allowed(allowed);
        let switch = || match text {
            "true" | "True" => Ok(true),
            "false" | "False" => Ok(false),
            _ => Err(wrong("true, false")),
        };
        let number = |least: f64, most: f64| {
            let value = text.parse::<f64>().ok().filter(|value| (least..=most).contains(value));
            value.ok_or_else(|| wrong(&format!("{least} to {most}")))
        };
        match name {
            "map" => self.map = text.into(),
            "map_topic" => self.map_topic = (!text.is_empty()).then(|| text.to_owned()),
            "publish_map" => self.publish_map = switch()?,
            "robot" => self.robot = (!text.is_empty()).then(|| text.into()),
            "method" => {
                let known = Method::all().each_ref().map(Method::name);
                let of = |_| wrong(&known.join(", ")).remedy(did_you_mean(text, &known));
                self.method = Method::named(text).map_err(of)?;
            }
            "readings_type" => {
                self.readings_type = match text {
                    "array" => ReadingsType::Array,
                    "joints" => ReadingsType::Joints,
                    "wrench" => ReadingsType::Wrench,
                    _ => {
                        let known = ["array", "joints", "wrench"];
                        return Err(wrong(&known.join(", ")).remedy(did_you_mean(text, &known)));
                    }
                }
            }
            "readings" => {
                let names = text.trim_matches(['[', ']']).split(',');
                self.readings = names.map(|one| one.trim().to_owned()).filter(|one| !one.is_empty()).collect();
                self.readings.iter().try_for_each(|one| channel(one).map(|_| ()))?;
            }
            "delay" => self.delay = number(-10.0, 10.0)?,
            "rate" => self.rate = number(0.1, 1000.0)?,
            "global_frame_id" => self.global_frame_id = text.trim_start_matches('/').to_owned(),
            "odom_frame_id" => self.odom_frame_id = text.trim_start_matches('/').to_owned(),
            "tf_broadcast" => self.tf_broadcast = switch()?,
            "transform_tolerance" => self.transform_tolerance = number(0.0, 10.0)?,
            "set_initial_pose" => self.set_initial_pose = switch()?,
            "initial_pose.x" => self.initial_pose[0] = number(-1e6, 1e6)?,
            "initial_pose.y" => self.initial_pose[1] = number(-1e6, 1e6)?,
            "initial_pose.yaw" => self.initial_pose[2] = number(-10.0, 10.0)?,
            "plan.footprint" => self.plan.footprint = number(0.0, 10.0)?,
            "plan.longest" => self.plan.longest = number(0.02, 10.0)?,
            "plan.sideways" => self.plan.sideways = switch()?,
            "plan.turns" => self.plan.turns = switch()?,
            "plan.largest_moment" => self.plan.largest_moment = Some(number(1e-9, 100.0)?),
            "use_sim_time" => self.use_sim_time = switch()?,
            "autostart" => self.autostart = switch()?,
            other => {
                let known = NAMES.map(|(name, _)| name);
                return Err(Error::usage("unknown parameter")
                    .value(other)
                    .allowed(known.join(", "))
                    .remedy(did_you_mean(other, &known)));
            }
        }
        Ok(())
    }

    fn remap(&mut self, from: &str, to: &str) {
        match from {
            "__node" | "__name" => self.name = to.to_owned(),
            "__ns" => self.namespace = format!("/{}", to.trim_matches('/')),
            _ => {
                self.remaps.insert(from.trim_start_matches('/').to_owned(), to.to_owned());
            }
        }
    }

    /// The name of a topic after remapping.
    #[must_use]
    pub fn topic<'a>(&'a self, name: &'a str) -> &'a str {
        self.remaps.get(name.trim_start_matches('/')).map_or(name, String::as_str)
    }

    /// The readings of a message for a robot.
    ///
    /// # Errors
    ///
    /// Names of whiskers that the robot does not have; a wrench for several readings.
    pub fn channels(&self, robot: &Robot) -> Result<Vec<Channel>> {
        let moment = |whisker: &str| Channel { whisker: whisker.to_owned(), quantity: Quantity::Moment };
        let channels: Vec<Channel> = if self.readings.is_empty() {
            robot.whiskers.iter().map(|whisker| moment(&whisker.name)).collect()
        } else {
            self.readings.iter().map(|one| channel(one)).collect::<Result<_>>()?
        };
        let names: Vec<&str> = robot.whiskers.iter().map(|whisker| whisker.name.as_str()).collect();
        if let Some(unknown) =
            channels.iter().find(|one| !one.whisker.is_empty() && !names.contains(&one.whisker.as_str()))
        {
            return Err(Error::usage("the parameter readings names a whisker that the robot does not have")
                .value(unknown.column())
                .allowed(names.join(", ")));
        }
        if self.readings_type == ReadingsType::Wrench
            && (channels.len() != 1 || channels[0].quantity != Quantity::Moment)
        {
            return Err(Error::usage("readings_type wrench is the moment of one whisker")
                .value(channels.iter().map(Channel::column).collect::<Vec<_>>().join(", "))
                .remedy("take readings_type:=array or joints"));
        }
        Ok(channels)
    }

    /// The region that the parameters say the robot starts in.
    #[must_use]
    pub fn initial_region(&self) -> Option<Region> {
        let [x, y, yaw] = self.initial_pose;
        // The variances that RViz and AMCL take where nothing is said: half a metre and a quarter of a radian.
        self.set_initial_pose.then(|| region_around(Pose2::new(x, y, yaw), [0.25, 0.25, 0.0685]))
    }
}

/// The channel of a name such as `moment` or `left.bx`.
fn channel(name: &str) -> Result<Channel> {
    let (whisker, word) = name.rsplit_once('.').unwrap_or(("", name));
    let known = Quantity::ALL.map(Quantity::word);
    let quantity = Quantity::ALL.into_iter().find(|quantity| quantity.word() == word).ok_or_else(|| {
        Error::usage("the parameter readings names no reading")
            .value(name)
            .allowed(format!("{}, each also as NAME.{}", known.join(", "), known[0]))
            .remedy(did_you_mean(word, &known))
    })?;
    Ok(Channel { whisker: whisker.to_owned(), quantity })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test that cannot go on must fail")]
mod tests {
    use super::{Parameters, ReadingsType};

    fn parse(text: &str) -> Result<Parameters, String> {
        parsed(text).map(|parsed| parsed.0)
    }

    fn parsed(text: &str) -> Result<(Parameters, Vec<String>), String> {
        let args: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        let variable = |name: &str| (name == "ROS_DOMAIN_ID").then(|| "7".to_owned());
        Parameters::from_args(&args, &variable).map_err(|e| e.to_string())
    }

    #[test]
    fn arguments_are_those_of_ros() {
        let parsed = parse(
            "--ros-args -p map:=a.svg -p readings_type:=joints -p readings:=[w0.bx,w0.by] -p initial_pose.x:=1.5 \
             -p set_initial_pose:=true -r __node:=amcl -r __ns:=/robot -r /odom:=base/odom",
        )
        .unwrap();
        assert_eq!((parsed.domain, parsed.name.as_str(), parsed.namespace.as_str()), (7, "amcl", "/robot"));
        assert_eq!((parsed.topic("odom"), parsed.topic("readings")), ("base/odom", "readings"));
        assert_eq!((parsed.readings_type, parsed.readings.len()), (ReadingsType::Joints, 2));
        let [x, _, _] = parsed.initial_region().unwrap();
        assert_eq!(x, [0.0, 3.0]);
    }

    #[test]
    fn files_of_parameters_are_those_of_ros() {
        let folder = std::env::temp_dir().join(format!("vibrissa-parameters-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).unwrap();
            path.display().to_string()
        };
        let whole = file(
            "whole.yaml",
            "/**:\n  ros__parameters:\n    map: a.svg\n    rate: 10\n    use_sim_time: true\nvibrissa:\n  ros__parameters:\n    \
             initial_pose: {x: 1.5, yaw: -0.5}\n    set_initial_pose: true\n    readings: [w0.bx, w0.by]\n    alpha1: 0.2\nother:\n  \
             ros__parameters:\n    rate: 1.0\n",
        );
        let (parsed_file, left_out) = parsed(&format!("--ros-args -p rate:=5 --params-file {whole}")).unwrap();
        assert_eq!((parsed_file.rate, parsed_file.use_sim_time, parsed_file.readings.len()), (10.0, true, 2));
        assert_eq!(parsed_file.initial_pose, [1.5, 0.0, -0.5]);
        assert!(left_out.len() == 1 && left_out[0].contains("alpha1"), "{left_out:?}");
        let later =
            parse(&format!("--ros-args --params-file {whole} -p rate:=5 --log-level info -p other:rate:=2")).unwrap();
        assert_eq!(later.rate, 5.0);
        let renamed = parse(&format!("--ros-args -r __node:=other --params-file {whole}")).unwrap();
        assert_eq!((renamed.rate, renamed.set_initial_pose), (1.0, false));
        for (name, text, words) in [
            ("range.yaml", "/**:\n  ros__parameters:\n    map: a.svg\n    rate: 1e9\n", "range.yaml:4"),
            ("cut.yaml", "/**:\n  ros__parameters: [\n", "cut.yaml"),
            ("none.yaml", "rate: 3\n", "ros__parameters"),
            ("empty.yaml", "", "ros__parameters"),
        ] {
            let error = parse(&format!("--params-file {}", file(name, text))).unwrap_err();
            assert!(error.contains(words), "{name}: {error}");
        }
        assert!(parse("--params-file").unwrap_err().contains("at the end"));
        assert!(parse(&format!("--params-file {}", folder.join("missing").display())).unwrap_err().contains("missing"));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_is_wrong_is_named_with_what_may_stand_there() {
        for (text, words) in [
            ("", "no map"),
            ("-p map:=a.svg -p rat:=3", "rate"),
            ("-p map:=a.svg -p rate:=0", "0.1 to 1000"),
            ("-p map:=a.svg -p rate:=nan", "0.1 to 1000"),
            ("-p map:=a.svg -p readings:=w0.momnt", "moment"),
            ("-p map:=a.svg -p tf_broadcast:=1", "true, false"),
            ("-p map:=a.svg -p method:=posibilistic", "the parameter method: \"posibilistic\""),
            ("-p map:=a.svg -p method:=posibilistic", "did you mean `possibilistic`?"),
            ("-p map:=a.svg -p method:=amcl", "known: deterministic, possibilistic, probabilistic"),
            ("-p map:=a.svg -p readings_type:=arrays", "did you mean `array`?"),
            ("-p map", "NAME:=VALUE"),
            ("-p map:=a.svg -p map_topic:=map", "twice"),
            ("-p map_topic:=map -p publish_map:=true", "publish_map"),
            ("--map a.svg", "unknown argument"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
