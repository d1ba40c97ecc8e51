"""The wheel and the source distribution, and what says how to install them."""

import re
import subprocess
import tarfile
import tomllib
import zipfile
from email import message_from_bytes

import pytest
from conftest import PROJECT
from uv import find_uv_bin

import povgen
from povgen import remedies

pytestmark = pytest.mark.timeout(600)  # the build's packages come over the network
ABOUT = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return the source distribution and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([find_uv_bin(), "build", "--quiet", "--out-dir", folder, PROJECT], check=True)
    (source,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return source, wheel


@pytest.fixture(scope="module")
def metadata(built):
    with zipfile.ZipFile(built[1]) as wheel:
        (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
        return message_from_bytes(wheel.read(name))


def test_both_are_small_and_hold_what_they_should(built):
    source, wheel = built
    assert source.stat().st_size < 2e6 and wheel.stat().st_size < 1.4e6
    with tarfile.open(source) as file:
        names = {name.partition("/")[2] for name in file.getnames()}
    assert {"pyproject.toml", "hatch_build.py", "LICENSE", "tests/conftest.py", "docs/lesson.md"} <= names
    with zipfile.ZipFile(wheel) as file:
        names = set(file.namelist())
    assert {
        "povgen/templates/floor.pov.j2",
        "povgen/movies/vary-z1.toml",
        "povgen/fonts/NotoSans.ttf",
        "povgen/fonts/NotoSans-Bold.ttf",
        "povgen/fonts/Symbols.otf",
    } <= names
    assert "povgen/rendering/volumes.xz" in names
    assert not [name for name in names if not name.startswith(("povgen/", "povgen-"))]


def test_the_readme_on_an_index_has_absolute_links_to_files_of_this_version(metadata):
    links = re.findall(r"(!?)\[[^][]*\]\(([^)]+)\)", metadata.get_payload(decode=True).decode())
    assert len([link for picture, link in links if picture]) >= 3
    for picture, link in links:
        if link == f"{ABOUT['urls']['Repository']}/releases":
            continue
        start = f"{ABOUT['urls']['Repository']}/{'raw' if picture else 'blob'}/v{povgen.__version__}/"
        assert link.startswith(start) and (PROJECT / link.removeprefix(start).partition("#")[0]).exists(), link


def test_metadata_are_complete(metadata):
    assert metadata["License-Expression"] == "MIT AND OFL-1.1"
    assert metadata.get_all("License-File") == ["LICENSE", "povgen/fonts/Fonts.txt"]
    least = int(re.search(r"3\.(\d+)", metadata["Requires-Python"])[1])
    pythons = [text for text in metadata.get_all("Classifier") if "Python :: 3." in text]
    assert pythons == [f"Programming Language :: Python :: 3.{minor}" for minor in range(least, least + len(pythons))]


def test_every_place_names_this_version():
    version = povgen.__version__
    assert re.search(r"^## (?!Unreleased\n)(\S+)", (PROJECT / "CHANGELOG.md").read_text(), re.M)[1] == version
    assert re.search(r"^version: (\S+)", (PROJECT / "CITATION.cff").read_text(), re.M)[1] == version
    notes = subprocess.run(["make", "--silent", "notes"], cwd=PROJECT, capture_output=True, text=True).stdout
    assert notes.startswith("\n**New**\n") and "\n## " not in notes


def test_all_instructions_install_the_same_packages():
    """The README and docs/install.md say what .ci/install does, and make installs these packages of OpenGL too."""
    steps = (PROJECT / ".ci" / "install").read_text()
    (packages,) = re.findall(r"apt-get install (?:-\S+ )*(.*) > /dev/null", steps)
    needed, gl = packages.split()[:2], packages.split()[2:]
    for page in ("README.md", "docs/install.md"):
        assert f" apt-get install {' '.join(needed)}\n" in (PROJECT / page).read_text()
    extras = set(ABOUT["optional-dependencies"]) - {"docs", "package", "test"}  # those are for developers
    assert extras == set(
        re.findall(r"^\| `pip install 'povgen\[(\w+)\]'`", (PROJECT / "docs/install.md").read_text(), re.M)
    )
    assert f"apt-get install {' '.join(gl)}`" in (PROJECT / "docs" / "install.md").read_text()
    (made,) = re.findall(r"^GL_PACKAGES := (.*(?:\n  .*)*)", (PROJECT / "Makefile").read_text(), re.M)
    assert re.findall(r",,([\w-]+)\)", made) == gl
    assert remedies.PACKAGES["apt-get"]["gl"].split() == gl
