#!/usr/bin/env bash
# The score of identification: random benches whose truth is known, judged by what they could answer.
#
#   tests/score.sh                                  1000 clean and 2000 affected cases in the release profile: an hour
#   CLEAN=20 AFFECTED=40 PROFILE=dev tests/score.sh fewer of them, in the dev profile
#   FIRST=50001 tests/score.sh                      other seeds
#   GEARWISE_SCORE_KIND=servo tests/score.sh        of one kind of bench alone
#
# Prints tables in Markdown and adds one line for each share to tests/score.csv: date, commit, profile, first seed, what,
# count, of, share and its 95 % interval. Every case is in target/score/cases.csv.
set -euo pipefail
cd "$(dirname "$0")/.."
export GEARWISE_SCORE_FIRST=${FIRST:-1} GEARWISE_SCORE_CLEAN=${CLEAN:-1000} GEARWISE_SCORE_AFFECTED=${AFFECTED:-2000}
work=$PWD/target/score
mkdir -p "$work"
export GEARWISE_SCORE_OUT=$work/cases.csv GEARWISE_SCORE_SUMMARY=$work/summary.csv
profile=${PROFILE:-release}
cargo test --quiet --profile "$profile" --test library -- --ignored --nocapture --exact measured::scoring::score

commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain -- src tests/library tests/simulator)" ] || commit=$commit+
out=tests/score.csv
[ -f $out ] || echo "date,commit,profile,first seed,what,count,of,share,low,high" > $out
sed "s/^/$(date -I),$commit,$profile,$GEARWISE_SCORE_FIRST,/" "$work/summary.csv" >> $out
