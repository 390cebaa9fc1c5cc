"""What users of MuJoCo, OVITO and CellModeller try first: it works, or an exception says what does."""

import pathlib
import pickle
import tempfile
import unittest

import numpy as np
import relcp

ROD = {"spherocylinder": {"diameter": 0.5, "length": 2}}


def rods():
    return relcp.Scene({
        "name": "rods", "planar": True, "time": {"dt": 0.01, "end": 1}, "output": {"every": 0.5, "picture": False},
        "dynamics": {"overdamped": {"drag": 1}}, "growth": {"rate": 0.5, "division_length": 3},
        "forces": [{"uniform": {"force": [1, 0, 0]}}],
        "walls": [{"half_space": {"normal": [0, 1, 0], "offset": -9, "motion": {"velocity": [0, 0.1, 0]}}}],
        "bodies": [
            {"shape": ROD, "position": [3 * nth, 0, 0], "axis": [1, 0, 0], "group": "ab"[nth % 2]} for nth in range(4)
        ],
    })  # fmt: skip


class FirstAttempts(unittest.TestCase):
    def setUp(self):
        self.simulation = relcp.Simulation(rods())
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.place = pathlib.Path(place.name)

    def test_writing_to_an_array_says_that_it_is_a_copy(self):
        with self.assertRaisesRegex(ValueError, "read-only"):
            self.simulation.positions[0] = [1, 2, 3]

    def test_a_dict_is_a_scene(self):
        self.assertEqual(relcp.Scene(rods().to_dict()), rods())

    def test_the_state_is_written_by_name(self):
        simulation = self.simulation
        simulation.set(of=0, position=[0, 5, 0], length=2.5, rate=0.2, group="b")
        self.assertEqual(simulation.positions[0].tolist(), [0, 5, 0])
        self.assertEqual((simulation.lengths[0], simulation.rates[0]), (2.5, 0.2))
        self.assertEqual(simulation.group_labels[0], "b")
        with self.assertRaisesRegex(ValueError, "without inertia"):
            simulation.set(velocity=np.zeros((4, 3)))

    def test_bodies_come_and_go(self):
        ids = self.simulation.add([{"shape": ROD, "position": [0, 4, 0], "axis": [1, 0, 0]}])
        self.assertEqual(self.simulation.n_bodies, 5)
        self.simulation.remove(ids=ids)
        self.assertEqual(self.simulation.n_bodies, 4)

    def test_forces_growth_wall_motion_and_the_step_change_on_the_way(self):
        simulation = self.simulation
        simulation.step(20)
        simulation.change({
            "forces.0.uniform.force": [0, 0, 0], "growth.rate": 1.0, "time.dt": 0.005,
        })  # fmt: skip
        before = simulation.positions, simulation.lengths
        simulation.step()
        np.testing.assert_array_equal(simulation.positions, before[0])
        np.testing.assert_allclose(simulation.lengths, before[1] * np.exp(0.005), rtol=1e-14)
        with self.assertRaises(relcp.SceneError):
            simulation.change({"growth.rat": 1.0})
        with self.assertRaises(relcp.SceneError):
            simulation.change({"planar": False})
        # It stays reproducible: the scene has the changes, and so have copies and saved states.
        simulation.step(30)
        again = relcp.Simulation(simulation.scene)
        again.step(simulation.n_steps)
        self.assertEqual(again.state_hash, simulation.state_hash)
        copy = pickle.loads(pickle.dumps(simulation))
        simulation.save(self.place / "state.npz")
        resumed = relcp.Simulation.resume(simulation.scene, self.place / "state.npz")
        for one in [simulation, copy, resumed]:
            one.step(20)
        self.assertEqual({copy.state_hash, resumed.state_hash}, {simulation.state_hash})

    def test_cells_decide_by_update_and_divide(self):
        class Rules:
            def update(self, cells):
                cells.rates = 1.0 + 0.1 * cells.groups

            def divide(self, mother, daughters):
                daughters[0].division_length = 2.9

        self.simulation.rules = Rules()
        self.simulation.step(60)
        self.assertGreater(self.simulation.n_bodies, 4)

    def test_it_is_shown_drawn_and_measured(self):
        simulation = self.simulation
        self.assertIn("iframe", simulation.show()._repr_html_())
        self.assertEqual(simulation.render(64).shape, (36, 64, 4))
        for ending in ["png", "svg", "pdf"]:
            path = simulation.save_picture(self.place / f"rods.{ending}", 120)
            self.assertGreater(path.stat().st_size, 200)
        self.assertIn("<svg", (self.place / "rods.svg").read_text())
        with self.assertRaisesRegex(ValueError, ".png, .svg or .pdf"):
            simulation.save_picture(self.place / "rods.jpg")
        with self.assertRaisesRegex(ValueError, "from a side"):
            simulation.save_picture(self.place / "rods.svg", view="front")
        self.assertEqual(simulation.measure("nematic")["nematic_order"], 1.0)

    def test_what_it_has_is_named(self):
        simulation = self.simulation
        self.assertEqual((simulation.n_bodies, simulation.n_steps), (4, 0))
        np.testing.assert_allclose(simulation.axes, [[1, 0, 0]] * 4, atol=1e-15)
        self.assertEqual(simulation.shape_labels, ["spherocylinder"] * 4)
        self.assertEqual(simulation.group_labels, ["a", "b", "a", "b"])
        self.assertTrue((simulation.shapes == relcp.Shape.SPHEROCYLINDER).all())

    def test_forces_are_vectors_those_on_walls_too(self):
        pressed = relcp.Simulation(relcp.Scene({
            "name": "pressed", "time": {"dt": 0.01, "end": 1},
            "walls": [{"half_space": {"normal": [0, 0, 1], "offset": 0}}],
            "forces": [{"uniform": {"force": [0, 0, -1]}}],
            "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, z]} for z in (0.5, 1.5)],
        }))  # fmt: skip
        pressed.run()
        np.testing.assert_allclose(pressed.contacts(1e-4).force, [[0, 0, 1]], atol=1e-3)
        np.testing.assert_allclose(pressed.wall_contacts(1e-4).force, [[0, 0, -2]], atol=1e-3)

    def test_a_run_is_read_exported_and_swept(self):
        run = relcp.run(rods(), self.place / "run", progress=False)
        run = relcp.Run(self.place / "run")
        self.assertEqual([len(run.states), run.steps.n_rows], [3, 100])
        self.assertTrue(run.export("vtk") and run.view().is_file())
        self.assertEqual(run.save_picture(self.place / "run.pdf", 0.5, 120), self.place / "run.pdf")
        self.assertEqual(run.render(width=64).shape, (36, 64, 4))
        batch = relcp.batch(rods(), {"growth.rate": [0.1, 0.2]}, out=self.place / "batch", progress=False)
        self.assertEqual(batch.table["status"], ["done", "done"])


if __name__ == "__main__":
    unittest.main()
