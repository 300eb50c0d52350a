#!/bin/sh
# Draws every picture of docs/ again, from the shipped catalogue and requirements. A test runs the same lines
# and compares (tests/program/cli/plots.rs). Lines that begin with `draw` are: file name, then the command.
set -eu
cd "$(dirname "$0")/.."
cargo build --quiet --release
draw() {
    name=$1
    shift
    # Exit status 1 only says that something is not feasible.
    ./target/release/gearwise "$@" --plot "docs/pictures/$name" >/dev/null || [ $? -eq 1 ]
}

draw motors.svg rank --mark t-motor-ri50 --mark t-motor-u8-lee
draw design.svg explain t-motor-ri50@9 requirements/quadruped_mini_cheetah.toml --joint knee
draw optimum.svg optimize requirements/exoskeleton_hip.toml
draw front.svg optimize requirements/quadruped_mini_cheetah.toml --pareto loss,reflected_inertia
draw fronts.svg optimize requirements/exoskeleton_hip.toml --pareto loss,mass,reflected_inertia
draw sweep.svg sweep requirements/exoskeleton_hip.toml
draw step.svg compare t-motor-ri50 t-motor-u8
draw residual.svg identify requirements/bench/leg_actuator.toml
