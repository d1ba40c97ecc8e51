"""What a user runs: make in a copy of the project, and a wheel in an empty environment."""

import os
import re
import shutil
import subprocess
import sys

import imageio_ffmpeg
import pytest
from conftest import PROJECT, tree
from uv import find_uv_bin

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


@pytest.mark.parametrize("note", ['"a; touch b"', '"$$HOME \\ #1"', '"it\'s"'])
def test_options_are_kept_as_they_are(note, bare):
    """A shell would run what follows a semicolon."""
    make(bare, "build/options", f"OPTIONS=--note {note}")
    kept = bare / "build" / "options"
    assert kept.read_text() == f"standard povray --note {note.replace('$$', '$')}\n" and not (bare / "b").exists()
    before = kept.stat().st_mtime_ns
    make(bare, "build/options", f"OPTIONS=--note {note}")
    assert kept.stat().st_mtime_ns == before


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


@pytest.mark.parametrize("why", ["interrupted", "another Python", "a copy", "POV-Ray is missing"])
def test_a_new_environment_gets_its_packages_again(why, bare):
    ready = bare / ".venv" / "ready"
    for file in ("charts-ready", "mitsuba/ready"):
        (bare / ".venv" / file).parent.mkdir(exist_ok=True)
        (bare / ".venv" / file).touch()
    assert "pip" not in make(bare, "--dry-run", "bench")
    path, text = os.environ["PATH"], ready.read_text()
    if why == "POV-Ray is missing":
        path = str(bare / "bin")
        (bare / "bin").mkdir()
        for program in ("sh", "cat", "find", "id", "python3", "sed"):
            (bare / "bin" / program).symlink_to(shutil.which(program))
    elif why == "interrupted":
        ready.unlink()
    else:
        stale = {
            "another Python": ("Python 3", "Python 2"),
            "a copy": (" in ", " in /elsewhere"),
        }
        ready.write_text(text.replace(*stale[why]))
    done = subprocess.run(
        [shutil.which("make"), "--dry-run", "bench"], cwd=bare, env={**os.environ, "PATH": path},
        capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    for line in (
        "python3 -m venv .venv\n",
        "--editable .[charts]",
        "install --quiet --disable-pip-version-check mitsuba",
    ):
        assert line in done.stdout, done.stdout + done.stderr


@pytest.mark.release
def test_targets(project):
    small = ["QUALITY=draft", "OPTIONS=--size 64x48 --frames 4"]
    interrupted(project)
    make(project, "movies", *small)
    assert "-m venv" not in make(project, "--dry-run", "frame")
    movies = sorted((project / "movies").glob("*.mp4"))
    assert [path.stem for path in movies] == ["spheres", "vary-alpha", "vary-z1"]
    for path in movies:
        assert imageio_ffmpeg.count_frames_and_secs(str(path)) == (4, pytest.approx(0.4, abs=0.05))
    made = {path: path.stat().st_mtime_ns for path in movies}
    make(project, "movies", *small)
    assert made == {path: path.stat().st_mtime_ns for path in movies}

    # a changed spec, template, quality or option makes a movie again
    spec = project / "movies" / "spheres.toml"
    spec.write_text(spec.read_text().replace("frame_rate = 10", "frame_rate = 20"))
    make(project, "movies/spheres.mp4", *small)
    assert imageio_ffmpeg.count_frames_and_secs(str(movies[0])) == (4, pytest.approx(0.2, abs=0.05))
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


@pytest.mark.release
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
        ["movie", "vary-z1", "--sheet", "none", "--quality", "draft", "--size", "64x48", "--frames", "8", "--quiet"],
        ["demo", "--quiet"],
    ):
        done = subprocess.run([povgen, *arguments], cwd=elsewhere, capture_output=True, text=True, timeout=200)
        assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(path.name for path in elsewhere.iterdir()) == ["demo.html", "vary-z1.mp4", "é.png"]
    listed = subprocess.run([povgen, "list"], cwd=elsewhere, capture_output=True, text=True).stdout
    assert "vary-alpha" in listed and "knight" in listed
