"""What README says in Python."""

import pathlib
import re
import unittest


class Readme(unittest.TestCase):
    def test_its_program_runs(self):
        page = pathlib.Path(__file__).parents[2] / "README.md"
        programs = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
        self.assertEqual(len(programs), 1)
        exec(programs[0], {})
