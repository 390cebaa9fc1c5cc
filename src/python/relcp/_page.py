"""The page of `relcp view` as an object that notebooks show."""

import html
import os
import pathlib
import tempfile

WIDTH, HEIGHT = "100%", 600


def _length(value, name):
    """A number of pixels, or a length of CSS."""
    if isinstance(value, str):
        return value
    try:
        pixels = int(value)
    except (TypeError, ValueError):
        pixels = 0
    if pixels < 1:
        raise ValueError(f"{name}: expected a number of pixels, or text such as '100%', found {value!r}")
    return f"{pixels}px"


class Page:
    """A page that shows states in any browser, without a network.

    A notebook shows it as a frame of `width` and `height`: numbers of pixels, or text such as "100%". `html` is its
    text, `save(path)` writes it.
    """

    def __init__(self, text, width=None, height=None):
        self.html = text
        self.width = _length(WIDTH if width is None else width, "width")
        self.height = _length(HEIGHT if height is None else height, "height")

    def save(self, path):
        """Writes the page, whole or not at all; returns its path."""
        path = pathlib.Path(path)
        handle, part = tempfile.mkstemp(prefix=".relcp-", suffix=".part", dir=path.parent)
        try:
            with open(handle, "w", encoding="utf-8", newline="") as file:
                file.write(self.html)
            # As any new file: a temporary one is its owner's alone.
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(part, 0o666 & ~mask)
            os.replace(part, path)
        except BaseException:
            pathlib.Path(part).unlink(missing_ok=True)
            raise
        return path

    def _repr_html_(self):
        # The page needs its scripts, and nothing of the notebook around it.
        page, width, height = (html.escape(text, quote=True) for text in (self.html, self.width, self.height))
        style = f"width: {width}; height: {height}; border: 0"
        return f'<iframe sandbox="allow-scripts allow-downloads" style="{style}" srcdoc="{page}"></iframe>'

    def __repr__(self):
        return f"Page({len(self.html) / 1e6:.2f} MB; a notebook shows it, save(path) writes it)"
