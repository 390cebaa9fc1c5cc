"""A scene that is stepped from Python gives the same bits as the program."""

import json
import os
import pathlib
import tempfile
import unittest

import numpy as np
import relcp
from program import relcp as program


class SameBits(unittest.TestCase):
    def compare(self, name, *sets):
        scene = relcp.Scene.load(name, list(sets))
        simulation = relcp.Simulation(scene)
        summary = simulation.run()
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place) / "run"
            options = [part for each in sets for part in ("--set", each)]
            program("run", name, "--backend", "cpu", "--quiet", "--out", folder, *options)
            theirs = json.loads((folder / "summary.json").read_text())
            final = json.loads((folder / "final.json").read_text())
            state = np.load(folder / "checkpoint.npz")
            position, orientation = state["position"], state["orientation"]
            for array, block in [
                (simulation.positions, "position"),
                (simulation.orientations, "orientation"),
                (simulation.velocities, "velocity"),
                (simulation.angular_velocities, "angular_velocity"),
                (simulation.sizes, "size"),
                (simulation.ids, "id"),
                (simulation.parents, "parent"),
                (simulation.births, "birth"),
                (simulation.generations, "generation"),
            ]:
                self.assertEqual(array.shape, state[block].shape, block)
                self.assertEqual(array.tobytes(), state[block].astype(array.dtype).tobytes(), block)
            resumed = relcp.Simulation.resume(scene, folder / "checkpoint.npz")
            self.assertEqual(resumed.state_hash, simulation.state_hash)
        self.assertEqual(theirs["state_hash"], simulation.state_hash)
        self.assertEqual(theirs["scene_hash"], scene.hash)
        for key in ["steps", "time", "bodies", "max_overlap", "final_max_overlap", "status"]:
            self.assertEqual(theirs[key], summary[key], key)
        for key in ["iterations", "products", "worst_residual"]:
            self.assertEqual(theirs["solver"][key], summary["solver"][key], key)
        written = np.array([body["position"] for body in final["bodies"]])
        self.assertEqual(written.tobytes(), position.tobytes())
        turned = np.array([body["orientation"] for body in final["bodies"]])
        self.assertLess(np.abs(turned - orientation).max(), 1e-12)
        self.assertEqual(simulation.final_scene().to_dict(), final)

    def test_two_ellipsoids(self):
        self.compare("two-ellipsoids")

    def test_every_built_in_scene(self):
        # All begin as they are given, and end after a few steps: fewer where there are thousands of bodies. With
        # RELCP_ALL_SCENES set those of usual size run to their ends.
        whole = "RELCP_ALL_SCENES" in os.environ
        for name in relcp.scenes():
            with self.subTest(scene=name):
                scene = relcp.Scene.load(name)
                steps = 2 if name.endswith("-full") else scene.steps if whole else 8
                end = scene.start + min(steps, scene.steps) * scene.dt
                self.compare(name, f"time.end={end!r}", "output.picture=false")

    def test_a_growing_colony(self):
        self.compare("colony", "time.end=3.0")

    def test_threads_do_not_matter(self):
        scene = relcp.Scene.load("colony", {"time.end": 2.5})
        hashes = set()
        for threads in [1, 2, 5]:
            simulation = relcp.Simulation(scene, threads=threads)
            simulation.run()
            hashes.add(simulation.state_hash)
        self.assertEqual(len(hashes), 1)

    def test_a_saved_state_goes_on_to_the_same_bits(self):
        scene = relcp.Scene.load("colony", {"time.end": 2.0})
        through = relcp.Simulation(scene)
        summary = through.run()
        half = relcp.Simulation(scene)
        half.step(1000)
        with tempfile.TemporaryDirectory() as place:
            path = pathlib.Path(place) / "half.npz"
            half.save(path)
            resumed = relcp.Simulation.resume(scene, path)
            self.assertEqual(np.load(path)["position"].tobytes(), half.positions.tobytes())
            other = relcp.Scene.load("colony", {"time.end": 2.1})
            with self.assertRaisesRegex(relcp.RecordError, "a different scene"):
                relcp.Simulation.resume(other, path)
            path.write_bytes(path.read_bytes()[:-40])
            with self.assertRaises(relcp.RecordError):
                relcp.Simulation.resume(scene, path)
        with self.assertRaisesRegex(relcp.RecordError, "No such file"):
            relcp.Simulation.resume(scene, path)
        self.assertEqual(resumed.steps, 1000)
        again = resumed.run()
        self.assertEqual(resumed.state_hash, through.state_hash)
        self.assertEqual(again["solver"]["products"], summary["solver"]["products"])


if __name__ == "__main__":
    unittest.main()
