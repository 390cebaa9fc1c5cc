"""Writing the state: values, bodies that come and go, and what a pickle of it goes on to."""

import copy
import pickle
import unittest

import numpy as np
import relcp

ROD = {"spherocylinder": {"diameter": 0.5, "length": 2}}


def rods(dynamics="overdamped"):
    """Sixteen rods in two groups, drawn together."""
    law = {"overdamped": {"drag": 1}} if dynamics == "overdamped" else {"inertial": {"density": 1}}
    scene = {
        "name": "rods",
        "time": {"dt": 0.02, "end": 4},
        "dynamics": law,
        "forces": [{"trap": {"stiffness": 3, "center": [0, 0, 0]}}],
        "generate": [
            {"isotropic": {"count": 8, "shape": ROD, "volume_fraction": 0.2, "group": "a"}},
            {"isotropic": {"count": 8, "shape": ROD, "volume_fraction": 0.2, "group": "b", "center": [9, 0, 0]}},
        ],
    }
    return relcp.Scene(scene)


def pull(bodies):
    return -0.5 * bodies.positions


class Scenes(unittest.TestCase):
    def test_a_scene_is_made_from_a_dict(self):
        scene = rods()
        self.assertEqual(relcp.Scene(scene.to_dict()), scene)
        self.assertEqual(relcp.Scene(scene.to_dict(), {"time.dt": 0.01}).dt, 0.01)
        with self.assertRaisesRegex(TypeError, "expected a dict, found str; Scene.load"):
            relcp.Scene("colony")
        with self.assertRaises(relcp.SceneError):
            relcp.Scene({"name": "x"})


class Arrays(unittest.TestCase):
    def test_writing_to_an_array_is_refused(self):
        simulation = relcp.Simulation(rods())
        for name in [
            "positions", "orientations", "velocities", "angular_velocities", "lengths", "sizes", "shapes", "groups",
            "ids", "parents", "births", "generations", "rates", "division_lengths",
        ]:  # fmt: skip
            array = getattr(simulation, name)
            self.assertFalse(array.flags.writeable, name)
            with self.assertRaisesRegex(ValueError, "read-only"):
                array[0] = array[0]
        with self.assertRaises(AttributeError):
            simulation.positions = np.zeros((16, 3))

    def test_names_in_place_of_codes(self):
        simulation = relcp.Simulation(rods())
        self.assertEqual((simulation.n_bodies, simulation.n_steps), (16, 0))
        self.assertEqual(simulation.group_labels, ["a"] * 8 + ["b"] * 8)
        self.assertEqual(simulation.shape_labels, ["spherocylinder"] * 16)
        simulation.set([3, 4], group=[None, "a"])
        self.assertIsNone(simulation.group_labels[3])
        simulation.step(2)
        self.assertEqual(simulation.n_steps, 2)


class Values(unittest.TestCase):
    def test_values_are_set_as_a_whole_for_some_and_for_ids(self):
        simulation = relcp.Simulation(rods())
        simulation.step(3)
        moved = simulation.positions + [0, 0, 30]
        simulation.set(position=moved, length=1.5)
        np.testing.assert_array_equal(simulation.positions, moved)
        np.testing.assert_array_equal(simulation.lengths, 1.5)
        simulation.set(of=[-1, 2], orientation=[2, 0, 0, 0], group=["a", "b"])
        np.testing.assert_array_equal(simulation.orientations[[15, 2]], [[1, 0, 0, 0]] * 2)
        self.assertEqual([simulation.group_labels[i] for i in (15, 2)], ["a", "b"])
        simulation.set(simulation.groups == 0, position=simulation.positions[simulation.groups == 0] - 1)
        simulation.set(slice(0, 2), columns={"mark": [1, 2]})
        np.testing.assert_array_equal(simulation.columns["mark"], [1, 2] + [0] * 14)
        simulation.remove([0])
        simulation.set(ids=[5], length=1.75)
        self.assertEqual(simulation.lengths[simulation.ids == 5], 1.75)
        self.assertLess(simulation.step().max_overlap, 1e-5)
        fast = relcp.Simulation(rods("inertial"))
        fast.set(velocity=[0, 1, 0], angular_velocity=np.ones((16, 3)))
        np.testing.assert_array_equal(fast.velocities, [[0, 1, 0]] * 16)
        fast.step()
        self.assertGreater(fast.velocities[:, 1].mean(), 0.5)

    def test_what_is_there_can_be_written_without_an_effect(self):
        written, plain = relcp.Simulation(rods()), relcp.Simulation(rods())
        for _ in range(10):
            written.step(3), plain.step(3)
            written.set(position=written.positions, orientation=written.orientations, length=written.lengths)
        self.assertEqual(written.state_hash, plain.state_hash)

    def test_wrong_values_name_argument_and_row_and_change_nothing(self):
        simulation = relcp.Simulation(rods())
        simulation.step(2)
        before = simulation.state_hash
        wrong = simulation.positions.copy()
        wrong[7, 1] = np.nan
        for arguments, exception, said in [
            (dict(position=wrong), ValueError, r"position\[7\] \(body 7, id 7\): must be finite, not NaN"),
            (dict(position=wrong[:3]), ValueError, r"position: found the shape \(3, 3\); expected \(16, 3\)"),
            (dict(position=np.ones((16, 2))), ValueError, r"position: found the shape \(16, 2\)"),
            (dict(position="here"), TypeError, "position: expected an array of numbers"),
            (dict(position=1j * wrong), TypeError, "position: expected an array of numbers"),
            (dict(of=[4], length=0.1), ValueError, r"length\[0\] \(body 4, id 4\): must be at least the diameter"),
            (dict(length=-1), ValueError, r"length\[0\]"),
            (dict(orientation=[0, 0, 0, 0]), ValueError, r"orientation\[0\] .*norm"),
            (dict(velocity=[1, 0, 0]), ValueError, r"velocity\[0\] .*without inertia"),
            (dict(rate=1), ValueError, r"rate\[0\] .*does not grow"),
            (dict(group="c"), ValueError, r"group\[0\]: no body of the scene starts in the group 'c'"),
            (dict(group=7), ValueError, r"group\[0\]: expected a name"),
            (dict(of=[16], length=2), IndexError, "index 16; there are 16 bodies"),
            (dict(of=[True, False], length=2), IndexError, "mask"),
            (dict(ids=[77], length=2), IndexError, "id 77: no body has it now"),
            (dict(of=[1, 1], length=2), IndexError, "body 1 is named twice"),
            (dict(of=[1], ids=[1], length=2), TypeError, "not by both"),
            (dict(columns={"own": np.full(16, np.inf)}), ValueError, r"own\[0\]"),
            (dict(length=2.5, position=wrong), ValueError, r"position\[7\]"),
        ]:
            with self.assertRaisesRegex(exception, said):
                simulation.set(**arguments)
            self.assertEqual(simulation.state_hash, before, arguments)

    def test_bodies_that_are_put_onto_others_are_parted(self):
        for law in ["overdamped", "inertial"]:
            simulation = relcp.Simulation(rods(law))
            simulation.step(5)
            simulation.set([0], position=simulation.positions[9])
            self.assertGreater(-simulation.contacts().separation.min(), 0.1)
            self.assertLess(simulation.step().max_overlap, 1e-5)


class Bodies(unittest.TestCase):
    def test_bodies_come_and_go(self):
        simulation = relcp.Simulation(rods())
        simulation.add_force(pull)
        simulation.step(3)
        ids = simulation.add([
            {"shape": ROD, "position": np.array([20, 0, 0]), "axis": [1, 0, 0], "group": "b"},
            {"shape": {"sphere": {"radius": 0.3}}, "position": [20, 5, 0]},
        ])
        np.testing.assert_array_equal(ids, [16, 17])
        self.assertEqual((simulation.n_bodies, simulation.group_labels[16:]), (18, ["b", None]))
        self.assertEqual(simulation.births[17], simulation.time)
        simulation.remove(ids=ids[:1])
        simulation.remove([0, 1])
        self.assertEqual(list(simulation.ids), [*range(2, 16), 17])
        before = simulation.positions[-1]
        simulation.step(5)
        self.assertLess(simulation.positions[-1][0], before[0])
        for body, key in [
            ({"shape": ROD}, "bodies.0.position"),
            ({"shape": {"sphere": {"radius": -1}}, "position": [9, 9, 9]}, "bodies.0.shape.sphere.radius"),
            ({"shape": ROD, "position": [9, 9, 9], "group": "c"}, "bodies.0.group"),
            ({"shape": ROD, "position": [9, 9, 9], "fixed": True}, "bodies.0.fixed"),
            ({"shape": ROD, "position": [9, 9, 9], "velocity": [1, 0, 0]}, "bodies.0.velocity"),
        ]:
            with self.assertRaises(relcp.SceneError) as raised:
                simulation.add([body])
            self.assertTrue(raised.exception.key.startswith(key) or key.startswith(raised.exception.key), raised.exception)
        with self.assertRaises(TypeError):
            simulation.remove()
        simulation.remove(slice(None))
        self.assertTrue(simulation.done)


class Pickles(unittest.TestCase):
    def test_a_pickle_goes_on_to_the_same_bits_after_changes(self):
        for law in ["overdamped", "inertial"]:
            simulation = relcp.Simulation(rods(law))
            simulation.add_force(pull)
            simulation.step(10)
            simulation.set([0], position=simulation.positions[9] + 0.2)
            simulation.remove([4])
            simulation.add([{"shape": ROD, "position": [6, 0, 0]}])
            simulation.set(columns={"own": np.arange(16.0)})
            again = pickle.loads(pickle.dumps(simulation))
            third = copy.deepcopy(simulation)
            self.assertEqual(again.state_hash, simulation.state_hash)
            for other in [simulation, again, third]:
                other.step(20)
            self.assertEqual(again.state_hash, simulation.state_hash)
            self.assertEqual(third.state_hash, simulation.state_hash)
            self.assertEqual(again.summary()["steps"], 30)
        simulation.add_force(lambda bodies: bodies.positions)
        with self.assertRaises((pickle.PicklingError, AttributeError)):
            pickle.dumps(simulation)


class Measures(unittest.TestCase):
    def test_a_state_is_measured(self):
        simulation = relcp.Simulation(rods())
        simulation.step(5)
        order = simulation.measure("nematic")
        self.assertIsNone(order["remark"])
        values = [value for name, value in order.items() if name not in ("remark", "profile")]
        self.assertTrue(values and all(value is None or isinstance(value, float) for value in values), order)
        aligned = relcp.Simulation(rods())
        aligned.set(orientation=[1, 0, 0, 0])
        self.assertAlmostEqual(aligned.measure("nematic")["nematic_order"], 1.0)
        self.assertLess(order["nematic_order"], 0.99)
        profile = simulation.measure("correlation")["profile"]
        self.assertTrue(all(isinstance(rows, np.ndarray) for rows in profile.values()))
        with self.assertRaisesRegex(ValueError, "nematicc"):
            simulation.measure("nematicc")


class Devices(unittest.TestCase):
    def test_changes_on_a_device(self):
        if not any(device["taken"] for device in relcp.devices()):
            self.skipTest("there is no adapter")
        both = [relcp.Simulation(rods()), relcp.Simulation(rods(), backend="gpu", precision="f32")]
        for simulation in both:
            simulation.step(3)
            simulation.set([0, 1], position=[[15, 0, 0], [15, 3, 0]], length=1.25)
            simulation.add([{"shape": {"sphere": {"radius": 0.3}}, "position": [20, 5, 0]}])
            simulation.remove([5])
            simulation.step(3)
        cpu, device = both
        self.assertEqual(device.backend, "gpu")
        np.testing.assert_array_equal(cpu.ids, device.ids)
        self.assertLess(np.abs(cpu.positions - device.positions).max(), 1e-3)
        again = pickle.loads(pickle.dumps(device))
        self.assertEqual((again.backend, again.state_hash), ("gpu", device.state_hash))


if __name__ == "__main__":
    unittest.main()
