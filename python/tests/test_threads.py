"""Threads, Ctrl-C, forks, and the end of the process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import SIZE

import pellucid

MANY = np.random.default_rng(0).normal(size=(300_000, 3))


def run(script: str, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
    """A script in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], text=True, capture_output=True, timeout=timeout, check=False
    )


def test_renderers_in_threads_render_the_same(renderer, points):
    expected = pellucid.render(points, opacity=0.3, size=SIZE).rgba
    found: list[np.ndarray] = []

    def work() -> None:
        with pellucid.Renderer() as own, own.load(points, opacity=0.3, size=SIZE) as loaded:
            found.extend(loaded.frame().rgba for _ in range(5))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 20
    for rgba in found:
        np.testing.assert_array_equal(rgba, expected)


def test_one_scene_serves_threads_in_turns(renderer, points):
    loaded = renderer.load(points, opacity=0.3, size=SIZE)
    views = [loaded.camera.orbit(45.0 * step) for step in range(8)]
    expected = [loaded.frame(camera=view).rgba for view in views]
    found: dict[int, np.ndarray] = {}

    def work(step: int) -> None:
        found[step] = loaded.frame(camera=views[step]).rgba

    threads = [threading.Thread(target=work, args=(step,)) for step in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for step in range(8):
        np.testing.assert_array_equal(found[step], expected[step])


def test_other_threads_go_on_while_a_frame_is_rendered(renderer):
    ticks: list[float] = []
    done = threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    with renderer.load(MANY, opacity=0.05, size=(512, 512), method="stochastic") as loaded:
        # A fast device needs more work, so that pauses of the system don't count.
        for samples in (16, 64, 256, 1024):
            begin = time.monotonic()
            loaded.frame(method__samples=samples)
            end = time.monotonic()
            if end - begin > 0.5:
                break
    done.set()
    thread.join()
    pauses = np.diff([begin, *(at for at in ticks if begin < at < end), end])
    assert pauses.max() < 0.5 * (end - begin), f"the longest pause of {end - begin:.3f} s was {pauses.max():.3f} s"


INTERRUPTED = """
    import os, signal, threading, time
    import numpy as np, pellucid

    points = np.random.default_rng(0).normal(size=(400_000, 3))
    loaded = {load}
    sent = []

    def interrupt():
        time.sleep({after})
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    try:
        while True:
            {call}
    except KeyboardInterrupt:
        print(time.monotonic() - sent[0])
    image = pellucid.render(points[:100], size=(16, 16))
    assert image.rgba.max() > 0.0, "the device goes on"
"""


@pytest.mark.parametrize(
    ("load", "call", "after"),
    [
        ("pellucid.Renderer().load(points, opacity=0.05, size=(1024, 1024))", "loaded.frame(method='abuffer')", 1.0),
        ("pellucid.Renderer().load(points, opacity=0.05)", "loaded.frame(method='stochastic', method__samples=1024)", 1.0),
        ("None", "pellucid.render(np.random.default_rng(1).normal(size=(2_000_000, 3)), opacity=0.1)", 1.5),
        ("None", "pellucid.check('abuffer/')", 1.0),
        # One dispatch that takes seconds: nobody waits for it, not even whoever closes what it works for.
        (
            "None",
            "with pellucid.Renderer() as renderer, renderer.load(points, opacity=0.05, radius=0.3, size=(1024, 1024)) as loaded:\n"
            "                loaded.frame(method='weighted')",
            4.0,
        ),
        ("None", "pellucid.render(points, opacity=0.05, radius=0.3, size=(1024, 1024), method='weighted')", 4.0),
    ],
    ids=["a frame", "samples", "preparing points", "a check", "a frame and closing", "a heavy picture"],
)
def test_ctrl_c_ends_work_at_once(renderer, load, call, after):
    waited = 1.0
    for _ in range(3):
        # A machine that does other things at the same time may take longer to wake anybody.
        done = run(INTERRUPTED.format(load=load, call=call, after=after))
        assert done.returncode == 0, done.stderr
        waited = min(waited, float(done.stdout))
        if waited < 0.2:
            break
    assert waited < 0.2, f"{waited:.3f} s"


def test_an_interruption_that_nobody_catches_ends_the_process(renderer):
    done = run(
        """
        import os, signal, threading
        import numpy as np, pellucid

        points = np.random.default_rng(0).normal(size=(400_000, 3))
        threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
        while True:
            pellucid.render(points, opacity=0.05, method="abuffer")
        """
    )
    assert done.returncode == -signal.SIGINT, done.stderr
    assert done.stderr.rstrip().endswith("KeyboardInterrupt")


def test_ctrl_c_at_the_end_of_the_process_is_quiet():
    done = run(
        """
        import pellucid

        def wait(seconds):
            raise KeyboardInterrupt

        pellucid._pellucid.wait = wait
        """
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_a_forked_process_is_refused_with_the_reason(renderer):
    done = run(
        """
        import os, warnings
        import numpy as np, pellucid

        warnings.simplefilter("ignore", DeprecationWarning)
        points = np.zeros((3, 3))
        loaded = pellucid.Renderer().load(points, size=(16, 16))
        loaded.frame()
        if os.fork() == 0:
            for call in (lambda: loaded.frame(), lambda: pellucid.render(points), lambda: pellucid.Cloud(points)):
                try:
                    call()
                except pellucid.Error as error:
                    assert "forked from process" in str(error) and 'get_context("spawn")' in str(error), error
                else:
                    os._exit(1)
            del loaded
            raise SystemExit(7)
        _, status = os.wait()
        assert os.waitstatus_to_exitcode(status) == 7, status
        assert loaded.frame().rgba.shape == (16, 16, 4)
        """
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_a_process_that_was_forked_before_may_render(renderer):
    done = run(
        """
        import os, warnings
        import numpy as np, pellucid

        warnings.simplefilter("ignore", DeprecationWarning)
        if os.fork() == 0:
            image = pellucid.render(np.zeros((3, 3)), size=(16, 16))
            os._exit(0 if image.rgba.max() > 0.0 else 1)
        _, status = os.wait()
        assert status == 0, status
        """
    )
    assert done.returncode == 0, done.stderr


def test_workers_that_are_spawned_render(renderer, tmp_path):
    (tmp_path / "work.py").write_text(
        textwrap.dedent(
            """
            import multiprocessing
            import numpy as np
            import pellucid

            def alpha(opacity):
                image = pellucid.render(np.zeros((1, 3)), radii=[1.0], opacity=opacity, size=(8, 8), method="abuffer")
                return float(image.rgba[4, 4, 3])

            if __name__ == "__main__":
                pellucid.render(np.zeros((1, 3)), size=(8, 8))
                with multiprocessing.get_context("spawn").Pool(2) as pool:
                    assert pool.map(alpha, [0.25, 0.5]) == [0.25, 0.5]
            """
        )
    )
    done = subprocess.run([sys.executable, tmp_path / "work.py"], text=True, capture_output=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr


def test_without_a_driver_the_error_says_what_to_install():
    calls = "pellucid.devices()\n    pellucid.Renderer()"
    script = f"import pellucid\ntry:\n    {calls}\nexcept pellucid.DeviceError as error:\n    print(error)"
    environment = {**os.environ, "VK_DRIVER_FILES": "/nowhere.json", "VK_ICD_FILENAMES": "/nowhere.json"}
    done = subprocess.run([sys.executable, "-c", script], text=True, capture_output=True, timeout=60, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    for system in ("Debian, Ubuntu: apt install libvulkan1 mesa-vulkan-drivers", "Fedora: dnf install", "Windows:", "macOS:"):
        assert system in done.stdout, done.stdout


def test_importing_brings_numpy_alone():
    """The import takes less than 50 ms; benches/speed.py measures it."""
    done = run(
        """
        import sys
        import numpy

        before = set(sys.modules)
        import pellucid

        packages = {name.partition(".")[0] for name in set(sys.modules) - before}
        print(*sorted(packages - set(sys.stdlib_module_names) - {"numpy"}), "pellucid._measures" in sys.modules)
        """
    )
    assert done.stdout == "pellucid False\n", done.stdout + done.stderr


def test_closed_things_say_so(points):
    renderer = pellucid.Renderer()
    loaded = renderer.load(points, size=SIZE)
    loaded.close()
    with pytest.raises(ValueError, match="was closed"):
        loaded.frame()
    renderer.close()
    with pytest.raises(ValueError, match="was closed"):
        renderer.load(points)
