"""The stub: what checkers of types say of it, and that it is what the package has."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import relcp

HERE = pathlib.Path(__file__).resolve().parent

# A line each that a checker must refuse.
WRONG = """import relcp
simulation = relcp.Simulation(relcp.Scene.load("colony"))
simulation.step("two")
simulation.positions = 3
simulation.render(colour="hue")
relcp.Run("run").states[0].position
relcp.run("colony", "out")
"""


def installed(name):
    if importlib.util.find_spec(name) is None:
        raise unittest.SkipTest(f"SKIP {name} is not installed")


class Types(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.place = pathlib.Path(place.name)
        (self.place / "wrong.py").write_text(WRONG)
        # The package, where the test put it.
        self.paths = {**os.environ, "MYPYPATH": "", "PYTHONPATH": str(pathlib.Path(relcp.__file__).parent.parent)}

    def check(self, *command):
        ran = subprocess.run(
            [sys.executable, "-m", *map(str, command)], capture_output=True, text=True, cwd=self.place, env=self.paths,
            timeout=300,
        )  # fmt: skip
        return ran.returncode, ran.stdout + ran.stderr

    def test_the_program_that_checkers_read_runs(self):
        sys.path.insert(0, str(HERE))
        self.addCleanup(sys.path.remove, str(HERE))
        import typed

        self.assertEqual(typed.simulate(self.place)["status"], "done")
        self.assertEqual(typed.record(self.place).n_rows, 5)

    def test_mypy(self):
        installed("mypy")
        status, said = self.check("mypy", "--strict", "--no-incremental", HERE / "typed.py")
        self.assertEqual(status, 0, said)
        status, said = self.check("mypy", "--strict", "--no-incremental", "wrong.py")
        lines = {int(line.split(":")[1]) for line in said.splitlines() if ": error:" in line}
        self.assertEqual(lines, {3, 4, 5, 6, 7}, said)

    def test_the_stub_is_what_the_package_has(self):
        installed("mypy")
        allowed = self.place / "allowed"
        # Exceptions have their attributes when they are raised, Cells those of its bodies; users make neither cells nor
        # states; modules with an underscore are the package's own. That Bodies is laid out in Rust is said by typing
        # extensions alone.
        names = ["Bodies", "SceneError\\..*", "Cells\\..*", "Cell\\.__init__", "(States|Pictures|Batch)\\.__init__", "_.*"]
        allowed.write_text("".join(f"relcp\\.{name}\n" for name in names))
        config = self.place / "mypy.ini"
        config.write_text("[mypy]\nignore_missing_imports = True\n")
        options = ["--allowlist", allowed, "--ignore-unused-allowlist", "--mypy-config-file", config]
        status, said = self.check("mypy.stubtest", "relcp", *options)
        self.assertEqual(status, 0, said)

    def test_pyright(self):
        installed("pyright")
        try:
            status, said = self.check("pyright", "--version")
        except subprocess.TimeoutExpired:
            status, said = 1, "its first use took too long"
        if status != 0:
            # It brings a Node of its own when it is first used.
            self.skipTest(f"SKIP pyright cannot run here: {said[-300:]}")
        status, said = self.check("pyright", "--pythonpath", sys.executable, HERE / "typed.py")
        self.assertEqual(status, 0, said)
        status, said = self.check("pyright", "--pythonpath", sys.executable, "wrong.py")
        lines = {int(line.split(":")[-3]) for line in said.splitlines() if " - error:" in line}
        self.assertEqual(lines, {3, 4, 5, 6, 7}, said)


if __name__ == "__main__":
    unittest.main()
