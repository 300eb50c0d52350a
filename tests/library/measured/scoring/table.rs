//! Shares of cases with their intervals, as tables for people and as files.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::draw::{Case, Unkind};
use super::information::Information;
use super::judge::{Answer, Judgement, Question};

/// A case with all that was found.
pub struct Row {
    pub case: Case,
    pub information: Information,
    pub answer: Answer,
    pub judgement: Judgement,
    /// To draw, simulate and weigh it; of the library.
    pub seconds: (f64, f64),
}

/// All cases.
pub struct Table {
    pub rows: Vec<Row>,
    /// Seeds that gave none.
    pub panicked: Vec<u64>,
}

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    pub count: usize,
    pub of: usize,
}

impl Share {
    /// Of rows.
    fn of<'a>(rows: impl IntoIterator<Item = &'a Row>, is: impl Fn(&Row) -> bool) -> Share {
        let mut share = Share::default();
        for row in rows {
            share.of += 1;
            share.count += usize::from(is(row));
        }
        share
    }

    /// Its value.
    pub fn value(self) -> f64 {
        self.count as f64 / self.of.max(1) as f64
    }

    /// Wilson's 95 % interval.
    pub fn wilson(self) -> (f64, f64) {
        if self.of == 0 {
            return (0.0, 1.0);
        }
        let (n, p, z) = (self.of as f64, self.value(), 1.959_964_f64);
        let scale = 1.0 / (1.0 + z * z / n);
        let center = (p + z * z / (2.0 * n)) * scale;
        let half = z * scale * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
        let low = if self.count == 0 { 0.0 } else { center - half };
        let high = if self.count == self.of { 1.0 } else { center + half };
        (low, high)
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.of == 0 {
            return write!(f, "none");
        }
        let (low, high) = self.wilson();
        let percent = 100.0 * self.value();
        write!(f, "{percent:.1} % ({} of {}; {:.1} to {:.1})", self.count, self.of, 100.0 * low, 100.0 * high)
    }
}

/// A cell with fewer cases is not marked.
const FEW: usize = 20;
/// A cell below this is marked.
const LOW: f64 = 0.8;

impl Table {
    fn asked(&self, question: Question) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |r| r.judgement.question == question)
    }

    /// Right name where it can be told.
    pub fn right(&self) -> Share {
        Share::of(self.asked(Question::Answerable), |r| r.judgement.right)
    }

    /// A false effect on a clean log.
    pub fn false_on_clean(&self) -> Share {
        Share::of(self.asked(Question::Clean), |r| !r.judgement.false_names.is_empty())
    }

    /// A false effect on any log.
    pub fn false_effects(&self) -> Share {
        Share::of(&self.rows, |r| !r.judgement.false_names.is_empty())
    }

    /// "Nothing is missing" where something is.
    pub fn false_completeness(&self) -> Share {
        Share::of(self.rows.iter().filter(|r| r.judgement.is_incomplete), |r| r.judgement.false_completeness)
    }

    /// Artefacts that were named.
    pub fn artefacts_named(&self) -> Share {
        self.artefact(|_| true)
    }

    fn artefact(&self, which: impl Fn(Unkind) -> bool) -> Share {
        let mut share = Share::default();
        for (_, named) in self.rows.iter().flat_map(|r| &r.judgement.artefacts).filter(|(u, _)| which(*u)) {
            share.of += 1;
            share.count += usize::from(*named);
        }
        share
    }

    /// Every share that is kept over time.
    fn shares(&self) -> Vec<(String, Share)> {
        let right = |question| Share::of(self.asked(question), |r| r.judgement.right);
        let friendly = |is: bool| {
            let rows = self.asked(Question::Answerable).filter(move |r| r.case.unkind.is_empty() == is);
            Share::of(rows, |r| r.judgement.right)
        };
        vec![
            ("right name, answerable".into(), self.right()),
            ("right name, answerable, friendly".into(), friendly(true)),
            ("right name, answerable, unfriendly".into(), friendly(false)),
            ("false effect, clean".into(), self.false_on_clean()),
            ("false effect, any".into(), self.false_effects()),
            ("false effect, broken equation".into(), Share::of(self.asked(Question::Broken), |r| !r.judgement.right)),
            ("false nothing_missing".into(), self.false_completeness()),
            ("right, unanswerable".into(), right(Question::Unanswerable)),
            ("right, invisible".into(), right(Question::Invisible)),
            ("artefact named".into(), self.artefacts_named()),
        ]
    }

    /// Tables in Markdown.
    pub fn markdown(&self) -> String {
        let count = self.rows.len().max(1) as f64;
        let mean = |of: fn(&Row) -> f64| self.rows.iter().map(of).sum::<f64>() / count;
        let (own, library) = (mean(|r| r.seconds.0), mean(|r| r.seconds.1));
        let mut text = format!("{} cases; each {own:.2} s to make and {library:.2} s to identify\n\n", self.rows.len());
        text.push_str("| what | share (count; 95 % interval) |\n|---|---|\n");
        for (what, share) in self.shares() {
            let _ = writeln!(text, "| {what} | {share} |");
        }
        text.push_str(&self.by_effect());
        text.push_str(&self.by_unkind());
        text.push_str(&self.worth_reading());
        text
    }

    /// Right names by effect and kind of bench; each effect of a pair counts.
    fn by_effect(&self) -> String {
        let mut cells: BTreeMap<(&str, &str), Share> = BTreeMap::new();
        for row in self.asked(Question::Answerable) {
            for effect in &row.case.effects {
                let cell = cells.entry((effect.name(), row.case.kind().name())).or_default();
                cell.of += 1;
                cell.count += usize::from(row.judgement.right);
            }
        }
        let mut text = "\n| effect | bench | right name, answerable | |\n|---|---|---|---|\n".to_string();
        for ((effect, kind), share) in cells {
            let mark = if share.of >= FEW && share.value() < LOW { "**low**" } else { "" };
            let _ = writeln!(text, "| {effect} | {kind} | {share} | {mark} |");
        }
        text
    }

    /// By what is unfriendly about the bench.
    fn by_unkind(&self) -> String {
        let mut text =
            "\n| unfriendly | right name, answerable | false effect | named |\n|---|---|---|---|\n".to_string();
        let mut line = |what: &str, rows: &dyn Fn(&Row) -> bool, named: String| {
            let answerable = self.asked(Question::Answerable).filter(|r| rows(r));
            let right = Share::of(answerable, |r| r.judgement.right);
            let wrong = Share::of(self.rows.iter().filter(|r| rows(r)), |r| !r.judgement.false_names.is_empty());
            let _ = writeln!(text, "| {what} | {right} | {wrong} | {named} |");
        };
        line("nothing", &|r| r.case.unkind.is_empty(), String::new());
        for unkind in Unkind::ALL {
            let named = if unkind.is_artefact() { self.artefact(|u| u == unkind).to_string() } else { String::new() };
            line(unkind.name(), &|r| r.case.is(unkind), named);
        }
        text
    }

    /// Cases that went wrong, one a line.
    fn worth_reading(&self) -> String {
        let mut text = "\nWrong:\n".to_string();
        let wrong = |r: &&Row| {
            let j = &r.judgement;
            !j.right || !j.false_names.is_empty() || j.false_completeness
        };
        for row in self.rows.iter().filter(wrong).take(60) {
            let _ = writeln!(
                text,
                "* {}: {}, {} d {:.0} separation {:.0} twin {:?}: {} {:?}",
                row.case.describe(),
                row.judgement.question.word(),
                if row.judgement.false_completeness { "falsely complete," } else { "" },
                finite(row.information.noncentrality()),
                finite(row.information.separation()),
                row.information.seen.iter().map(|s| s.twin.unwrap_or("none")).collect::<Vec<_>>(),
                row.answer.word(),
                row.answer.names(),
            );
        }
        text
    }

    /// One line for each share: what, count, of, share, low, high.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        for (what, share) in self.shares() {
            let (low, high) = share.wilson();
            let _ = writeln!(text, "\"{what}\",{},{},{:.4},{low:.4},{high:.4}", share.count, share.of, share.value());
        }
        text
    }

    /// One line for each case.
    pub fn cases(&self) -> String {
        let mut text =
            "seed,kind,effects,size,unfriendly,band,noncentrality,separation,twin,visible,question,verdict,named,\
                        right,false,false completeness,artefacts named,seconds to make,to identify\n"
                .to_string();
        for row in &self.rows {
            let (case, judgement) = (&row.case, &row.judgement);
            let artefacts: Vec<String> = judgement
                .artefacts
                .iter()
                .map(|(u, named)| format!("{}: {}", u.name(), if *named { "yes" } else { "no" }))
                .collect();
            let cells = [
                case.seed.to_string(),
                case.kind().name().into(),
                case.names().join(" + "),
                case.size.to_string(),
                case.unkind.iter().map(|u| u.name().replace(',', "")).collect::<Vec<_>>().join("; "),
                case.band.map_or(String::new(), |b| b.to_string()),
                format!("{:.1}", finite(row.information.noncentrality())),
                format!("{:.1}", finite(row.information.separation())),
                row.information.seen.iter().map(|s| s.twin.unwrap_or("")).collect::<Vec<_>>().join(" + "),
                row.information.is_visible.to_string(),
                judgement.question.word().into(),
                row.answer.word().into(),
                row.answer.names().join(" + "),
                judgement.right.to_string(),
                judgement.false_names.join(" + "),
                judgement.false_completeness.to_string(),
                artefacts.join("; "),
                format!("{:.2}", row.seconds.0),
                format!("{:.2}", row.seconds.1),
            ];
            let _ = writeln!(text, "{}", cells.join(","));
        }
        text
    }
}

/// Zero for a clean case, which has none.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
