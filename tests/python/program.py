"""The program, where a test compares the package with it."""

import os
import pathlib
import shutil
import subprocess
import unittest

# Seconds after which a program hangs.
LONGEST = 3600 if "RELCP_ALL_SCENES" in os.environ else 300
ROOT = pathlib.Path(__file__).resolve().parents[2]


def program():
    """The program that RELCP_PROGRAM names, or that was built here, or that is on the path."""
    named = os.environ.get("RELCP_PROGRAM")
    built = [ROOT / "target" / profile / "relcp" for profile in ("release", "debug")]
    for candidate in [named] if named else [*built, shutil.which("relcp")]:
        if candidate and pathlib.Path(candidate).exists():
            return str(candidate)
    raise unittest.SkipTest("there is no program: build it, or name it in RELCP_PROGRAM")


def relcp(*arguments):
    """Runs the program and returns what it says on standard output."""
    ran = subprocess.run([program(), *map(str, arguments)], capture_output=True, text=True, timeout=LONGEST)
    if ran.returncode != 0:
        raise AssertionError(f"{arguments}: status {ran.returncode}\n{ran.stderr}")
    return ran.stdout
