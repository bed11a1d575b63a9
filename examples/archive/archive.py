"""Predicts an archive of programs on a Dask cluster: the command `truefeed predict --ndjson`, spread over its workers.

    python archive.py FOLDER... --machine M.toml --out OUT.ndjson [--scheduler ADDRESS] [--tolerance MM]...

Without --scheduler it starts a cluster on this machine. Workers need the command and the files under the same paths.
Which programs there are, which of them are done, and what a line says is the command's own business (--list, --out);
retries and lost workers are Dask's. So the file of lines is the same, in another order, as that of one machine, and a
run that was stopped goes on with the same request. A program on which workers keep dying gets a line with an error.
"""

import argparse
import json
import os
import subprocess
import sys

from distributed import Client, LocalCluster, as_completed


def command(truefeed, machine, tolerances, *more):
    options = [word for tolerance in tolerances for word in ("--tolerance", str(tolerance))]
    return [truefeed, "predict", "--machine", machine, "--ndjson", *options, *more]


def run(words):
    """What the command prints; its status is 1 where a line of an archive says an error, which is a result."""
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    if done.returncode not in (0, 1):
        raise RuntimeError(done.stderr.decode(errors="replace").strip() or f"status {done.returncode}")
    return done.stdout


def to_do(truefeed, machine, tolerances, paths, out):
    """The programs that have no current line in `out`, which is repaired if its last line is half a line."""
    listed = run(command(truefeed, machine, tolerances, "--out", out, "--list", "--", *paths))
    return [json.loads(line)["path"] for line in listed.splitlines()]


def predicted(truefeed, machine, tolerances, paths):
    """The lines of some programs; runs on a worker."""
    return run(command(truefeed, machine, tolerances, "--jobs", "1", "--", *paths))


def archive(client, truefeed, machine, tolerances, paths, out, batch=20, retries=3):
    """Adds the lines of all programs to `out` as they are done; how many programs got none."""
    left = to_do(truefeed, machine, tolerances, paths, out)
    batches = [left[first : first + batch] for first in range(0, len(left), batch)]
    done, lost = 0, 0
    with open(out, "ab", buffering=0) as lines:

        def submit(paths):
            future = client.submit(predicted, truefeed, machine, tolerances, paths, retries=retries, pure=False)
            paths_of[future.key] = paths
            return future

        paths_of = {}
        running = as_completed([submit(paths) for paths in batches], raise_errors=False)
        for future in running:
            paths = paths_of.pop(future.key)
            if future.status == "finished":
                lines.write(future.result())
                done += len(paths)
            elif len(paths) > 1:
                # One bad program must not take its neighbours with it.
                for path in paths:
                    running.add(submit([path]))
            else:
                error = f"not predicted: {future.exception()}"
                lines.write(json.dumps({"path": paths[0], "error": error}).encode() + b"\n")
                lost += 1
            print(f"{done + lost} of {len(left)} programs, {lost} not predicted", file=sys.stderr)
    return lost


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="FOLDER")
    parser.add_argument("--machine", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--tolerance", type=float, action="append", default=[])
    parser.add_argument("--truefeed", default="truefeed", help="the command, if it is not on the path")
    parser.add_argument("--scheduler", help="address of a running cluster")
    parser.add_argument("--batch", type=int, default=20, help="programs a task")
    given = parser.parse_args()
    where = os.path.abspath
    # A worker does one program at a time, so that there is one worker a processor.
    cluster = given.scheduler or LocalCluster(threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        paths = [where(path) for path in given.paths]
        request = (given.truefeed, where(given.machine), given.tolerance, paths, where(given.out))
        sys.exit(1 if archive(client, *request, batch=given.batch) else 0)


if __name__ == "__main__":
    main()
