"""The examples of examples/python: each runs, and does what its first line says."""

import pathlib
import runpy
import unittest

import numpy as np

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "examples" / "python"
PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "cellmodeller.md"

# The longest example, in lines.
LONGEST = 40


def ran(name):
    return runpy.run_path(str(FOLDER / f"{name}.py"), run_name="example")


class Examples(unittest.TestCase):
    def test_growth_is_exponential(self):
        names = ran("growth")
        simulation = names["simulation"]
        self.assertLessEqual(names["summary"]["max_overlap"], 1e-5)
        # Divisions keep the length, and rates are within a tenth of 1.
        grown = np.log(simulation.lengths.sum() / 2.0) / simulation.time
        self.assertTrue(0.9 < grown < 1.1, grown)
        self.assertTrue((simulation.lengths <= 4.8 * np.exp(1.1 * 0.02)).all())
        self.assertGreater(len(set(simulation.division_lengths)), simulation.n_bodies // 2)

    def test_two_strains_compete_by_their_rates(self):
        names = ran("two_strains")
        self.assertAlmostEqual(names["fast"] / names["slow"] / names["expected"], 1.0, places=12)

    def test_pressed_cells_rest_for_good_and_in_the_middle(self):
        names = ran("pressure_switch")
        rests, distance = names["rests"], names["distance"]
        self.assertTrue(5 < rests.sum() < len(rests) - 5, rests.sum())
        self.assertLess(distance[rests].mean(), 0.8 * distance[~rests].mean())
        for before, after in zip(names["switched"], names["switched"][1:]):
            self.assertLessEqual(before, after)

    def test_a_clock_divides_all_cells_at_once(self):
        names = ran("timer")
        # By time 4 four clocks have rung; each rings at a step's start, so that a division is late by steps at most.
        self.assertEqual(names["simulation"].n_bodies, 16)
        self.assertTrue((names["late"] >= -1e-9).all() and (names["late"] <= 4 * 0.02 + 1e-9).all(), names["late"])

    def test_unequal_daughters_live_unequally_long(self):
        names = ran("asymmetric")
        self.assertGreater(len(names["lives"][0.4]), 2)
        # A division is late by up to a step, and so is the birth.
        self.assertLess(abs(names["small"] - np.log(1 / 0.4)), 0.03)
        self.assertLess(abs(names["large"] - np.log(1 / 0.6)), 0.03)

    def test_the_dead_are_as_many_as_their_rate_says(self):
        names = ran("death")
        # A sum of independent chances: its variance is at most its mean.
        self.assertLess(abs(names["died"] - names["expected"]), 4 * np.sqrt(names["expected"]))
        self.assertGreater(names["died"], 20)

    def test_swimmers_drift_as_the_closed_form_says(self):
        names = ran("chemotaxis")
        self.assertLess(abs(names["drift"].mean() - names["expected"]), 4 * names["error"] + 0.02)
        self.assertGreater(names["drift"].mean(), 0.3)

    def test_a_plasmid_is_lost_by_half_its_probability_a_generation(self):
        names = ran("plasmid")
        held, simulation = names["holds"], names["simulation"]
        self.assertGreater(simulation.generations.min(), 2)
        # Founders are independent, their descendants are not: the deviation of the mean over 24 founders.
        share = np.sqrt(names["expected"] * (1 - names["expected"]) / 24)
        self.assertLess(abs(held.mean() - names["expected"]), 3 * share)
        self.assertTrue(0 < held.sum() < len(held))

    def test_bonded_daughters_are_one_filament(self):
        names = ran("adhesion")
        cells = names["simulation"].n_bodies
        self.assertGreater(cells, 8)
        self.assertEqual(len(names["bonds"]), cells - 1)
        self.assertEqual(len({a for a, _ in names["bonds"]}), cells - 1)
        # The gap at rest is a hundredth of the diameter, and the bonds are rigid.
        self.assertLess(np.abs(names["gaps"] - 0.01).max(), 1e-4)

    def test_trenches_stay_full_of_one_lineage_each(self):
        names = ran("mother_machine")
        simulation = names["simulation"]
        self.assertGreater(sum(names["summary"]["removed"]), 8)
        for mother in names["mothers"]:
            # The mother is at the closed end, 14 below the open one, less her half length and the wall.
            self.assertLess(simulation.positions[mother, 1], -11)
        # A trench is 14 long, and a cell leaves when its centre is outside.
        filled = np.array(names["filled"])
        self.assertTrue((filled > 9).all() and (filled < 18).all(), filled)

    def test_they_are_short_and_on_the_page(self):
        files = sorted(FOLDER.glob("*.py"))
        self.assertEqual(len(files), 10)
        page = PAGE.read_text(encoding="utf-8")
        for file in files:
            self.assertLess(len(file.read_text(encoding="utf-8").splitlines()), LONGEST, file.name)
            self.assertIn(f"examples/python/{file.name}", page)
            picture = PAGE.parent / "pictures" / f"cellmodeller-{file.stem.replace('_', '-')}.png"
            self.assertLess(picture.stat().st_size, 60_000, picture.name)
            self.assertIn(picture.name, page)


if __name__ == "__main__":
    unittest.main()
