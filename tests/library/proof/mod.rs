//! Whether an answer is what it claims to be: the best there is, infeasible, certified.

mod balanced;
mod brute_force;
mod cases;
mod effects_in_design;
mod extremes;
mod fronts;
mod gear_map;
mod golden;
mod heat_over_motion;
mod instants;
mod losses;
mod near_best;
mod optimality;
mod program_on_paper;
mod properties;
mod prune;
mod robust;
mod second_formulation;
mod spring;
mod stopped;
mod supply;
mod turns;
mod weakening;
mod windings;
