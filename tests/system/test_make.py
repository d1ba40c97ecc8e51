"""The user's way: make's own targets in a copy of the project, and the wheel in an empty environment."""

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


def left_by_an_interrupted_make(project):
    """An environment that was being made by another Python when make was stopped: it has neither pip nor povgen."""
    bin = project / ".venv" / "bin"
    bin.mkdir(parents=True)
    (bin / "python").symlink_to("/nowhere/python3.9")
    (bin / "python3").symlink_to("python")
    (project / ".venv-made-by-make").touch()


def test_an_environment_that_is_not_make_s_is_left_alone(project):
    own = project / ".venv" / "own"
    own.mkdir(parents=True)
    for target in ("frame", "clean"):
        done = subprocess.run(["make", target], cwd=project, capture_output=True, text=True, timeout=100)
        assert own.is_dir()
        assert (done.returncode, "remove it" in done.stderr) == ((2, True) if target == "frame" else (0, False))
    shutil.rmtree(project / ".venv")


def test_targets_at_draft_quality(project):
    left_by_an_interrupted_make(project)
    make(project, "movies", "QUALITY=draft")
    assert "-m venv" not in make(project, "--dry-run", "frame")
    movies = sorted((project / "movies").glob("*.mp4"))
    assert [path.stem for path in movies] == ["spheres", "vary-alpha", "vary-z1"]
    for path in movies:
        frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
        assert frames == 16 and seconds == pytest.approx(6.4, abs=0.1)
    made = {path: path.stat().st_mtime_ns for path in movies}

    make(project, "movies", "QUALITY=draft")
    assert made == {path: path.stat().st_mtime_ns for path in movies}

    # each of these makes a movie again, from the frames that it can keep
    spec = project / "movies" / "spheres.toml"
    spec.write_text(spec.read_text().replace("frame_rate = 10", "frame_rate = 20"))
    make(project, "movies/spheres.mp4", "QUALITY=draft")
    assert imageio_ffmpeg.count_frames_and_secs(str(movies[0])) == (16, pytest.approx(3.2, abs=0.1))
    os.utime(project / "templates" / "floor.pov.j2")
    assert "vary-z1" in make(project, "movies/vary-z1.mp4", "QUALITY=draft")
    assert "vary-z1" in make(project, "--dry-run", "movies/vary-z1.mp4", "QUALITY=high")

    assert "wrote build/demo/index.html" in make(project, "demo", "QUALITY=draft")
    assert len(list((project / "build" / "demo" / "frames").glob("*.webp"))) == 96

    make(project, "frame", "QUALITY=draft")
    assert (project / "frame.png").read_bytes().startswith(b"\x89PNG")
    assert all(word in make(project, "help") for word in ("movies", "frame", "demo", "test", "clean", "QUALITY"))
    # the environment is made anew where an installation was interrupted, for another Python, and in a copied checkout
    ready = project / ".venv" / "ready"
    whole = ready.read_text()
    for stale in ("", whole.replace("Python 3", "Python 2"), whole.replace(" in ", " in /elsewhere"), None):
        ready.unlink() if stale is None else ready.write_text(stale)
        (project / ".venv" / "charts-ready").touch()
        assert "python3 -m venv .venv" in make(project, "--dry-run", "bench")
        assert "[charts]" in make(project, "--dry-run", "bench")  # with all that had been installed
        ready.write_text(whole)
    make(project, "clean")
    assert not list(project.rglob("*.mp4")) and not (project / ".venv").exists()


def test_the_wheel_works_from_any_folder(project, tmp_path):
    uv = find_uv_bin()
    # by way of the source distribution, as a packager would
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
        ["demo", "vary-z1", "--quality", "draft", "--size", "64x48", "--quiet"],
    ):
        done = subprocess.run([povgen, *arguments], cwd=elsewhere, capture_output=True, text=True, timeout=200)
        assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(path.name for path in elsewhere.iterdir()) == ["demo", "vary-z1.mp4", "é.png"]
    listed = subprocess.run([povgen, "list"], cwd=elsewhere, capture_output=True, text=True).stdout
    assert "vary-alpha" in listed and "knight" in listed
