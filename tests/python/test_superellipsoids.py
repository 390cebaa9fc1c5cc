"""Superellipsoids: their numbers, steps, pickles, bodies that are added, a run's folder, refusals."""

import pathlib
import pickle
import tempfile
import unittest

import numpy as np
import relcp

DIE = {"superellipsoid": {"radii": [0.5, 0.5, 0.5], "exponents": [8, 8]}}
BRICK = {"superellipsoid": {"radii": [0.3, 0.4, 0.8], "exponents": [6, 3]}}


def crowd(**changes):
    """Dice, bricks and a ball that are drawn together."""
    shapes = [DIE, BRICK, {"sphere": {"radius": 0.4}}]
    bodies = [
        {"shape": shapes[i % 3], "position": [1.6 * (i % 2), 1.6 * (i // 2 % 2), 1.6 * (i // 4)], "axis": [1, i, 2]}
        for i in range(8)
    ]
    scene = {
        "name": "crowd",
        "time": {"dt": 0.02, "end": 0.4},
        "forces": [{"trap": {"stiffness": 4, "center": [0.8, 0.8, 0.8]}}],
        "bodies": bodies,
        "output": {"every": 0.1},
    }
    return relcp.Scene(scene, changes)


class Superellipsoids(unittest.TestCase):
    def test_their_numbers(self):
        simulation = relcp.Simulation(crowd())
        kinds = [relcp.Shape.SUPERELLIPSOID, relcp.Shape.SUPERELLIPSOID, relcp.Shape.SPHERE]
        np.testing.assert_array_equal(simulation.shapes, [kinds[i % 3] for i in range(8)])
        np.testing.assert_array_equal(simulation.sizes[:2], [[0.5, 0.5, 0.5], [0.3, 0.4, 0.8]])
        np.testing.assert_array_equal(simulation.exponents, [[[8, 8], [6, 3], [0, 0]][i % 3] for i in range(8)])
        # A corner is where x = y = z: 3 (x / a)^8 = 1.
        self.assertAlmostEqual(simulation.lengths[0], 2 * 0.5 * 3 ** (0.5 - 1 / 8), places=12)

    def test_a_pickle_goes_on_to_the_same_bits(self):
        whole, broken = relcp.Simulation(crowd()), relcp.Simulation(crowd())
        broken.step(7)
        broken = pickle.loads(pickle.dumps(broken))
        whole.run()
        broken.run()
        np.testing.assert_array_equal(broken.positions, whole.positions)
        np.testing.assert_array_equal(broken.orientations, whole.orientations)
        self.assertGreater(len(whole.contacts(1e-3)), 3)

    def test_forces_and_rules_see_exponents(self):
        seen = []

        def force(bodies):
            seen.append(bodies.exponents)
            return -bodies.positions

        simulation = relcp.Simulation(crowd())
        simulation.add_force(force)
        simulation.step(1)
        np.testing.assert_array_equal(seen[0], simulation.exponents)

    def test_many_are_added_from_arrays(self):
        simulation = relcp.Simulation(crowd())
        radii, exponents = np.linspace(0.2, 0.4, 15).reshape(5, 3), np.linspace(2, 10, 10).reshape(5, 2)
        simulation.add(
            [
                {"shape": {"superellipsoid": {"radii": r.tolist(), "exponents": n.tolist()}}, "position": [3 * i, 9, 9]}
                for i, (r, n) in enumerate(zip(radii, exponents))
            ]
        )
        np.testing.assert_array_equal(simulation.sizes[-5:], radii)
        np.testing.assert_array_equal(simulation.exponents[-5:], exponents)
        self.assertLess(simulation.step(3).max_overlap, 1e-5)

    def test_bodies_are_added(self):
        simulation = relcp.Simulation(crowd())
        simulation.add([{"shape": BRICK, "position": [9, 9, 9]}])
        self.assertEqual(simulation.shapes[-1], relcp.Shape.SUPERELLIPSOID)
        np.testing.assert_array_equal(simulation.sizes[-1], [0.3, 0.4, 0.8])
        np.testing.assert_array_equal(simulation.exponents[-1], [6, 3])
        self.assertLess(simulation.step(3).max_overlap, 1e-5)

    def test_a_run_is_read_back(self):
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place) / "run"
            last = relcp.run(crowd(), folder).states[-1]
            simulation = relcp.Simulation(crowd())
            simulation.run()
            np.testing.assert_array_equal(last.positions, simulation.positions)
            np.testing.assert_array_equal(last.shapes, simulation.shapes)
            np.testing.assert_array_equal(last.exponents, simulation.exponents)
            self.assertEqual(last.shape_labels[:3], ["superellipsoid", "superellipsoid", "sphere"])

    def test_what_is_refused_names_the_key(self):
        for exponents, key in [([0.8, 2], "exponents.0"), ([2, 30], "exponents.1")]:
            with self.assertRaisesRegex(relcp.SceneError, key):
                relcp.Scene(
                    {
                        "name": "one",
                        "time": {"dt": 0.1, "end": 1},
                        "bodies": [
                            {
                                "shape": {"superellipsoid": {"radii": [1, 1, 1], "exponents": exponents}},
                                "position": [0, 0, 0],
                            }
                        ],
                    }
                )


if __name__ == "__main__":
    unittest.main()
