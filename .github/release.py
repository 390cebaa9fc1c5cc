"""What a release needs, and whether it agrees: versions, names of archives, and what is in them.

    python3 .github/release.py [ARCHIVE...]

Compares Cargo.toml, CITATION.cff, CHANGELOG.md, recipe/recipe.yaml and .github/workflows/release.yml with each other, and
archives that the workflow packed with what `cargo binstall` looks for in them. For a tag (GITHUB_REF_NAME) also its name,
and that Cargo.toml says where the repository is.
"""

import os
import pathlib
import re
import sys
import tarfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
# The endings that `cargo binstall` tries for each of its formats.
ENDINGS = {"tgz": ["tgz", "tar.gz"], "zip": ["zip"]}


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


def found(pattern, name):
    match = re.search(pattern, text(name), re.MULTILINE)
    return match.group(1) if match else None


def versions(cargo):
    version = cargo["workspace"]["package"]["version"]
    others = {
        "CITATION.cff": found(r"^version: (\S+)", "CITATION.cff"),
        "recipe/recipe.yaml": found(r'^  version: "(.*)"', "recipe/recipe.yaml"),
        "CHANGELOG.md": version if f"\n## {version}" in text("CHANGELOG.md") else None,
    }
    return version, [f"{name} has version {other}, Cargo.toml {version}" for name, other in others.items() if other != version]


def targets():
    """Target and ending of the archive of each program that the workflow builds."""
    entry = r"\{ target: (\S+), os: \S+, archive: (\S+) \}"
    return re.findall(entry, text(".github/workflows/release.yml"))


def names(cargo, version):
    """Whether `cargo binstall` finds the archives that the workflow makes, and the program in them."""
    binstall = cargo["package"]["metadata"]["binstall"]
    faults = []
    for target, ending in targets():
        form = binstall.get("overrides", {}).get(target, {}).get("pkg-fmt", binstall["pkg-fmt"])
        fill = {"{ repo }": "", "{ version }": version, "{ target }": target, "{ archive-suffix }": f".{ending}"}
        url = binstall["pkg-url"]
        for key, value in fill.items():
            url = url.replace(key, value)
        if url != f"/releases/download/v{version}/relcp-{target}.{ending}" or ending not in ENDINGS[form]:
            faults.append(f"cargo binstall looks for {url} as {form}, the workflow makes relcp-{target}.{ending}")
    folder = binstall["bin-dir"].split("/")[0].replace("{ target }", "${{ matrix.target }}")
    if f"name={folder}\n" not in text(".github/workflows/release.yml"):
        faults.append(f"cargo binstall looks for the folder {folder}")
    return faults


def contents(archive):
    path = pathlib.Path(archive)
    folder = path.name.removesuffix(".zip").removesuffix(".tar.gz")
    inside = zipfile.ZipFile(path).namelist() if path.suffix == ".zip" else tarfile.open(path).getnames()
    program = "relcp.exe" if "windows" in folder else "relcp"
    wanted = [program, "README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"]
    return [f"{archive} has no {folder}/{name}" for name in wanted if f"{folder}/{name}" not in inside]


def main():
    cargo = tomllib.loads(text("Cargo.toml"))
    version, faults = versions(cargo)
    faults += names(cargo, version)
    for archive in sys.argv[1:]:
        faults += contents(archive)
    tag = os.environ.get("GITHUB_REF_NAME") if os.environ.get("GITHUB_REF_TYPE") == "tag" else None
    if tag and tag != f"v{version}":
        faults.append(f"the tag is {tag}, the version {version}")
    if "repository" not in cargo["package"]:
        message = "Cargo.toml does not say where the repository is, which `cargo binstall` needs"
        faults += [message] if tag else []
        print(f"before a release: {message}")
    print(f"version {version}, {len(targets())} programs, {len(faults)} faults")
    sys.exit("\n".join(faults) or None)


main()
