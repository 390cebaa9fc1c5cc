"""Rules: cells whose growth, division and state Python decides."""

import os
import pickle
import tempfile
import unittest

import numpy as np
import relcp


def colony(**changes):
    return relcp.Scene.load("colony", {"time.dt": 0.01, "time.end": 6, "growth.division_length_noise": 0.1, **changes})


class Crowded:
    """Cells sense crowding, and count the divisions of their line."""

    def update(self, cells):
        cells.rates = 1.0 / (1.0 + np.maximum(cells.pressures, 0.0))
        if "divisions" not in cells:
            cells["divisions"] = np.zeros(len(cells))
        cells["age"] = cells.ages

    def divide(self, mother, daughters):
        for daughter, length in zip(daughters, [3.0, 3.5]):
            daughter.division_length = length
            daughter["divisions"] = mother["divisions"] + 1


class Rules(unittest.TestCase):
    def test_cells_grow_and_divide_by_them(self):
        simulation = relcp.Simulation(colony())
        simulation.rules = Crowded()
        while simulation.n_bodies < 12:
            simulation.step()
        np.testing.assert_array_equal(simulation.columns["divisions"], simulation.generations)
        self.assertLessEqual(set(simulation.division_lengths), {3.0, 3.5})
        self.assertTrue((simulation.rates <= 1).all() and (simulation.rates < 1).any())
        self.assertIsInstance(simulation.rules, Crowded)
        simulation.rules = None
        self.assertIsNone(simulation.rules)
        simulation.step()

    def test_they_go_on_to_the_same_bits_whatever_the_threads_by_a_file_and_by_a_pickle(self):
        def ruled(**arguments):
            simulation = relcp.Simulation(colony(), **arguments)
            simulation.rules = Crowded()
            return simulation

        whole, threads = ruled(), ruled(threads=3)
        whole.step(400), threads.step(400)
        half = ruled()
        half.step(250)
        pickled = pickle.loads(pickle.dumps(half))
        self.assertIsInstance(pickled.rules, Crowded)
        with tempfile.TemporaryDirectory() as place:
            path = os.path.join(place, "state.npz")
            half.save(path)
            resumed = relcp.Simulation.resume(colony(), path)
            with np.load(path) as file:
                self.assertEqual(file["own_rate"].shape, (half.n_bodies,))
        resumed.rules = Crowded()
        for simulation in [half, pickled, resumed]:
            simulation.step(150)
        hashes = {simulation.state_hash for simulation in [whole, threads, half, pickled, resumed]}
        self.assertGreater(whole.n_bodies, 4)
        self.assertEqual(len(hashes), 1)

    def test_rules_that_do_nothing_keep_every_bit(self):
        class Nothing:
            def update(self, cells):
                cells.rates = cells.rates
                cells.groups = [None] * len(cells)

        simulation, plain = relcp.Simulation(colony()), relcp.Simulation(colony())
        simulation.rules = Nothing()
        simulation.step(300), plain.step(300)
        self.assertEqual(simulation.state_hash, plain.state_hash)

    def test_a_timer_of_ones_own_and_uneven_growth(self):
        class Timer:
            def update(self, cells):
                cells.division_lengths[:] = np.where(cells.ages >= 0.5, cells.lengths, np.inf)
                cells.rates[:] = np.where(cells.ids % 2 == 0, 1.0, 1.3)

        simulation = relcp.Simulation(colony())
        simulation.rules = Timer()
        simulation.run(until=1.2)
        self.assertEqual(simulation.n_bodies, 4)
        self.assertEqual(set(simulation.rates), {1.0, 1.3})

    def test_a_cell_divides_unevenly(self):
        class Uneven:
            def divide(self, mother, daughters):
                lower, upper = daughters
                whole = lower.length + upper.length
                lower.length = 0.4 * whole
                upper.length = whole - lower.length

        simulation = relcp.Simulation(colony())
        simulation.rules = Uneven()
        while simulation.n_bodies < 2:
            simulation.step()
        small, large = simulation.lengths
        self.assertAlmostEqual(small / large, 2 / 3, places=12)
        # They meet: neither a gap nor an overlap, in the next step as well.
        self.assertLessEqual(simulation.step().max_overlap, 1e-5)
        while simulation.n_bodies < 20:
            self.assertLessEqual(simulation.step().max_overlap, 1e-5)

        class Wrong:
            def divide(self, mother, daughters):
                daughters[0].length = 2 * mother.length

        simulation = relcp.Simulation(colony())
        simulation.rules = Wrong()
        with self.assertRaisesRegex(ValueError, r"length\[0\] \(body 0, id 1\): the lengths of two daughters add up"):
            simulation.run()
        self.assertEqual(simulation.n_bodies, 1)

    def test_wrong_values_name_the_cell_and_the_state_is_that_before(self):
        def setting(name, value):
            class Wrong:
                def update(self, cells):
                    if len(cells) > 1:
                        if name == "own":
                            cells["own"] = value
                        else:
                            setattr(cells, name, value)

            return Wrong()

        for name, value, exception, said in [
            ("rates", [1.0, np.nan], ValueError, r"rate\[1\] \(body 1, id 2\): must be finite"),
            ("rates", [-1.0, 1.0], ValueError, r"rate\[0\] \(body 0, id 1\): must not be negative"),
            ("rates", [1.0], ValueError, r"rates: found the shape \(1,\); expected \(2,\)"),
            ("rates", ["fast", "slow"], TypeError, "rates: expected an array of numbers"),
            ("division_lengths", [3.0, -4.0], ValueError, r"division_length\[1\] \(body 1, id 2\): must be positive"),
            ("own", [0.0, np.nan], ValueError, r"own\[1\] \(body 1, id 2\)"),
            ("groups", ["none", "none"], ValueError, r"group\[0\]: no body"),
            ("lengths", [1.0, 1.0], AttributeError, "'lengths' cannot be set by a rule"),
            ("rate", [1.0, 1.0], AttributeError, "'rate' cannot be set"),
        ]:
            simulation = relcp.Simulation(colony())
            simulation.rules = setting(name, value)
            while simulation.n_bodies < 2:
                simulation.step()
            before = simulation.state_hash, simulation.n_steps
            with self.assertRaisesRegex(exception, said):
                simulation.step()
            self.assertEqual((simulation.state_hash, simulation.n_steps), before)
            simulation.rules = None
            simulation.step()

    def test_what_they_raise_is_raised_with_the_cell_and_the_state_is_that_before(self):
        class Raises:
            def divide(self, mother, daughters):
                raise LookupError("no such gene")

        simulation = relcp.Simulation(colony())
        simulation.rules = Raises()
        with self.assertRaisesRegex(LookupError, "no such gene") as raised:
            simulation.run()
        if hasattr(raised.exception, "__notes__"):
            self.assertIn("cell 0 divided", raised.exception.__notes__[0])
        self.assertEqual(simulation.n_bodies, 1)
        before = simulation.state_hash
        with self.assertRaises(LookupError):
            simulation.step()
        self.assertEqual(simulation.state_hash, before)

        class Wrong:
            def divide(self, mother, daughters):
                daughters[1].division_length = -mother.length

        simulation.rules = Wrong()
        with self.assertRaisesRegex(ValueError, r"division_length\[1\] \(body 1, id 2\): must be positive"):
            simulation.step()
        self.assertEqual(simulation.state_hash, before)

        class Peeks:
            def update(self, cells):
                simulation.positions

        simulation.rules = Peeks()
        with self.assertRaisesRegex(relcp.SimulationError, "evaluating a force or a rule"):
            simulation.step()
        for nothing in [3, "rules", object()]:
            with self.assertRaises(TypeError):
                simulation.rules = nothing

    def test_a_device_takes_steps_by_rules(self):
        if not any(device["taken"] for device in relcp.devices()):
            self.skipTest("there is no adapter")
        both = [relcp.Simulation(colony()), relcp.Simulation(colony(), backend="gpu", precision="f32")]
        for simulation in both:
            simulation.rules = Aging()
            simulation.step(200)
        cpu, device = both
        self.assertGreater(cpu.n_bodies, 2)
        np.testing.assert_array_equal(cpu.ids, device.ids)
        np.testing.assert_array_equal(cpu.columns["age"], device.columns["age"])
        self.assertLess(np.abs(cpu.positions - device.positions).max(), 1e-3)


class Aging:
    """Of the age alone, so that a device's rounding decides nothing."""

    def update(self, cells):
        cells.rates = 1.0 / (1.0 + cells.ages)
        cells["age"] = cells.ages

    def divide(self, mother, daughters):
        for daughter in daughters:
            daughter.division_length = 3.0
        whole = sum(daughter.length for daughter in daughters)
        daughters[0].length = 0.45 * whole
        daughters[1].length = whole - daughters[0].length


if __name__ == "__main__":
    unittest.main()
