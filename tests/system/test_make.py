"""What a user runs: make in a copy of the project, and a wheel in an empty environment."""

import os
import shutil
import subprocess
import sys

import imageio_ffmpeg
import pytest
from conftest import PROJECT
from uv import find_uv_bin

pytestmark = pytest.mark.timeout(1500)  # packages come over the network


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
    (project / ".venv-made-by-make").touch()


def test_make_keeps_an_environment_that_it_did_not_create(project):
    own = project / ".venv" / "own"
    own.mkdir(parents=True)
    for target in ("frame", "clean"):
        done = subprocess.run(["make", target], cwd=project, capture_output=True, text=True, timeout=100)
        assert own.is_dir()
        assert (done.returncode, "remove it" in done.stderr) == ((2, True) if target == "frame" else (0, False))
    shutil.rmtree(project / ".venv")


def test_targets(project):
    small = ["QUALITY=draft", "OPTIONS=--size 64x48"]
    interrupted(project)
    make(project, "movies", *small)
    assert "-m venv" not in make(project, "--dry-run", "frame")
    movies = sorted((project / "movies").glob("*.mp4"))
    assert [path.stem for path in movies] == ["spheres", "vary-alpha", "vary-z1"]
    for path in movies:
        assert imageio_ffmpeg.count_frames_and_secs(str(path)) == (16, pytest.approx(6.4, abs=0.1))
    made = {path: path.stat().st_mtime_ns for path in movies}
    make(project, "movies", *small)
    assert made == {path: path.stat().st_mtime_ns for path in movies}

    # a changed spec, template, quality or option makes a movie again
    spec = project / "movies" / "spheres.toml"
    spec.write_text(spec.read_text().replace("frame_rate = 10", "frame_rate = 20"))
    make(project, "movies/spheres.mp4", *small)
    assert imageio_ffmpeg.count_frames_and_secs(str(movies[0])) == (16, pytest.approx(3.2, abs=0.1))
    os.utime(project / "templates" / "floor.pov.j2")
    z1 = "movies/vary-z1.mp4"
    for options in (small, ["QUALITY=draft", "OPTIONS=--size 64x48 --sheet none"]):
        assert f"wrote {z1}" in make(project, z1, *options)
        assert f"wrote {z1}" not in make(project, z1, *options)

    made = make(project, "demo", "OPTIONS=--movies --quality draft --size 64x48")
    assert "wrote build/demo.html" in made and len(list((project / "build").glob("demo-*.mp4"))) == 3

    make(project, "frame", *small)
    assert (project / "frame.png").read_bytes().startswith(b"\x89PNG")
    assert all(word in make(project, "help") for word in ("movies", "frame", "demo", "test-fast", "clean", "QUALITY"))

    # make creates a new environment after an interruption, for another Python, and in a copy of the checkout
    ready = project / ".venv" / "ready"
    whole = ready.read_text()
    for stale in ("", whole.replace("Python 3", "Python 2"), whole.replace(" in ", " in /elsewhere"), None):
        ready.unlink() if stale is None else ready.write_text(stale)
        (project / ".venv" / "charts-ready").touch()
        assert "python3 -m venv .venv" in make(project, "--dry-run", "bench")
        assert "[charts]" in make(project, "--dry-run", "bench")  # and installs again what it had
        ready.write_text(whole)
    make(project, "clean")
    assert not list(project.rglob("*.mp4")) and not (project / ".venv").exists()


def test_the_wheel_works_from_any_folder(project, tmp_path):
    uv = find_uv_bin()
    # from the source distribution, as a packager does
    subprocess.run([uv, "build", "--quiet", "--sdist", "-o", tmp_path], cwd=project, check=True, timeout=200)
    (source,) = tmp_path.glob("povgen-*.tar.gz")
    python = tmp_path / "venv" / "bin" / "python"
    subprocess.run([uv, "venv", "--quiet", "--python", sys.executable, tmp_path / "venv"], check=True)
    subprocess.run([uv, "pip", "install", "--quiet", "--python", python, source], check=True, timeout=300)
    elsewhere = tmp_path / "else where"
    elsewhere.mkdir()
    povgen = tmp_path / "venv" / "bin" / "povgen"
    for arguments in (
        ["check"],
        ["frame", "spheres", "--z1", "2", "--z1", "4", "--size", "64x48", "-o", "é.png"],
        ["movie", "vary-z1", "--sheet", "none", "--quality", "draft", "--size", "64x48", "--quiet"],
        ["demo", "--quiet"],
    ):
        done = subprocess.run([povgen, *arguments], cwd=elsewhere, capture_output=True, text=True, timeout=200)
        assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(path.name for path in elsewhere.iterdir()) == ["demo.html", "vary-z1.mp4", "é.png"]
    listed = subprocess.run([povgen, "list"], cwd=elsewhere, capture_output=True, text=True).stdout
    assert "vary-alpha" in listed and "knight" in listed
