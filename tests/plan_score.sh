#!/usr/bin/env bash
# How often a planned run separates what the logs of a bench did not, against a chirp of the same length made by hand.
#
#   tests/plan_score.sh                      300 random benches in the release profile
#   FIRST=20001 CASES=50 tests/plan_score.sh others
#   TIME=6 tests/plan_score.sh               shorter runs [s]
set -euo pipefail
cd "$(dirname "$0")/.."
export GEARWISE_PLAN_FIRST=${FIRST:-10001} GEARWISE_PLAN_CASES=${CASES:-300} GEARWISE_PLAN_TIME=${TIME:-12}
cargo test --quiet --profile "${PROFILE:-release}" --test library -- --ignored --nocapture --exact measured::planned::score
