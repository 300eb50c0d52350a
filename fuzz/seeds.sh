#!/usr/bin/env bash
# Lays the project's own files into a folder as what fuzzing begins with: fuzz/seeds.sh FOLDER. Long tables are cut short.
set -euo pipefail
to=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$(dirname "$0")/.."

put() { # target, name; the text on stdin
    mkdir -p "$to/$1"
    cat > "$to/$1/seed-$2"
}
rows() { # the first rows of a table, with its header
    { grep -v '^#' "$1" || true; } | head -n "$2"
}
closed() { # the first rows of a motion that then repeats its first
    rows "$1" 9
    rows "$1" 9 | awk -F, 'NR == 2 { $1 = ""; first = $0 } { before = last; last = $1 }
        END { OFS = ","; gsub(" +", ",", first); sub("^,+", "", first); print 2 * last - before "," first }'
}
named() { # text that follows is another file
    printf '\n== %s ==\n' "$1"
}
motions_of() { # the motions that a requirement names
    { grep -oE '"[^"]*\.csv"' "$1" || true; } | tr -d '"' | sort -u | while read -r file; do
        named "$(basename "$file")"
        closed "requirements/$file"
    done
}

for file in catalogs/motors/*.csv catalogs/gears/*.csv tests/fixtures/paper_motors.csv; do
    rows "$file" 4 | put catalogue "$(basename "$file")"
done
{ printf '== fitted.toml ==\n'; sed -n '/^id = "t-motor-ri50-fitted"/,/^"#;/p' tests/library/proof/effects_in_design.rs | sed '$d'; } | put catalogue fitted
{ rows catalogs/motors/t-motor.csv 3; named gears.csv; rows catalogs/gears/belt.csv 3; } | put catalogue both
for file in requirements/*.toml; do
    name=$(basename "$file" .toml)
    for target in requirement solve; do
        {
            grep -v '^#' "$file"
            motions_of "$file"
            if grep -q '^model = ' "$file"; then named ur5e.urdf; cat requirements/robots/ur5e.urdf; fi
        } | put "$target" "$name"
    done
done
for file in requirements/motions/*.csv; do
    closed "$file" | put motion "$(basename "$file")"
done
printf 'time [s],torque [N*m],position [deg]\n0,1,0\n0.1,2,30\n0.2,0,10\n0.3,-1,-5\n0.4,1,0\n' | put motion position
for design in requirements/designs/*; do
    { grep -v '^#' "$design/rules.toml"; named design.lock; grep -v '^#' "$design/design.lock"; } | put rules "$(basename "$design")"
done
for design in requirements/designs/*/design.toml; do
    name=$(basename "$(dirname "$design")")
    grep -v '^#' "$design" | put design "$name"
done
grep -v '^#' requirements/studies/quadruped.toml | put study quadruped
cat << 'END' | put study many
requirements = ["a.toml", "robots/*.toml"]
catalog = ["motors"]
[grid]
bus.voltage = { from = "24 V", to = "48 V", steps = 5 }
"joint.knee.gear.efficiency" = [0.8, 0.9]
joint."*".ratio.max = [10, 20]
"scale.speed" = { from = 0.5, to = 2, steps = 3 }
budget.actuator_mass = ["5 kg"]
END
for file in requirements/robots/ur5e.urdf tests/fixtures/robots/panda.urdf; do
    put urdf "$(basename "$file")" < "$file"
done
cat << 'END' | put urdf two
<robot name="two"><link name="base"/>
<link name="a"><inertial><origin xyz="0 0 0.1" rpy="0 1 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="q" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="3"/><dynamics damping="0.1" friction="0.2"/></joint>
<joint name="s" type="prismatic"><origin xyz="0 0 1"/><parent link="a"/><child link="b"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="9" velocity="3"/></joint>
</robot>
== motion.csv ==
time [s],q [rad],s [m],b.force_z [N]
0,0,0,1
0.1,0.1,0.01,1
0.2,0.2,0.05,2
0.3,0.1,0.02,1
0.4,0,0,1
END
put mjcf leg < tests/fixtures/robots/mini_cheetah_leg.xml
cat << 'END' | put mjcf arm
<mujoco model="arm"><compiler angle="radian" autolimits="true"/><option gravity="0 0 -9.81"/>
<default><joint damping="0.1"/><default class="small"><geom type="capsule" size="0.02"/></default></default>
<worldbody><body name="upper" pos="0 0 1" childclass="small"><joint name="q" axis="0 1 0" range="-1 1" armature="0.01"/>
<geom fromto="0 0 0 0 0 -0.3" mass="1"/><site name="tool" pos="0 0 -0.3"/>
<body name="lower" pos="0 0 -0.3" euler="0 0.1 0"><joint name="s" type="slide" axis="0 0 1" stiffness="3" springref="0.1"/>
<inertial pos="0 0 -0.1" mass="0.5" diaginertia="0.01 0.01 0.001"/></body></body></worldbody></mujoco>
== motion.csv ==
time [s],q [rad],s [m],tool.force_x [N]
0,0,0,1
0.1,0.1,0.01,1
0.2,0.2,0.05,2
0.3,0.1,0.02,1
0.4,0,0,1
END
for file in requirements/bench/*.toml tests/fixtures/benches/*.toml; do
    name=$(basename "$file" .toml)
    sed -E 's/file = "[^"]*"/file = "log.csv"/' "$file" | grep -v '^#' | put bench "$name"
done
cat << 'END' | put bench small
catalog = ["motors.csv"]
actuator = { motor = "outrunner", ratio = 6, gear = { efficiency = 0.9 }, effects = [{ coulomb_friction = { torque = "0.01 N*m" } }] }
kind = "dynamometer"
[columns]
time = { name = "t", unit = "s" }
current = { name = "i", unit = "A", convention = "phase_amplitude" }
velocity = { name = "w", unit = "rpm", side = "motor" }
torque = { name = "tau", unit = "mN*m", side = "output", sign = -1 }
[[log]]
file = "log.csv"
select = { column = "run", equals = "a" }
[[log]]
file = "log.csv"
use = "held_out"
select = [{ column = "run", equals = "b" }, { column = "temp", min = 20, max = 30 }]
END
for kind in a b c; do # the benches of the target `log`, by its first byte
    for run in 1 2 3; do
        { printf '%s' "$kind"; printf 't,i,w,q,tau,temp,run\n'
          for k in 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23; do
              echo "0.$((100 + k)),$((k % 7 - 3)).5,$((k * run)),0.$((k * k)),$((k % 5 - 2)).2,25.$k,$([ $((k % 2)) = 0 ] && echo a || echo b)"
          done; } | put log "$kind$run"
    done
    { printf '%s' "$kind"; rows requirements/bench/motor_on_bench_stall_1.csv 6 | sed '1s/.*/t,i,tau,temp/'; } | put log "$kind-stall"
done
cat << 'END' | put mgdb both
key,manufacturer,ID,type,V,k_t,R,L,mass,inertia,omega_nl,I_nl,I_nom,max_int_torque,max_int_speed,max_cont_speed,max_cont_power,coulomb_friction,viscous_friction,Rth1,Rth2
AC_B1,Acme,B1,BLDC,24,0.05,0.5,0.0001,0.3,1e-5,470,0.2,4,inf,900,800,Inf,NaN,NaN,0.5,6
AC_D1,Acme,D1,DC,24,0.05,0.5,0.0001,0.3,1e-5,470,0.2,4,inf,900,800,Inf,,,,
AC_B3,"Acme, Inc",B3,BLDC,24,0.05,0.5,,,,460,,,,,,,,,,
== a_gearboxes.csv ==
key,manufacturer,ID,type,stages,ratio,mass,inertia,efficiency,direction,max_int_torque,max_cont_torque
G1,Acme,1,planetary,2,9,0.1,1e-7,0.8,1,5,2
G2,Acme,2,planetary,1,4.5,0.1,1e-7,0.9,1,5,
== a_compatibility.csv ==
AC_B1,G1,G2
AC_D1,G2
END
for k in $(seq 60); do # bytes without a meaning, the same each time
    for part in a b c d; do echo "$k$part" | sha512sum | cut -c1-128; done | tr -d '\n' | base64 -d | put optimize "$k"
done
