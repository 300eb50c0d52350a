"""Wakes one mutant after the other and runs the tests that reach it, quick ones first, until one fails.

    run.py TREE                    builds the tests of the woven tree, notes which test reaches which mutant and how
                                   long it takes (TREE/tests.json)
    run.py TREE ROOM [SEED [FROM COUNT]]
                                   tries mutants of a room in an order fixed by the seed: all, or some of that order;
                                   one line of JSON for each on stdout, a line of CSV at the end on stderr
"""

import datetime
import hashlib
import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Tests as a user would see the crate, next to those inside of it: modules of two of the programs in tests/.
PROGRAMS = ["library", "program"]
SUITES = {"worked_examples", "properties", "optimality", "second_formulation", "effects_in_design", "extremes", "cords",
          "spring", "robust", "identification", "brute_force", "plots", "model_on_paper", "identification_numbers",
          "program_on_paper", "robot_enumeration"}
# Pictures against pictures of before: they would notice any change, and say of none what is right.
LEFT_OUT = ["every_command_draws_its_picture", "the_committed_pictures_are_what_the_program_draws"]
# What a mutant may cost all in all [s of processor], and what a test may take longer than without a mutant.
BUDGET = float(os.environ.get("GEARWISE_BUDGET", "25"))
PATIENCE, GRACE = 4.0, 3.0


def key(test):
    return f"{test['binary']} {test['name']}"


def execute(test, tree, seconds, **variables):
    """Exit status and processor time [s] of one test."""
    def limits():
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 2))
        resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    environment = {**os.environ, "INSTA_UPDATE": "no", "RUST_BACKTRACE": "0", "RAYON_NUM_THREADS": "1",
                   "GEARWISE_CASES": "0.1", "CARGO_MANIFEST_DIR": str(tree), **variables}
    process = subprocess.Popen([test["path"], "--exact", test["name"]], cwd=tree, env=environment,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=limits)
    # Processor time is what counts; the clock only ends what waits for nothing.
    clock = threading.Timer(60 + 40 * seconds, process.kill)
    clock.start()
    _, status, usage = os.wait4(process.pid, 0)
    clock.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_utime + usage.ru_stime


def is_asked(binary, name):
    """Whether a test is among those that are run: all that are inside of the crate, and those of SUITES."""
    *modules, test = name.split("::")
    return test not in LEFT_OUT and (binary not in PROGRAMS or not SUITES.isdisjoint(modules))


def build(tree, programs):
    """The test programs of the woven tree: name and path."""
    arguments = ["cargo", "test", "--no-run", "--message-format=json", "--lib"]
    for program in programs:
        arguments += ["--test", program]
    run = subprocess.run(arguments, cwd=tree, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(run.stderr[-4000:])
    messages = [json.loads(line) for line in run.stdout.splitlines()]
    return [(m["target"]["name"], m["executable"]) for m in messages if m.get("executable") and m["profile"]["test"]]


def record(tree, programs):
    """Notes of each test which mutants it reaches and how long it takes; other programs' notes stay."""
    file = Path(tree, "tests.json")
    kept = [t for t in json.loads(file.read_text()) if t["binary"] not in dict(programs)] if file.exists() else []
    for binary, path in programs:
        listed = subprocess.run([path, "--list", "--format", "terse"], cwd=tree, capture_output=True, text=True)
        names = [line[:-6] for line in listed.stdout.splitlines() if line.endswith(": test")]
        for name in (n for n in names if is_asked(binary, n)):
            test = {"binary": binary, "path": path, "name": name}
            with tempfile.TemporaryDirectory() as folder:
                reached = Path(folder, "reached")
                status, _ = execute(test, tree, 600, GEARWISE_REACHED=str(reached))
                test["reaches"] = sorted({int(n) for n in reached.read_text().split()}) if reached.exists() else []
            if status != 0:
                print(f"fails without a mutant and is left out: {key(test)}", flush=True)
            elif test["reaches"]:
                # Noting takes its time: how long the test takes is another run.
                _, test["seconds"] = execute(test, tree, 600)
                kept.append(test)
                print(f"{test['seconds']:7.2f} s {len(test['reaches']):5d} {key(test)}", flush=True)
        file.write_text(json.dumps(kept))


def order(mutants, numbers, seed):
    """In an order that depends on the seed and on what the mutant is, but not on the line it is in."""
    seen, keys = Counter(), {}
    for n in numbers:
        m = mutants[n]
        name = (m["file"], m["function"]["function_name"] if m.get("function") else "", m["genre"], m["name"].split(": ", 1)[1])
        seen[name] += 1
        keys[n] = hashlib.sha256(f"{seed} {name} {seen[name]}".encode()).hexdigest()
    return sorted(numbers, key=keys.get)


def attempt(number, first, tests, tree, helpful):
    """What became of a mutant, by which test, after how many seconds."""
    every = [t for t in tests if first in t["reaching"]]
    if not every:
        return "missed", "no test reaches it", 0.0
    reach = [t for t in every if t["seconds"] <= BUDGET]
    spent = 0.0
    # Quick ones first, and of those the ones that are about little: then those that helped nearby.
    worth = {key(t): (t["seconds"] + 0.02) * len(t["reaches"]) ** 0.5 / (1 + 3 * helpful[key(t)]) for t in reach}
    for test in sorted(reach, key=lambda t: worth[key(t)]):
        allowed = PATIENCE * test["seconds"] + GRACE
        if spent and spent + test["seconds"] > BUDGET:
            continue
        status, seconds = execute(test, tree, allowed, GEARWISE_MUTANT=str(number))
        spent += seconds
        if status != 0:
            helpful[key(test)] += 1
            return ("timeout" if status in (-24, -9) else "caught"), key(test), spent
    return "missed", f"{len(every)} tests reach it", spent


def rooms(mutants):
    import rooms as definition
    return definition.rooms(mutants)


def main():
    tree = Path(sys.argv[1]).resolve()
    if len(sys.argv) == 2:
        return record(tree, build(tree, PROGRAMS))
    if sys.argv[2] == "--programs":
        return record(tree, [p.split("=", 1) for p in sys.argv[3:]])
    room, seed = sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else "1"
    mutants = json.load(open(tree / "list.json"))
    woven = json.load(open(tree / "woven.json"))
    inside = set(woven["woven"])
    numbers = order(mutants, rooms(mutants)[room], seed)
    total = len(numbers)
    if len(sys.argv) > 5:
        numbers = numbers[int(sys.argv[4]):int(sys.argv[4]) + int(sys.argv[5])]
    if "GEARWISE_ONLY" in os.environ:
        # Again: those of a list of numbers.
        numbers = [n for n in numbers if n in set(json.loads(os.environ["GEARWISE_ONLY"]))]
    tests = json.load(open(os.environ.get("GEARWISE_TESTS", tree / "tests.json")))
    for test in tests:
        test["reaching"] = set(test["reaches"])
    helpful, count, start = {}, Counter(), time.time()
    lock = threading.Lock()

    def one(number):
        mutant = mutants[number]
        place = json.dumps(mutant["span"]), mutant["file"], mutant["genre"]
        first = number
        while mutant["genre"] == "BinaryOperator" and first and \
                (json.dumps(mutants[first - 1]["span"]), mutants[first - 1]["file"], mutants[first - 1]["genre"]) == place:
            first -= 1
        known = helpful.setdefault((mutant["file"], (mutant.get("function") or {}).get("function_name")), Counter())
        if number not in inside:
            result = "not built", woven["unfit"].get(str(number), ""), 0.0
        else:
            result = attempt(number, first, tests, tree, known)
        with lock:
            count[result[0]] += 1
            print(json.dumps({"room": room, "number": number, "name": mutant["name"], "result": result[0], "by": result[1],
                              "seconds": round(result[2], 2)}), flush=True)

    with ThreadPoolExecutor(int(os.environ.get("GEARWISE_JOBS", os.cpu_count()))) as pool:
        list(pool.map(one, numbers))
    print(",".join(map(str, [datetime.date.today(), room, seed, total, sum(count.values()), count["caught"], count["missed"],
                             count["timeout"], count["not built"]])), file=sys.stderr)
    print(f"{time.time() - start:.0f} s", file=sys.stderr)


main()
