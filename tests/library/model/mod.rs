//! Whether the equations are those of the literature and of the paper.

mod audit;
mod constraints;
mod coupling;
mod families;
mod gear_limits;
mod model_on_paper;
mod module_audit;
mod modules;
mod one_place;
mod saturation;
mod transmission;
mod worked_examples;
