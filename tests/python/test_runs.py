"""A run's folder, read back, finished and running."""

import csv
import json
import math
import os
import pathlib
import pickle
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import warnings

import numpy as np
import relcp
from program import relcp as program
from relcp._relcp import Recording

ARRAYS = [
    ("positions", "position"), ("orientations", "orientation"), ("velocities", "velocity"),
    ("angular_velocities", "angular_velocity"), ("sizes", "size"), ("ids", "id"), ("parents", "parent"),
    ("births", "birth"), ("generations", "generation"),
]  # fmt: skip


def colony(**changes):
    """A colony that loses the cells that are far from its middle, with its forces in each state."""
    return relcp.Scene.load("colony", {
        "time.dt": 0.01, "time.end": 4, "output.every": 0.5, "output.forces": True, "output.picture": False,
        "output.measures": ["nematic", "groups"], "growth.division_length_noise": 0.1,
        "removal": [{"outside": {"sphere": {"center": [0, 0, 0], "radius": 4}}}], **changes,
    })  # fmt: skip


class Folders(unittest.TestCase):
    """One run for all tests that do not change its folder."""

    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.place.cleanup)
        cls.path = pathlib.Path(cls.place.name) / "run"
        cls.run_ = relcp.run(colony(), cls.path, progress=False)

    def test_what_it_is(self):
        run = relcp.Run(str(self.path))
        self.assertEqual((run.path, run.status, run.scene), (self.path, "done", colony()))
        self.assertEqual(run.summary, json.loads((self.path / "summary.json").read_text()))
        self.assertIn("done", repr(run))
        self.assertIs(run.steps, run.steps)
        before = run.steps
        self.assertIsNot(run.refresh().steps, before)

    def test_states_are_those_of_the_files(self):
        states = self.run_.states
        files = sorted((self.path / "states").glob("*.npz"))
        self.assertEqual(len(states), len(files))
        self.assertEqual(len(states), 9)
        np.testing.assert_array_equal(self.run_.times, [state.time for state in states])
        np.testing.assert_allclose(self.run_.times, np.arange(9) / 2)
        np.testing.assert_array_equal(states.steps, [state.step for state in states])
        np.testing.assert_array_equal(states.n_bodies, [len(state) for state in states])
        self.assertGreater(states.n_bodies[-1], 4)
        for state, file in zip(states, files):
            with np.load(file) as recorded:
                for name, block in ARRAYS:
                    array = getattr(state, name)
                    self.assertEqual(array.tobytes(), recorded[block].astype(array.dtype).tobytes(), name)
                    self.assertFalse(array.flags.writeable)
        self.assertEqual([state.step for state in states[::-4]], [400, 200, 0])
        self.assertEqual(states[-1].step, states[8].step)
        for wrong in [9, -10]:
            with self.assertRaisesRegex(IndexError, "there are 9"):
                states[wrong]
        self.assertEqual(self.run_.at(1.49).time, 1.0)
        self.assertEqual(self.run_.at(0.1 + 0.2 + 0.7).time, 1.0)
        self.assertEqual(self.run_.at(99).time, 4.0)
        with self.assertRaisesRegex(ValueError, "the first is at 0.0"):
            self.run_.at(-1)

    def test_a_state_is_that_of_the_simulation(self):
        simulation = relcp.Simulation(colony())
        simulation.run()
        state = self.run_.states[-1]
        self.assertIsInstance(state, relcp.Bodies)
        for name in [name for name, _ in ARRAYS] + ["lengths", "shapes", "groups", "rates", "division_lengths"]:
            np.testing.assert_array_equal(getattr(state, name), getattr(simulation, name), name)
        self.assertEqual((state.shape_labels, state.group_labels), (simulation.shape_labels, simulation.group_labels))
        self.assertEqual((state.n_bodies, state.columns), (simulation.n_bodies, {}))
        for name in ["nematic", "contacts", "stress", "length"]:
            mine, theirs = state.measure(name), simulation.measure(name)
            np.testing.assert_equal(mine, theirs)
        here, there = state.contacts(), simulation.contacts(1e-3 * state.sizes[:, 0].min())
        self.assertGreater(len(here), 2)
        for name in ["pairs", "separation", "normal", "point_a", "gamma", "force"]:
            np.testing.assert_array_equal(getattr(here, name), getattr(there, name), name)
        self.assertEqual(len(state.contacts(-1.0)), 0)

    def test_missing_values_are_no_large_numbers(self):
        state = self.run_.states[-1]
        self.assertEqual((relcp.NO_GROUP, relcp.NO_PARENT), (-1, -1))
        self.assertEqual(set(state.groups), {-1})
        self.assertEqual(set(state.group_labels), {None})
        self.assertEqual(self.run_.states[0].parents.tolist(), [-1])
        self.assertTrue((state.parents >= 0).all())
        self.assertTrue((state.shapes == relcp.Shape.SPHEROCYLINDER).all())
        self.assertEqual(list(relcp.Shape), [0, 1, 2, 3, 5])  # 4 are custom shapes

    def test_tables_are_those_of_the_files(self):
        for name in ["steps", "measures", "lineage"]:
            table = getattr(self.run_, name)
            with open(self.path / f"{name}.csv", newline="") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual((table.n_rows, list(table)), (len(rows), list(rows[0])))
            for column, values in table.items():
                for value, row in zip(values, rows):
                    if isinstance(value, str):
                        self.assertEqual(value, row[column])
                    elif row[column] == "":
                        self.assertTrue(math.isnan(value))
                    else:
                        self.assertEqual(value, float(row[column]))
        self.assertEqual(self.run_.steps["step"].dtype, np.int64)
        self.assertEqual(self.run_.steps["residual"].dtype, np.float64)
        self.assertTrue(np.isnan(self.run_.steps["sliding"]).all())
        lives = self.run_.lineage
        self.assertTrue(np.isnan(lives["parent"][lives["id"] == 0]).all())
        self.assertEqual(set(lives["cause"]), {"division", "outside"})
        self.assertFalse(lives["time"].flags.writeable)
        with self.assertRaisesRegex(KeyError, "the columns are step, time, id"):
            lives["age"]
        self.assertIn("rows: step, time", repr(lives))

    def test_tables_as_data_frames(self):
        with unittest.mock.patch.dict(sys.modules, {"pandas": None}):
            with self.assertRaisesRegex(ImportError, "pip install pandas"):
                self.run_.steps.to_pandas()
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not installed")
        frame = self.run_.lineage.to_pandas()
        self.assertIsInstance(frame, pandas.DataFrame)
        self.assertEqual(list(frame.columns), list(self.run_.lineage))
        self.assertEqual(frame["parent"].isna().sum(), 1)
        self.assertEqual(set(frame[frame["cause"] == "division"]["rule"].isna()), {True})

    def test_measures_over_the_states(self):
        table = self.run_.measure("nematic")
        np.testing.assert_array_equal(table["time"], self.run_.times)
        np.testing.assert_array_equal(table["bodies"], self.run_.states.n_bodies)
        for name in table:
            if name not in ("step", "time", "bodies"):
                last = self.run_.states[-1].measure("nematic")[name]
                np.testing.assert_equal(table[name][-1], np.nan if last is None else last)
        written = self.run_.measures
        row = np.flatnonzero(written["step"] == 400)
        self.assertEqual(written["nematic_order"][row], table["nematic_order"][-1])
        self.assertIsNone(table.profile)
        profile = self.run_.measure("correlation", bin=0.5).profile
        self.assertEqual(profile["time"].max(), 4.0)
        alone = self.run_.states[-1].measure("correlation")["profile"]
        self.assertLessEqual(set(alone), set(profile))
        self.assertTrue(self.run_.measure("msd").n_rows == 9 and relcp.measures()["msd"])
        with self.assertRaisesRegex(ValueError, "unknown measure `nematicc`\nthe measures are nematic"):
            self.run_.measure("nematicc")
        with self.assertRaisesRegex(ValueError, "bin: expected a positive number"):
            self.run_.measure("correlation", bin=-1)

    def test_contacts_over_the_states(self):
        table = self.run_.contacts
        self.assertGreater(len(set(table["time"])), 4)
        last = self.run_.states[-1]
        rows = table["step"] == last.step
        here = last.contacts()
        self.assertEqual(rows.sum(), len(here))
        np.testing.assert_array_equal(table["id_a"][rows], last.ids[here.pairs[:, 0]])
        np.testing.assert_array_equal(table["gamma"][rows], here.gamma)
        force = np.stack([table[f"force_{axis}"] for axis in "xyz"], axis=1)
        np.testing.assert_allclose(np.linalg.norm(force, axis=1), table["gamma"], atol=1e-15)

    def test_exports_and_pages(self):
        with tempfile.TemporaryDirectory() as place:
            place = pathlib.Path(place)
            [file] = self.run_.export("xyz", place / "xyz")
            self.assertEqual(file, place / "xyz" / "run.xyz")
            self.assertEqual(sum(line.isdigit() for line in file.read_text().splitlines()), 9)
            self.assertGreater(len(self.run_.export("vtk", place / "vtk", cutoff=0.1, last=True)), 2)
            for wrong in [dict(format="xyzz"), dict(format="xyz", cutoff=0.1)]:
                with self.assertRaises(ValueError):
                    self.run_.export(**wrong)
            mine = self.run_.view(place / "mine.html", colour="generation")
            program("view", self.path, "--out", place / "theirs.html", "--colour", "generation")
            self.assertEqual(mine.read_bytes(), (place / "theirs.html").read_bytes())
            few = self.run_.view(place / "few.html", every=2, start=1, end=3)
            self.assertLess(few.stat().st_size, mine.stat().st_size)
            with self.assertRaisesRegex(ValueError, "none of the 9 states"):
                self.run_.view(place / "none.html", start=5)
            with self.assertRaisesRegex(relcp.RecordError, "absent"):
                self.run_.view(place / "absent" / "page.html")

    def test_runs_are_not_in_pickles_but_their_paths_are(self):
        again = pickle.loads(pickle.dumps(relcp.Run(self.path)))
        self.assertEqual((again.path, again.states[-1].step), (self.path, 400))


class Faults(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.place = pathlib.Path(place.name)

    def test_folders_that_are_none(self):
        (self.place / "empty").mkdir()
        for path, said in [("absent", "there is no such folder"), ("empty", "it has no scene.json")]:
            with self.assertRaisesRegex(relcp.RecordError, f"{path}: not the folder of a run: {said}"):
                relcp.Run(self.place / path)
        (self.place / "empty" / "scene.json").write_text('{"name": 3}')
        with self.assertRaisesRegex(relcp.SceneError, "scene.json"):
            relcp.Run(self.place / "empty")
        with self.assertRaises(TypeError):
            relcp.Run(3)

    def test_what_a_run_does_not_have_and_what_is_damaged(self):
        scene = relcp.Scene.load("two-ellipsoids", {"time.end": 0.5, "output.every": 0.1, "output.picture": False})
        run = relcp.run(scene, self.place / "run", progress=False)
        for name, said in [("measures", "output.measures"), ("lineage", "removal")]:
            with self.assertRaisesRegex(relcp.RecordError, f"run/{name}.csv: there is none; .*{said}"):
                getattr(run, name)
        self.assertTrue(run.states[-1].has_forces)
        self.assertFalse(run.states[2].has_forces)
        self.assertEqual(set(run.contacts["step"]) - {50}, set())
        near = run.states[2].contacts(9.0)
        self.assertTrue(np.isnan(near.gamma).all() and np.isnan(near.force).all() and len(near) == 1)
        rows = (run.path / "steps.csv").read_text()
        (run.path / "steps.csv").write_text(rows.replace("\n7,", "\nseven,"))
        with self.assertRaisesRegex(relcp.RecordError, "steps.csv: line 8: step: \"seven\" is not a whole number"):
            run.refresh().steps
        (run.path / "steps.csv").write_text(rows[:-5])
        self.assertEqual(run.steps.n_rows, 49)
        (run.path / "summary.json").write_text("{")
        with self.assertRaisesRegex(relcp.RecordError, "summary.json: "):
            run.summary
        state = run.path / "states" / "state_0000000020.npz"
        state.write_bytes(state.read_bytes()[:-40])
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            self.assertEqual(len(run.refresh().states), 5)
        self.assertIn("state_0000000020.npz: the file is truncated; it is left out", str(caught[0].message))

    def test_a_run_that_goes_on(self):
        scene = relcp.Scene.load("two-ellipsoids", {"time.end": 1, "output.every": 0.1, "output.picture": False})
        recording = Recording(scene, self.place / "run", "cpu", None, None, None, False, None, None, [], None, None)
        run = relcp.Run(self.place / "run")
        self.assertEqual((run.status, len(run.states), run.steps.n_rows), ("running", 1, 0))
        with self.assertRaisesRegex(relcp.RecordError, "none yet"):
            run.summary
        done, states = False, 0
        while not done:
            _, _, _, done = recording.advance(0.0)
            run.refresh()
            self.assertGreaterEqual(len(run.states), states)
            states = len(run.states)
            self.assertEqual(run.steps.n_rows, 0 if run.steps.n_rows == 0 else run.steps["step"][-1])
        self.assertGreater(run.steps.n_rows, 80)
        recording.finish()
        self.assertEqual((run.refresh().status, len(run.states), run.steps.n_rows), ("done", 11, 100))

    def test_states_with_columns_and_changes(self):
        class Marks:
            def update(self, cells):
                cells["mark"] = cells.ids + 0.5
                cells.rates = np.full(len(cells), 0.25)

        short = {"time.dt": 0.02, "time.end": 1, "output.every": 0.5, "output.picture": False}
        scene = relcp.Scene.load("colony", short)
        run = relcp.run(scene, self.place / "ruled", rules=Marks(), progress=False)
        last = run.states[-1]
        np.testing.assert_array_equal(last.columns["mark"], last.ids + 0.5)
        np.testing.assert_array_equal(last.rates, 0.25)
        changes = [{"at": 0.5, "set": {"growth.rate": 0.5}}]
        run = relcp.run(relcp.Scene(scene.to_dict(), {"changes": changes}), self.place / "changed", progress=False)
        rates = [state.rates[0] for state in run.states]
        self.assertEqual(rates[0], rates[1])
        self.assertNotEqual(rates[1], rates[2])

    def test_a_forked_process_reads_runs(self):
        if not hasattr(os, "fork"):
            self.skipTest("no fork")
        scene = relcp.Scene.load("two-ellipsoids", {"time.end": 0.2, "output.picture": False})
        relcp.run(scene, self.place / "run", progress=False)
        code = (
            "import os, sys, relcp\n"
            "run = relcp.Run(sys.argv[1])\n"
            "run.render(width=64), run.times\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    os._exit(0 if run.refresh().render(width=64).shape == (36, 64, 4) and len(run.times) > 1 else 1)\n"
            "sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) if hasattr(os, 'waitstatus_to_exitcode')\n"
            "         else os.waitpid(child, 0)[1])\n"
        )
        subprocess.run([sys.executable, "-W", "ignore", "-c", code, self.place / "run"], check=True, timeout=120)


if __name__ == "__main__":
    unittest.main()
