#!/usr/bin/env python3
"""Do two programs give the same answers?

    tests/same_answers.py take PROGRAM FOLDER [JOBS]    every command over all that is shipped, into FOLDER
    tests/same_answers.py compare BEFORE AFTER          what differs; exit status 1 where anything does
        --kinds json,csv,txt    which outputs (default: json)
        --renamed OLD=NEW       a key of JSON that has another name now; may be repeated
        --added KEY             a key of JSON that is new; may be repeated

Used where code moves and no number may: the bytes are compared, and for JSON the first places that differ are told.
"""

import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parents[1]
REQUIREMENTS = sorted(p.relative_to(HERE) for p in (HERE / "requirements").glob("*.toml"))
DESIGNS = sorted(p.relative_to(HERE) for p in (HERE / "requirements/designs").glob("*/design.toml"))
BENCHES = sorted(
    p.relative_to(HERE)
    for folder in ("requirements/bench", "tests/fixtures/benches")
    for p in (HERE / folder).glob("*.toml")
)




def commands():
    """Name -> arguments; every output of each is taken."""
    every = {}
    for requirement in REQUIREMENTS:
        name, path = requirement.stem, str(requirement)
        every[f"optimize-{name}"] = ["optimize", path, "--top", "500", "--rejected"]
        every[f"only-top-{name}"] = ["optimize", path, "--only-top", "2"]
        every[f"checked-{name}"] = ["optimize", path, "--only-checked"]
        every[f"robust-{name}"] = ["optimize", path, "--robust"]
        every[f"pareto-{name}"] = ["optimize", path, "--pareto", "loss,mass", "--points", "5"]
        every[f"sweep-{name}"] = ["sweep", path, "--ratios", "12"]
        text = (HERE / requirement).read_text()
        joints = [line.split('"')[1] for line in text.splitlines() if line.startswith("name") and '"' in line][1:]
        for joint in joints:
            for motor in ("t-motor-ri50", "maxon-ec-90-flat-323772", "tq-robodrive-ilm70x10"):
                every[f"explain-{name}-{joint}-{motor}"] = ["explain", motor, path, "--joint", joint]
    for name in ("quadruped_mini_cheetah", "leg_prosthesis_walking"):
        every[f"robot-{name}"] = ["optimize", f"requirements/{name}.toml", "--robot"]
    for design in DESIGNS:
        every[f"check-{design.parent.name}"] = ["check", str(design)]
        every[f"export-json-{design.parent.name}"] = ["export", str(design), "--to", "json"]
        every[f"export-mjcf-{design.parent.name}"] = ["export", str(design), "--to", "mjcf"]
        every[f"export-urdf-{design.parent.name}"] = ["export", str(design), "--to", "urdf"]
    for bench in BENCHES:
        every[f"identify-{bench.stem}"] = ["identify", str(bench)]
        every[f"characterize-{bench.stem}"] = ["characterize", str(bench)]
    every["identify-remade"] = [
        "identify", "requirements/bench/leg_actuator.toml", "--requirement", "requirements/quadruped_mini_cheetah.toml",
    ]
    every["rank"] = ["rank", "--top", "500"]
    every["rank-s_t"] = ["rank", "--sort", "s_t", "--mass-weight", "--tolerance", "5%"]
    every["compare"] = ["compare", "t-motor-ri50", "maxon-ec-90-flat-323772"]
    every["audit"] = ["audit"]
    every["torques"] = ["torques", "requirements/robots/ur5e.urdf", "requirements/robots/ur5e_pick.csv"]
    return every


KINDS = {"json": ["--json"], "csv": ["--csv"], "txt": []}


def take(program, folder, jobs):
    program, folder = pathlib.Path(program).resolve(), pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)

    def one(name, arguments, kind):
        options = KINDS[kind]
        if arguments[0] == "export" and options:
            return
        done = subprocess.run(
            [program, *arguments, *options], cwd=HERE, capture_output=True, env={"COLUMNS": "100", "PATH": "/usr/bin:/bin"}
        )
        if done.returncode == 2 and b"unexpected argument" in done.stderr:
            return
        (folder / f"{name}.{kind}").write_bytes(done.stdout + b"\n--- stderr, status %d\n" % done.returncode + done.stderr)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = [pool.submit(one, n, a, k) for n, a in commands().items() for k in KINDS]
        runs.append(pool.submit(study, program, folder))
        for run in runs:
            run.result()
    print(len(list(folder.iterdir())), "outputs")


def study(program, folder):
    import tempfile

    with tempfile.TemporaryDirectory() as out:
        subprocess.run(
            [program, "study", "requirements/studies/quadruped.toml", "--out", out, "--json"],
            cwd=HERE, check=False, capture_output=True,
        )
        for file in sorted(pathlib.Path(out).glob("*.csv")) + sorted(pathlib.Path(out).glob("summary*")):
            (folder / f"study-{file.stem}.{file.suffix[1:]}").write_bytes(file.read_bytes())


def renamed(value, names, added):
    if isinstance(value, dict):
        return {names.get(k, k): renamed(v, names, added) for k, v in value.items() if k not in added}
    if isinstance(value, list):
        return [renamed(v, names, added) for v in value]
    return value


def differences(a, b, where=""):
    if isinstance(a, dict) and isinstance(b, dict):
        if list(a) != list(b):
            missing, new = [k for k in a if k not in b], [k for k in b if k not in a]
            if missing or new:
                yield f"{where}: gone {missing}, new {new}"
            else:
                yield f"{where}: keys in another order"
        for key in a:
            if key in b:
                yield from differences(a[key], b[key], f"{where}.{key}")
    elif isinstance(a, list) and isinstance(b, list):
        if len(a) != len(b):
            yield f"{where}: {len(a)} entries, now {len(b)}"
        for k, (x, y) in enumerate(zip(a, b)):
            yield from differences(x, y, f"{where}[{k}]")
    elif a != b or type(a) is not type(b):
        yield f"{where}: {a!r} → {b!r}"


def compare(before, after, kinds, names, added):
    before, after = pathlib.Path(before), pathlib.Path(after)
    files = sorted({f.name for d in (before, after) for f in d.iterdir() if f.suffix[1:] in kinds})
    bad = 0
    for name in files:
        a, b = before / name, after / name
        if not (a.exists() and b.exists()):
            bad += 1
            print(f"{name}: only {'before' if a.exists() else 'after'}")
            continue
        x, y = a.read_bytes(), b.read_bytes()
        if x == y:
            continue
        lines = [f"{name}: bytes differ"]
        if name.endswith(".json"):
            try:
                (p, q), (r, s) = (t.decode().split("\n--- stderr", 1) for t in (x, y))
                p, r = (renamed(json.loads(p), names, added), renamed(json.loads(r), {}, added)) if p and r else (p, r)
                lines = [f"{name}{d}" for d in differences(p, r)] + ([f"{name}: stderr or status"] if q != s else [])
            except ValueError:
                pass
        bad += bool(lines)
        print("\n".join(lines[:6]))
    print(f"{len(files)} outputs compared, {bad} differ")
    return bool(bad) or not files


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["take", "compare"])
    parser.add_argument("one")
    parser.add_argument("two")
    parser.add_argument("jobs", nargs="?", type=int, default=2)
    parser.add_argument("--kinds", default="json")
    parser.add_argument("--renamed", action="append", default=[])
    parser.add_argument("--added", action="append", default=[])
    given = parser.parse_args()
    if given.what == "take":
        take(given.one, given.two, given.jobs)
        return 0
    names = dict(pair.split("=", 1) for pair in given.renamed)
    return compare(given.one, given.two, given.kinds.split(","), names, set(given.added))


if __name__ == "__main__":
    sys.exit(main())
