#!/usr/bin/env python3
"""A study on a real Dask cluster, one of whose workers is killed in the middle, is the single run byte for byte.

    pip install distributed==2026.8.0        # see `.ci/external`
    python tests/external/dask_study.py [target/debug/gearwise]

The cluster is a scheduler and worker processes of their own. One worker is killed with SIGKILL, with the
gearwise it has started, while its shard is half done; another one comes in its place. Then the study is driven
again through the script's own command line.
"""

import argparse
import importlib.util
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time

from distributed import Client, LocalCluster

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILES = ["results.csv", "results.parquet", "errors.csv", "inputs.csv", "summary.json", "summary.svg", "manifest.json"]

STUDY = """requirement = "{base}"
catalog = ["{catalog}"]
[grid]
"bus.voltage" = ["18 V", "24 V", "36 V", "48 V"]
"scale.torque" = {{ from = 0.5, to = 1.5, steps = 6 }}
"scale.speed" = [1, 1.25]
"joint.*.gear.efficiency" = [0.85, 0.95]
"""


def contents(folder):
    return {name: (folder / name).read_bytes() for name in FILES}


def recorded(parts):
    return sum(block.read_bytes().count(b"\n") for block in parts.glob("shard-*/journal/block-*.jsonl"))


def descendants(pid):
    """The process and all that it has started."""
    found = [pid]
    for parent in found:
        for task in pathlib.Path(f"/proc/{parent}/task").glob("*/children"):
            found += [int(child) for child in task.read_text().split()]
    return found


def kill_one(client, parts, robots, log):
    """Waits until a part of the robots is finished, then kills a worker that is at work, with its children."""
    while recorded(parts) < robots // 5:
        time.sleep(0.01)
    busy = [address for address, tasks in client.processing().items() if tasks]
    assert busy, "no worker is at work any more: the study is too short for this machine"
    pid = client.run(os.getpid, workers=[busy[0]])[busy[0]]
    for process in descendants(pid):
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass
    log.append((busy[0], recorded(parts)))


def main():
    gearwise = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/debug/gearwise").resolve()
    driver = ROOT / "tools/gearwise_dask.py"
    spec = importlib.util.spec_from_file_location("gearwise_dask", driver)
    module = importlib.util.module_from_spec(spec)
    # Workers get the function by its name: they must find the module too.
    sys.path.insert(0, str(driver.parent))
    os.environ["PYTHONPATH"] = os.pathsep.join([str(driver.parent), os.environ.get("PYTHONPATH", "")])
    sys.modules["gearwise_dask"] = module
    spec.loader.exec_module(module)

    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        study = folder / "study.toml"
        base = ROOT / "requirements/quadruped_mini_cheetah.toml"
        study.write_text(STUDY.format(base=base, catalog=ROOT / "catalogs/motors/t-motor.csv"))
        robots = 4 * 6 * 2 * 2
        subprocess.run([gearwise, "study", study, "--out", folder / "single"], check=True, stdout=subprocess.DEVNULL)
        single = contents(folder / "single")

        with LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
            with Client(cluster) as client:
                before = set(client.run(os.getpid).values())
                assert len(before) == 3 and os.getpid() not in before, "workers are processes of their own"
                log = []
                killer = threading.Thread(
                    target=kill_one, args=(client, folder / "dask.shards", robots, log), daemon=True
                )
                killer.start()
                arguments = argparse.Namespace(
                    out=folder / "dask", shards=6, threads=1, retries=10, gearwise=str(gearwise), study=[str(study)]
                )
                status = module.drive(client, arguments)
                killer.join(timeout=60)
                assert status == 0, status
                assert log, "no worker was killed"
                assert 0 < log[0][1] < robots, log
        assert contents(folder / "dask") == single, "the results differ from the single run"
        print(f"killed {log[0][0]} after {log[0][1]} of {robots} robots: the results are those of the single run")

        command = [sys.executable, driver, "--out", folder / "again", "--shards", "5", "--workers", "2"]
        command += ["--gearwise", gearwise, "--", study]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        assert contents(folder / "again") == single, "the command line's results differ from the single run"
        wrong = subprocess.run([*command[:-1], folder / "none.toml"], capture_output=True, text=True)
        assert wrong.returncode == 2 and "there is no file or folder" in wrong.stderr, wrong
        print("the driver's command line does the same, and hands on mistakes")


if __name__ == "__main__":
    main()
