//! Whether an answer is what it claims to be: the best there is, infeasible, certified.

mod cords;
mod metamorphic;
mod unjudged;
mod written;
