//! The design space of one requirement, asked again and again: what a page with sliders shows.
//!
//! The one idea: a question is a state (values in the place of the requirement's own, and what is looked at), and its answer is made
//! of the parts that the pages of `optimize` and `explain` are made of. The joint that is viewed is answered first, all others after
//! it; a newer question of the same page stops an older one. What was found for a joint is kept by what was asked of it. Nothing
//! here opens a file, a connection or a clock: the requirement's files were read before, and whoever asks brings threads and time.

pub mod controls;
mod files;
pub mod grid;
mod page;
pub mod state;
pub mod work;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::{Map, Value, json};

use crate::ask::optimize::{Asked, Names, Optimized, Ready, optimize};
use crate::ask::{Answer, Failure, Rows, Watch, chosen, pareto};
use crate::design::answer::JointResult;
use crate::design::explain::{Explanation, look};
use crate::input::{InputError, Source};
use crate::report::html::explore::{self as view, Before};
use crate::report::html::{self, Part};
use crate::requirement::{Balancing, Joint, RatioChoice, Robot, Settings};
use crate::study::worker::Store;
pub use page::Demo;
use state::{Ask, Wrong};
use work::{Course, Work};

/// Joints of which is kept what was found.
const KEPT: usize = 64;
/// Pages whose newest question is known.
const TABS: usize = 64;
/// Ratios along each motor's front.
const FRONT: usize = 33;

/// What is explored.
#[derive(Debug)]
pub struct Ground {
    /// The requirement.
    pub source: Arc<Source>,
    /// The state that is begun with: what the call sets.
    pub begin: BTreeMap<String, String>,
    /// The motors.
    pub rows: Rows,
    /// The words of a call of `optimize` that chooses from the same: file and catalogue.
    pub words: Vec<String>,
}

/// Asked whether a report or a front is to end.
pub type Stop = Arc<dyn Fn() -> bool + Send + Sync>;

/// Answers questions about one requirement.
pub struct Explorer {
    ground: Ground,
    store: Store,
    /// The requirement as it is in its file.
    file: Robot,
    kept: Mutex<Vec<(String, Arc<Optimized>)>>,
    newest: Mutex<Vec<(String, Arc<Course>)>>,
    /// How the words of a call are written.
    call: fn(Vec<String>) -> String,
}

impl std::fmt::Debug for Explorer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Explorer").field("ground", &self.ground).finish_non_exhaustive()
    }
}

/// The requirement with what a question sets.
struct Read {
    robot: Robot,
    /// The place of the joint that is viewed.
    place: usize,
    wrong: Vec<Wrong>,
}

impl Explorer {
    /// Reads a requirement, with every file that it names.
    ///
    /// # Errors
    /// Every mistake of them.
    pub fn new(ground: Ground, call: fn(Vec<String>) -> String) -> Result<Explorer, Failure> {
        let store = Store::default();
        let base = PathBuf::new();
        let file = Settings::default().read_with(&ground.source, None, &mut store.reading(&base))?;
        ground.rows.for_robot(&file)?;
        Ok(Explorer { ground, store, file, kept: Mutex::default(), newest: Mutex::default(), call })
    }

    /// The requirement as it is in its file.
    pub fn robot(&self) -> &Robot {
        &self.file
    }

    /// A question of the page, as JSON: it stops what the same page asked before. `announce` is called whenever [`Work::next`] has
    /// something new.
    ///
    /// # Errors
    /// In words: what is no question.
    pub fn begin(&self, body: &str, announce: Box<dyn Fn() + Send + Sync>) -> Result<Work, String> {
        let work = Work::new(Ask::read(body)?, announce);
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = newest.iter().position(|(tab, _)| *tab == work.ask.tab) {
            newest.remove(at).1.stop();
        }
        if newest.len() == TABS {
            newest.remove(0).1.stop();
        }
        newest.push((work.ask.tab.clone(), work.course.clone()));
        drop(newest);
        Ok(work)
    }

    /// Works on a question until it is answered or stale. Input cannot break it; what does is told.
    pub fn run(&self, work: &Work) {
        // It may have waited for its turn, and be stale by now.
        if work.course.is_stopped() {
            return work.end();
        }
        let done = catch_unwind(AssertUnwindSafe(|| self.answer(work)));
        match done {
            Ok(Ok(())) | Ok(Err(Failure::Interrupted(_))) => work.end(),
            Ok(Err(failure)) => {
                let message = words(&failure);
                work.reply(json!({ "ask": work.ask.ask, "problems": [problem(&Wrong::of("", message))] }).to_string());
                work.end();
            }
            Err(_) => {
                let keys: Vec<&str> = work.ask.state.keys().map(String::as_str).collect();
                work.broke(format!("the program broke at what is set: {}", keys.join(", ")));
            }
        }
    }

    fn answer(&self, work: &Work) -> Result<(), Failure> {
        let mut ask = work.ask.clone();
        let read = match self.read(&mut ask) {
            Ok(read) => read,
            Err(wrong) => {
                let problems: Vec<Value> = wrong.iter().map(problem).collect();
                work.reply(json!({ "ask": ask.ask, "problems": problems }).to_string());
                return Ok(());
            }
        };
        let Read { robot, place, wrong } = read;
        let found = self.found(&ask, &robot, place, &work.course)?;
        // What the file chooses, to compare with, where it is known already.
        let plain = if ask.state.is_empty() { Some(found.clone()) } else { self.known(&Ask::default(), place) };
        work.reply(self.viewed(&ask, &work.course, (&robot, place, wrong), (&found, plain.as_deref()))?.to_string());
        if ask.design_only {
            return Ok(());
        }
        self.rest(&ask, work, (&robot, place), (&found, plain.is_none()))
    }

    /// What is said of the joint that is viewed, and of the design that is looked at; `plain` is what was found by the file as it is.
    fn viewed(
        &self,
        ask: &Ask,
        course: &Arc<Course>,
        (robot, place, mut wrong): (&Robot, usize, Vec<Wrong>),
        (found, plain): (&Optimized, Option<&Optimized>),
    ) -> Result<Value, Failure> {
        let result = &found.found().result.joints[0];
        let mut views = Map::new();
        let story = self.story(found, &ask.design).unwrap_or_else(|why| {
            wrong.push(Wrong::of("design", why));
            self.story(found, "").unwrap_or(Ok(None))
        });
        let looked = match &story {
            Ok(Some(story)) => view::design(found.robot(), story),
            Ok(None) => vec![Part::Text("Choose a motor to see what keeps it from being a choice.".into())],
            Err(why) => vec![Part::Text(why.clone())],
        };
        views.insert("design".into(), html::fragment(&looked));
        if !ask.design_only {
            let compared = plain.filter(|_| !ask.state.is_empty()).map(before);
            let parts = view::headline(result, found.without(0), compared.as_ref());
            views.insert("headline".into(), html::fragment(&parts));
            views.insert("ranking".into(), html::fragment(&view::ranking(result)));
        }
        views.insert("pins".into(), html::fragment(&self.pinned(ask, course, &mut wrong)?));
        let joint = &robot.joints[place];
        let problems: Vec<Value> = wrong.iter().map(problem).collect();
        Ok(json!({
            "ask": ask.ask, "joint": html::shown(&joint.name), "state": ask.state, "problems": problems,
            "controls": controls::json((&self.file, &self.file.joints[place]), (robot, joint)), "objective": objective(joint),
            "references": plain.map(|plain| references(&plain.found().result.joints[0])), "notes": self.notes(robot),
            "joints": [short(result)], "design": described(story.as_ref().ok().and_then(Option::as_ref), result),
            "views": views, "pending": !ask.design_only,
        }))
    }

    /// What comes after the joint that is viewed: why the others cannot do it, the file's choice where it is `owed`, all other joints.
    fn rest(
        &self,
        ask: &Ask,
        work: &Work,
        (robot, place): (&Robot, usize),
        (found, owed): (&Optimized, bool),
    ) -> Result<(), Failure> {
        let result = &found.found().result.joints[0];
        let reply = |what: Value| {
            let mut reply = json!({ "ask": ask.ask, "pending": true });
            if let (Some(reply), Value::Object(what)) = (reply.as_object_mut(), what) {
                reply.extend(what);
            }
            work.reply(reply.to_string());
        };
        reply(json!({ "views": {
            "others": html::fragment(&view::others(result)), "trade": html::fragment(&[view::trade(result)]),
            "near": html::fragment(&view::near(found.robot(), result, found.catalog())),
        }}));
        if owed {
            let plain = self.found(&Ask::default(), &self.file, place, &work.course)?;
            let parts = view::headline(result, found.without(0), Some(&before(&plain)));
            let references = references(&plain.found().result.joints[0]);
            reply(json!({ "views": { "headline": html::fragment(&parts) }, "references": references }));
        }
        let mut all = Vec::new();
        for other in 0..robot.joints.len() {
            let found = self.found(ask, robot, other, &work.course)?;
            if other != place {
                reply(json!({ "joints": [short(&found.found().result.joints[0])] }));
            }
            all.push(found);
        }
        let whole = view::whole(robot, all.iter().map(|found| found.found().result.joints[0].clone()).collect());
        reply(json!({ "views": { "whole": html::fragment(&whole) }, "pending": false }));
        Ok(())
    }

    /// The requirement with what a question sets. Of a lenient question what is wrong is left out of it, and told.
    fn read(&self, ask: &mut Ask) -> Result<Read, Vec<Wrong>> {
        let mut wrong = Vec::new();
        let robot = match self.robot_of(&ask.state) {
            Ok(robot) => robot,
            Err(why) if !ask.lenient => return Err(self.placed(&ask.state, why)),
            Err(_) => {
                let mut kept = BTreeMap::new();
                let mut left: Vec<(String, String)> = std::mem::take(&mut ask.state).into_iter().collect();
                // A value may need another one that stands behind it.
                for last in [false, true] {
                    for (key, value) in std::mem::take(&mut left) {
                        let mut with = kept.clone();
                        with.insert(key.clone(), value.clone());
                        match self.robot_of(&with) {
                            Ok(_) => kept = with,
                            Err(why) if last => wrong.extend(why.into_iter().map(|w| Wrong { key: key.clone(), ..w })),
                            Err(_) => left.push((key, value)),
                        }
                    }
                }
                let robot = self.robot_of(&kept)?;
                ask.state = kept;
                robot
            }
        };
        // A page shows a name without what turns the direction of a text.
        let is = |joint: &Joint| joint.name == ask.joint || html::shown(&joint.name) == ask.joint;
        let place = robot.joints.iter().position(is);
        if place.is_none() && !ask.joint.is_empty() {
            wrong.push(Wrong::of("joint", format!("there is no joint `{}`", ask.joint)));
        }
        Ok(Read { robot, place: place.unwrap_or(0), wrong })
    }

    /// Mistakes of a whole file, each at the first key without which there is none.
    fn placed(&self, state: &BTreeMap<String, String>, wrong: Vec<Wrong>) -> Vec<Wrong> {
        let without = |key: &String| {
            let mut other = state.clone();
            other.remove(key);
            self.robot_of(&other).is_ok()
        };
        let whose = || state.keys().find(|key| without(key)).cloned().unwrap_or_default();
        let place = |w: Wrong| if w.key.is_empty() { Wrong { key: whose(), ..w } } else { w };
        wrong.into_iter().map(place).collect()
    }

    /// The requirement with values in the place of its own.
    fn robot_of(&self, state: &BTreeMap<String, String>) -> Result<Robot, Vec<Wrong>> {
        let settings = state::settings(state)?;
        let homes = settings.parts().1.to_vec();
        let key_of = |error: &InputError| {
            let home = homes.iter().position(|home| Arc::ptr_eq(home, &error.source));
            home.and_then(|k| state.keys().nth(k)).cloned().unwrap_or_default()
        };
        let base = PathBuf::new();
        let mut known = files::Known { store: &self.store, reading: self.store.reading(&base) };
        let robot = settings.read_with(&self.ground.source, None, &mut known).map_err(|errors| {
            let of = |error: &InputError| {
                let key = key_of(error);
                let one = |p: &crate::input::Problem| Wrong {
                    key: key.clone(),
                    message: p.message.clone(),
                    help: p.help.clone().unwrap_or_default(),
                };
                error.problems.iter().map(one).collect::<Vec<_>>()
            };
            errors.iter().flat_map(of).collect::<Vec<_>>()
        })?;
        if robot.rules != self.file.rules {
            let key = state.keys().find(|key| key.starts_with("rules")).cloned().unwrap_or_default();
            return Err(vec![Wrong::of(&key, files::REFUSED)]);
        }
        let names = |robot: &Robot| robot.joints.iter().map(|joint| joint.name.clone()).collect::<Vec<_>>();
        if names(&robot) != names(&self.file) {
            let key = state.keys().find(|key| *key == "joint" || key.ends_with(".name")).cloned().unwrap_or_default();
            return Err(vec![Wrong::of(&key, "the joints stay those of the file, with their names")]);
        }
        Ok(robot)
    }

    /// The key of what is kept for a joint.
    fn key(&self, ask: &Ask, robot: &Robot, place: usize) -> String {
        let names: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
        ask.of_joint(names[place], &names, robot.is_coupled())
    }

    /// What is kept of a question by the file's joints.
    fn known(&self, ask: &Ask, place: usize) -> Option<Arc<Optimized>> {
        let key = self.key(ask, &self.file, place);
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(known, _)| *known == key).map(|(_, found)| found.clone())
    }

    /// What is found for a joint; it may be known.
    fn found(&self, ask: &Ask, robot: &Robot, place: usize, course: &Arc<Course>) -> Result<Arc<Optimized>, Failure> {
        let key = self.key(ask, robot, place);
        {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(at) = kept.iter().position(|(known, _)| *known == key) {
                let last = kept.remove(at);
                let found = last.1.clone();
                kept.push(last);
                return Ok(found);
            }
        }
        let asked = Asked { joint: Some(place), ..Asked::default() };
        let watch = || {
            let (step, stop) = (course.clone(), course.clone());
            let tick = Box::new(move || step.step());
            Watch { tick, stop: Box::new(move || stop.is_stopped()), ..Watch::default() }
        };
        let catalog = self.ground.rows.for_robot(robot)?;
        course.begin(catalog.motors.len());
        let ready = Ready::of(robot.clone(), catalog, &asked, false, &watch())?;
        let names = Names { requirement: "".as_ref(), given: None, catalog: &[] };
        let found = Arc::new(optimize(ready, &asked, names, watch())?);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() == KEPT {
            kept.remove(0);
        }
        kept.push((key, found.clone()));
        Ok(found)
    }

    /// A design of a joint; `design` as `explain` names it, the first choice where it is empty. `Ok(Ok(None))` where there is nothing
    /// to look at, `Ok(Err)` in words why it cannot be looked at.
    fn story<'f>(&self, found: &'f Optimized, design: &str) -> Result<Result<Option<Explanation<'f>>, String>, String> {
        let (robot, catalog) = (found.robot(), found.catalog());
        let result = &found.found().result.joints[0];
        let joint = result.joint;
        let first = || result.candidates.first().or_else(|| result.designs().next());
        let by_name = |motor: &str| result.designs().find(|d| d.motor.id == motor);
        let told = |story: Result<Explanation<'f>, crate::design::Unusable>, motor: &str| {
            story.map(Some).map_err(|why| format!("{motor} is no candidate at this joint: {}.", why.reason()))
        };
        let of_design = |d: &'f crate::design::answer::Design<'f>| {
            let gear = d.gear.and_then(|id| catalog.gear_of(d.motor, id));
            let best = Ok((&d.optimum, d.spring));
            told(look(robot, joint, (d.motor, gear), None, best), &d.motor.id)
        };
        if design.is_empty() {
            return Ok(first().map_or(Ok(None), of_design));
        }
        let named = chosen::id(design);
        if design == named
            && let Some(known) = by_name(named)
        {
            return Ok(of_design(known));
        }
        let rejected = result.rejected.iter().find(|r| r.motor.id == named);
        if let Some(rejected) = rejected.filter(|_| design == named) {
            let gear = rejected.gear.and_then(|id| catalog.gear_of(rejected.motor, id));
            let story = look(robot, joint, (rejected.motor, gear), None, Err(&rejected.reason));
            return Ok(told(story, named).map_err(|_| self.why(rejected, joint)));
        }
        let chosen::Chosen { motor, gear, ratio } = chosen::design(design, joint, catalog).map_err(|f| words(&f))?;
        let same = |id: Option<&str>| gear.is_none_or(|gear| id == Some(gear.id.as_str()));
        let known = result.designs().find(|d| d.motor.id == motor.id && same(d.gear));
        let best = match (known, rejected) {
            (Some(known), _) => Ok((&known.optimum, known.spring)),
            (None, Some(rejected)) => Err(&rejected.reason),
            (None, None) => return Err(format!("{} is not among the motors of this joint", motor.id)),
        };
        Ok(told(look(robot, joint, (motor, gear), ratio, best), &motor.id))
    }

    /// Why a motor is no candidate, in words.
    fn why(&self, rejected: &crate::design::answer::Rejected, joint: &Joint) -> String {
        format!("{}: {}.", rejected.motor.id, crate::report::reason::reason_text(&rejected.reason, joint).1)
    }

    /// Pinned designs next to each other.
    fn pinned(&self, ask: &Ask, course: &Arc<Course>, wrong: &mut Vec<Wrong>) -> Result<Vec<Part>, Failure> {
        let mut held = Vec::new();
        for (place_of_pin, pin) in ask.pins.iter().enumerate() {
            let mut of = match Ask::of_link(pin) {
                Ok(of) => of,
                Err(why) => {
                    wrong.push(Wrong::of("pin", why));
                    continue;
                }
            };
            match self.read(&mut of) {
                Ok(Read { robot, place, wrong: left }) => {
                    wrong.extend(left.into_iter().map(|w| Wrong { key: "pin".into(), ..w }));
                    held.push((place_of_pin, self.found(&of, &robot, place, course)?, of.design));
                }
                Err(why) => wrong.extend(why.into_iter().map(|w| Wrong { key: "pin".into(), ..w })),
            }
        }
        let mut stories = Vec::new();
        for (place, found, design) in &held {
            match self.story(found, design) {
                Ok(Ok(Some(story))) => stories.push((*place, found.robot(), story)),
                Ok(Ok(None)) => wrong.push(Wrong::of("pin", "there is no design to look at")),
                Ok(Err(why)) | Err(why) => wrong.push(Wrong::of("pin", why)),
            }
        }
        let stories: Vec<_> = stories.iter().map(|(place, robot, story)| (*place, *robot, story)).collect();
        Ok(view::pinned(&stories))
    }

    /// What is not looked at here.
    fn notes(&self, robot: &Robot) -> Vec<String> {
        let mut notes = Vec::new();
        if robot.is_coupled() {
            notes.push(
                "These joints depend on each other (a budget, a shared supply, or actuators that carry actuators). Each is taken by \
                itself here; `gearwise optimize` looks at the whole robot."
                    .to_string(),
            );
        }
        if robot.rules.is_some() {
            notes.push(
                "Of the requirement's rules those that bound a limit are kept here; `gearwise optimize` and `gearwise check` look at \
                all."
                    .into(),
            );
        }
        notes
    }

    /// The file of a state, with its comments.
    ///
    /// # Errors
    /// What is wrong with the state.
    pub fn toml(&self, body: &str) -> Result<String, Vec<Wrong>> {
        let ask = Ask::read(body).map_err(|why| vec![Wrong::of("", why)])?;
        self.robot_of(&ask.state)?;
        let settings = state::settings(&ask.state)?;
        let base = PathBuf::new();
        Ok(settings.to_toml(&self.ground.source, &mut self.store.reading(&base)))
    }

    /// The page of `optimize --html` for a state.
    ///
    /// # Errors
    /// What is wrong with the state.
    pub fn report(&self, body: &str, stop: Stop) -> Result<String, Vec<Wrong>> {
        let whole = |failure: Failure| vec![Wrong::of("", words(&failure))];
        let ask = Ask::read(body).map_err(|why| vec![Wrong::of("", why)])?;
        let robot = self.robot_of(&ask.state)?;
        let asked = Asked { runner_ups: 3, with_costs: true, ..Asked::default() };
        let catalog = self.ground.rows.for_robot(&robot).map_err(whole)?;
        let watch = || watching(&stop);
        let ready = Ready::of(robot, catalog, &asked, false, &watch()).map_err(whole)?;
        let names = Names { requirement: "".as_ref(), given: None, catalog: &[] };
        let found = optimize(ready, &asked, names, watch()).map_err(whole)?;
        let mut words = self.ground.words.clone();
        words.extend(ask.state.iter().flat_map(|(key, value)| ["--set".into(), format!("{key}={value}")]));
        Ok(html::text(&found.whole_page(&(self.call)(words))))
    }

    /// The fronts of loss, mass and inertia of the viewed joint, as a fragment of the page.
    ///
    /// # Errors
    /// What is wrong with the state.
    pub fn fronts(&self, body: &str, stop: Stop) -> Result<Value, Vec<Wrong>> {
        let whole = |failure: Failure| vec![Wrong::of("", words(&failure))];
        let mut ask = Ask::read(body).map_err(|why| vec![Wrong::of("", why)])?;
        let Read { mut robot, place, .. } = self.read(&mut ask)?;
        let catalog = self.ground.rows.for_robot(&robot).map_err(whole)?;
        // The fronts of one joint: whom it carries does not change them.
        let joint = robot.joints.swap_remove(place);
        robot.joints = vec![Joint { carries: Vec::new(), phases: Vec::new(), ..joint }];
        robot.budget = crate::requirement::Budget::default();
        let quantities =
            pareto::quantities(["loss", "mass", "reflected_inertia"]).map_err(|why| vec![Wrong::of("", why)])?;
        let ready = Ready::of(robot, catalog, &Asked::default(), true, &watching(&stop)).map_err(whole)?;
        let fronts = pareto::pareto(ready, &quantities, FRONT, false, watching(&stop)).map_err(whole)?;
        let page = fronts.page();
        let parts: Vec<Part> =
            page.summary.into_iter().chain(page.sections.into_iter().flat_map(|s| s.parts)).collect();
        Ok(html::fragment(&parts))
    }

    /// The page, which begins with a state where its address says none, and its policy.
    pub fn page(&self, link: &str) -> (String, String) {
        page::live(self, link)
    }

    /// Whether the page begins with a value of this key.
    fn begins_with(&self, key: &str) -> bool {
        self.ground.begin.keys().any(|own| state::overlap(own, key))
    }

    /// The state that is begun with, as a link.
    pub fn link(&self) -> String {
        state::link(&self.ground.begin)
    }

    /// That the requirement takes what is begun with.
    ///
    /// # Errors
    /// What it does not take.
    pub fn check(&self) -> Result<(), Vec<Wrong>> {
        self.robot_of(&self.ground.begin).map(drop)
    }

    /// What of a state the requirement does not take.
    pub fn left_out(&self, mut ask: Ask) -> Vec<Wrong> {
        ask.lenient = true;
        self.read(&mut ask).map_or_else(|wrong| wrong, |read| read.wrong)
    }
}

/// Who asks whether to stop.
fn watching(stop: &Stop) -> Watch {
    let stop = stop.clone();
    Watch { stop: Box::new(move || stop()), ..Watch::default() }
}

/// What was found for a joint, to compare with.
fn before(found: &Optimized) -> Before {
    Before::of(&found.found().result.joints[0])
}

/// A failure in words.
fn words(failure: &Failure) -> String {
    match failure {
        Failure::Argument(why) | Failure::Interrupted(why) => why.clone(),
        Failure::Input(errors) => {
            let all = errors.iter().flat_map(|error| &error.problems).map(|p| p.message.clone());
            all.collect::<Vec<_>>().join("; ")
        }
    }
}

fn problem(wrong: &Wrong) -> Value {
    json!({ "key": wrong.key, "message": wrong.message, "help": wrong.help })
}

/// A joint in a row of all.
fn short(result: &JointResult) -> Value {
    let first = result.candidates.first();
    json!({
        "joint": html::shown(&result.joint.name), "count": result.joint.count, "satisfied": first.is_some(), "text": view::in_short(result),
        "ratio": first.map(|d| d.evaluation.ratio), "motor": first.map(|d| d.motor.id.clone()),
    })
}

/// What is looked at, for the slider of the ratio.
fn described(story: Option<&Explanation>, result: &JointResult) -> Value {
    let Some(story) = story else { return Value::Null };
    let joint = result.joint;
    let free = match joint.ratio {
        RatioChoice::Continuous { min, max } if story.gear.is_none() && story.motor.inside.is_none() => {
            Some([min, max])
        }
        _ => None,
    };
    let best = story.best.as_ref().and_then(|best| best.as_ref().ok()).map(|optimum| optimum.ratio);
    json!({
        "motor": story.motor.id, "gear": story.gear.map(|gear| gear.id.clone()), "ratio": story.evaluation.ratio, "range": free,
        "text": html::explain::ratio_text(story), "best": best, "choice": story.is_choice(), "feasible": story.evaluation.feasible,
    })
}

/// The objective of a joint, as the page chooses it: the name of a single one, else nothing.
fn objective(joint: &Joint) -> Value {
    let sole = match joint.balancing {
        Balancing::No => joint.objective.sole().map(|quantity| quantity.name()),
        _ => Some("balanced"),
    };
    json!({ "key": controls::OBJECTIVE.replace(controls::JOINT, &joint.name), "sole": sole })
}

/// Loss, mass and inertia of the first choice, as references of weights.
fn references(result: &JointResult) -> Value {
    let Some(first) = result.candidates.first() else { return Value::Null };
    let e = &first.evaluation;
    json!({ "loss": [e.loss, "W"], "mass": [e.mass, "kg"], "reflected_inertia": [e.reflected_inertia, "kg*m^2"] })
}
