#!/usr/bin/env bash
# Robots per second and memory of `study`, release build. Prints one line for each case.
#   benches/study.sh [target/release/gearwise [memory]]
# 1 000 robots of 4 joints on the shipped catalogue with one thread and with two; then 2 000, 11 000 and 101 000
# robots of one short joint on five motors, for the memory.
set -euo pipefail
cd "$(dirname "$0")/.."
gearwise=$(realpath "${1:-target/release/gearwise}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
requirements=$PWD/requirements

# The quadruped with the knee once more as an ankle: four joints, all with motions or points of their own.
{
    sed "s#motions/#$requirements/motions/#" requirements/quadruped_mini_cheetah.toml
    cat <<'TOML'

[[joint]]
name = "ankle"
count = 4
ratio = { min = 3, max = 25 }
gear = { efficiency = 0.9, mass = "120 g", inertia = "1e-6 kg*m^2" }
TOML
    echo "motion = \"$requirements/motions/quadruped_trot_hip.csv\""
    cat <<'TOML'
[joint.limits]
actuator_mass = "0.6 kg"
winding_temperature = "100 degC"
safety = 1.1
TOML
} > "$work/four.toml"
cat > "$work/thousand.toml" <<'TOML'
requirement = "four.toml"
[grid]
"bus.voltage" = { from = "18 V", to = "48 V", steps = 5 }
"scale.torque" = { from = 0.5, to = 1.4, steps = 10 }
"scale.speed" = [0.8, 1, 1.2, 1.4]
"joint.*.gear.efficiency" = [0.8, 0.85, 0.88, 0.91, 0.95]
TOML

cat > "$work/short.toml" <<'TOML'
name = "short"
[bus]
voltage = "24 V"
[[joint]]
name = "knee"
ratio = { min = 3, max = 30 }
gear = { efficiency = 0.95, mass = "150 g" }
points = [{ torque = "4 N*m", speed = "0 rad/s", duration = "1 s" }, { torque = "1 N*m", speed = "6 rad/s", duration = "1 s" }]
TOML
{ head -1 catalogs/motors/t-motor.csv; sed -n 2,6p catalogs/motors/t-motor.csv; } > "$work/five.csv"
for robots in 1000 10000 100000; do
    cat > "$work/short$robots.toml" <<TOML
requirement = "short.toml"
catalog = ["five.csv"]
[grid]
"bus.voltage" = { from = "12 V", to = "48 V", steps = 10 }
"scale.torque" = { from = 0.5, to = 1.5, steps = 10 }
"joint.knee.gear.efficiency" = { from = 0.8, to = 0.98, steps = 10 }
"scale.speed" = { from = 0.9, to = 1.1, steps = $((robots / 1000 + 1)) }
TOML
done

measure() { # name, robots, arguments
    local name=$1 robots=$2
    shift 2
    /usr/bin/time -f "%e %U %M" -o "$work/time" "$gearwise" study "$@" --force > "$work/text"
    read -r seconds cpu kilobytes < "$work/time"
    awk -v n="$name" -v r="$robots" -v s="$seconds" -v c="$cpu" -v k="$kilobytes" \
        'BEGIN { printf "%-44s %7.1f s %8.1f robots/s %7.1f s CPU %6.0f MB\n", n, s, r / s, c, k / 1024 }'
}
[ "${2:-all}" = memory ] || for threads in 1 2; do
    measure "1000 robots x 4 joints x 125 motors, $threads thread" 1000 "$work/thousand.toml" --out "$work/out" --threads $threads
done
for robots in 1000 10000 100000; do
    # A range has two values at least.
    measure "$((robots + 1000)) robots x 1 joint x 5 motors" $((robots + 1000)) "$work/short$robots.toml" --out "$work/out"
done
