//! The next motion, told while the robot rests. Plans are made on a thread of their own: a run never waits for them.

use crate::output::{complain, warn};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use vibrissa::Result;
use vibrissa::flow::pose::{Hypothesis, Status};
use vibrissa::plane::Pose2;
use vibrissa::tasks::explore::{Ended, ExploreOptions, Order, Pilot, way_back};
use vibrissa::tasks::plan::{Past, Plan, PlanOptions, Planner};
use vibrissa::world::{Map, Robot};
use vibrissa_live::estimate::Told;
use vibrissa_live::robot::Errand;
use vibrissa_live::run::Update;

/// So long (s) the robot has rested before a plan is made,
const REST: f64 = 0.3;
/// and so much of that the estimate has seen.
const SEEN: f64 = 0.1;
/// So long (s) the estimator has said that it knows where the robot is before a robot that obeys believes it.
const SURE: f64 = 0.3;
/// A robot that obeys and has rested for so long (s) finds out nothing more: no place is known, or no motion came of a plan.
const IDLE: f64 = 10.0;

/// What a plan is asked for.
struct Question {
    t: f64,
    places: Vec<Hypothesis>,
    planner: Planner,
}

/// What comes of it.
pub(super) struct Answer {
    /// Time of the row at which the robot began to rest (s).
    pub(super) t: f64,
    /// The plan, where one was made.
    pub(super) plan: Option<Plan>,
}

/// Asks for a plan whenever the robot has come to rest and several places are left.
pub(super) struct Planning {
    options: PlanOptions,
    planner: Option<Planner>,
    /// When the rest began for which a plan was asked (s).
    asked: Option<f64>,
    questions: Option<SyncSender<Question>>,
    answers: Receiver<Answer>,
    /// Whether the robot obeys; since when (s) it is localized, and whether its errands are over.
    obeys: bool,
    known_since: Option<f64>,
    arrived: bool,
}

impl Planning {
    /// For a robot on a map; what is planned goes to `errands`, where a robot obeys.
    pub(super) fn start(
        map: &Map,
        robot: &Robot,
        options: PlanOptions,
        errands: Option<Sender<Errand>>,
    ) -> Result<Self> {
        robot.require_level("plan")?;
        let (map, robot) = (map.clone(), robot.clone());
        let (questions, theirs) = sync_channel::<Question>(1);
        let (sender, answers) = channel();
        let pilot = Pilot::new(options)?;
        let obeys = errands.is_some();
        std::thread::spawn(move || match errands {
            Some(errands) => steer(&map, &robot, pilot, &theirs, &sender, &errands),
            None => advise(&map, &robot, &theirs, &sender),
        });
        Ok(Self {
            options,
            planner: None,
            asked: None,
            questions: Some(questions),
            answers,
            obeys,
            known_since: None,
            arrived: false,
        })
    }

    /// Takes what is new in the run.
    pub(super) fn see(&mut self, update: &Update<'_>) {
        match update {
            Update::Began(channels, robot) => match Planner::new(robot, channels, self.options) {
                Ok(planner) => self.planner = Some(planner),
                Err(error) => complain("no plans", &error),
            },
            Update::Row(row) => self.planner.iter_mut().for_each(|planner| planner.row(&row.row)),
            Update::Estimate(told, _) if told.carried <= 0.0 => self.estimate(told),
            _ => {}
        }
    }

    fn estimate(&mut self, told: &Told) {
        let status = told.estimate.status;
        self.known_since = self.known_since.or(Some(told.t)).filter(|_| status == Status::Localized);
        let is_sure = self.known_since.is_some_and(|since| told.t - since >= SURE);
        let Some((rested, since)) = self.planner.as_ref().and_then(Planner::rest) else { return };
        let rests = rested >= REST && told.t >= since + SEEN;
        self.arrived |= self.obeys && (is_sure || rested >= IDLE || (rests && status == Status::Inconsistent));
        if rests && self.asked != Some(since) && status == Status::Ambiguous && !told.estimate.hypotheses.is_empty() {
            self.ask(since, told.estimate.hypotheses.clone());
        }
    }

    fn ask(&mut self, since: f64, places: Vec<Hypothesis>) {
        let (Some(planner), Some(questions)) = (&self.planner, &self.questions) else { return };
        // While an earlier plan is being made none is asked for: the robot still rests then.
        if questions.try_send(Question { t: since, places, planner: planner.clone() }).is_ok() {
            self.asked = Some(since);
        }
    }

    /// A plan that is ready.
    pub(super) fn ready(&mut self) -> Option<Answer> {
        self.answers.try_recv().ok()
    }

    /// The plans that are still being made when the run is over.
    pub(super) fn end(self) -> Vec<Answer> {
        drop(self.questions);
        self.answers.iter().collect()
    }

    /// Ends the errands of a robot that knows where it is, or cannot find out.
    pub(super) fn end_errands(&mut self) {
        if self.arrived {
            self.questions = None;
        }
    }
}

/// Makes plans until the run is over.
fn advise(map: &Map, robot: &Robot, questions: &Receiver<Question>, answers: &Sender<Answer>) {
    for Question { t, places, planner } in questions {
        match planner.plan(map, robot, &places) {
            Ok(plan) => {
                if answers.send(Answer { t, plan: Some(plan) }).is_err() {
                    break;
                }
            }
            Err(error) => complain("no plan", &error),
        }
    }
}

/// Sends a robot from plan to plan, until it has made too many or there is no motion.
fn steer(
    map: &Map,
    robot: &Robot,
    mut pilot: Pilot,
    questions: &Receiver<Question>,
    answers: &Sender<Answer>,
    errands: &Sender<Errand>,
) {
    let most = ExploreOptions::default().most_motions;
    for (count, Question { t, places, planner }) in questions.iter().enumerate() {
        let (history, readings) = planner.past();
        let (order, plan) = match pilot.next(map, robot, &places, &Past { history: &history, readings }) {
            Ok(next) => next,
            Err(error) => return complain("no plan", &error),
        };
        // Whoever listens may have ended.
        let _ = answers.send(Answer { t, plan });
        let errand = match order {
            Order::Go { motion, stop_at } => Errand { waypoints: motion.waypoints().to_vec(), stop_at },
            Order::Back => Errand { waypoints: seen_from_here(way_back(planner.way())), stop_at: Vec::new() },
            Order::End(ended) => return warn(&format!("the robot stops: {}", why(ended))),
        };
        if count >= most {
            return warn(&format!("the robot stops: it knows no more after {most} motions"));
        }
        if errands.send(errand).is_err() {
            return;
        }
    }
}

fn why(ended: Ended) -> &'static str {
    match ended {
        Ended::Symmetric => "no motion tells the places apart, the map is symmetric",
        _ => "no motion is free of collision and gentle at all places that are left",
    }
}

fn seen_from_here(newest_first: Vec<Pose2>) -> Vec<Pose2> {
    newest_first.first().map_or_else(Vec::new, |here| newest_first.iter().map(|pose| here.between(*pose)).collect())
}
