//! What a model has: terms are added one at a time while one deserves it, and then taken out while one can be spared.
//!
//! The one idea: the loop is the same whoever judges, the balance of an equation or a simulated position; what deserves its
//! place, and why the others do not, is for the judge to say.

/// Chance that the best of all candidates does as well where there is nothing.
pub(crate) const CHANCE: f64 = 0.01;

/// Who says what a model lacks.
pub trait Judge {
    /// Something that may be added, as it was judged.
    type Candidate;

    /// The candidate that deserves its place best, where one does; the others are refused with their reasons.
    fn next(&mut self) -> Option<Self::Candidate>;

    /// Adds it.
    fn add(&mut self, candidate: Self::Candidate);
}

/// Who says what a model can spare.
pub trait Pruner {
    /// Something that may be taken out, as it was judged.
    type Term;

    /// What the model needs least, where it can spare it.
    fn superfluous(&mut self) -> Option<Self::Term>;

    /// Takes it out.
    fn remove(&mut self, term: Self::Term);
}

/// Adds what deserves it, at most so many times.
pub fn forward(judge: &mut impl Judge, steps: usize) {
    for _ in 0..steps {
        let Some(candidate) = judge.next() else { return };
        judge.add(candidate);
    }
}

/// Takes out what can be spared.
pub fn backward(pruner: &mut impl Pruner) {
    while let Some(term) = pruner.superfluous() {
        pruner.remove(term);
    }
}

/// Adds and takes out in turn: whatever is added, what it made superfluous goes before the next is asked. The judge sees to
/// it that what went does not come back.
pub fn in_turn<J: Judge + Pruner>(judge: &mut J, steps: usize) {
    for _ in 0..steps {
        let Some(candidate) = judge.next() else { return };
        judge.add(candidate);
        backward(judge);
    }
}
