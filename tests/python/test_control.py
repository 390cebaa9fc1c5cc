"""Forces of one's own, runs with callbacks and ends, steps that end, scenes that are pickled and copied."""

import copy
import multiprocessing
import os
import pickle
import signal
import tempfile
import threading
import traceback
import unittest

import numpy as np
import relcp


def balls(n=3, planar=False, **more):
    """Balls in a row, too far apart to meet."""
    scene = {
        "name": "balls",
        "planar": planar,
        "dynamics": {"overdamped": {"drag": 2.0}},
        "time": {"dt": 0.01, "end": 1.0},
        "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [4.0 * i, 0, 0]} for i in range(n)],
        **more,
    }
    return relcp.Scene.from_dict(scene)


def rods(**more):
    rod = {"spherocylinder": {"diameter": 0.5, "length": 2}}
    placed = {"isotropic": {"count": 12, "shape": rod, "volume_fraction": 0.1}}
    scene = {"name": "rods", "time": {"dt": 0.01, "end": 0.2}, "generate": [placed], **more}
    return relcp.Scene.from_dict(scene)


def a_device():
    """Whether there is an adapter; where one is required it must be there."""
    there = any(adapter["taken"] for adapter in relcp.devices())
    assert there or os.environ.get("RELCP_REQUIRE_GPU") != "1", "RELCP_REQUIRE_GPU is set, and there is no adapter"
    return there


class Forces(unittest.TestCase):
    def test_a_force_is_that_of_the_scene(self):
        # The same trap twice: the scene's own, and as a function.
        for stepping in ["euler", "midpoint"]:
            for dynamics in [{"overdamped": {"drag": 1.0}}, {"inertial": {"density": 1.0}}]:
                # The default tolerance follows the scene's own forces.
                solver = {"tolerance": 1e-9}
                more = {"dynamics": dynamics, "time": {"dt": 0.01, "end": 0.2, "stepping": stepping}, "solver": solver}
                trap = {"trap": {"stiffness": 3.0, "center": [0, 0, 0]}}
                own = relcp.Simulation(rods(forces=[trap], **more))
                own.run()
                simulation = relcp.Simulation(rods(**more))
                calls = []

                def force(bodies):
                    calls.append(bodies.time)
                    return -3.0 * bodies.positions

                simulation.add_force(force)
                simulation.run()
                self.assertLess(np.abs(simulation.positions - own.positions).max(), 1e-12)
                at = np.arange(20) * 0.01
                expected = at if stepping == "euler" else np.sort(np.concatenate([at, at + 0.005]))
                self.assertLess(np.abs(np.array(calls) - expected).max(), 1e-12)

    def test_what_a_force_sees(self):
        simulation = relcp.Simulation(rods(seed=4))
        seen = []
        simulation.add_force(lambda bodies: (seen.append(bodies), np.zeros((len(bodies), 3)))[1])
        simulation.step(3)
        names = ["positions", "orientations", "velocities", "angular_velocities", "lengths", "shapes", "sizes", "groups", "ids"]
        before = {name: getattr(simulation, name) for name in names}
        simulation.step()
        self.assertEqual(len(seen), 4)
        for name in names:
            self.assertTrue(np.array_equal(getattr(seen[3], name), before[name]), name)
        self.assertEqual((len(seen[3]), seen[3].time), (12, 0.03))
        w, x, y, z = before["orientations"].T
        axes = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
        self.assertLess(np.abs(seen[3].axes - axes).max(), 1e-15)

    def test_torques(self):
        # With the mobility 12 / (xi L^3) a ball of length 1 turns by 12 / 2 of its torque in a unit of time.
        simulation = relcp.Simulation(balls(1))
        simulation.add_force(lambda bodies: (np.zeros((1, 3)), [[0, 0, 0.01]]))
        simulation.add_force(lambda bodies: ([[1, 0, 0]], None))
        simulation.step()
        self.assertLess(np.abs(simulation.angular_velocities - [[0, 0, 0.06]]).max(), 1e-15)
        self.assertLess(np.abs(simulation.velocities - [[0.5, 0, 0]]).max(), 1e-15)

    def test_in_the_plane_bodies_stay_in_it(self):
        simulation = relcp.Simulation(balls(2, planar=True))
        simulation.add_force(lambda bodies: (np.ones((2, 3)), np.ones((2, 3))))
        simulation.step(10)
        self.assertEqual(simulation.positions[:, 2].tolist(), [0.0, 0.0])
        self.assertLess(np.abs(simulation.velocities - [0.5, 0.5, 0]).max(), 1e-12)
        self.assertEqual(np.abs(simulation.angular_velocities[:, :2]).max(), 0.0)

    def test_colonies_grow_under_it(self):
        simulation = relcp.Simulation(relcp.Scene.load("colony", {"time.end": 2.0}))
        numbers = set()

        def force(bodies):
            numbers.add(len(bodies))
            return -0.5 * bodies.positions

        simulation.add_force(force)
        simulation.run()
        self.assertEqual(simulation.bodies, max(numbers))
        self.assertGreater(len(numbers), 1)

    def test_what_it_raises_is_raised_and_the_state_is_that_before(self):
        simulation = relcp.Simulation(balls())

        def force(bodies):
            if bodies.time > 0.045:
                raise LookupError("no such field")
            return np.ones((3, 3))

        simulation.add_force(force)
        try:
            simulation.run()
            self.fail("it did not raise")
        except LookupError as raised:
            lines = traceback.extract_tb(raised.__traceback__)
            self.assertEqual((str(raised), lines[-1].name), ("no such field", "force"))
        self.assertEqual(simulation.steps, 5)
        self.assertLess(np.abs(simulation.positions[:, 1] - 0.025).max(), 1e-12)
        with self.assertRaises(LookupError):
            simulation.step()
        self.assertEqual(simulation.steps, 5)

    def test_wrong_answers(self):
        rows = np.ones((3, 3))
        for answer, exception, said in [
            (np.ones(3), ValueError, r"shape \[3\]: expected one row per body, \(3, 3\)"),
            (np.ones((2, 3)), ValueError, r"forces of shape \[2, 3\]"),
            (np.ones((3, 2)), ValueError, r"shape \[3, 2\]"),
            (np.ones((3, 3, 1)), ValueError, "shape"),
            (1.0, ValueError, r"shape \[\]"),
            ((rows, np.ones((3, 4))), ValueError, r"torques of shape \[3, 4\]"),
            ((rows, rows, rows), ValueError, "tuple of 3"),
            (np.array([[0, 0, 0], [0, 0, 0], [0, np.nan, 0]]), ValueError, "NaN for body 2"),
            ((rows, np.full((3, 3), np.inf)), ValueError, "torques that are not finite: inf for body 0"),
            (None, TypeError, "not an array of numbers"),
            ("north", TypeError, "not an array of numbers"),
            ([[1, 2, 3], [1, 2], [1, 2, 3]], TypeError, "not an array"),
            (1j * rows, TypeError, "not an array"),
        ]:
            simulation = relcp.Simulation(balls())
            simulation.add_force(lambda bodies: answer)
            with self.assertRaisesRegex(exception, said):
                simulation.step()
            self.assertEqual(simulation.steps, 0)
        for nothing in [None, 3, "force", np.ones((3, 3))]:
            with self.assertRaises(TypeError):
                relcp.Simulation(balls()).add_force(nothing)

    def test_it_cannot_use_its_own_simulation_but_another(self):
        simulation, other = relcp.Simulation(balls()), relcp.Simulation(balls())
        simulation.add_force(lambda bodies: simulation.positions)
        with self.assertRaisesRegex(relcp.SimulationError, "evaluating a force"):
            simulation.step()
        simulation = relcp.Simulation(balls())
        simulation.add_force(lambda bodies: other.step().step * np.ones((3, 3)))
        simulation.step(3)
        self.assertEqual(other.steps, 3)

    def test_in_two_threads(self):
        """Many bodies, so that steps run on threads of the pool."""
        sphere = {"count": 600, "shape": {"sphere": {"radius": 0.5}}, "volume_fraction": 0.05}
        scene = relcp.Scene.from_dict({"name": "many", "time": {"dt": 0.01, "end": 1}, "generate": [{"isotropic": sphere}]})
        both = [relcp.Simulation(scene) for _ in range(2)]
        for simulation in both:
            simulation.add_force(lambda bodies: -bodies.positions)
        threads = [threading.Thread(target=simulation.step, args=(10,)) for simulation in both]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            self.assertEqual(both[0].positions.shape, (600, 3))
        self.assertEqual(both[0].steps, 10)
        self.assertEqual(both[0].state_hash, both[1].state_hash)

    def test_on_a_device(self):
        if not a_device():
            self.skipTest("there is no adapter")
        cpu = relcp.Simulation(rods())
        device = relcp.Simulation(rods(), backend="gpu", precision="f32")
        for simulation in [cpu, device]:
            simulation.add_force(lambda bodies: (-3.0 * bodies.positions, 0.1 * np.ones((12, 3))))
            simulation.step(5)
        self.assertEqual(device.backend, "gpu")
        self.assertLess(np.abs(device.positions - cpu.positions).max(), 1e-4)
        self.assertLess(np.abs(device.orientations - cpu.orientations).max(), 1e-4)

        def broken(bodies):
            raise ZeroDivisionError("by zero")

        device.add_force(broken)
        with self.assertRaisesRegex(ZeroDivisionError, "by zero"):
            device.step()
        self.assertEqual(device.steps, 5)

    def test_a_saved_state_goes_on_to_the_same_bits_with_the_force(self):
        def force(bodies):
            return -bodies.positions

        whole = relcp.Simulation(rods())
        whole.add_force(force)
        whole.step(20)
        half = relcp.Simulation(rods())
        half.add_force(force)
        half.step(9)
        with tempfile.TemporaryDirectory() as place:
            path = os.path.join(place, "state.npz")
            half.save(path)
            again = relcp.Simulation.resume(rods(), path)
        again.add_force(force)
        again.step(11)
        self.assertEqual(again.state_hash, whole.state_hash)


class Runs(unittest.TestCase):
    def test_until(self):
        simulation = relcp.Simulation(balls())
        self.assertEqual(simulation.run(until=0.25)["status"], "interrupted")
        self.assertEqual(simulation.steps, 25)
        simulation.run(until=0.1)
        self.assertEqual(simulation.steps, 25, "a time that is past takes no step")
        simulation.run(until=0.301)
        self.assertEqual(simulation.steps, 31, "the first step at or after it")
        simulation.run(until=1.0)
        self.assertTrue(simulation.done)
        self.assertEqual((simulation.steps, simulation.time), (100, 1.0))
        simulation.run(until=1.2)
        self.assertEqual(simulation.steps, 120)
        for wrong in [float("nan"), float("inf")]:
            with self.assertRaises(ValueError):
                simulation.run(until=wrong)
        odd = relcp.Simulation(balls(time={"dt": 0.3, "end": 1.0}))
        with self.assertRaisesRegex(ValueError, "shorter step"):
            odd.run(until=2.0)
        odd.run(until=0.9)
        self.assertEqual(odd.steps, 3)
        odd.run(until=1.0)
        self.assertEqual((odd.steps, odd.time), (4, 1.0))
        stopped = relcp.Simulation(relcp.Scene.load("colony", {"growth.stop": {"population": 2}}))
        stopped.run()
        with self.assertRaisesRegex(ValueError, "growth.stop"):
            stopped.run(until=100)
        later = relcp.Simulation(relcp.Scene.load("colony", {"growth.stop": {"population": 4}, "time.end": 0.5}))
        later.run()
        self.assertEqual((later.bodies, later.done), (1, True))
        later.run(until=100)
        self.assertEqual((later.bodies, later.done), (4, True))
        self.assertLess(later.time, 10)

    def test_callbacks(self):
        simulation = relcp.Simulation(balls())
        seen = []
        simulation.run(callback=lambda report: seen.append((report.step, simulation.steps)))
        self.assertEqual(seen, [(k, k) for k in range(1, 101)])
        simulation = relcp.Simulation(balls())
        seen.clear()
        simulation.run(callback=lambda report: seen.append(report.step), every=30, until=0.7)
        self.assertEqual(seen, [30, 60, 70])
        for no in [False, np.False_]:
            simulation = relcp.Simulation(balls())
            summary = simulation.run(callback=lambda report: no if report.step == 7 else None)
            self.assertEqual((simulation.steps, summary["status"]), (7, "interrupted"))
        # None, zero and an empty list go on.
        for yes in [None, True, 0, []]:
            simulation = relcp.Simulation(balls())
            simulation.run(callback=lambda report: yes, every=50)
            self.assertEqual(simulation.steps, 100)

        def fails(report):
            raise LookupError(f"at {report.step}")

        simulation = relcp.Simulation(balls())
        with self.assertRaisesRegex(LookupError, "at 10"):
            simulation.run(callback=fails, every=10)
        self.assertEqual(simulation.steps, 10)
        with self.assertRaises(ValueError):
            simulation.run(callback=fails, every=0)
        with self.assertRaises(TypeError):
            simulation.run(callback=3)
        # One that steps the simulation itself: these steps count.
        simulation = relcp.Simulation(balls())
        seen.clear()
        simulation.run(until=0.5, callback=lambda report: (seen.append(report.step), simulation.step(4))[0])
        self.assertEqual(seen, list(range(1, 51, 5)))
        self.assertEqual(simulation.steps, 50)

    def test_an_interrupt_in_a_run_with_callbacks_and_forces(self):
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        simulation = relcp.Simulation(balls(time={"dt": 1e-6, "end": 1e3}))
        simulation.add_force(lambda bodies: np.ones((3, 3)))
        called = []
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            simulation.run(callback=called.append, every=3)
        self.assertGreater(len(called), 0)
        self.assertLess(simulation.steps, simulation.scene.steps)
        simulation.step()

    def test_steps_end_at_the_scenes_end(self):
        simulation = relcp.Simulation(balls())
        self.assertEqual(simulation.step(1_000).step, 100)
        with self.assertRaisesRegex(relcp.SimulationError, "past_end"):
            simulation.step()
        self.assertEqual(simulation.step(5, past_end=True).step, 105)
        with self.assertRaises(TypeError):
            simulation.step(5, True)
        stopped = relcp.Simulation(relcp.Scene.load("colony", {"growth.stop": {"population": 2}}))
        stopped.step(10_000_000)
        self.assertEqual((stopped.bodies, stopped.done), (2, True))


def hash_after(scene):
    """A scene's state after three steps, in a process of its own."""
    simulation = relcp.Simulation(scene, threads=1)
    simulation.step(3)
    return simulation.state_hash


class Scenes(unittest.TestCase):
    def test_they_are_pickled_to_the_last_bit(self):
        odd = {"bodies.0.position.1": 0.1 + 0.2, "time.dt": 1 / 3, "bodies.1.orientation": [0.3, -0.4, 0.5, 0.6]}
        for scene in [relcp.Scene.load(name) for name in relcp.scenes()] + [relcp.Scene.load("two-ellipsoids", odd)]:
            for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
                again = pickle.loads(pickle.dumps(scene, protocol))
                self.assertEqual(again, scene)
                self.assertEqual((again.to_json(), again.hash), (scene.to_json(), scene.hash))

    def test_copies_are_equal(self):
        scene = balls()
        for again in [copy.copy(scene), copy.deepcopy(scene), copy.deepcopy({"a": [scene]})["a"][0]]:
            self.assertEqual(again, scene)
        self.assertNotEqual(scene, balls(2))
        self.assertNotEqual(scene, scene.to_json())
        self.assertFalse(scene == 3)

    def test_they_go_to_other_processes(self):
        scene = balls(forces=[{"uniform": {"force": [1, 0.1, 0]}}])
        with multiprocessing.get_context("spawn").Pool(2) as pool:
            hashes = pool.map(hash_after, [scene, scene, balls()])
        here = hash_after(scene)
        self.assertEqual(hashes[:2], [here, here])
        self.assertNotEqual(hashes[2], here)


if __name__ == "__main__":
    unittest.main()
