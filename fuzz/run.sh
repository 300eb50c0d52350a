#!/usr/bin/env bash
# Fuzzes every target, two at a time: fuzz/run.sh [SECONDS [TARGET…]], 600 seconds each by default. Prints a line for each
# and appends it to fuzz/results.csv. New inputs that reach new code go to `work`, below here; what breaks a promise goes
# to fuzz/artifacts/<target>. `fuzz/run.sh keep [TARGET…]` puts some of the least that reach the same code into fuzz/corpus.
# PARALLEL: how many at a time. BUILT: a folder with targets that are built already. KEEP: how many inputs are kept.
#
# Needs a nightly toolchain and cargo-fuzz (`cargo install cargo-fuzz`). Without a sanitizer: there is no `unsafe` in the
# program of its own, and a sanitizer costs time; overflow checks and debug assertions are on.
set -euo pipefail
cd "$(dirname "$0")"
fuzz=(cargo +nightly fuzz)
triple=$(rustc -vV | sed -n 's/^host: //p')
built="target/$triple/release"
# Inputs lie in memory where there is such a folder; one thread each, so that two targets share two cores.
[ -d /dev/shm ] && export TMPDIR=/dev/shm
export RAYON_NUM_THREADS=1

seconds=600
if [ $# -gt 0 ] && [ "$1" != keep ]; then seconds=$1; shift; fi
keep=
if [ "${1:-}" = keep ]; then keep=1; shift; fi
targets=("$@")
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(ls targets | sed 's/\.rs$//')

if [ -n "${BUILT:-}" ]; then built=$BUILT; else "${fuzz[@]}" build --sanitizer none 2>&1 | tail -n 1; fi

longest() { # how large inputs may get [bytes]
    case $1 in
        optimize) echo 400 ;;
        motion | log) echo 2048 ;;
        mcap | npz | parquet) echo 4096 ;;
        solve) echo 4096 ;;
        *) echo 8192 ;;
    esac
}

patience() { # after how long an input counts as a hang [s]: of a solver on a machine that has more to do, longer
    case $1 in
        optimize | solve) echo 120 ;;
        *) echo 5 ;;
    esac
}

run_one() {
    local target=$1 log="work/$1.log"
    mkdir -p "work/$target" "corpus/$target" "artifacts/$target" "work/seeds/$target"
    local dictionary=()
    [ -f "dictionaries/$target.dict" ] && dictionary=("-dict=dictionaries/$target.dict")
    # Bytes that are drawn from are best long from the beginning.
    [ "$target" = optimize ] && dictionary=(-len_control=0)
    local status=0
    # libFuzzer goes on after a slow input or one that takes much memory only where it is told so; a panic ends it.
    nice -n 5 "$built/$target" "work/$target" "corpus/$target" "work/seeds/$target" "${dictionary[@]}" \
        -artifact_prefix="artifacts/$target/" -max_total_time="$seconds" -timeout="$(patience "$target")" -rss_limit_mb=256 \
        -max_len="$(longest "$target")" -print_final_stats=1 > "$log" 2>&1 || status=$?
    report "$target" "$log" "$status"
}

stat_of() { # name, log
    sed -n "s/^stat::$1: *//p" "$2" | tail -n 1
}

report() { # target, log, exit status
    local target=$1 log=$2 executions peak took rate cover corpus findings=0
    executions=$(stat_of number_of_executed_units "$log")
    peak=$(stat_of peak_rss_mb "$log")
    took=$(sed -n 's/^Done [0-9]* runs in \([0-9]*\) second.*/\1/p' "$log" | tail -n 1)
    cover=$(grep -oE 'cov: [0-9]+' "$log" | tail -n 1 | tr -dc 0-9)
    corpus=$(grep -oE 'corp: [0-9]+' "$log" | tail -n 1 | tr -dc 0-9)
    [ "$3" = 0 ] || findings=1
    took=${took:-stopped}
    rate=$([ "$took" = stopped ] || [ "$took" = 0 ] && echo 0 || echo $((${executions:-0} / took)))
    printf '%-12s %7s s %10s runs %6s/s  corpus %5s  coverage %6s  peak %4s MB  findings %s\n' \
        "$target" "$took" "${executions:-?}" "$rate" "${corpus:-?}" "${cover:-?}" "${peak:-?}" "$findings"
    printf '%s,%s,%s,%s,%s,%s,%s,%s,%s\n' "$(date +%F)" "$target" "$took" "${executions:-}" "$rate" "${corpus:-}" "${cover:-}" \
        "${peak:-}" "$findings" >> results.csv
    if [ "$findings" != 0 ]; then
        grep -E 'panicked at|ERROR: libFuzzer|Test unit written' -A 1 "$log" | head -n 8 | sed 's/^/    /'
    fi
}

keep_one() { # a small set that reaches the same lines; of that, inputs of all sizes up to 4 kB, for the test run has to be quick
    local target=$1 least="work/least/$1" most=${KEEP:-40}
    mkdir -p "work/$target" "corpus/$target"
    rm -rf "$least"
    mkdir -p "$least"
    "$built/$target" -set_cover_merge=1 -use_counters=0 -max_len="$(longest "$target")" -timeout="$(patience "$target")" \
        -rss_limit_mb=256 "$least" "work/$target" "corpus/$target" "work/seeds/$target" > "work/$target.merge.log" 2>&1
    find "$least" -type f -size -4097c -printf '%s %p\n' | sort -n > "$least.list"
    rm -rf "corpus/$target"
    mkdir "corpus/$target"
    awk -v most="$most" '{ path[NR] = $2 } END { for (k = 0; k < most && k < NR; k++)
        print path[NR <= most ? k + 1 : int(k * (NR - 1) / (most - 1)) + 1] }' "$least.list" | xargs -I{} cp {} "corpus/$target/"
    echo "$target: $(find "$least" -type f | wc -l) inputs reach all, $(find "corpus/$target" -type f | wc -l) kept"
}

./seeds.sh work/seeds
if [ -n "$keep" ]; then
    for target in "${targets[@]}"; do keep_one "$target"; done
    exit
fi
[ -f results.csv ] || echo 'date,target,seconds,executions,executions_per_s,corpus,coverage,peak_mb,findings' > results.csv
running=0
for target in "${targets[@]}"; do
    run_one "$target" &
    running=$((running + 1))
    if [ "$running" -ge "${PARALLEL:-2}" ]; then wait -n; running=$((running - 1)); fi
done
wait
