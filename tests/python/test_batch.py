"""Sweeps from Python: the folders, the table and the bits of `relcp batch`."""

import csv
import importlib.util
import json
import pathlib
import tempfile
import unittest
import warnings

import numpy as np
import relcp
from program import relcp as program


def scene():
    return relcp.Scene.load("two-ellipsoids", {"time.end": 1.0, "output.picture": False, "output.every": 0.5})


class Batches(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.place = pathlib.Path(place.name)

    def test_it_is_that_of_the_program(self):
        out = self.place / "mine"
        batch = relcp.batch(scene(), {"time.dt": np.array([0.1, 0.05])}, seeds=[1, 4], out=out, progress=False)
        self.assertEqual((len(batch), batch.path, set(batch.table["status"])), (4, out, {"done"}))
        np.testing.assert_array_equal(batch.table["time.dt"], [0.1, 0.1, 0.05, 0.05])
        np.testing.assert_array_equal(batch.table["seed"], [1, 4, 1, 4])
        np.testing.assert_array_equal(batch.table["steps"], [10, 10, 20, 20])
        sweep = {
            "name": "theirs", "scene": str(out / "scene.json"), "grid": {"time.dt": [0.1, 0.05]}, "seeds": [1, 4],
        }  # fmt: skip
        (self.place / "theirs.json").write_text(json.dumps(sweep))
        program("batch", self.place / "theirs.json", "--out", self.place / "theirs", "--quiet")
        with open(self.place / "theirs" / "batch.csv") as file:
            theirs = list(csv.DictReader(file))
        self.assertEqual(batch.table["state_hash"], [row["state_hash"] for row in theirs])
        self.assertEqual(batch.table["folder"], [row["folder"] for row in theirs])
        self.assertEqual(batch[2].steps.n_rows, 20)
        self.assertEqual([run.scene.seed for run in batch], [1, 4, 1, 4])
        self.assertEqual(len(batch[1:3]), 2)
        with self.assertRaisesRegex(IndexError, "there are 4"):
            batch[4]
        self.assertIn("4 done", repr(batch))
        # The program goes on with the folder.
        said = program("batch", out / "sweep.json", "--out", out, "--list")
        self.assertEqual(len(said.splitlines()), 4)
        program("batch", out / "sweep.json", "--out", out, "--quiet")

    def test_what_has_ended_is_left_alone_and_a_longer_sweep_adds_to_it(self):
        out = self.place / "sweep"
        first = relcp.batch(scene(), seeds=2, out=out, progress=False)
        times = [(run.path / "summary.json").stat().st_mtime_ns for run in first]
        more = relcp.batch(scene(), seeds=3, out=out, jobs=2, threads=2, progress=False)
        self.assertEqual([(run.path / "summary.json").stat().st_mtime_ns for run in more[:2]], times)
        self.assertEqual(len(more), 3)
        alone = relcp.Simulation(relcp.Scene.from_json(scene().to_json(), {"seed": 3}))
        alone.run()
        self.assertEqual(more.table["state_hash"][2], alone.state_hash)

    def test_lists_files_and_names(self):
        list_ = [{"contact.method": "relcp"}, {"contact.method": "snsd", "contact.overlap_tolerance": 1e-3}]
        file = self.place / "own.json"
        file.write_text(scene().to_json())
        for of in [file, "two-ellipsoids"]:
            out = self.place / pathlib.Path(of).stem
            set_ = {"time.end": 0.2, "time.dt": 0.05, "output.picture": False}
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                batch = relcp.batch(of, list=list_, set=set_, out=out, progress=False)
            self.assertEqual(batch.table["contact.method"], ["relcp", "snsd"])
            np.testing.assert_array_equal(batch.table["steps"], [4, 4])
        (self.place / "sweep.json").write_text(json.dumps({"name": "s", "scene": "own.json", "seeds": [5]}))
        batch = relcp.batch(sweep=self.place / "sweep.json", out=self.place / "s", progress=False)
        self.assertEqual(batch.table["seed"].tolist(), [5])

    def test_a_member_that_fails_is_in_the_table_and_counted(self):
        region = {"box": {"minimum": [0, 0, 0], "maximum": [6, 6, 6]}}
        crowd = {"count": 60, "shape": {"sphere": {"radius": 0.5}}, "region": region}
        full = relcp.Scene({
            "name": "full", "time": {"dt": 0.1, "end": 0.2}, "output": {"picture": False},
            "generate": [{"isotropic": crowd}],
        })  # fmt: skip
        out = self.place / "full"
        with self.assertWarnsRegex(RuntimeWarning, "1 of 2 members did not reach their end"):
            batch = relcp.batch(full, {"generate.0.isotropic.count": [60, 400]}, out=out, progress=False)
        self.assertEqual(batch.table["status"], ["done", "failed"])
        self.assertIn("placed", batch.table["message"][1])
        self.assertTrue(np.isnan(batch.table["steps"][1]))

    def test_what_cannot_be_is_refused_before_anything_runs(self):
        out = self.place / "no"
        for arguments, raised, said in [
            ({"grid": {"time.dt": 0.1}}, TypeError, "time.dt needs a list of values"),
            ({"grid": {"time.dt": "0.1"}}, TypeError, "needs a list"),
            ({"grid": {"time.dd": [0.1]}}, relcp.SceneError, "unknown key `dd`"),
            ({"grid": {"time.dt": [-0.1]}}, relcp.SceneError, "time.dt"),
            ({"seeds": 0}, ValueError, "seeds: expected at least one"),
            ({"seeds": [1, 1]}, relcp.SceneError, "are the same scene"),
            ({"seeds": ["a"]}, TypeError, ""),
            ({"jobs": 0}, ValueError, "jobs"),
            ({"threads": 0}, ValueError, "threads"),
            ({"backend": "auto"}, ValueError, "backend"),
        ]:
            with self.assertRaisesRegex(raised, said, msg=arguments):
                relcp.batch(scene(), out=out, progress=False, **arguments)
            self.assertFalse(out.exists(), arguments)
        with self.assertRaisesRegex(ValueError, "a sweep file has the scene"):
            relcp.batch(scene(), sweep="x.json")
        with self.assertRaises(TypeError):
            relcp.batch()

    def test_ctrl_c_stops_all_and_the_same_call_goes_on(self):
        import _thread
        import threading
        import time

        long = relcp.Scene.load("colony", {"time.dt": 0.001, "time.end": 4, "output.picture": False})
        out = self.place / "long"
        ended = threading.Event()

        def interrupt():
            while not any(out.glob("*/scene.json")) and not ended.is_set():
                time.sleep(0.01)
            if not ended.is_set():
                _thread.interrupt_main()

        key = threading.Thread(target=interrupt)
        key.start()
        try:
            with self.assertRaises(KeyboardInterrupt):
                relcp.batch(long, seeds=2, out=out, progress=False)
        finally:
            ended.set()
            key.join()
        statuses = {relcp.Run(path).status for path in out.iterdir() if path.is_dir()}
        self.assertEqual(statuses, {"interrupted"})
        batch = relcp.batch(long, seeds=2, out=out, progress=False)
        alone = relcp.Simulation(relcp.Scene.from_json(long.to_json(), {"seed": 1}))
        alone.run()
        self.assertEqual(batch.table["state_hash"][0], alone.state_hash)

    def test_a_device_runs_them_as_an_ensemble(self):
        if not any(device["taken"] for device in relcp.devices()):
            self.skipTest("there is no adapter")
        out = self.place / "device"
        batch = relcp.batch(scene(), seeds=2, out=out, backend="gpu", precision="f32", progress=False)
        self.assertEqual((batch.table["status"], batch.table["backend"]), (["done"] * 2, ["gpu"] * 2))


class Datasets(unittest.TestCase):
    def test_a_run_is_a_dataset_over_time_and_ids(self):
        if importlib.util.find_spec("xarray") is None:
            self.skipTest("xarray is not installed")
        with tempfile.TemporaryDirectory() as place:
            changes = {"time.dt": 0.01, "time.end": 2, "output.every": 0.5, "output.picture": False}
            run = relcp.run(relcp.Scene.load("colony", changes), pathlib.Path(place) / "run", progress=False)
            data = run.to_xarray()
            self.assertEqual(dict(data.sizes), {"time": 5, "id": 7, "space": 3, "quaternion": 4})
            for nth, state in enumerate(run.states):
                there = data.isel(time=nth).sel(id=state.ids)
                np.testing.assert_array_equal(there.position, state.positions)
                np.testing.assert_array_equal(there.length, state.lengths)
                np.testing.assert_array_equal(there.parent, state.parents)
                self.assertEqual(int(data.length.isel(time=nth).notnull().sum()), len(state))
            self.assertTrue(np.isnan(data.group).all())
            self.assertAlmostEqual(float(data.length.sum("id")[-1]), 2.0 * np.exp(2.0), places=9)
            self.assertEqual(data.attrs["scene"], "colony")

    def test_it_says_what_is_missing(self):
        from unittest import mock

        with mock.patch.dict("sys.modules", {"xarray": None}), tempfile.TemporaryDirectory() as place:
            run = relcp.run(scene(), pathlib.Path(place) / "run", progress=False)
            with self.assertRaisesRegex(ImportError, "pip install xarray"):
                run.to_xarray()


if __name__ == "__main__":
    unittest.main()
