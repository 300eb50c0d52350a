#!/usr/bin/env bash
# Mutation testing: which changes of a sign, a comparison, a term or a whole function would no test notice?
#
#   tests/mutants.sh                                all mutants of all rooms: hours
#   tests/mutants.sh actuator program               of some rooms
#   SEED=2 FROM=0 COUNT=120 tests/mutants.sh ...    a sample: COUNT of each room from place FROM on, in an order that
#                                                   the seed fixes
#
# cargo-mutants (`cargo install cargo-mutants`) lists the mutants; weave.py puts all of them into one copy of the
# program, each asleep; run.py wakes one at a time and runs the tests that reach it. Rooms are defined in rooms.py.
# Results go to tests/mutants.csv (one line for each room) and target/mutants/<room>.jsonl (one for each mutant).
# Needs Python 3 with venv and PyPI for tree-sitter. BUDGET: seconds of processor that one mutant may cost.
set -euo pipefail
export PYTHONDONTWRITEBYTECODE=1
cd "$(dirname "$0")/.."
work=target/mutants
tree=$work/tree
mkdir -p "$tree"
[ -x $work/venv/bin/python ] || python3 -m venv $work/venv
$work/venv/bin/pip install --quiet tree-sitter==0.26.1 tree-sitter-rust==0.24.2
python=$work/venv/bin/python

# The tree has the files of the working tree, and its own target: a second run builds little.
git ls-files -z --cached --others --exclude-standard ':!src/*.rs' ':!crates/*/src/*.rs' | xargs -0 cp --parents -pt "$tree"
files=()
while read -r pattern; do files+=(-f "$pattern"); done < <($python tests/mutants/rooms.py)
cargo mutants --list --json "${files[@]}" > "$tree/list.json"
$python tests/mutants/weave.py "$tree/list.json" . "$tree"
$python tests/mutants/run.py "$tree"

if [ $# -eq 0 ]; then set -- conventions program identification actuator; fi
[ -f tests/mutants.csv ] || echo "date,room,seed,mutants,tried,caught,missed,timeout,not built" > tests/mutants.csv
for room in "$@"; do
    GEARWISE_BUDGET=${BUDGET:-25} $python tests/mutants/run.py "$tree" "$room" "${SEED:-1}" ${COUNT:+"${FROM:-0}" "$COUNT"} \
        > "$work/$room.jsonl" 2> "$work/$room.csv"
    grep -h '^20' "$work/$room.csv" >> tests/mutants.csv
    tail -n 1 tests/mutants.csv
    $python -c '
import json, sys
for line in open(sys.argv[1]):
    result = json.loads(line)
    if result["result"] == "missed":
        print("missed", result["name"], "-", result["by"])
' "$work/$room.jsonl"
done
