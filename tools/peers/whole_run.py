"""Runs one command and prints what it took, as JSON: whole_run.py LIMIT_S OUTPUT COMMAND...

A process of its own, since the peak of memory that Linux reports for a child is at least that of its parent. LIMIT_S is
when the command is stopped, OUTPUT the file for all that it prints.
"""

import json
import os
import signal
import subprocess
import sys
import time

# How often threads are counted, and so how precise times are. Seconds.
STEP_S = 0.005


def threads_of(pid):
    """The threads that a process has now, 0 if it has ended."""
    try:
        return len(os.listdir(f"/proc/{pid}/task"))
    except OSError:
        return 0


def watch(command, limit_s, output):
    """Runs a command: its exit status (negative: the signal), times in seconds, threads at most, and peak in bytes."""
    start, threads = time.perf_counter(), 0
    process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
    while True:
        done, status, usage = os.wait4(process.pid, os.WNOHANG)
        wall_s = time.perf_counter() - start
        if done:
            break
        if wall_s > limit_s:
            os.kill(process.pid, signal.SIGKILL)
        threads = max(threads, threads_of(process.pid))
        time.sleep(STEP_S)
    return {
        "status": os.waitstatus_to_exitcode(status),
        "wall_s": wall_s,
        "cpu_s": usage.ru_utime + usage.ru_stime,
        "threads": threads,
        "peak_bytes": usage.ru_maxrss * 1024,
    }


def main():
    """The command line."""
    limit_s, path, *command = sys.argv[1:]
    with open(path, "wb") as output:
        try:
            print(json.dumps(watch(command, float(limit_s), output)))
        except OSError as error:
            print(json.dumps({"missing": str(error)}))


if __name__ == "__main__":
    main()
