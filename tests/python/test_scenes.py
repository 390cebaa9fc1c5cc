"""Scenes from names, files, text and dicts, and what is said of bad ones."""

import copy
import json
import pathlib
import pickle
import tempfile
import unittest

import numpy as np
import relcp

BALL = {
    "name": "ball",
    "time": {"dt": 0.1, "end": 1},
    "bodies": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]}],
}


class Scenes(unittest.TestCase):
    def test_all_ways_lead_to_the_same_scene(self):
        text = json.dumps(BALL)
        scenes = [relcp.Scene.from_dict(BALL), relcp.Scene.from_json(text)]
        with tempfile.TemporaryDirectory() as place:
            path = pathlib.Path(place) / "ball.json"
            path.write_text(text)
            scenes += [relcp.Scene.load(path), relcp.Scene.load(str(path))]
        arrays = copy.deepcopy(BALL)
        arrays["bodies"][0]["position"] = np.zeros(3)
        arrays["time"]["dt"] = np.float64(0.1)
        arrays["seed"] = np.int64(0)
        scenes.append(relcp.Scene.from_dict(arrays))
        for scene in scenes:
            self.assertEqual(scene, scenes[0])
            self.assertEqual(scene.hash, scenes[0].hash)
        self.assertEqual((scene.name, scene.dt, scene.end, scene.steps, scene.planar), ("ball", 0.1, 1.0, 10, False))
        self.assertEqual(relcp.Scene.from_dict(scene.to_dict()), scene)
        self.assertEqual(relcp.Scene.from_json(scene.to_json()), scene)

    def test_overrides(self):
        for overrides in [{"time.dt": 0.05, "contact.method": "snsd"}, ["time.dt=0.05", "contact.method=snsd"]]:
            scene = relcp.Scene.load("two-ellipsoids", overrides)
            self.assertEqual((scene.dt, scene.to_dict()["contact"]["method"]), (0.05, "snsd"))
        moved = relcp.Scene.from_dict(BALL, {"bodies.0.position": np.array([1.0, 2.0, 3.0])})
        self.assertEqual(relcp.Simulation(moved).positions.tolist(), [[1.0, 2.0, 3.0]])
        self.assertEqual(relcp.Scene.load("colony", "time.end=2").end, 2.0)

    def test_the_built_in_ones(self):
        self.assertIn("two-ellipsoids", relcp.scenes())
        for name in relcp.scenes():
            self.assertEqual(relcp.Scene.load(name).name, name)


class BadScenes(unittest.TestCase):
    def refused(self, make):
        with self.assertRaises(relcp.SceneError) as caught:
            make()
        self.assertIsInstance(caught.exception, relcp.Error)
        return caught.exception

    def test_line_and_column(self):
        fault = self.refused(lambda: relcp.Scene.from_json('{\n  "name": "x",\n  "tme": {}\n}', origin="x.json"))
        self.assertEqual((fault.line, fault.column, fault.key, fault.origin), (3, 3, "tme", "x.json"))
        self.assertEqual(fault.kind, "unknown_key")
        self.assertTrue(str(fault).startswith("x.json:3:3: tme: "), fault)
        self.assertIn("`time`", fault.message)
        back = pickle.loads(pickle.dumps(fault))
        self.assertEqual((type(back), str(back), back.line), (relcp.SceneError, str(fault), 3))

    def test_syntax(self):
        fault = self.refused(lambda: relcp.Scene.from_json('{\n  "name": oops\n}'))
        self.assertEqual((fault.kind, fault.line), ("syntax", 2))
        self.assertGreaterEqual(fault.column, 11)

    def test_a_dict_has_keys_only(self):
        bad = copy.deepcopy(BALL)
        bad["bodies"][0]["shape"]["sphere"]["radius"] = -1
        fault = self.refused(lambda: relcp.Scene.from_dict(bad))
        self.assertEqual((fault.key, fault.line, fault.column), ("bodies.0.shape.sphere.radius", None, None))
        self.assertTrue(str(fault).startswith("bodies.0.shape.sphere.radius: "), fault)

    def test_values_that_are_not_json(self):
        for value in [float("nan"), np.array([1.0, np.inf, 0.0]), object(), {1, 2}]:
            bad = copy.deepcopy(BALL)
            bad["bodies"][0]["position"] = value
            self.assertEqual(self.refused(lambda: relcp.Scene.from_dict(bad)).line, None)

    def test_overrides(self):
        for overrides, origin, key in [
            ({"time.ent": 2}, 'overrides["time.ent"]', "time.ent"),
            ({"time.end": "soon"}, 'overrides["time.end"]', "time.end"),
            ({"time.dt": -1}, 'overrides["time.dt"]', "time.dt"),
            ({"time..dt": 1}, 'overrides["time..dt"]', "time..dt"),
            ({"time.dt.x": 1}, 'overrides["time.dt.x"]', "time.dt.x"),
            ({"time=dt": 1}, 'overrides["time=dt"]', "time=dt"),
            ({"contact.method": {"multisphere": {}}}, 'overrides["contact.method"]', "contact.method.multisphere"),
            (["time.dt=0.1", "time.ent=2"], 'overrides[1] "time.ent=2"', "time.ent"),
            (["time.end"], 'overrides[0] "time.end"', ""),
            ("time.end", 'overrides "time.end"', ""),
        ]:
            for make in [
                lambda: relcp.Scene.load("colony", overrides),
                lambda: relcp.Scene.from_dict(BALL, overrides),
                lambda: relcp.Scene.from_json(json.dumps(BALL), overrides),
            ]:
                fault = self.refused(make)
                self.assertTrue(fault.key.startswith(key), fault)
                self.assertEqual(fault.origin, origin)
                self.assertTrue(str(fault).startswith(origin + ": "), fault)
        fault = self.refused(lambda: relcp.Scene.load("colony", {"time.dt": float("nan")}))
        self.assertTrue(str(fault).startswith('overrides["time.dt"]: expected '), fault)

    def test_files(self):
        fault = self.refused(lambda: relcp.Scene.load("two-elipsoids"))
        self.assertEqual(fault.kind, "unknown_scene")
        self.assertIn("two-ellipsoids", fault.help)

    def test_bodies_without_a_place(self):
        crowded = {"isotropic": {"count": 50, "shape": {"sphere": {"radius": 1}}, "volume_fraction": 0.6}}
        self.refused(lambda: relcp.Simulation(relcp.Scene.from_dict({**BALL, "bodies": [], "generate": [crowded]})))


class Words(unittest.TestCase):
    def test_no_message_speaks_of_the_program_and_its_options(self):
        ball = relcp.Scene.from_dict(BALL)
        with tempfile.TemporaryDirectory() as place:
            state = pathlib.Path(place) / "state.npz"
            relcp.Simulation(ball).save(state)
            torn = pathlib.Path(place) / "torn.npz"
            torn.write_bytes(state.read_bytes()[:100])
            other = relcp.Scene.load("three-capsules")
            cases = [
                lambda: relcp.Scene.load("colony", {"time.dt": -1}),
                lambda: relcp.Scene.load("colony", ["time.dt"]),
                lambda: relcp.Scene.load("colny"),
                lambda: relcp.Scene.from_dict({**BALL, "seed": -1}),
                lambda: relcp.Scene.from_json("{"),
                lambda: relcp.Simulation(ball, backend="tpu"),
                lambda: relcp.Simulation(ball, threads=0),
                lambda: relcp.Simulation(ball, precision="f16"),
                lambda: relcp.Simulation(ball, precision="f32"),
                lambda: relcp.Simulation(ball, adapter="x"),
                lambda: relcp.Simulation(ball, backend="gpu", adapter="no-such-adapter"),
                lambda: relcp.Simulation(ball, backend="auto", adapter="no-such-adapter"),
                lambda: relcp.Simulation(ball).step(0),
                lambda: relcp.Simulation(ball).contacts(float("inf")),
                lambda: relcp.Simulation(ball).save(pathlib.Path(place) / "no" / "state.npz"),
                lambda: relcp.Simulation.resume(ball, pathlib.Path(place) / "none.npz"),
                lambda: relcp.Simulation.resume(ball, torn),
                lambda: relcp.Simulation.resume(other, state),
            ]
            for case in cases:
                with self.assertRaises((relcp.Error, ValueError)) as caught:
                    case()
                message = f"{caught.exception} {getattr(caught.exception, 'help', '')}"
                self.assertNotRegex(message, r"(^|[\s`'\"(])--?[a-z]|relcp [a-z]", message)


if __name__ == "__main__":
    unittest.main()
