//! What the declared bounds leave open of a log that no likely place explains: set inversion \[jaulin2009robust\] as a second opinion. The true
//! state is in the set as long as the bounds hold, whatever the law of the errors within.

use crate::Stop;
use crate::config::{PossibilisticOptions, ProbabilisticOptions};
use crate::flow::pose::{Event, Localization, Status};
use crate::flow::sensor_log::{LogRow, SensorLog};
use crate::localizer::{Localizer, Method};
use crate::sets::Interval;
use crate::world::{Map, Robot};

/// From so much way after the first contact on the whisker may touch in two places at once (m).
const TWO_CONTACTS: f64 = 0.05;
/// Work of the final refinement: who has no answer can wait for some seconds.
const LAST_WORK: usize = 5_000_000;
/// A set of more places than this, or with one that is larger (m), is no answer: it says that little was felt. Of 16 drives around corners that were
/// `inconsistent` it makes nine `ambiguous`, all with the truth in the set; of 84 with a wrong sign, mirrored odometry or a wrong map one.
const MOST_PLACES: usize = 4;
const LARGEST_PLACE: f64 = 0.15;
/// Nor is the set asked where the readings scatter so far from the likeliest place (mean square over that of the declared noise): half of them are false
/// there, each of which counts 36, and map or robot are others. With a wrong map the bounds may leave some place, too.
const LARGEST_MISFIT: f64 = 18.0;

/// What the other method was told.
pub(super) struct Told<'a> {
    pub(super) log: &'a SensorLog,
    /// Of the log's rows those that count.
    pub(super) rows: &'a [LogRow],
    pub(super) map: &'a Map,
    pub(super) robot: &'a Robot,
    pub(super) options: &'a ProbabilisticOptions,
    pub(super) stop: &'a Stop,
}

impl Told<'_> {
    /// The set of all states that the rows leave open; none where the method does not take the robot or the map, or the end is asked for.
    pub(super) fn enclosure(&self) -> Option<Localization> {
        let ProbabilisticOptions { prior, heading_error, .. } = *self.options;
        let options = PossibilisticOptions {
            two_contacts: Some(TWO_CONTACTS),
            last_work: LAST_WORK,
            prior,
            heading_error,
            ..PossibilisticOptions::default()
        };
        let method = Method::Possibilistic(options);
        let mut localizer = Localizer::new(self.map, self.robot, &self.log.channels, &method).ok()?;
        localizer.heed(self.stop);
        for row in self.rows {
            localizer.step(row).ok()?;
            if self.stop.is_asked() {
                return None;
            }
        }
        let set = localizer.finish();
        (!self.stop.is_asked()).then_some(set)
    }

    /// The answer on a log that the probabilistic method calls `inconsistent`: the places of the set, where the declared bounds leave few and small ones
    /// (event `enclosed`), else the answer as it is. It is no more than `ambiguous`: the set takes for exact what the robot file does not bound, and may leave
    /// a place on another's map, too.
    pub(super) fn answer(&self, answer: Localization) -> Localization {
        let is_elsewhere = answer.consistency.as_ref().is_some_and(|fit| fit.statistic > LARGEST_MISFIT);
        if answer.status != Status::Inconsistent || is_elsewhere || self.stop.is_asked() {
            return answer;
        }
        let Some(set) = self.enclosure().filter(tells) else { return answer };
        let t = self.rows.last().map_or(0.0, |row| row.t);
        let count = set.hypotheses.len();
        let places = if count == 1 { "one place".to_owned() } else { format!("{count} places") };
        let detail = format!(
            "no likely place explains all readings, but the declared bounds leave {places}: told as by the possibilistic method, which takes what \
             the robot file does not bound for exact"
        );
        let mut events = answer.events;
        events.push(Event { t, kind: "enclosed", detail });
        Localization { status: Status::Ambiguous, events, consistency: answer.consistency, ..set }
    }
}

/// Whether a set says where the robot is.
fn tells(set: &Localization) -> bool {
    let is_small = |range: Interval| range.width() <= LARGEST_PLACE;
    matches!(set.status, Status::Localized | Status::Ambiguous)
        && (1..=MOST_PLACES).contains(&set.hypotheses.len())
        && set.hypotheses.iter().all(|place| is_small(place.extent.x) && is_small(place.extent.y))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::flow::pose::StampedPose;
    use crate::plane::{Curve, Pose2, Vec2};
    use crate::sim::{Pace, SimulateOptions, SweepNoise, path_through, simulate};
    use crate::world::{Boundary, Role};

    /// Along the lower wall of a room, over a bay or not; with the like bay opposite or not.
    pub(crate) fn swept(from: f64, to: f64, is_symmetric: bool) -> (Map, Robot, SensorLog, Pose2) {
        let half = [(0.0, 0.0), (0.25, 0.0), (0.25, -0.05), (0.32, -0.05), (0.32, 0.0), (0.45, 0.0)];
        let mut points: Vec<Vec2> = half.into_iter().map(|(x, y)| Vec2::new(x, y)).collect();
        let opposite = |p: Vec2| Vec2::new(0.45, 0.3) - p;
        if is_symmetric {
            points.extend(half.map(|(x, y)| opposite(Vec2::new(x, y))));
        } else {
            points.extend([Vec2::new(0.45, 0.3), Vec2::new(0.0, 0.3)]);
        }
        let map = Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&points, true).unwrap(), None).unwrap()]);
        let (map, mut robot) = (map.unwrap(), Robot::default());
        robot.whiskers[0].beam.length = 0.08;
        robot.whiskers[0].robot_from_whisker = Pose2::new(0.0, 0.0, -1.2);
        let way = [Pose2::new(from, 0.09, 0.0), Pose2::new(from + 0.01, 0.066, 0.0), Pose2::new(to, 0.066, 0.0)];
        let path = path_through(&way, &Pace { speed: 0.1, turn_rate: 1.0, rate: 50.0 }).unwrap();
        let sweep = simulate(&map, &robot, &path, &SweepNoise::seeded(5), &SimulateOptions::default()).unwrap();
        let truth = path.last().map(|last: &StampedPose| last.map_from_robot).unwrap();
        (map, robot, sweep.log, truth)
    }

    #[test]
    fn a_log_that_nothing_explains_is_told_by_what_the_bounds_leave() {
        let ask = |log: &SensorLog, map: &Map, robot: &Robot, options: ProbabilisticOptions, stop: &Stop| {
            let event = Event { t: 0.5, kind: "inconsistent", detail: String::new() };
            let none = Localization { status: Status::Inconsistent, events: vec![event], ..Localization::default() };
            Told { log, rows: &log.rows, map, robot, options: &options, stop }.answer(none)
        };
        let (map, robot, log, truth) = swept(0.12, 0.4, false);
        let never = Stop::default();
        for options in [ProbabilisticOptions::default(), ProbabilisticOptions::exact()] {
            let told = ask(&log, &map, &robot, options, &never);
            assert_eq!((told.status, told.hypotheses.len(), told.encloses), (Status::Ambiguous, 1, true));
            let place = &told.hypotheses[0].extent;
            assert!(place.x.contains(truth.x) && place.y.contains(truth.y), "{place:?}, {truth:?}");
            let kinds: Vec<&str> = told.events.iter().map(|event| event.kind).collect();
            assert_eq!(kinds, ["inconsistent", "enclosed"]);
        }
        let stays = |told: Localization| told.status == Status::Inconsistent && told.hypotheses.is_empty();
        // Along a straight wall too many places are left to be an answer, and where the bounds do not hold none is.
        let (.., short, _) = swept(0.06, 0.15, false);
        assert!(stays(ask(&short, &map, &robot, ProbabilisticOptions::default(), &never)));
        let mut sure = robot.clone();
        (sure.whiskers[0].noise.moment_relative, sure.whiskers[0].noise.moment_absolute) = (1e-4, 1e-8);
        assert!(stays(ask(&log, &map, &sure, ProbabilisticOptions::default(), &never)));
        // Who wants an end does not wait.
        let now = Stop::default();
        now.ask();
        assert!(stays(ask(&log, &map, &robot, ProbabilisticOptions::default(), &now)));
    }
}
