"""Pictures as arrays, and pages in notebooks."""

import html
import importlib.util
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import zlib

import numpy as np
import relcp
from program import relcp as program


def png(path):
    """A PNG file of 8-bit red, green, blue, and opacity where it has some, as (height, width, 3 or 4)."""
    bytes_, at, packed = path.read_bytes(), 8, b""
    while at < len(bytes_):
        length, kind = struct.unpack(">I4s", bytes_[at : at + 8])
        chunk = bytes_[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colours = struct.unpack(">IIBB", chunk[:10])
            assert depth == 8
            of_pixel = {2: 3, 6: 4}[colours]
        elif kind == b"IDAT":
            packed += chunk
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * of_pixel)
    image = np.zeros((height + 1, width + 1, of_pixel), np.int64)
    for y in range(height):
        kind, row = rows[y, 0], rows[y, 1:].reshape(width, of_pixel).astype(np.int64)
        for x in range(width):
            left, up, corner = image[y + 1, x], image[y, x + 1], image[y, x]
            if kind == 4:
                distances = [abs(left + up - corner - own) for own in (left, up, corner)]
                nearest = np.where(
                    (distances[0] <= distances[1]) & (distances[0] <= distances[2]), left,
                    np.where(distances[1] <= distances[2], up, corner),
                )  # fmt: skip
            else:
                nearest = [0, left, up, (left + up) // 2][kind]
            image[y + 1, x + 1] = (row[x] + nearest) % 256
    return image[1:, 1:].astype(np.uint8)


class Pictures(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.place = pathlib.Path(place.name)

    def test_they_are_those_of_the_program(self):
        scene = relcp.Scene.load("colony", {"time.dt": 0.01, "time.end": 3, "output.every": 1, "output.picture": False})
        run = relcp.run(scene, self.place / "run", progress=False)
        simulation = relcp.Simulation(scene)
        simulation.run()
        for look, options in [
            ({}, []),
            ({"colour": "age", "view": "oblique"}, ["--colour", "age", "--view", "oblique"]),
            ({"colour": "length", "range": (1.0, 3.0)}, ["--colour", "length", "--range", "1:3"]),
            ({"background": "transparent", "words": False}, ["--background", "transparent", "--bare"]),
            ({"background": "dark", "colour": "pressure"}, ["--background", "dark", "--colour", "pressure"]),
        ]:
            options += ["--last", "--size", "96x54", "--no-movie", "--out", self.place / "pictures"]
            program("render", run.path, *options)
            theirs = png(self.place / "pictures" / "frames" / "000000.png")
            mine = run.render(width=96, **look)
            self.assertEqual((mine.shape, mine.dtype), ((54, 96, 4), np.uint8))
            np.testing.assert_array_equal(mine[:, :, : theirs.shape[2]], theirs, str(look))
            if theirs.shape[2] == 3:
                self.assertEqual(set(mine[:, :, 3].flat), {255})
            np.testing.assert_array_equal(simulation.render(96, **look), mine)
        self.assertGreater(len(np.unique(mine.reshape(-1, 4), axis=0)), 50)
        early, late = run.render(1.4, width=96), run.render(1.0, width=96)
        np.testing.assert_array_equal(early, late)
        self.assertTrue((early != run.render(0.0, width=96)).any())

    def test_pictures_of_a_run_have_one_camera(self):
        scene = relcp.Scene.load("colony", {"time.dt": 0.01, "time.end": 3, "output.every": 1, "output.picture": False})
        run = relcp.run(scene, self.place / "run", progress=False)
        options = ["--size", "96x54", "--no-movie", "--colour", "length", "--out", self.place / "pictures"]
        program("render", run.path, *options)
        pictures = run.pictures(96, colour="length")
        self.assertEqual(len(pictures), 4)
        for nth, mine in enumerate(pictures):
            theirs = png(self.place / "pictures" / "frames" / f"{nth:06}.png")
            np.testing.assert_array_equal(mine[:, :, :3], theirs)
        each = run.pictures(96, colour="length", fit="each", start=1, every=2)
        self.assertEqual(len(each), 2)
        for mine, time in zip(each, [1.0, 3.0]):
            np.testing.assert_array_equal(mine, run.render(time, 96, colour="length"))
        np.testing.assert_array_equal(pictures[-2:][1], pictures[-1])
        with self.assertRaises(IndexError):
            pictures[4]
        for arguments, exception, said in [
            (dict(color="red"), TypeError, "color: no such argument; view, colour"),
            (dict(fit="all"), ValueError, "fit"),
            (dict(every=0), ValueError, "every"), (dict(start=9), ValueError, "none of the 4 states is at time 9"),
        ]:  # fmt: skip
            with self.assertRaisesRegex(exception, said):
                run.pictures(**arguments)
        movie = run.movie(self.place / "movie.png", 96, colour="length", frames_a_second=5)
        bytes_ = movie.read_bytes()
        self.assertEqual((bytes_[:4], bytes_.count(b"acTL"), bytes_.count(b"fcTL")), (b"\x89PNG", 1, 4))
        with self.assertRaisesRegex(ValueError, "a movie's name ends in .png, .apng"):
            run.movie(self.place / "movie.gif")
        with unittest.mock.patch.dict("os.environ", {"PATH": str(self.place)}):
            with self.assertRaisesRegex(relcp.RecordError, "`ffmpeg` is not on the path\ninstall ffmpeg"):
                run.movie(self.place / "movie.mp4")
        self.assertEqual(sorted(path.name for path in self.place.iterdir()), ["movie.png", "pictures", "run"])

    def test_a_ball_is_round_and_in_the_middle(self):
        ball = relcp.Scene({
            "name": "ball", "time": {"dt": 0.01, "end": 1},
            "bodies": [{"shape": {"sphere": {"radius": 2}}, "position": [7, -3, 1]}],
        })  # fmt: skip
        simulation = relcp.Simulation(ball)
        for view in ["top", "front", "right", "oblique"]:
            picture = simulation.render(120, 100, view=view, colour="plain", background="transparent", words=False)
            ys, xs = np.nonzero(picture[:, :, 3] > 127)
            self.assertLess(abs(xs.mean() - 59.5), 0.1)
            self.assertLess(abs(ys.mean() - 49.5), 0.1)
            self.assertLessEqual(abs((xs.max() - xs.min()) - (ys.max() - ys.min())), 1)
            radius = (xs.max() - xs.min() + 1) / 2
            self.assertLess(abs(len(xs) / (np.pi * radius**2) - 1), 0.03)

    def test_wrong_arguments(self):
        simulation = relcp.Simulation(relcp.Scene.load("two-ellipsoids"))
        for arguments, said in [
            (dict(width=0), "width: expected 1 to 16384 pixels"), (dict(height=99999), "height"),
            (dict(view="left"), "view: expected one of top, front, right, oblique, found \"left\""),
            (dict(colour="hue"), "colour: expected one of orientation, age"), (dict(background="red"), "background"),
            (dict(colour="length", range=(2, 1)), "range"), (dict(range=(0, 1)), "orientation has no scale|scale"),
            (dict(colour="age"), "no body was born"),
        ]:  # fmt: skip
            with self.assertRaisesRegex(ValueError, said):
                simulation.render(**arguments)
        with self.assertRaises((OverflowError, TypeError)):
            simulation.render(-1)
        with self.assertRaisesRegex(ValueError, "colour"):
            simulation.show(colour="hue")

    def test_pages_are_shown_as_frames(self):
        scene = relcp.Scene.load("two-ellipsoids", {"name": 'a "quoted" <b>name', "time.end": 0.2, "output.every": 0.1})
        simulation = relcp.Simulation(scene)
        simulation.step(10)
        page = simulation.show(height=400)
        frame = page._repr_html_()
        self.assertTrue(frame.startswith("<iframe ") and frame.endswith("></iframe>"))
        self.assertIn('style="width: 100%; height: 400px; border: 0"', frame)
        attributes = frame[len("<iframe ") : -len("></iframe>")]
        source = attributes.split('srcdoc="')[1]
        self.assertEqual(source.count('"'), 1)
        self.assertEqual(html.unescape(source[:-1]), page.html)
        self.assertIn('id="state-0"', page.html)
        self.assertNotIn('id="state-1"', page.html)
        saved = page.save(self.place / "page.html")
        self.assertEqual(saved.read_text(encoding="utf-8"), page.html)
        self.assertEqual([path.name for path in self.place.iterdir()], ["page.html"])
        run = relcp.run(scene, self.place / "run", progress=False)
        whole = run.show("640px", 480)
        self.assertEqual((whole.width, whole.height), ("640px", "480px"))
        self.assertEqual(whole.html.count('id="state-'), 3)
        self.assertEqual(run.view().read_text(encoding="utf-8"), whole.html)
        self.assertEqual(run.states[1].show().html.count('id="state-'), 1)
        for wrong in [0, -3, [], None.__class__]:
            with self.assertRaisesRegex(ValueError, "width"):
                simulation.show(width=wrong)

    def test_notebooks_show_them(self):
        if importlib.util.find_spec("IPython") is None:
            self.skipTest("IPython is not installed")
        from IPython.core.formatters import DisplayFormatter

        page = relcp.Simulation(relcp.Scene.load("three-capsules")).show(300, 200)
        shown, _ = DisplayFormatter().format(page)
        self.assertEqual(shown["text/html"], page._repr_html_())

    def test_the_package_needs_numpy_alone(self):
        code = (
            "import sys\n"
            "for name in ['pandas', 'tqdm', 'IPython', 'matplotlib']: sys.modules[name] = None\n"
            "import relcp\n"
            "assert not {'numpy', 'tempfile', 'json'} & set(sys.modules), sorted(sys.modules)\n"
            "simulation = relcp.Simulation(relcp.Scene.load('three-capsules'))\n"
            "assert simulation.render(64).shape == (36, 64, 4)\n"
            "assert 'iframe' in simulation.show()._repr_html_()\n"
        )
        subprocess.run([sys.executable, "-c", code], check=True, timeout=120)


if __name__ == "__main__":
    unittest.main()
