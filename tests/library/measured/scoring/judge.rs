//! Whether what was said of a case is right.

use gearwise::measured::identify::{About, Ground, Report, Verdict};

use super::draw::{Case, Unkind};
use super::information::Information;

/// A name that was given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    pub name: &'static str,
    /// What it cannot be told from.
    pub ties: Vec<&'static str>,
}

impl Name {
    /// Whether it is an effect, or says that it may be.
    fn may_be(&self, effect: &str) -> bool {
        self.name == effect || self.ties.contains(&effect)
    }

    /// Whether it says "A", or "A or B".
    fn tells(&self, effect: &str) -> bool {
        self.name == effect || (self.ties.len() == 1 && self.ties.contains(&effect))
    }
}

/// What the library said.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Effects in the order of the first report that names any, then of the others.
    pub named: Vec<Name>,
    /// `None` where identification said why nothing can be learnt.
    pub verdict: Option<Verdict>,
    /// Refusals: name and ground.
    refused: Vec<(String, Ground)>,
    /// What was found in the logs.
    findings: Vec<About>,
    /// What should be known.
    remarks: Vec<String>,
}

impl Answer {
    /// Of reports, or of the reason why there is none.
    pub fn of(said: &Result<Vec<Report>, String>) -> Answer {
        let reports = said.as_deref().unwrap_or_default();
        let name = |found: &gearwise::measured::identify::Found| Name {
            name: found.name(),
            ties: found.confounded_with.iter().map(|e| e.name()).collect(),
        };
        Answer {
            named: reports.iter().flat_map(|r| &r.effects).map(name).collect(),
            verdict: (!reports.is_empty()).then(|| Verdict::over(reports.iter().map(|r| r.verdict))),
            refused: reports.iter().flat_map(|r| &r.refused).map(|r| (r.name.clone(), r.ground)).collect(),
            findings: reports.iter().flat_map(|r| &r.findings).map(|f| f.about.clone()).collect(),
            remarks: reports.iter().flat_map(|r| &r.remarks).cloned().collect(),
        }
    }

    /// Whether an artefact is named: among what was found in the logs, or for an ampere in a remark of its own.
    fn names_artefact(&self, unkind: Unkind) -> bool {
        let found = |is: fn(&About) -> bool| self.findings.iter().any(is);
        match unkind {
            Unkind::WrongScale => found(|about| matches!(about, About::Scale { .. } | About::Unrelated { .. })),
            Unkind::WrongSign => found(|about| matches!(about, About::Sign { .. })),
            Unkind::WrongAmpere => self.remarks.iter().any(|line| line.contains("check `convention`")),
            Unkind::Stale => found(|about| matches!(about, About::Stale { .. } | About::Owns { .. })),
            Unkind::HeldChannel => found(|about| matches!(about, About::Held { .. })),
            other => panic!("{other:?} is no artefact"),
        }
    }

    /// Whether an effect is refused by every report that speaks of it, and for what the bench is.
    fn is_hidden(&self, effect: &str) -> bool {
        let own: Vec<Ground> = self.refused.iter().filter(|(name, _)| name == effect).map(|(_, g)| *g).collect();
        !own.is_empty() && own.iter().all(|g| !matches!(g, Ground::Judged | Ground::Drift))
    }

    /// Its names with their ties, for people.
    pub fn names(&self) -> Vec<String> {
        self.named.iter().map(|n| [vec![n.name], n.ties.clone()].concat().join("~")).collect()
    }

    /// The verdict's word.
    pub fn word(&self) -> &'static str {
        self.verdict.map_or("refused", Verdict::word)
    }
}

/// What a case is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Question {
    /// Nothing was put in: nothing may be named.
    Clean,
    /// The equation does not hold: no effect may be named.
    Broken,
    /// The effect cannot be seen: it must be refused for that.
    Invisible,
    /// The effects can be told.
    Answerable,
    /// They are too weak, or too like others.
    Unanswerable,
}

impl Question {
    /// Of a case, from its truth.
    pub fn of(case: &Case, information: &Information) -> Question {
        match () {
            () if case.unkind.iter().any(|u| u.breaks_the_equation()) => Question::Broken,
            () if case.effects.is_empty() => Question::Clean,
            () if !information.is_visible => Question::Invisible,
            () if information.is_answerable() => Question::Answerable,
            () => Question::Unanswerable,
        }
    }

    /// Its word in tables.
    pub fn word(self) -> &'static str {
        match self {
            Question::Clean => "clean",
            Question::Broken => "broken",
            Question::Invisible => "invisible",
            Question::Answerable => "answerable",
            Question::Unanswerable => "unanswerable",
        }
    }
}

/// How a case was answered.
#[derive(Debug, Clone)]
pub struct Judgement {
    pub question: Question,
    pub right: bool,
    /// Effects that were named and are neither there nor a tie with one that is.
    pub false_names: Vec<&'static str>,
    /// "Nothing is missing" where something is.
    pub false_completeness: bool,
    /// Whether "nothing is missing" would have been false.
    pub is_incomplete: bool,
    /// Each artefact, and whether it was named.
    pub artefacts: Vec<(Unkind, bool)>,
}

impl Judgement {
    /// Of an answer.
    pub fn of(case: &Case, information: &Information, answer: &Answer) -> Judgement {
        let wanted = case.names();
        let question = Question::of(case, information);
        let companions: Vec<&str> = case.companions().collect();
        let is_true = |name: &Name| wanted.iter().chain(&companions).any(|w| name.may_be(w));
        let false_names: Vec<&'static str> = answer.named.iter().filter(|n| !is_true(n)).map(|n| n.name).collect();
        let told = |effect: &str| match wanted.len() {
            // A companion may come first.
            1 => answer
                .named
                .iter()
                .find(|n| n.tells(effect) || !companions.contains(&n.name))
                .is_some_and(|n| n.tells(effect)),
            _ => answer.named.iter().any(|n| n.tells(effect)),
        };
        let all_told = wanted.iter().all(|w| told(w));
        let open = matches!(answer.verdict, Some(Verdict::NotResolved | Verdict::NoneOfThese) | None);
        let right = match question {
            Question::Clean => answer.named.is_empty(),
            // Nothing can be learnt from it but that it is broken.
            Question::Broken => false_names.is_empty(),
            Question::Invisible => {
                let hidden =
                    case.visible().iter().zip(&wanted).filter(|(v, _)| v.is_err()).all(|(_, w)| answer.is_hidden(w));
                hidden && false_names.is_empty()
            }
            Question::Answerable => all_told,
            Question::Unanswerable => {
                let or = !answer.named.is_empty() && false_names.is_empty();
                all_told || or || (open && false_names.is_empty())
            }
        };
        let artefacts: Vec<(Unkind, bool)> = case.artefacts().map(|u| (u, answer.names_artefact(u))).collect();
        // An artefact that is named is not passed over.
        let is_incomplete = information.is_there() || artefacts.iter().any(|(_, named)| !named);
        let false_completeness = is_incomplete && answer.verdict == Some(Verdict::NothingMissing);
        Judgement { question, right, false_names, false_completeness, is_incomplete, artefacts }
    }
}
