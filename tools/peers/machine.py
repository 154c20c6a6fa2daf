"""The machine that measures: its processor's name, and a fixed job that tells when others use it."""

import platform
import threading
import time

import numpy as np


def processor():
    """The processor's name."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.processor()


def calibrate():
    """Milliseconds of a fixed job on two threads, the better of two: it grows when others use the machine."""
    values = np.random.default_rng(1).random(3_000_000).astype(np.float32)
    times = []
    for _ in range(2):
        threads = [threading.Thread(target=np.sort, args=(values,), kwargs={"kind": "stable"}) for _ in range(2)]
        start = time.perf_counter()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        times.append((time.perf_counter() - start) * 1e3)
    return min(times)
