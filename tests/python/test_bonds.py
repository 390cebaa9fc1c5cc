"""Bonds of a simulation and of recorded states."""

import pathlib
import tempfile
import unittest

import numpy as np
import relcp

WEIGHT = 2.0
LENGTH = 1.3


def hanging(**keys):
    bodies = [{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, -LENGTH * i]} for i in range(6)]
    bodies[0]["fixed"] = True
    bond = {"at": [[0, 0, 0], [0, 0, 0]], "length": LENGTH, "stiffness": "rigid", **keys}
    return relcp.Scene({
        "name": "hanging", "time": {"dt": 0.01, "end": 4}, "dynamics": {"overdamped": {"drag": 1}},
        "forces": [{"uniform": {"force": [0, 0, -WEIGHT]}}], "solver": {"tolerance": 1e-9}, "bodies": bodies,
        "bonds": [{"bodies": [i, i + 1], **bond} for i in range(5)],
        "output": {"every": 2, "forces": True, "picture": False},
    })  # fmt: skip


class Bonds(unittest.TestCase):
    def test_a_hanging_chain_carries_5_4_3_2_and_1_weights(self):
        simulation = relcp.Simulation(hanging())
        np.testing.assert_array_equal(simulation.bonds.tension, np.zeros(5))
        simulation.run()
        bonds = simulation.bonds
        self.assertEqual(len(bonds), 5)
        np.testing.assert_array_equal(bonds.number, range(5))
        np.testing.assert_array_equal(bonds.bodies, [[i, i + 1] for i in range(5)])
        np.testing.assert_allclose(bonds.tension, WEIGHT * np.arange(5, 0, -1), atol=2e-3)
        np.testing.assert_allclose(bonds.force[:, 2], bonds.tension, rtol=1e-12)
        np.testing.assert_allclose(bonds.length, LENGTH, atol=2e-5)
        np.testing.assert_array_equal(bonds.rest_length, LENGTH)
        np.testing.assert_array_equal(bonds.point_a, simulation.positions[:-1])
        np.testing.assert_allclose(bonds.point_b, simulation.positions[1:], atol=1e-12)
        self.assertTrue(bonds.contact.all())
        with self.assertRaises(ValueError):
            bonds.tension[0] = 1

    def test_states_have_them_and_broken_ones_are_gone(self):
        with tempfile.TemporaryDirectory() as place:
            run = relcp.run(hanging(break_force=4.5 * WEIGHT), pathlib.Path(place) / "run")
            first, last = run.states[0].bonds, run.states[-1].bonds
            np.testing.assert_array_equal(first.number, range(5))
            np.testing.assert_array_equal(last.number, range(1, 5))
            np.testing.assert_allclose(last.tension, 0, atol=2e-3)
            self.assertEqual(repr(last), "Bonds(4)")


if __name__ == "__main__":
    unittest.main()
