#!/usr/bin/env python3
"""Runs a gearwise study on a Dask cluster: one task for each shard, then `gearwise merge`.

The results are those of a single run, byte for byte. A shard keeps a journal in its own folder, so that a
task that is tried again (its worker was lost) goes on where the lost one stopped, as long as the folders
are on a disk that all workers see; on a disk of their own the shard begins anew, which is slower, not wrong.

    python gearwise_dask.py --out result --shards 64 -- study.toml            # all cores of this machine
    python gearwise_dask.py --out result --shards 64 --scheduler tcp://head:8786 -- study.toml

The two lines to change for another cluster are marked CLUSTER below: anything that gives a
`distributed.Client` will do (dask-jobqueue, dask-kubernetes, dask-cloudprovider, Coiled). What follows `--`
goes to `gearwise study` as it stands; paths in it must mean the same on every worker.

Exit status as `gearwise`: 0 done, 1 done but robots were broken, 2 it could not be done.
"""

import argparse
import pathlib
import subprocess
import sys
import time

from distributed import Client, LocalCluster, as_completed


def run_shard(gearwise, study, folder, number, of, threads, cwd):
    """One shard on a worker: begun, or gone on with. Returns its exit status and what it said."""
    command = [gearwise, "study", *study, "--out", folder, "--shard", f"{number}/{of}", "--resume"]
    command += ["--threads", str(threads)]
    process = subprocess.Popen(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        out, err = process.communicate()
    finally:
        # A task that is cancelled leaves no process behind.
        if process.poll() is None:
            process.kill()
            process.wait()
    busy = process.returncode == 2 and "another process works on the study" in err
    if process.returncode < 0 or busy:
        # Killed from outside, or a lost worker's process is still at it: worth another try.
        time.sleep(2 if busy else 0)
        raise RuntimeError(f"shard {number}/{of}: {err.strip() or process.returncode}")
    return number, process.returncode, out, err


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder for the results")
    parser.add_argument("--shards", type=int, default=16, help="number of tasks; a few for each worker")
    parser.add_argument("--scheduler", help="address of a Dask scheduler; a local cluster without it")
    parser.add_argument("--workers", type=int, help="processes of the local cluster")
    parser.add_argument("--threads", type=int, default=1, help="threads of each task")
    parser.add_argument("--retries", type=int, default=10, help="how often a shard is tried again")
    parser.add_argument("--gearwise", default="gearwise", help="the program, as workers find it")
    parser.add_argument("study", nargs="+", help="arguments of `gearwise study`")
    arguments = parser.parse_args()

    if arguments.scheduler:
        cluster = arguments.scheduler  # CLUSTER: where your scheduler is, or an object such as
    else:
        cluster = LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None)  # CLUSTER
    with Client(cluster) as client:
        status = drive(client, arguments)
    if not arguments.scheduler:
        cluster.close()
    return status


def drive(client, arguments):
    cwd = str(pathlib.Path.cwd())
    parts = arguments.out.resolve().with_name(arguments.out.name + ".shards")
    parts.mkdir(parents=True, exist_ok=True)
    folders = {n: str(parts / f"shard-{n:04}") for n in range(1, arguments.shards + 1)}
    futures = [
        client.submit(
            run_shard, arguments.gearwise, arguments.study, folder, number, arguments.shards, arguments.threads, cwd,
            # Not pure: a shard is done for what it leaves on the disk. Ties go to the lower number.
            pure=False, retries=arguments.retries, key=f"shard-{number}-of-{arguments.shards}-{time.time_ns()}",
            priority=-number,
        )
        for number, folder in folders.items()
    ]  # fmt: skip
    began, done, wrong = time.monotonic(), 0, False
    for future in as_completed(futures):
        if future.status != "finished":
            print(f"a shard was given up: {future.exception()}", file=sys.stderr)
            wrong = True
            continue
        number, status, _, err = future.result()
        done += 1
        passed = time.monotonic() - began
        left = passed / done * (len(futures) - done)
        print(f"{done} of {len(futures)} shards, {left:.0f} s left", file=sys.stderr, flush=True)
        if status != 0 and err:
            print(err, file=sys.stderr, end="")
        if status not in (0, 1):
            # The same mistake would be made by every shard.
            for other in futures:
                other.cancel()
            return 2
    if wrong:
        print(f"run it again: what is finished is kept in {parts}", file=sys.stderr)
        return 2
    merge = [arguments.gearwise, "merge", str(arguments.out), *folders.values(), "--force"]
    return subprocess.run(merge).returncode


if __name__ == "__main__":
    sys.exit(main())
