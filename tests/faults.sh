#!/usr/bin/env bash
# Faults that are large, slow, or need a file system of their own: one line each, what | how | result.
#
#   tests/faults.sh [GEARWISE]        the program (default: target/release/gearwise, else target/debug/gearwise)
#   KILLS=200 tests/faults.sh         more kills for each kind of output (default 40)
#   RECORD=tests/faults.csv tests/faults.sh   the lines as a CSV file too, for docs/reliability.md
#   ONLY='disk|kill' tests/faults.sh  some of them: disk, folder, kill, change, log, rows, joints, motion
#
# As root it mounts small file systems; otherwise those lines say that they were left out. Exit status 1 if a line is
# not `ok`. The whole takes some ten minutes, 2 GB of disk and 10 GB of memory.
set -u
cd "$(dirname "$0")/.."
ROOT=$PWD
G=${1:-}
if [ -z "$G" ]; then G=target/release/gearwise; [ -x "$G" ] || G=target/debug/gearwise; fi
G=$(realpath "$G") || exit 2
KILLS=${KILLS:-40}
ONLY=${ONLY:-.}
RECORD=${RECORD:+$(realpath "$RECORD")}
WORK=$(mktemp -d)
MOUNTED=()
bad=0
cleanup() {
  for m in "${MOUNTED[@]:-}"; do [ -n "$m" ] && umount "$m" 2>/dev/null; done
  rm -rf "$WORK"
}
trap cleanup EXIT
cd "$WORK" || exit 2

[ -z "$RECORD" ] || echo 'what,how,result' > "$RECORD"
record() { [ -z "$RECORD" ] || printf '"%s","%s","%s"\n' "${1//\"/\"\"}" "${2//\"/\"\"}" "${3//\"/\"\"}" >> "$RECORD"; }
line() { record "$@"; printf '%s | %s | %s\n' "$1" "$2" "$3"; case $3 in ok*|left\ out*) ;; *) bad=1 ;; esac; }
wanted() { [[ $1 =~ $ONLY ]]; }

# What every line needs: a robot, motors, a design, a bench, a database.
mkdir desk && cd desk || exit 2
cat > robot.toml <<'TOML'
name = "leg"
[bus]
voltage = "48 V"
drive_current = "40 A"
[[joint]]
name = "knee"
ratio = { min = 3, max = 30 }
gear = { efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2" }
points = [ { torque = "3 N*m", speed = "2 rad/s", duration = "1 s" } ]
objective = "loss"
TOML
head -1 "$ROOT/catalogs/motors/maxon.csv" > motors.csv
grep -h -e '^maxon-ec-i-40' -e '^t-motor' "$ROOT"/catalogs/motors/*.csv >> motors.csv
printf 'requirement = "robot.toml"\ncatalog = ["motors.csv"]\n[grid]\n"scale.torque" = { from = 0.5, to = 1.5, steps = 40 }\n' > study.toml
mkdir db
cat > db/a_motors.csv <<'CSV'
key,manufacturer,ID,type,V,k_t,R,L,mass,inertia,omega_nl,I_nl,I_nom,max_int_torque,max_int_speed,max_cont_speed,max_cont_power,coulomb_friction,viscous_friction,Rth1,Rth2
A_1,Acme,one,BLDC,24,0.05,0.5,0.0001,0.3,1e-5,470,0.2,4,inf,900,800,Inf,,,,
A_2,Other,two,BLDC,24,0.05,0.5,0.0001,0.3,1e-5,470,0.2,4,inf,900,800,Inf,,,,
CSV
echo 'key,manufacturer,ID,type,stages,ratio,mass,inertia,efficiency,direction,max_int_torque,max_cont_torque
G_1,Acme,g,planetary,1,5,0.1,1e-7,0.9,1,10,5' > db/a_gearboxes.csv
cat > arm.urdf <<'XML'
<robot name="arm"><link name="base"/><link name="tip"><inertial><mass value="2"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>
<limit effort="900" velocity="5" lower="-1" upper="1"/></joint></robot>
XML
printf '[[joint]]\nnames = ["elbow"]\nmodule = "robstride-rs04"\n' > hardware.toml
"$G" study study.toml --out part --shard 1/1 --quiet > /dev/null || { echo "the examples are not good"; exit 2; }
"$G" optimize robot.toml --catalog motors.csv --write-design design.toml > /dev/null || { echo "the examples are not good"; exit 2; }
cd ..
DESK=$WORK/desk
UR5E="$ROOT/requirements/robots/ur5e.urdf $ROOT/requirements/robots/ur5e_pick.csv"
BENCH=$ROOT/requirements/bench

# name: command, with OUT for the path that is written
declare -A OUTPUTS=(
  [svg]="rank motors.csv --plot OUT.svg"
  [png]="rank motors.csv --plot OUT.png"
  [html]="rank motors.csv --html OUT.html"
  [design]="optimize robot.toml --catalog motors.csv --write-design OUT.toml"
  [junit]="check design.toml --junit OUT.xml"
  [sarif]="check design.toml --sarif OUT.sarif"
  [export]="export design.toml --to mjcf --out OUT.xml"
  [torques]="torques $UR5E --out OUT"
  [import]="import mgdb db --out OUT --force"
  [man]="man --out OUT"
  [study]="study study.toml --out OUT --force"
  [row]="characterize $BENCH/motor_on_bench.toml --write OUT.csv"
  [fitted]="identify $BENCH/leg_actuator.toml --write OUT.toml"
  [plan]="identify $BENCH/leg_actuator.toml --plan OUT.csv"
  [fix]="check-model arm.urdf --against hardware.toml --fix --out OUT.urdf"
  [static]="explore robot.toml --catalog motors.csv --grid scale.torque=1,1.5 --static OUT.html"
  [merge]="merge OUT part --force"
)
NAMES=$(printf '%s\n' "${!OUTPUTS[@]}" | sort)
run() { (cd "$DESK" && eval "\"$G\" ${OUTPUTS[$1]//OUT/$2}"); }
# The files below a folder with their sums, without hidden ones and what a study keeps to go on.
sums() { (cd "$1" && find . -type f ! -name '.*' ! -path '*/journal/*' -exec sha256sum {} + | sort -k2); }

if wanted disk; then
  for name in $NAMES; do
    mkdir -p full
    if mount -t tmpfs -o size=64k,nr_inodes=64 none full 2> /dev/null; then
      MOUNTED+=("$WORK/full")
      # What was there before: the whole result of another run would be, so it must stay.
      result=ok; said=""
      for free in 0 8; do
        rm -rf full/* full/.[!.]* 2> /dev/null
        head -c $((65536 - free * 1024)) /dev/zero > full/ballast 2> /dev/null
        run "$name" "$WORK/full/x" > /dev/null 2> said; status=$?
        said=$(grep -m1 -o 'the disk is full' said)
        left=$(cd full && find . -type f ! -name ballast ! -name '.study.lock' ! -path '*/journal/*' | head -3)
        if [ $status -eq 2 ] && [ -n "$said" ]; then
          # Folders may have some of their files, each whole.
          [ -z "$left" ] || [ -d full/x ] || result="NOT: left $left"
        elif [ $status -gt 1 ]; then result="NOT: status $status, $(head -1 said)"
        elif [ $free -eq 0 ]; then result="NOT: status $status on a full disk"; fi
      done
      umount full; MOUNTED=()
      line "full disk: $name" "tmpfs of 64 KiB without room, and with 8 KiB" "$result"
    else
      line "full disk: $name" "tmpfs" "left out: not root"
    fi
  done
fi

if wanted folder; then
  for name in $NAMES; do
    rm -rf ro; mkdir ro; chmod 555 ro
    if [ "$(id -u)" = 0 ]; then
      if mount -t tmpfs none ro 2> /dev/null && mount -o remount,ro ro; then MOUNTED+=("$WORK/ro"); else
        umount ro 2> /dev/null; line "read-only: $name" "mount" "left out: cannot mount"; continue; fi
      how="read-only file system"
    else how="folder without permission"; fi
    run "$name" "$WORK/ro/x" > /dev/null 2> said; status=$?
    if [ $status -eq 2 ] && grep -q -e 'is read-only' -e 'permission denied' said; then result=ok
    else result="NOT: status $status, $(head -1 said)"; fi
    [ "$(id -u)" = 0 ] && umount ro && MOUNTED=()
    line "read-only: $name" "$how" "$result"
  done
fi

if wanted kill; then
  for name in $NAMES; do
    rm -rf kill; mkdir kill
    from=$(date +%s%N); run "$name" "$WORK/kill/x" > /dev/null 2>&1; to=$(date +%s%N)
    takes=$(((to - from) / 1000000))
    sums kill > whole
    whole=0; none=0; broken=""
    for k in $(seq "$KILLS"); do
      # Of two, one with the files of before and at a random moment, one as soon as anything appears in the folder.
      [ $((k % 2)) = 0 ] || rm -rf kill/* kill/.[!.]*
      command="${OUTPUTS[$name]//OUT/$WORK/kill/x}"
      (cd "$DESK" && exec "$G" $command > /dev/null 2>&1) &
      pid=$!
      if [ $((k % 2)) = 0 ]; then
        ms=$((takes / 5 + RANDOM % (takes + 1)))
        sleep "$(printf '%d.%03d' $((ms / 1000)) $((ms % 1000)))"
      else
        shopt -s nullglob dotglob
        while here=(kill/* kill/x/*); [ ${#here[@]} = 0 ] && kill -0 $pid 2> /dev/null; do :; done
        shopt -u nullglob dotglob
      fi
      kill -9 $pid 2> /dev/null; wait $pid 2> /dev/null
      sums kill > now
      if [ -s now ]; then
        grep -v -x -F -f whole now > other && broken="$broken $(awk '{print $2}' other | head -1)"
        if cmp -s whole now; then whole=$((whole + 1)); fi
      else none=$((none + 1)); fi
    done
    left=$(find kill -name '*.part' | wc -l)
    run "$name" "$WORK/kill/x" > /dev/null 2>&1; sums kill > now
    result="ok: $whole whole, $none nothing, $((KILLS - whole - none)) some files of several; $left hidden leftovers; then right"
    cmp -s whole now || result="NOT: the next run gave something else"
    [ -z "$broken" ] || result="NOT: half a file:$broken"
    line "kill -9: $name" "$KILLS kills, half of them when its first file appears, half at random in its $takes ms" "$result"
  done
fi

if wanted change; then
  # A catalogue of a thousand motors, all of them `a`, or all of them `b`; rewritten in place, truncated, or moved.
  for letter in a b; do
    { echo 'id,manufacturer,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],source,source_kind'
      for i in $(seq 1000); do echo "$letter$i,$letter,q_axis,q_axis,0.2,0.06,300,test,derived"; done; } > "$letter.csv"
  done
  cp a.csv c.csv
  ( while :; do
      for letter in a b; do
        cat "$letter.csv" > c.csv; dd if="$letter.csv" of=c.csv conv=notrunc bs=700 2> /dev/null
        cp "$letter.csv" c.new; mv c.new c.csv
      done
    done ) & writer=$!
  whole=0; cut=0; refused=0; mixed=0
  for i in $(seq 200); do
    if "$G" rank c.csv --json > out 2> said; then
      a=$(grep -c '"motor": "a' out); b=$(grep -c '"motor": "b' out)
      if [ "$a" -gt 0 ] && [ "$b" -gt 0 ]; then mixed=$((mixed + 1))
      elif [ $((a + b)) = 1000 ]; then whole=$((whole + 1)); else cut=$((cut + 1)); fi
    else refused=$((refused + 1)); fi
  done
  kill $writer; wait $writer 2> /dev/null
  result="ok: $whole whole, $refused refused, $cut cut off before they were opened"; [ $mixed = 0 ] || result="NOT: $mixed mixtures"
  line "file changes while it is read" "catalogue rewritten without end, 200 reads" "$result"
fi

# The largest inputs, with time and memory. A result that is not 0 or a clear limit is not ok.
measured() {
  local what=$1 how=$2; shift 2
  local begin end status peak="?"
  begin=$(date +%s)
  if [ -x /usr/bin/time ]; then /usr/bin/time -f 'peak %M' "$@" > out 2> said; status=$?
    peak=$(awk '/^peak/ {printf "%.1f GB", $2 / 1e6}' said)
  else "$@" > out 2> said; status=$?; fi
  end=$(date +%s)
  if [ $status -le 1 ]; then line "$what" "$how" "ok: $((end - begin)) s, $peak, $(wc -c < out) bytes of answer"
  elif [ $status -eq 2 ] && grep -q 'at most\|more than' said; then line "$what" "$how" "ok, refused: $(grep -m1 'at most\|more than' said)"
  else line "$what" "$how" "NOT: status $status, $(head -1 said)"; fi
}

if wanted rows; then
  { head -1 "$ROOT/catalogs/motors/maxon.csv" | cut -d, -f1-3,6,7,8,12,20 | sed 's/$/,mass [g],continuous_current [A],peak_current [A],source,source_kind/'
    awk 'BEGIN { for (i = 0; i < 1000000; i++) printf "m%07d,Maker %d,Model %d,line_to_line,phase_amplitude,%.4f,%.5f,%d,%d,%d,%d,made up,derived\n", i, i % 97, i % 1013, 0.1 + i % 977 * 0.001, 0.05 + i % 613 * 0.0003, 50 + i % 331, 300 + i % 401, 8 + i % 9, 20 + i % 23 }'
  } > rows.csv
  measured "10^6 rows" "rank of a catalogue of $(wc -c < rows.csv) bytes" "$G" rank rows.csv
  measured "10^6 rows" "optimize --only-top 5" "$G" optimize desk/robot.toml --catalog rows.csv --only-top 5
  rm rows.csv
fi

if wanted joints; then
  { sed '/\[\[joint/,$d' desk/robot.toml
    awk 'BEGIN { for (i = 0; i < 10000; i++) printf "[[joint]]\nname = \"j%d\"\nratio = { min = 3, max = 30 }\npoints = [ { torque = \"%.3f N*m\", speed = \"%d rad/s\", duration = \"0.5 s\" } ]\nobjective = \"loss\"\n", i, 1 + i * 1e-3, 1 + i % 7 }'
  } > joints.toml
  measured "10^4 joints" "optimize with $(($(wc -l < desk/motors.csv) - 1)) motors" "$G" optimize joints.toml --catalog desk/motors.csv
fi

if wanted motion; then
  { echo 'time [s],torque [N*m],velocity [rad/s]'
    awk 'BEGIN { n = 1000000; for (i = 0; i <= n; i++) { p = 6.283185307179586 * (i % n) / n; printf "%.6f,%.9f,%.9f\n", i * 1e-6, 3 * sin(p), 4 * cos(p) } }'
  } > motion.csv
  sed 's/^points.*/motion = "motion.csv"/' desk/robot.toml > motion.toml
  measured "10^6 samples" "optimize with $(($(wc -l < desk/motors.csv) - 1)) motors" "$G" optimize motion.toml --catalog desk/motors.csv
  rm motion.csv
fi

if wanted log; then
  { head -1 "$BENCH/leg_actuator_1.csv"
    awk -F, -v OFS=, 'NR > 1 { rows[NR - 1] = substr($0, index($0, ",") + 1) } END { while (size < 1e9) { for (k = 1; k < NR && size < 1e9; k++) { s = sprintf("%.4f,%s", n * 0.0025, rows[k]); n++; size += length(s) + 1; print s } } }' "$BENCH/leg_actuator_1.csv"
  } > log.csv
  sed -e 's/leg_actuator_1.csv/log.csv/' -e "s#\"leg_actuator_\([23]\)#\"$BENCH/leg_actuator_\1#" "$BENCH/leg_actuator.toml" > log.toml
  measured "1 GB log" "identify, $(($(wc -l < log.csv) - 1)) rows" "$G" identify log.toml
fi

exit $bad
