"""Fields of a simulation and of recorded states."""

import pathlib
import tempfile
import unittest

import numpy as np
import relcp


def fed():
    return relcp.Scene({
        "name": "fed", "planar": True, "time": {"dt": 0.02, "end": 2},
        "fields": {"food": {
            "cells": [8, 6, 1], "spacing": 1, "diffusion": 0.5, "initial": 1,
            "boundary": {"x": [{"value": 2}, "closed"]}, "exchange": [{"uptake": 0.5, "half": 0.2}],
        }},
        "growth": {"rate": 1, "division_length": 2, "nutrient": {"field": "food", "half": 0.2}},
        "generate": [{"founder": {"diameter": 0.5, "length": 1.2}}],
        "output": {"every": 1, "picture": False, "measures": ["fields"]},
    })  # fmt: skip


class Fields(unittest.TestCase):
    def test_a_simulation_has_its_fields_as_arrays_by_x_y_and_z(self):
        simulation = relcp.Simulation(fed())
        np.testing.assert_array_equal(simulation.fields["food"], np.ones((8, 6, 1)))
        simulation.run()
        food = simulation.fields["food"]
        self.assertEqual(food.shape, (8, 6, 1))
        # More at the side with the larger concentration, less where the cells are.
        self.assertGreater(food[0].mean(), food[-1].mean())
        self.assertLess(food[3:5, 2:4].mean(), food[-1].mean())
        measured = simulation.measure("fields")
        self.assertAlmostEqual(measured["field_mean"], food.mean(), places=12)
        self.assertAlmostEqual(measured["field_amount"], food.sum(), places=9)
        with self.assertRaises(ValueError):
            food[0, 0, 0] = 1

    def test_states_and_runs_have_them_too(self):
        with tempfile.TemporaryDirectory() as place:
            run = relcp.run(fed(), pathlib.Path(place) / "run")
            simulation = relcp.Simulation(fed())
            simulation.run()
            np.testing.assert_array_equal(run.states[-1].fields["food"], simulation.fields["food"])
            np.testing.assert_array_equal(run.states[0].fields["food"], 1)
            self.assertAlmostEqual(run.measures["field_mean"][-1], simulation.fields["food"].mean(), places=9)


if __name__ == "__main__":
    unittest.main()
