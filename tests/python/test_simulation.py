"""Simulations: reports, arrays, contacts, threads, interrupts, memory, faults."""

import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import relcp

PROPERTIES = [
    "positions", "orientations", "velocities", "angular_velocities", "lengths", "shapes", "sizes", "groups",
    "ids", "parents", "births", "generations",
]  # fmt: skip


def crowd(steps=1_000_000):
    """Fifty rods that are drawn together for ever."""
    rods = {"count": 50, "shape": {"spherocylinder": {"diameter": 1, "length": 3}}, "volume_fraction": 0.05}
    scene = {
        "name": "crowd",
        "time": {"dt": 0.01, "end": 0.01 * steps},
        "forces": [{"radial_inward": {}}],
        "generate": [{"isotropic": rods}],
    }
    return relcp.Scene.from_dict(scene)


def resident():
    """Bytes of this process that are in memory."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Simulations(unittest.TestCase):
    def test_reports(self):
        simulation = relcp.Simulation(relcp.Scene.load("three-capsules"))
        report = simulation.step()
        self.assertEqual((report.step, report.bodies, report.recursions, report.status), (1, 3, 1, "solved"))
        self.assertLess(report.max_overlap, 1e-5)
        self.assertLess(report.residual, 1e-6)
        self.assertGreater(report.constraints, 0)
        self.assertGreaterEqual(report.products, report.iterations)
        self.assertGreater(report.wall_seconds, 0)
        fields = report.to_dict()
        for name, value in fields.items():
            self.assertEqual(getattr(report, name), value)
        public = {name for name in dir(report) if not name.startswith("_")} - {"to_dict"}
        self.assertEqual(public, set(fields))
        self.assertEqual(simulation.step(3).step, 4)
        self.assertFalse(simulation.done)
        summary = simulation.run()
        self.assertTrue(simulation.done)
        self.assertEqual((summary["status"], summary["steps"], simulation.steps), ("done", 8, 8))
        self.assertEqual(summary["state_hash"], simulation.state_hash)
        self.assertEqual(simulation.step(past_end=True).step, 9)
        with self.assertRaises(ValueError):
            simulation.step(0)
        with self.assertRaises(OverflowError):
            simulation.step(-1)

    def test_bodies_that_pass_are_told_of(self):
        chain = str(pathlib.Path(__file__).parent.parent / "data" / "torn-chain.json")
        # Halves of the step hold it together.
        held = relcp.Simulation(relcp.Scene.load(chain)).step()
        self.assertEqual((held.passed, held.pieces > 1), (0, True))
        # Torn so fast that a 64th of the step is too long as well.
        fast = {"contact.on_failure": "continue", "time.dt": 20, "time.end": 100}
        simulation = relcp.Simulation(relcp.Scene.load(chain, fast))
        report = simulation.step()
        self.assertGreater(report.passed, 0)
        self.assertIsNotNone(report.passed_pair)
        self.assertLess(report.max_overlap, 1e-5)
        summary = simulation.run()
        self.assertEqual(summary["status"], "out_of_tolerance")
        self.assertEqual(tuple(summary["first_passed"][0]["pair"]), report.passed_pair)

    def test_arrays(self):
        simulation = relcp.Simulation(relcp.Scene.load("two-ellipsoids"))
        start = simulation.positions
        self.assertEqual(start.tolist(), [[0.5, 2.5, 0.0], [-0.5, -2.5, 0.0]])
        bodies = simulation.scene.to_dict()["bodies"]
        given = np.array([body["orientation"] for body in bodies])
        self.assertLess(np.abs(simulation.orientations - given).max(), 1e-15)
        self.assertEqual(simulation.lengths.tolist(), [4.0, 4.0])
        self.assertEqual(simulation.sizes.tolist(), [[1.0, 1.0, 2.0]] * 2)
        self.assertEqual(simulation.shapes.tolist(), [2, 2])
        self.assertEqual([simulation.scene.group_names[i] for i in simulation.groups], ["upper", "lower"])
        self.assertEqual(simulation.ids.tolist(), [0, 1])
        self.assertEqual(simulation.parents.tolist(), [relcp.NO_PARENT] * 2)
        simulation.step(10)
        self.assertEqual(start[0, 1], 2.5, "an array is a copy")
        with self.assertRaisesRegex(ValueError, "read-only"):
            start[:] = 7.0
        moved = simulation.positions
        simulation.step()
        velocity = (simulation.positions - moved) / simulation.scene.dt
        self.assertLess(np.abs(velocity - simulation.velocities).max(), 1e-9)

    def test_lineage(self):
        simulation = relcp.Simulation(relcp.Scene.load("colony", {"time.end": 3.0}))
        seen, parents = set(), set()
        while not simulation.done:
            simulation.step(50)
            seen.update(simulation.ids.tolist())
            parents.update(simulation.parents.tolist())
        self.assertGreater(simulation.bodies, 4)
        self.assertEqual(len(set(simulation.ids.tolist())), simulation.bodies)
        self.assertTrue(parents - {relcp.NO_PARENT} <= seen)
        self.assertGreaterEqual(simulation.generations.min(), 2)
        for name in PROPERTIES:
            self.assertEqual(getattr(simulation, name).shape[0], simulation.bodies, name)

    def test_contacts(self):
        simulation = relcp.Simulation(relcp.Scene.load("two-ellipsoids"))
        self.assertEqual(len(simulation.contacts()), 0)
        far = simulation.contacts(10.0)
        self.assertEqual((far.pairs.tolist(), far.gamma.tolist()), ([[0, 1]], [0.0]))
        while True:
            simulation.step(10)
            found = simulation.contacts(1e-3)
            if len(found):
                break
        # Points are on both surfaces, the normal leads from the one to the other over the separation.
        gap = found.point_b - found.point_a
        self.assertLess(np.abs(gap - found.separation[:, None] * found.normal).max(), 1e-9)
        simulation.step(10)
        found = simulation.contacts(1e-3)
        self.assertGreater(found.gamma[0], 0.1)
        self.assertEqual(found.point_a.shape, (1, 3))
        with self.assertRaises(ValueError):
            simulation.contacts(float("nan"))

    def test_walls(self):
        scene = relcp.Scene.from_dict(
            {
                "name": "floor",
                "time": {"dt": 0.01, "end": 2},
                "forces": [{"uniform": {"force": [0, 0, -1]}}],
                "walls": [{"half_space": {"normal": [0, 0, 1], "offset": 0}}],
                "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, 1]}],
            }
        )
        simulation = relcp.Simulation(scene)
        self.assertEqual(len(simulation.wall_contacts()), 0)
        self.assertLessEqual(simulation.run()["final_max_overlap"], 1e-5)
        found = simulation.wall_contacts(1e-4)
        self.assertEqual((found.body.tolist(), found.wall.tolist()), ([0], [0]))
        self.assertLess(np.abs(found.normal[0] - [0, 0, -1]).max(), 1e-12)
        self.assertLess(abs(found.point[0, 2]), 1e-4)

    def test_what_cannot_be_is_refused(self):
        scene = relcp.Scene.load("three-capsules")
        for arguments in [
            {"backend": "tpu"}, {"precision": "f16"}, {"precision": "f32"}, {"adapter": "x"}, {"threads": 0},
            {"threads": 100_000},
        ]:  # fmt: skip
            with self.assertRaises(ValueError, msg=arguments):
                relcp.Simulation(scene, **arguments)
        with self.assertRaises(TypeError):
            relcp.Simulation("three-capsules")
        with self.assertRaisesRegex(relcp.RecordError, "nowhere"):
            relcp.Simulation(scene).save("/nowhere/at/all.npz")

    def test_a_step_that_cannot_be_taken(self):
        # A ball so light that its velocity overflows.
        scene = {
            "name": "wild",
            "dynamics": {"inertial": {"density": 1e-60}},
            "time": {"dt": 1e60, "end": 1e60},
            "contact": {"overlap_tolerance": 1e-59},
            "forces": [{"uniform": {"force": [1e60, 0, 0]}}],
            "bodies": [{"shape": {"sphere": {"radius": 1e-58}}, "position": [0, 0, 0]}],
        }
        simulation = relcp.Simulation(relcp.Scene.from_dict(scene))
        with self.assertRaisesRegex(relcp.SimulationError, "step 1: .*not finite"):
            simulation.step()
        self.assertEqual((simulation.steps, simulation.positions.tolist()), (0, [[0.0, 0.0, 0.0]]))


class Devices(unittest.TestCase):
    def test_they_are_listed(self):
        for adapter in relcp.devices():
            self.assertLessEqual({"name", "kind", "f64", "lacks", "taken"}, set(adapter))

    def test_a_device_that_is_not_there(self):
        with self.assertRaisesRegex(relcp.DeviceError, "no-such-adapter"):
            relcp.Simulation(relcp.Scene.load("three-capsules"), backend="gpu", adapter="no-such-adapter")

    def test_what_only_the_cpu_does(self):
        scene = relcp.Scene.load("three-capsules", {"contact.method": {"multisphere": {"count": 7}}})
        with self.assertRaises(relcp.DeviceError):
            relcp.Simulation(scene, backend="gpu")

    @unittest.skipUnless(os.name == "posix", "other systems have no such variable")
    def test_drivers_are_silent_without_a_runtime_folder(self):
        program = """
import os, relcp
relcp.devices()
scene = relcp.Scene.load("three-capsules")
for backend in ("auto", "gpu"):
    try:
        relcp.Simulation(scene, backend=backend).run()
    except relcp.DeviceError:
        pass
assert "XDG_RUNTIME_DIR" not in os.environ
os.environ["XDG_RUNTIME_DIR"] = "/"
relcp.devices()
assert os.environ["XDG_RUNTIME_DIR"] == "/"
"""
        environment = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"}
        # What relcp itself says of an old driver is a warning of Python, and no noise of the driver.
        command = [sys.executable, "-W", "ignore::RuntimeWarning", "-c", program]
        ran = subprocess.run(command, env=environment, capture_output=True, text=True)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))

    def test_a_run(self):
        if not any(adapter["taken"] for adapter in relcp.devices()):
            if os.environ.get("RELCP_REQUIRE_GPU") == "1":
                self.fail("RELCP_REQUIRE_GPU is set, and there is no adapter")
            self.skipTest("there is no adapter")
        scene = relcp.Scene.load("three-capsules")
        simulation = relcp.Simulation(scene, backend="gpu", precision="f32")
        self.assertEqual((simulation.backend, simulation.precision), ("gpu", "f32"))
        self.assertIsNotNone(simulation.adapter)
        summary = simulation.run()
        self.assertEqual((summary["backend"], summary["status"]), ("gpu", "done"))
        cpu = relcp.Simulation(scene)
        cpu.run()
        self.assertLess(np.abs(simulation.positions - cpu.positions).max(), 1e-3)


class Process(unittest.TestCase):
    @unittest.skipUnless(os.path.exists("/proc/self/statm"), "this system does not tell what is resident so")
    def test_reads_do_not_leak(self):
        simulation = relcp.Simulation(relcp.Scene.load("two-ellipsoids"))
        simulation.step(10)

        def read(times):
            for _ in range(times // len(PROPERTIES)):
                for name in PROPERTIES:
                    getattr(simulation, name)
            for _ in range(times // 100):
                simulation.contacts(10.0).normal

        read(20_000)
        before = resident()
        read(1_000_000)
        after = resident()
        print(f"resident before {before} and after {after} bytes", file=sys.stderr)
        # One leaked array of 48 bytes a read would be 48 MB; allocators and threads keep some of their own.
        self.assertLess(after - before, 4_000_000)

    @unittest.skipUnless(os.path.exists("/proc/self/statm"), "this system does not tell what is resident so")
    def test_simulations_do_not_leak(self):
        scene = relcp.Scene.load("three-capsules")

        def run(times):
            for _ in range(times):
                relcp.Simulation(scene, threads=1).run()

        run(20)
        before = resident()
        run(300)
        after = resident()
        print(f"resident before {before} and after {after} bytes", file=sys.stderr)
        self.assertLess(after - before, 16_000_000)

    def test_other_threads_run_on_meanwhile(self):
        simulation = relcp.Simulation(crowd())
        counted, over = [0], threading.Event()

        def count():
            while not over.is_set():
                counted[0] += 1
                # A while, so that a thread that waits for the interpreter's lock gets it: one of no length may keep it from others for ever.
                time.sleep(1e-4)

        # So long that a thread could not count if the lock were only lent at the interpreter's own pace.
        sys.setswitchinterval(3600.0)
        thread = threading.Thread(target=count)
        thread.start()
        try:
            before = counted[0]
            # A busy machine may give the thread little time: steps go on until it has counted.
            while counted[0] < before + 20 and simulation.steps < 2_000:
                simulation.step(100)
            meanwhile = counted[0] - before
        finally:
            over.set()
            sys.setswitchinterval(0.005)
            thread.join()
        self.assertGreaterEqual(meanwhile, 20)

    def test_one_simulation_in_two_threads(self):
        simulation = relcp.Simulation(crowd())
        threads = [threading.Thread(target=simulation.step, args=(50,)) for _ in range(2)]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            self.assertTrue(np.isfinite(simulation.positions).all())
        for thread in threads:
            thread.join()
        self.assertEqual(simulation.steps, 100)
        alone = relcp.Simulation(crowd())
        alone.step(100)
        self.assertEqual(simulation.state_hash, alone.state_hash)

    def test_an_interrupt_ends_it_between_two_steps(self):
        # A process that was started in the background of a script ignores the signal, and so would this one.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        simulation = relcp.Simulation(crowd())
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        begun = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            simulation.run()
        self.assertGreater(simulation.steps, 0)
        self.assertLess(simulation.steps, simulation.scene.steps)
        print(f"interrupted after {time.monotonic() - begun:.3f} s", file=sys.stderr)
        again = relcp.Simulation(crowd())
        again.step(simulation.steps)
        self.assertEqual(again.state_hash, simulation.state_hash)
        simulation.step()

    @unittest.skipUnless(hasattr(os, "fork"), "this system does not fork")
    def test_a_forked_process(self):
        scene = relcp.Scene.load("three-capsules")
        parents = relcp.Simulation(scene)
        parents.run()

        def child(out):
            try:
                parents.step(past_end=True)
                out.put("stepped its parent's")
            except relcp.SimulationError:
                own = relcp.Simulation(scene)
                own.run()
                out.put(own.state_hash)

        context = multiprocessing.get_context("fork")
        out = context.Queue()
        process = context.Process(target=child, args=(out,))
        process.start()
        self.assertEqual(out.get(timeout=60), parents.state_hash)
        process.join(10)

    def test_version(self):
        self.assertRegex(relcp.__version__, r"^\d+\.\d+\.\d+")
        with tempfile.TemporaryDirectory() as place:
            path = os.path.join(place, "state.npz")
            relcp.Simulation(relcp.Scene.load("three-capsules")).save(path)
            self.assertGreater(os.path.getsize(path), 1000)


if __name__ == "__main__":
    unittest.main()
