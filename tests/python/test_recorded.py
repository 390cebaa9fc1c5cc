"""Runs that Python records: the folder that the program writes, and runs that are interrupted and resumed."""

import csv
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import unittest.mock
import warnings

import numpy as np
import relcp
from program import program as find_program
from program import relcp as program

# What depends on the clock, the machine's memory or the moment.
OF_THE_CLOCK = {"wall_seconds", "peak_bytes", "legs"}


def colony(**changes):
    return relcp.Scene.load("colony", {"time.dt": 0.01, "time.end": 3, "output.every": 1, **changes})


class Crowded:
    """Cells that sense crowding, with a column of their own."""

    def update(self, cells):
        cells.rates = 1.0 / (1.0 + np.maximum(cells.pressures, 0.0))
        cells["age"] = cells.ages


def outwards(bodies):
    return 0.1 * bodies.positions


class Recorded(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.place = pathlib.Path(place.name)

    def compare(self, mine, theirs):
        """Two folders have the same files with the same bits, but for times of the clock."""
        names = [sorted(path.relative_to(of).as_posix() for path in of.rglob("*")) for of in (mine, theirs)]
        self.assertEqual(*names)
        for name in names[0]:
            a, b = mine / name, theirs / name
            if name == "steps.csv":
                rows = [list(csv.DictReader(path.read_text().splitlines())) for path in (a, b)]
                for row in rows[0] + rows[1]:
                    row.pop("wall_seconds")
                self.assertEqual(*rows)
            elif name == "summary.json":
                both = [json.loads(path.read_text()) for path in (a, b)]
                for summary in both:
                    for key in OF_THE_CLOCK:
                        summary.pop(key, None)
                self.assertEqual(*both)
            elif name.startswith("checkpoint"):
                with np.load(a) as one, np.load(b) as other:
                    self.assertEqual(one.files, other.files)
                    for block in set(one.files) - {"header"}:
                        self.assertEqual(one[block].tobytes(), other[block].tobytes(), f"{name}: {block}")
            elif a.is_file():
                self.assertEqual(a.read_bytes(), b.read_bytes(), name)

    def test_the_folder_is_that_of_the_program(self):
        scene = colony(**{"output.measures": ["nematic"], "output.forces": True, "solver.dump": {"when": "slow", "products": 5}})
        (self.place / "scene.json").write_text(scene.to_json())
        options = ["--backend", "cpu", "--quiet", "--threads", 3, "--out", self.place / "theirs"]
        program("run", self.place / "scene.json", *options)
        run = relcp.run(scene, self.place / "mine", threads=3, progress=False)
        self.assertEqual((run.path, run.status), (self.place / "mine", "done"))
        self.compare(run.path, self.place / "theirs")
        simulation = relcp.Simulation(scene)
        simulation.run()
        self.assertEqual(run.summary["state_hash"], simulation.state_hash)

    def test_new_folders_are_named_after_the_scene_and_full_ones_are_refused(self):
        before = os.getcwd()
        os.chdir(self.place)
        self.addCleanup(os.chdir, before)
        scene = relcp.Scene.load("three-capsules", {"output.picture": False})
        paths = [relcp.run(scene, progress=False).path.as_posix() for _ in range(2)]
        self.assertEqual(paths, ["runs/three-capsules", "runs/three-capsules-2"])
        with self.assertRaisesRegex(relcp.RecordError, "the folder is not empty\nname another folder, or resume"):
            relcp.run(scene, paths[0])
        for arguments, said in [
            (dict(resume=True), "resume"), (dict(until=3.0), "until"), (dict(start_time=1.0), "start_time"),
            (dict(out="x", resume=True, start_from=paths[0]), "start_from"), (dict(backend="tpu"), "backend"),
            (dict(threads=0), "threads"), (dict(checkpoint_every=-1.0), "checkpoint_every"),
        ]:  # fmt: skip
            with self.assertRaisesRegex(ValueError, said):
                relcp.run(scene, **arguments)
        with self.assertRaisesRegex(TypeError, "rules"):
            relcp.run(scene, "y", rules=3)
        with self.assertRaisesRegex(TypeError, "force"):
            relcp.run(scene, "y", forces=[3])
        self.assertEqual(sorted(os.listdir()), ["runs"])

    def interrupted(self, path, **arguments):
        """A run that gets a Ctrl-C after its second recorded state, at a third of its time."""

        def interrupt():
            deadline = time.monotonic() + 60
            while len(list((path / "states").glob("*.npz"))) < 2 and time.monotonic() < deadline:
                time.sleep(0.001)
            os.kill(os.getpid(), signal.SIGINT)

        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        threading.Thread(target=interrupt).start()
        # Python looks for signals after each step.
        every_step = unittest.mock.patch("relcp._record._UPDATE_EVERY", 0.0)
        with every_step, self.assertRaises(KeyboardInterrupt):
            relcp.run(colony(**{"time.dt": 0.0005}), path, progress=False, **arguments)
        signal.signal(signal.SIGINT, before)
        run = relcp.Run(path)
        self.assertEqual((run.status, run.summary["status"]), ("interrupted", "interrupted"))
        self.assertFalse((path / "final.json").exists())
        self.assertLess(run.summary["steps"], 6000)
        return run

    def test_ctrl_c_leaves_a_run_that_goes_on_to_the_same_bits(self):
        whole = relcp.run(colony(**{"time.dt": 0.0005}), self.place / "whole", progress=False)
        first = self.interrupted(self.place / "first")
        program("run", "--resume", "--out", first.path, "--quiet")
        second = self.interrupted(self.place / "second")
        self.assertIs(second.resume(progress=False), second)
        for run in [first.refresh(), second]:
            self.assertEqual(run.status, "done")
            self.compare_but_legs(run.path, whole.path)
        self.assertAlmostEqual(second.resume(until=3.01, progress=False).times[-1], 3.01, 12)

    def compare_but_legs(self, mine, theirs):
        hashes = [json.loads((path / "summary.json").read_text())["state_hash"] for path in (mine, theirs)]
        self.assertEqual(*hashes)
        self.assertEqual((mine / "final.json").read_bytes(), (theirs / "final.json").read_bytes())

    def test_forces_and_rules_are_recorded_and_resumed(self):
        ruled = dict(forces=[outwards], rules=Crowded(), progress=False)
        whole = relcp.run(colony(), self.place / "whole", **ruled)
        simulation = relcp.Simulation(colony())
        simulation.add_force(outwards)
        simulation.rules = Crowded()
        simulation.run()
        self.assertEqual(whole.summary["state_hash"], simulation.state_hash)
        np.testing.assert_array_equal(whole.states[-1].columns["age"], simulation.columns["age"])
        steps = []

        def interrupting(bodies):
            steps.append(bodies.time)
            if len(steps) == 150:
                signal.raise_signal(signal.SIGINT)
            return outwards(bodies)

        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        with self.assertRaises(KeyboardInterrupt):
            relcp.run(colony(), self.place / "half", **{**ruled, "forces": [interrupting]})
        half = relcp.Run(self.place / "half")
        self.assertEqual(half.status, "interrupted")
        self.assertFalse((half.path / "final.json").exists())
        self.assertIn(half.summary["steps"], [149, 150])
        other = self.place / "other"
        shutil.copytree(half.path, other)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            half.resume(**ruled)
        self.assertEqual(half.summary["state_hash"], whole.summary["state_hash"])
        # Nobody goes on without them unknowingly.
        ran = subprocess.run(
            [find_program(), "run", "--resume", "--out", other], capture_output=True, text=True, timeout=300
        )
        for own in ["forces", "rules"]:
            self.assertIn(f"{own} of a user's own acted on this run and are not in its folder", ran.stderr)
        self.assertNotEqual(relcp.Run(other).summary["state_hash"], whole.summary["state_hash"])

    def test_what_fails_is_raised_and_recorded(self):
        def failing(bodies):
            if bodies.time > 0.045:
                raise LookupError("no such field")
            return outwards(bodies)

        with self.assertRaisesRegex(LookupError, "no such field"):
            relcp.run(colony(), self.place / "run", forces=[failing], progress=False)
        run = relcp.Run(self.place / "run")
        self.assertEqual((run.status, run.summary["steps"]), ("stopped", 5))
        rod = {"spherocylinder": {"diameter": 1, "length": 2}}
        stuck = relcp.Scene({
            "name": "stuck", "planar": True, "time": {"dt": 0.05, "end": 5}, "output": {"picture": False},
            "growth": {"rate": 1, "division_length": 3},
            "walls": [{"sphere": {"center": [0, 0, 0], "radius": 1.5}}],
            "bodies": [{"shape": rod, "position": [0, 0, 0], "axis": [1, 0, 0]}],
        })  # fmt: skip
        with self.assertRaisesRegex(relcp.SimulationError, "stuck: .*step"):
            relcp.run(stuck, self.place / "stuck", progress=False)
        self.assertEqual(relcp.Run(self.place / "stuck").status, "stopped")

    def test_a_run_begins_with_a_state_of_another(self):
        first = relcp.run(colony(), self.place / "first", progress=False)
        scene = colony(**{"time.end": 3.5})
        with self.assertWarnsRegex(RuntimeWarning, "the state has no multipliers of contacts") as warned:
            branch = relcp.run(scene, self.place / "branch", start_from=first, start_time=2.0, progress=False)
        self.assertEqual(warned.filename, __file__)
        program("run", self.place / "first" / "scene.json", "--from", f"{first.path}@2.0", "--set", "time.end=3.5",
                "--backend", "cpu", "--quiet", "--out", self.place / "theirs")  # fmt: skip
        self.assertEqual(branch.summary["state_hash"], relcp.Run(self.place / "theirs").summary["state_hash"])
        self.assertEqual(branch.times[0], 2.0)
        with self.assertRaisesRegex(relcp.RecordError, "planar"):
            relcp.run(colony(planar=False), self.place / "no", start_from=str(first.path), progress=False)

    def test_progress(self):
        try:
            import tqdm.auto
        except ImportError:
            self.skipTest("tqdm is not installed")
        scene = relcp.Scene.load("two-ellipsoids", {"time.end": 5, "output.picture": False})
        bars = []

        class Bar(tqdm.auto.tqdm):
            def __init__(self, *arguments, **named):
                super().__init__(*arguments, file=open(os.devnull, "w"), **named)
                bars.append(self)

        terminal = unittest.mock.Mock(isatty=lambda: True)
        with unittest.mock.patch("tqdm.auto.tqdm", Bar), unittest.mock.patch("sys.stderr", terminal), \
                unittest.mock.patch("relcp._record._UPDATE_EVERY", 0.0):  # fmt: skip
            relcp.run(scene, self.place / "shown")
            relcp.run(scene, self.place / "silent", progress=False)
        self.assertEqual([(bar.n, bar.total) for bar in bars], [(500, 500)])
        with unittest.mock.patch.dict("sys.modules", {"tqdm": None, "tqdm.auto": None}), \
                unittest.mock.patch("sys.stderr", terminal):  # fmt: skip
            self.assertEqual(relcp.run(scene, self.place / "without").status, "done")


if __name__ == "__main__":
    unittest.main()
