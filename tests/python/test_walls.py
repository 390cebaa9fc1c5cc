"""Forces on walls, of a simulation and of recorded states."""

import pathlib
import tempfile
import unittest

import numpy as np
import relcp

WEIGHT = 2.0


def heap(**changes):
    rod = {"spherocylinder": {"diameter": 0.5, "length": 2}}
    return relcp.Scene({
        "name": "heap", "planar": True, "time": {"dt": 0.01, "end": 12}, "solver": {"tolerance": 1e-9},
        "walls": [{"box": {"minimum": [0, 0, -1], "maximum": [5, 8, 1]}}],
        "forces": [{"uniform": {"force": [0, -WEIGHT, 0]}}],
        "generate": [{"isotropic": {"count": 12, "shape": rod}}], "output": {"every": 6, "picture": False}, **changes,
    })  # fmt: skip


class Walls(unittest.TestCase):
    def test_a_box_bears_what_is_in_it(self):
        simulation = relcp.Simulation(heap())
        simulation.run()
        found = simulation.wall_contacts(1e-3)
        np.testing.assert_allclose(found.force.sum(axis=0), [0, -12 * WEIGHT, 0], atol=2e-3)
        self.assertEqual(set(found.wall), {0})
        # Low and high side along x, then along y: nothing touches the top.
        self.assertLessEqual(set(found.face), {0, 1, 2})
        np.testing.assert_allclose((found.force * found.normal).sum(axis=1), found.gamma, rtol=1e-12)
        measured = simulation.measure("walls")
        self.assertAlmostEqual(measured["wall_force"], found.gamma.sum(), places=9)
        self.assertAlmostEqual(measured["wall_force_y"], -12 * WEIGHT, places=2)
        self.assertIsNone(measured["wall_force_z"])
        profile = measured["profile"]
        floor = found.gamma[found.face == 2].sum()
        self.assertAlmostEqual(profile["normal_force"][2], floor, places=9)
        self.assertAlmostEqual(profile["pressure"][2], floor / 5, places=9)
        np.testing.assert_array_equal(profile["area"], [8, 8, 5, 5])

    def test_states_and_runs_have_them_too(self):
        with tempfile.TemporaryDirectory() as place:
            path = pathlib.Path(place) / "run"
            run = relcp.run(heap(output={"every": 6, "forces": True, "picture": False, "measures": ["walls"]}), path)
            simulation = relcp.Simulation(heap())
            simulation.run()
            last = run.states[-1]
            for name in ["body", "wall", "face", "separation", "normal", "point", "gamma", "force"]:
                mine, theirs = getattr(last.wall_contacts(1e-3), name), getattr(simulation.wall_contacts(1e-3), name)
                np.testing.assert_array_equal(mine, theirs, name)
            self.assertGreater(len(last.wall_contacts()), 2)
            table = run.measure("walls")
            self.assertAlmostEqual(table["wall_force_y"][-1], -12 * WEIGHT, places=2)
            self.assertTrue(np.isnan(table["wall_force"][0]), "there is no force before the first step")
            self.assertAlmostEqual(run.measures["wall_force_y"][-1], table["wall_force_y"][-1], places=9)
            self.assertEqual(table.profile.n_rows, 8)
            with self.assertRaisesRegex(ValueError, "finite"):
                last.wall_contacts(np.nan)

    def test_forces_that_are_not_known_are_nan(self):
        with tempfile.TemporaryDirectory() as place:
            run = relcp.run(heap(), pathlib.Path(place) / "run", progress=False)
            middle = run.states[1].wall_contacts(0.1)
            self.assertGreater(len(middle), 0)
            self.assertTrue(np.isnan(middle.gamma).all() and np.isnan(middle.force).all())

    def test_a_scene_without_walls_has_none(self):
        simulation = relcp.Simulation(relcp.Scene.load("three-capsules"))
        simulation.step()
        self.assertEqual(len(simulation.wall_contacts(9)), 0)
        self.assertIn("no walls", simulation.measure("walls")["remark"])


if __name__ == "__main__":
    unittest.main()
