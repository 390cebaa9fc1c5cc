"""Many scenes that are run together."""

import unittest

import numpy as np
import relcp


def scenes(count):
    return [relcp.Scene.load("colony", {"seed": seed, "time.dt": 0.01, "time.end": 1.2}) for seed in range(1, 1 + count)]


def alone(scene, backend="cpu"):
    simulation = relcp.Simulation(scene, backend=backend)
    simulation.run()
    return simulation.state_hash


class Ensembles(unittest.TestCase):
    def check_members(self, backend):
        ensemble = relcp.Ensemble(scenes(4), backend=backend)
        self.assertEqual(ensemble.run(), [None] * 4)
        hashes = [member.state_hash for member in ensemble]
        self.assertEqual(hashes, [alone(scene, backend) for scene in scenes(4)])
        self.assertEqual(len(set(hashes)), 4)
        self.assertTrue(all(isinstance(member.positions, np.ndarray) for member in ensemble))
        self.assertEqual([summary["seed"] for summary in ensemble.summaries()], [1, 2, 3, 4])

    def test_members_have_the_bits_of_their_scenes_alone(self):
        self.check_members("cpu")

    @unittest.skipUnless(any(device["taken"] for device in relcp.devices()), "no adapter")
    def test_members_on_a_gpu_have_the_bits_of_their_scenes_alone_there(self):
        self.check_members("gpu")

    def test_one_that_fails_does_not_stop_the_others_and_says_why(self):
        def raises(bodies):
            raise RuntimeError("no force today")

        ensemble = relcp.Ensemble(scenes(3))
        ensemble[1].add_force(raises)
        stopped = ensemble.run()
        self.assertEqual([stopped[0], stopped[2]], [None, None])
        self.assertIn("no force today", str(stopped[1]))
        self.assertEqual([member.done for member in ensemble], [True, False, True])

    def test_a_part_of_the_way_and_the_rest(self):
        ensemble = relcp.Ensemble(scenes(2))
        ensemble.run(until=0.5)
        self.assertTrue(all(abs(member.time - 0.5) < 1e-9 for member in ensemble))
        ensemble.run()
        self.assertEqual([member.state_hash for member in ensemble], [alone(scene) for scene in scenes(2)])

    def test_what_cannot_be_an_ensemble_is_refused(self):
        with self.assertRaisesRegex(ValueError, "at least one"):
            relcp.Ensemble([])
        with self.assertRaisesRegex(ValueError, "backend"):
            relcp.Ensemble(scenes(1), backend="auto")
        with self.assertRaises(IndexError):
            relcp.Ensemble(scenes(1))[1]


if __name__ == "__main__":
    unittest.main()
