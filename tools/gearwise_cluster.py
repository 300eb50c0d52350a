#!/usr/bin/env python3
"""Runs a gearwise study in shards, here or on a cluster, then `gearwise merge`.

    python gearwise_cluster.py --out result --shards 64 -- study.toml                  # cores of this machine
    python gearwise_cluster.py --executor dask --address tcp://head:8786 --out result --shards 64 -- study.toml
    python gearwise_cluster.py --executor ray --address auto --out result --shards 64 -- study.toml
    python gearwise_cluster.py --executor slurm --sbatch="--time=1:00:00" --out result --shards 64 -- study.toml

The results are those of a single run, byte for byte. A shard keeps a journal in its own folder, so that one
whose worker was lost goes on where that stopped. The folders are in RESULT.shards, on a disk that this machine
and all workers see. Run again after a stop, it goes on too: with the same number of shards.

Who does the work is the executor's business: threads here, tasks of Dask or Ray, an array job of Slurm. Dask
(`pip install distributed`) and Ray (`pip install ray`) begin a cluster on this machine without --address. For
another kind of Dask cluster change the line marked CLUSTER below. What follows `--` goes to `gearwise study` as
it stands; paths in it must mean the same on every worker. A worker that has the Python package (`pip install gearwise`)
needs nothing else; another needs the program `gearwise`, or where --gearwise says it is.

Exit status as `gearwise`: 0 done, 1 done but robots were broken, 2 it could not be done, 130 stopped.
"""

import argparse
import concurrent.futures
import contextlib
import functools
import importlib
import importlib.util
import logging
import os
import pathlib
import platform
import shlex
import shutil
import subprocess
import sys
import threading
import time

BUSY = "another process works on the study"


def found(gearwise):
    """How gearwise is called on this machine: the program that is named; else the package, else the program of that name."""
    if gearwise:
        return [gearwise] if shutil.which(gearwise) else None
    # The source of the package without its library is no package.
    if importlib.util.find_spec("gearwise") and importlib.util.find_spec("gearwise._native"):
        return [sys.executable, "-m", "gearwise"]
    return ["gearwise"] if shutil.which("gearwise") else None


def run_shard(gearwise, study, folder, number, of, threads, cwd):
    """One shard on a worker: begun, or gone on with. Returns its number, its exit status and what it said."""
    called = found(gearwise)
    if not called:
        return number, 2, f"error: on {platform.node()}: gearwise was not found: pip install gearwise, or --gearwise\n"
    command = [*called, "study", *study, "--out", folder, "--shard", f"{number}/{of}", "--resume"]
    command += ["--threads", str(threads)]
    # What a lost worker had started may still be at it: ten minutes of patience, then another try.
    for _ in range(300):
        try:
            process = subprocess.Popen(command, cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        except OSError as error:
            return number, 2, f"error: on {platform.node()}: {error}\n"
        try:
            _, said = process.communicate()
        finally:
            # A task that is cancelled leaves no process behind.
            if process.poll() is None:
                process.kill()
                process.wait()
        busy = process.returncode == 2 and BUSY in said
        if not busy:
            break
        time.sleep(2)
    if busy or process.returncode < 0 or process.returncode == 130:
        # Killed or stopped from outside: worth another try.
        raise RuntimeError(f"shard {number}/{of}: {said.strip() or f'exit status {process.returncode}'}")
    return number, process.returncode, said


# Each executor yields for every shard, in any order, what `run_shard` returns, or the exception it was given up with.
# When it is closed before the end, what waits is cancelled.


def on_this_machine(tasks, arguments):
    stopped = threading.Event()

    def patient(task):
        for left in range(arguments.retries, -1, -1):
            try:
                return run_shard(*task)
            except RuntimeError:
                if not left or stopped.is_set():
                    raise

    workers = arguments.workers or max(1, os.cpu_count() // arguments.threads)
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        futures = [pool.submit(patient, task) for task in tasks]
        try:
            for future in concurrent.futures.as_completed(futures):
                yield outcome(future.result)
        finally:
            stopped.set()
            pool.shutdown(cancel_futures=True)


def on_dask(tasks, arguments):
    dask = package("distributed")
    if arguments.address:
        cluster = contextlib.nullcontext(arguments.address)
    else:
        # CLUSTER: an object of dask_jobqueue, dask_kubernetes, dask_cloudprovider or coiled will do.
        cluster = dask.LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None)
    with cluster as place, dask.Client(place) as client:
        futures = [
            # Not pure: a shard is done for what it leaves on the disk. Ties go to the lower number.
            client.submit(
                run_shard, *task, pure=False, retries=arguments.retries, key=f"shard-{number}-{time.time_ns()}",
                priority=-number,
            )
            for number, task in enumerate(tasks, 1)
        ]  # fmt: skip
        try:
            for future in dask.as_completed(futures):
                yield outcome(future.result)
        finally:
            client.cancel(futures)


def on_ray(tasks, arguments):
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    if arguments.address:
        # Two minutes for a cluster that does not answer; Ray's own limit is some fourteen.
        os.environ.setdefault("RAY_NUM_REDIS_GET_RETRIES", "3")
    ray = package("ray")
    cores = arguments.workers and arguments.workers * arguments.threads
    ray.init(
        arguments.address or "local",
        num_cpus=None if arguments.address else cores,
        logging_level=logging.WARNING,
        log_to_driver=False,
    )
    try:
        run = ray.remote(num_cpus=arguments.threads, max_retries=arguments.retries, retry_exceptions=True)(run_shard)
        waiting = [run.remote(*task) for task in tasks]
        while waiting:
            (ready,), waiting = ray.wait(waiting)
            yield outcome(functools.partial(ray.get, ready))
    finally:
        ray.shutdown()


ARRAY = """#!/bin/sh
# A shard for each task of the array. Its exit status is left in a file; a task that was killed leaves none.
cd {cwd} || exit 2
shard={parts}/shard-$(printf %04d "$SLURM_ARRAY_TASK_ID")
{gearwise} study {study} --out "$shard" --shard "$SLURM_ARRAY_TASK_ID/{of}" --resume --threads {threads} > /dev/null
status=$?
echo $status > "$shard.status"
exit $status
"""


def on_slurm(tasks, arguments):
    if not shutil.which("sbatch"):
        fail("--executor slurm needs `sbatch`, which was not found: run this where jobs are submitted")
    gearwise, study, folder, _, of, threads, cwd = tasks[0]
    parts = pathlib.Path(folder).parent
    quoted = {name: shlex.quote(str(value)) for name, value in (("cwd", cwd), ("parts", parts))}
    quoted["gearwise"] = shlex.join(found(gearwise))
    (parts / "array.sh").write_text(ARRAY.format(**quoted, study=shlex.join(study), of=of, threads=threads))
    waiting = {task[3]: pathlib.Path(task[2]) for task in tasks}
    for _ in range(arguments.retries + 1):
        for shard in waiting.values():
            shard.with_suffix(".status").unlink(missing_ok=True)
        which = f"1-{of}" if len(waiting) == of else ",".join(map(str, waiting))
        command = ["sbatch", "--job-name=gearwise", f"--cpus-per-task={threads}", *shlex.split(arguments.sbatch)]
        command += ["--parsable", "--wait", "--requeue", f"--array={which}", "--output=shard-%4a.log", "array.sh"]
        job = subprocess.Popen(command, cwd=parts, stdout=subprocess.PIPE, text=True)
        try:
            name = job.stdout.readline().strip().split(";")[0]
            if not name:
                fail("sbatch did not take the job")
            running = True
            while running and waiting:
                time.sleep(1)
                running = job.poll() is None
                for number, shard in list(waiting.items()):
                    with contextlib.suppress(OSError, ValueError):
                        status = int(shard.with_suffix(".status").read_text())
                        said = shard.with_suffix(".log").read_text()
                        # 128 and above: killed or stopped from outside.
                        if status < 128 and BUSY not in said:
                            del waiting[number]
                            yield number, status, said
        finally:
            if job.poll() is None:
                # `sbatch --wait` looks rarely: it may be the last to know that all is done.
                job.terminate()
                if waiting:
                    subprocess.run(["scancel", name])
            job.wait()
        if not waiting:
            return
    for number, shard in waiting.items():
        yield RuntimeError(f"shard {number}/{of}: see {shard.with_suffix('.log')}")


EXECUTORS = {"local": on_this_machine, "dask": on_dask, "ray": on_ray, "slurm": on_slurm}


def outcome(get):
    try:
        return get()
    except Exception as error:
        # Ray wraps what a task raises.
        return getattr(error, "cause", None) or error


def package(name):
    try:
        return importlib.import_module(name)
    except ImportError as error:
        fail(f"the Python package `{name}` is needed for this executor ({error}): pip install {name}")


def fail(why):
    print(f"error: {why}", file=sys.stderr)
    sys.exit(2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executor", choices=EXECUTORS, default="local", help="who does the work")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder for the results")
    parser.add_argument("--shards", type=int, default=16, help="number of tasks; a few for each worker")
    parser.add_argument("--address", help="of a Dask scheduler or a Ray cluster; one on this machine without it")
    parser.add_argument("--workers", type=int, help="how many at a time on this machine")
    parser.add_argument("--threads", type=int, default=1, help="threads of each task")
    parser.add_argument("--retries", type=int, default=10, help="how often a shard is tried again")
    parser.add_argument("--sbatch", default="", help="more options of sbatch: --sbatch='--time=60 --mem=2G'")
    parser.add_argument("--gearwise", help="the program, as workers find it; by default the package, else `gearwise`")
    parser.add_argument("study", nargs="+", help="arguments of `gearwise study`")
    arguments = parser.parse_args()
    if arguments.shards < 1 or arguments.threads < 1 or (arguments.workers or 1) < 1:
        fail("--shards, --threads and --workers are 1 or more")
    if not found(arguments.gearwise):
        named = f"the program `{arguments.gearwise}`" if arguments.gearwise else "neither the package nor the program `gearwise`"
        fail(f"{named} was not found: pip install gearwise, or say where the program is with --gearwise")
    try:
        return drive(arguments)
    except OSError as error:
        fail(f"{error}")
    except KeyboardInterrupt:
        print("stopped: run it again to go on", file=sys.stderr)
        return 130


def drive(arguments):
    cwd = str(pathlib.Path.cwd())
    parts = arguments.out.resolve().with_name(arguments.out.name + ".shards")
    parts.mkdir(parents=True, exist_ok=True)
    folders = [str(parts / f"shard-{n:04}") for n in range(1, arguments.shards + 1)]
    tasks = [
        (arguments.gearwise, arguments.study, folder, number, arguments.shards, arguments.threads, cwd)
        for number, folder in enumerate(folders, 1)
    ]
    began, done, wrong = time.monotonic(), 0, False
    with contextlib.closing(EXECUTORS[arguments.executor](tasks, arguments)) as results:
        for result in results:
            if isinstance(result, Exception):
                print(f"a shard was given up: {result}", file=sys.stderr)
                wrong = True
                continue
            _, status, said = result
            done += 1
            left = (time.monotonic() - began) / done * (len(tasks) - done)
            print(f"{done} of {len(tasks)} shards, {left:.0f} s left", file=sys.stderr, flush=True)
            if status != 0 and said:
                print(said, file=sys.stderr, end="")
            if status not in (0, 1):
                # The same mistake would be made by every shard.
                return 2
    if wrong:
        print(f"run it again: what is finished is kept in {parts}", file=sys.stderr)
        return 2
    return subprocess.run([*found(arguments.gearwise), "merge", str(arguments.out), *folders, "--force"]).returncode


if __name__ == "__main__":
    sys.exit(main())
