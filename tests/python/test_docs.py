"""The examples of docs/python.md, in their order, as one program."""

import os
import pathlib
import re
import tempfile
import unittest
import warnings

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "python.md"


class Page(unittest.TestCase):
    def test_its_examples_run(self):
        programs = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
        self.assertGreaterEqual(len(programs), 6)
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        names = {"__name__": "page"}
        with tempfile.TemporaryDirectory() as place:
            os.chdir(place)
            try:
                for nth, program in enumerate(programs):
                    with self.subTest(example=nth), warnings.catch_warnings():
                        warnings.simplefilter("error")
                        exec(compile(program, f"docs/python.md, example {nth}", "exec"), names)
            finally:
                os.chdir(before)


if __name__ == "__main__":
    unittest.main()
