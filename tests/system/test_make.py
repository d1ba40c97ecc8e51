"""What a user runs: make in a copy of the project, and a wheel in an empty environment."""

import os
import re
import shutil
import subprocess
import sys

import imageio_ffmpeg
import pytest
from conftest import PROJECT, tree

pytestmark = pytest.mark.timeout(1500)  # packages come over the network


@pytest.fixture(autouse=True, scope="module")
def real_python():
    """The first python3 on the PATH is a program, and no script of pyenv: make starts it often."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", os.path.join(sys.base_prefix, "bin"), prepend=os.pathsep)
        yield


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    copy = tmp_path_factory.mktemp("user") / "povgen"
    unwanted = shutil.ignore_patterns(".git", ".venv*", "build", "*.mp4", "*.png", "__pycache__", ".pytest_cache")
    shutil.copytree(PROJECT, copy, symlinks=True, ignore=unwanted)
    return copy


def make(project, *arguments):
    done = subprocess.run(["make", *arguments], cwd=project, capture_output=True, text=True, timeout=400)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def interrupted(project):
    """Leave what make leaves if it is stopped: an environment of another Python, without pip and povgen."""
    programs = project / ".venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "python").symlink_to("/nowhere/python3.9")
    (programs / "python3").symlink_to("python")
    (project / ".venv" / "made-by-make").touch()


@pytest.fixture
def bare(tmp_path):
    """A project where make installs nothing. The povgen of its environment writes its arguments into its output."""
    for file in ("Makefile", "pyproject.toml", "movies/spheres.toml", "povgen/__init__.py", "templates/floor.pov.j2"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        shutil.copy2(PROJECT / file, tmp_path / file)
    programs = tmp_path / ".venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "python").symlink_to(sys.executable)
    (programs / "povgen").write_text('#!/bin/sh\necho "$@" > "$(echo "$*" | sed "s/.*-o \\([^ ]*\\).*/\\1/")"\n')
    (programs / "povgen").chmod(0o755)
    python = subprocess.run(["python3", "-VV"], capture_output=True, text=True).stdout.strip()
    (tmp_path / ".venv" / "ready").write_text(f"{python} in {tmp_path}\n")
    (tmp_path / ".venv" / "made-by-make").touch()
    return tmp_path


@pytest.mark.parametrize("arguments", [["clean"], ["-n", "movies", "bench"], ["frame"]], ids=" ".join)
def test_make_keeps_an_environment_that_it_did_not_create(arguments, bare):
    """Also one that took the place of make's own."""
    for folder in (".venv", "mine"):
        shutil.rmtree(bare / folder, ignore_errors=True)
        for file in ("ready", "charts-ready", "test-ready", "mitsuba/ready", "thesis"):
            (bare / folder / file).parent.mkdir(parents=True, exist_ok=True)
            (bare / folder / file).write_text("own")
        (bare / f"{folder}-made-by-make").touch()  # where make's mark once was
        before = tree(bare)
        command = ["make", *arguments, f"VENV={folder}"]
        done = subprocess.run(command, cwd=bare, capture_output=True, text=True, timeout=100)
        refused = arguments == ["frame"]
        assert done.returncode == 2 * refused and ("remove it" in done.stderr) == refused, done.stderr
        assert {path: kept for path, kept in tree(bare).items() if path != bare / "build"} == before


def test_options_are_kept_as_they_are(bare):
    """A shell would run what follows a semicolon."""
    make(bare, "build/options", "OPTIONS=--note 'a; touch b' \"it's $$HOME\"")
    kept = bare / "build" / "options"
    assert kept.read_text() == "standard povray --note 'a; touch b' \"it's $HOME\"\n" and not (bare / "b").exists()


@pytest.mark.parametrize("name", ["", "my env"])
def test_a_name_that_is_no_folder_for_an_environment(name, bare):
    before = tree(bare)
    for target in ("clean", "frame"):
        done = subprocess.run(["make", target, f"VENV={name}"], cwd=bare, capture_output=True, text=True, timeout=100)
        assert done.returncode == 2 and f"VENV = '{name.strip()}': allowed: " in done.stderr
    assert tree(bare) == before


def test_clean_removes_the_folders_that_make_writes_to(bare):
    """Movies, pictures and other files of the user stay."""
    before = tree(bare)
    make(bare, "frame", "demo", "movies/spheres.mp4")
    assert (bare / "build" / "demo.html").exists()
    make(bare, "clean")
    made = {bare / "frame.png", bare / "movies" / "spheres.mp4"}
    assert tree(bare).keys() == made | {path for path in before if ".venv" not in path.parts}
    make(bare, "clean")


@pytest.mark.parametrize("why", ["interrupted", "another Python", "a copy"])
def test_a_new_environment_gets_its_packages_again(why, bare):
    ready = bare / ".venv" / "ready"
    for file in ("charts-ready", "mitsuba/ready"):
        (bare / ".venv" / file).parent.mkdir(exist_ok=True)
        (bare / ".venv" / file).touch()
    assert "pip" not in make(bare, "--dry-run", "bench")
    text = ready.read_text()
    stale = {
        "interrupted": (text, ""),
        "another Python": ("Python 3", "Python 2"),
        "a copy": (" in ", " in /elsewhere"),
    }
    ready.write_text(text.replace(*stale[why]))
    planned = make(bare, "--dry-run", "bench")
    for line in ("python3 -m venv .venv\n", "--editable .[charts]", "--disable-pip-version-check mitsuba"):
        assert line in planned


@pytest.mark.release
def test_targets(project):
    small = ["QUALITY=draft", "OPTIONS=--size 64x48 --frames 4"]
    interrupted(project)
    make(project, "movies", *small)
    assert "-m venv" not in make(project, "--dry-run", "frame")
    movies = sorted((project / "movies").glob("*.mp4"))
    assert [path.stem for path in movies] == ["spheres", "vary-alpha", "vary-z1"]
    for path in movies:
        assert imageio_ffmpeg.count_frames_and_secs(str(path)) == (4, pytest.approx(4 / 15, abs=0.03))
    # a changed template, quality or option makes a movie again
    os.utime(project / "templates" / "floor.pov.j2")
    z1 = "movies/vary-z1.mp4"
    for options in (small, ["QUALITY=draft", "OPTIONS=--size 64x48 --frames 4 --sheet none"]):
        assert f"wrote {z1}" in make(project, z1, *options)
        assert f"wrote {z1}" not in make(project, z1, *options)

    for path in (project / "movies").glob("*.toml"):
        path.write_text(re.sub(r"(?m)^frames = \d+", "frames = 3", path.read_text()))
    made = make(project, "demo", "OPTIONS=--movies --quality draft --size 64x48")
    assert "wrote build/demo.html" in made and len(list((project / "build").glob("demo-*.mp4"))) == 3

    make(project, "frame", "QUALITY=draft", "OPTIONS=--size 64x48")
    assert (project / "frame.png").read_bytes().startswith(b"\x89PNG")
    assert all(word in make(project, "help") for word in ("movies", "frame", "demo", "test-fast", "clean", "QUALITY"))

    make(project, "clean")
    assert not (project / "build").exists() and not (project / ".venv").exists()
