#!/usr/bin/env bash
# Instructions executed by the sweep kernel, the ratio program and the identification, counted by callgrind: the same
# on a busy machine as on a quiet one. Fails where one needs 5 % more than benches/instructions.csv says.
#   benches/instructions.sh [--update]
# Counts of another compiler or processor are not comparable: there, `--update` on the older commit comes first.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "valgrind is needed" >&2; exit 2; }
baseline=benches/instructions.csv
compiler=$(rustc --version)
processor=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
program=$(cargo bench --locked --bench instructions --no-run --message-format=json 2>/dev/null |
    python3 -c 'import json,sys
for line in sys.stdin:
    m = json.loads(line)
    if m.get("executable") and m["target"]["name"] == "instructions": print(m["executable"])')

count() { # CASE TIMES -> instructions
    RAYON_NUM_THREADS=1 valgrind --tool=callgrind --callgrind-out-file=/dev/null "$program" "$1" "$2" 2>&1 >/dev/null |
        sed -n 's/.*Collected : //p'
}

if [ "${1:-}" != --update ]; then
    stored=$(sed -n 's/^# compiler: //p' "$baseline")
    if [ "$stored" != "$compiler" ]; then
        echo "the stored counts are of $stored, this is $compiler: nothing to compare" >&2
        exit 2
    fi
fi

worse=0
counts=$(mktemp)
trap 'rm -f "$counts"' EXIT
printf '# compiler: %s\n# processor: %s\ncase,instructions\n' "$compiler" "$processor" > "$counts"
while read -r case times; do
    prepared=$(count "$case" 0)
    whole=$(count "$case" "$times")
    work=$(((whole - prepared) / times))
    echo "$case,$work" >> "$counts"
    before=$(sed -n "s/^$case,//p" "$baseline" 2>/dev/null || true)
    if [ -z "$before" ]; then
        printf '%-32s %14d  new\n' "$case" "$work"
        [ "${1:-}" = --update ] || worse=1
        continue
    fi
    printf '%-32s %14d  %+.2f %%\n' "$case" "$work" "$(awk "BEGIN { print 100 * ($work / $before - 1) }")"
    if [ $((work * 100)) -gt $((before * 105)) ]; then
        worse=1
        echo "  more than 5 % above $before"
    fi
done < <("$program")
if [ "${1:-}" = --update ]; then
    mv "$counts" "$baseline"
    trap - EXIT
elif [ "$worse" = 1 ]; then
    exit 1
fi
