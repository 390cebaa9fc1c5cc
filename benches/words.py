"""Words of the pages for users: prose, lists and hand-made tables, without code, generated tables and docs/scene.md.

    python3 benches/words.py [COMMIT]

Prints one line for each page of docs/ and their sum; with COMMIT the pages as they were there.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def words(text):
    """Words between white space, without fenced code and what `benches/peers/run` and `benches/paper/run` fill."""
    text = re.sub(r"<!-- (peers|paper): (?!end).*?<!-- \1: end -->", "", text, flags=re.S)
    text = re.sub(r"^ *```.*?^ *```", "", text, flags=re.S | re.M)
    return sum(any(letter.isalnum() for letter in word) for word in text.split())


def git(*arguments):
    return subprocess.run(["git", "-C", ROOT, *arguments], check=True, capture_output=True, text=True).stdout


def pages(commit):
    if commit is None:
        return {path.name: path.read_text() for path in sorted((ROOT / "docs").glob("*.md"))}
    names = [line for line in git("ls-tree", "--name-only", commit, "docs/").split() if line.endswith(".md")]
    return {name.removeprefix("docs/"): git("show", f"{commit}:{name}") for name in names}


def main():
    counts = {name: words(text) for name, text in pages(*sys.argv[1:2] or [None]).items() if name != "scene.md"}
    for name, count in counts.items():
        print(f"{count:6} {name}")
    print(f"{sum(counts.values()):6} all pages")


main()
