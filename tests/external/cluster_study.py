#!/usr/bin/env python3
"""A study on every executor of tools/gearwise_cluster.py, with a worker killed, is the single run byte for byte.

    pip install -r tests/external/requirements.txt        # see `.ci/external`
    python tests/external/cluster_study.py [target/debug/gearwise]

The clusters are real ones of this machine. While its shard is half done a worker is killed with SIGKILL, with the
gearwise that it has started. Slurm (Debian: slurm-wlm, munge) is one node that this script starts and stops. Where
it cannot be started a stand-in for `sbatch` takes its place, and the script says so; Ray is left out where its
package is missing.
"""

import contextlib
import importlib.util
import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
DRIVER = ROOT / "tools/gearwise_cluster.py"
FILES = ["results.csv", "results.parquet", "errors.csv", "inputs.csv", "summary.json", "summary.svg", "manifest.json"]
SHARDS = 6

STUDY = """requirement = "{base}"
catalog = ["{catalog}"]
[grid]
"bus.voltage" = ["18 V", "24 V", "36 V", "48 V"]
"scale.torque" = {{ from = 0.5, to = 1.5, steps = {steps} }}
"scale.speed" = [1, 1.25]
"joint.*.gear.efficiency" = [0.85, 0.95]
"""

SLURM = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus}
PartitionName=all Nodes=ALL Default=YES
"""

# What `sbatch --parsable --wait --array` does: the script once for each task, two at a time. A task that was killed is
# queued again once if STAND_IN_REQUEUES is set, as after the loss of a node; otherwise it has failed.
STAND_IN = """#!/usr/bin/env python3
import concurrent.futures, os, pathlib, subprocess, sys
options = dict(word.partition("=")[::2] for word in sys.argv[1:-1])
assert {"--parsable", "--wait", "--requeue"} <= set(options), sys.argv
print("1;stand-in", flush=True)
with open(os.environ["STAND_IN_SUBMITTED"], "a") as submitted:
    print(options["--array"], file=submitted)
tasks = []
for part in options["--array"].split(","):
    first, _, last = part.partition("-")
    tasks += range(int(first), int(last or first) + 1)
def run(task):
    for left in (1, 0):
        with open(f"shard-{task:04}.log", "w") as log:
            environment = {**os.environ, "SLURM_ARRAY_TASK_ID": str(task)}
            status = subprocess.run(["sh", sys.argv[-1]], env=environment, stdout=log, stderr=log).returncode
        if status >= 0 or not os.environ.get("STAND_IN_REQUEUES"):
            return status
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    sys.exit(any(list(pool.map(run, tasks))))
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
            with contextlib.suppress(OSError):
                found += [int(child) for child in task.read_text().split()]
    return found


def at_work(parts):
    """Each gearwise that works on a shard: its process, that one's parent, and the shard."""
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            words = [os.fsdecode(word) for word in (entry / "cmdline").read_bytes().split(b"\0")]
            shards = [word for word in words if word.startswith(f"{parts}/shard-")]
            if words[1:2] == ["study"] and shards:
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                yield int(entry.name), parent, pathlib.Path(shards[0])


def signal_all(processes, what):
    for process in processes:
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, what)


def kill_one(driver, parts, robots):
    """Waits until a part of the robots is finished, then kills a worker whose shard is not, with all it has started."""
    while driver.poll() is None:
        time.sleep(0.01)
        if recorded(parts) < robots // 5:
            continue
        for pid, parent, shard in at_work(parts):
            # Here the gearwise itself is the worker if nothing stands between it and the driver.
            lost = descendants(pid if parent == driver.pid else parent)
            assert driver.pid not in lost
            signal_all(lost, signal.SIGSTOP)
            if pid in lost and not (shard / "results.csv").exists():
                signal_all(lost, signal.SIGKILL)
                return shard, len(lost), recorded(parts)
            signal_all(lost, signal.SIGCONT)
    raise AssertionError("no worker was killed: the study is too short for this machine")


def command(executor, out, gearwise, study, *more):
    line = [sys.executable, DRIVER, "--executor", executor, "--out", out, "--shards", str(SHARDS), *more]
    return [*line, "--gearwise", gearwise, "--", study]


def compare(executor, folder, gearwise, study, robots, environment=None, what=""):
    """The study with a lost worker, then a mistake, which is handed on."""
    out, began = folder / f"{executor}{what}", time.monotonic()
    more = [] if executor == "slurm" else ["--workers", "2"]
    line = command(executor, out, gearwise, study, *more)
    driver = subprocess.Popen(line, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    shard, lost, done = kill_one(driver, folder / f"{out.name}.shards", robots)
    _, said = driver.communicate(timeout=600)
    assert driver.returncode == 0, said
    assert f"{SHARDS} of {SHARDS} shards" in said and done < robots, said
    assert contents(out) == contents(folder / "single"), f"{executor}: the results differ from the single run"
    took = time.monotonic() - began
    killed = f"{lost} processes of {shard.name} killed after {done} of {robots} robots"
    print(f"{executor}{what}: {killed}; byte for byte the single run, {took:.1f} s")
    wrong = subprocess.run([*line[:-1], folder / "none.toml"], env=environment, capture_output=True, text=True)
    assert wrong.returncode == 2 and "there is no file or folder" in wrong.stderr, wrong
    return shard


def with_address(executor, address, folder, gearwise, study):
    """The same cluster, but begun by somebody else."""
    out = folder / f"{executor}-address"
    subprocess.run(command(executor, out, gearwise, study, "--address", address), check=True, capture_output=True)
    assert contents(out) == contents(folder / "single"), f"{executor}: the results differ from the single run"
    print(f"{executor}: the same at {address}")


@contextlib.contextmanager
def one_node_slurm(folder):
    """Slurm on this machine, as an environment for its commands; None where it cannot be."""
    search = os.pathsep.join([os.environ["PATH"], "/usr/sbin", "/sbin"])
    munged, slurmctld, slurmd = (shutil.which(name, path=search) for name in ("munged", "slurmctld", "slurmd"))
    if not (munged and slurmctld and slurmd and shutil.which("sbatch")):
        yield None
        return
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    (folder / "key").write_bytes(os.urandom(128))
    (folder / "key").chmod(0o400)
    with socket.socket() as one, socket.socket() as other:
        one.bind(("127.0.0.1", 0))
        other.bind(("127.0.0.1", 0))
        ports = one.getsockname()[1], other.getsockname()[1]
    host, user = socket.gethostname().split(".")[0], pwd.getpwuid(os.getuid()).pw_name
    conf = SLURM.format(folder=folder, host=host, user=user, cpus=os.cpu_count(), ports=ports)
    (folder / "slurm.conf").write_text(conf)
    environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
    files = {"key-file": "key", "socket": "munge.socket", "pid-file": "pid", "log-file": "log", "seed-file": "seed"}
    munge = [f"--{option}={folder}/{name}" for option, name in files.items()]
    daemons = []
    try:
        for line in ([munged, "--foreground", "--force", *munge], [slurmctld, "-D", "-c"], [slurmd, "-D"]):
            quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            daemons.append(subprocess.Popen(line, env=environment, **quiet))
            time.sleep(1)
        for _ in range(60):
            states = subprocess.run(["sinfo", "-h", "-o", "%t"], env=environment, capture_output=True, text=True)
            if "idle" in states.stdout:
                break
            time.sleep(0.5)
        else:
            environment = None
        yield environment
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
            daemon.wait(timeout=30)


def slurm(folder, gearwise, study, robots):
    with one_node_slurm(folder / "slurm-node") as environment:
        if environment:
            version = subprocess.run(["sbatch", "--version"], env=environment, capture_output=True, text=True).stdout
            print(f"slurm: a real node, {version.strip()}")
            compare("slurm", folder, gearwise, study, robots, environment)
            return
    print("slurm: NOT the real one, which could not be started here; a stand-in for `sbatch` takes its place")
    stand_in = folder / "bin/sbatch"
    stand_in.parent.mkdir()
    stand_in.write_text(STAND_IN)
    stand_in.chmod(0o755)
    for requeues in ("", "1"):
        submitted = folder / f"submitted{requeues}"
        environment = {**os.environ, "PATH": f"{stand_in.parent}{os.pathsep}{os.environ['PATH']}"}
        environment |= {"STAND_IN_REQUEUES": requeues, "STAND_IN_SUBMITTED": str(submitted)}
        what = " stand-in, queued again by it" if requeues else " stand-in, submitted again"
        shard = compare("slurm", folder, gearwise, study, robots, environment, what)
        # The last line is that of the mistake.
        again = [] if requeues else [str(int(shard.name.removeprefix("shard-")))]
        assert submitted.read_text().split()[:-1] == [f"1-{SHARDS}", *again], submitted.read_text()


def refusals(folder, gearwise, study):
    """Mistakes of the command line are told, not shown as a traceback."""

    def refused(line, why, **more):
        told = subprocess.run(line, capture_output=True, text=True, **more)
        assert told.returncode == 2 and why in told.stderr and "Traceback" not in told.stderr, told

    out = folder / "refused"
    refused(command("local", out, gearwise, study, "--shards", "0"), "--shards, --threads and --workers are 1 or more")
    refused(command("local", out, folder / "none", study), "was not found: pip install gearwise, or say where the program is with --gearwise")
    nothing = {**os.environ, "PATH": str(folder)}
    refused(command("slurm", out, gearwise, study), "needs `sbatch`, which was not found", env=nothing)
    for executor, package in (("dask", "distributed"), ("ray", "ray")):
        line = command(executor, out, gearwise, study)
        # -S: without installed packages.
        refused([line[0], "-S", *line[1:]], f"pip install {package}")
    print("mistakes of the command line are told")


def main():
    gearwise = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/debug/gearwise").resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        study = folder / "study.toml"
        base, catalog = ROOT / "requirements/quadruped_mini_cheetah.toml", ROOT / "catalogs/motors/t-motor.csv"
        steps, took = 6, 0
        # Long enough that a worker can be killed in the middle, however fast this machine is.
        while took < 4:
            study.write_text(STUDY.format(base=base, catalog=catalog, steps=steps))
            began, robots = time.monotonic(), 4 * steps * 2 * 2
            single = [gearwise, "study", study, "--out", folder / "single", "--threads", "1", "--force"]
            subprocess.run(single, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            took = time.monotonic() - began
            steps = int(steps * max(1.2, 5 / took))
        print(f"the single run: {robots} robots, {took:.1f} s on one thread")

        refusals(folder, gearwise, study)
        compare("local", folder, gearwise, study, robots)
        compare("dask", folder, gearwise, study, robots)
        from distributed import LocalCluster

        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            with_address("dask", cluster.scheduler_address, folder, gearwise, study)
        if importlib.util.find_spec("ray"):
            compare("ray", folder, gearwise, study, robots)
            os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
            import ray

            ray.init("local", num_cpus=2, log_to_driver=False)
            with_address("ray", ray.get_runtime_context().gcs_address, folder, gearwise, study)
            ray.shutdown()
        else:
            print("ray: left out, its package is missing here")
        slurm(folder, gearwise, study, robots)


if __name__ == "__main__":
    main()
