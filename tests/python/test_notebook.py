"""The example notebook: its cells run, and its page in the documentation has the same code."""

import importlib.util
import json
import pathlib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def cells(kind):
    notebook = json.loads((ROOT / "examples" / "swimmers.ipynb").read_text(encoding="utf-8"))
    return ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == kind]


class Notebook(unittest.TestCase):
    def test_its_cells_run(self):
        draws = importlib.util.find_spec("matplotlib") is not None
        if draws:
            import matplotlib

            matplotlib.use("Agg")
        names, ran = {}, 0
        for source in cells("code"):
            if draws or "plt" not in source:
                exec(compile(source, "swimmers.ipynb", "exec"), names)
                ran += 1
        self.assertGreaterEqual(ran, 4)
        self.assertEqual(names["summary"]["status"], "done")
        # Of random directions the mean cosine is under a half, of those that turned it is not.
        self.assertLess(names["order"][0], 0.5)
        self.assertGreater(names["order"][-1], 0.7)

    def test_its_page_is_of_this_notebook(self):
        page = (ROOT / "docs" / "notebook" / "swimmers.md").read_text(encoding="utf-8")
        for source in cells("code") + cells("markdown"):
            self.assertIn(source.rstrip(";"), page)


if __name__ == "__main__":
    unittest.main()
