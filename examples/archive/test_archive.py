"""The engine gives the lines of the command, though a worker is killed in the middle and the run is stopped and resumed.

    python test_archive.py TRUEFEED MACHINE.toml FOLDER
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time

from distributed import Client, LocalCluster

import archive


def lines(path):
    with open(path, "rb") as file:
        objects = [json.loads(line) for line in file]
    by_path = {one["path"]: one for one in objects}
    assert len(by_path) == len(objects), "a program has two lines"
    return by_path


def count(path):
    try:
        with open(path, "rb") as file:
            return file.read().count(b"\n")
    except FileNotFoundError:
        return 0


def main(truefeed, machine, folder):
    tolerances = [0.01, 0.05]
    with tempfile.TemporaryDirectory() as scratch:
        alone, spread = os.path.join(scratch, "alone.ndjson"), os.path.join(scratch, "spread.ndjson")
        subprocess.run(archive.command(truefeed, machine, tolerances, "--out", alone, folder), check=True)
        expected = lines(alone)

        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            killed = []

            def kill():
                while count(spread) < len(expected) // 5:
                    time.sleep(0.01)
                pid = next(iter(client.run(os.getpid).values()))
                os.kill(pid, signal.SIGKILL)
                killed.append(count(spread))

            killer = threading.Thread(target=kill)
            killer.start()
            lost = archive.archive(client, truefeed, machine, tolerances, [folder], spread, batch=5)
            killer.join()
            assert lost == 0, f"{lost} programs were not predicted"
            assert 0 < killed[0] < len(expected), f"killed at {killed[0]} of {len(expected)}"
            assert lines(spread) == expected, "the engine says something else than the command"

            # Stopped: the second half of the lines is lost, and the last one torn.
            with open(spread, "rb") as file:
                half = file.read().splitlines(keepends=True)[: len(expected) // 2]
            with open(spread, "wb") as file:
                file.write(b"".join(half)[:-20])
            assert len(archive.to_do(truefeed, machine, tolerances, [folder], spread)) == len(expected) - len(half) + 1
            assert archive.archive(client, truefeed, machine, tolerances, [folder], spread) == 0
            assert lines(spread) == expected, "resumed, it says something else"
            assert archive.to_do(truefeed, machine, tolerances, [folder], spread) == []
    print(f"{len(expected)} programs, a worker killed at {killed[0]}, resumed at {len(half) - 1}: the lines of the command")


if __name__ == "__main__":
    main(*sys.argv[1:])
