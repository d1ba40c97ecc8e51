"""Unusual names, links, read-only folders, users without a home, missing settings and closed standard files."""

import os
import pty
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import imageio_ffmpeg
import pytest
from conftest import POVGEN, povgen, run_povgen

TINY = ["--size", "64x48", "--sheet", "none"]
SPEC = """
title = "A film"
scene = "chess"
frame_rate = 10
frames = 3
[[sweep]]
parameter = "z1"
start = 2
stop = 4
"""


@pytest.mark.parametrize(
    "name",
    [
        'o\'clock "quoted" `$HOME` ö',
        *(pytest.param(name, marks=pytest.mark.release) for name in ("-dash", "--help", "Größe-回転-🎬", "a%03d\n")),
    ],
)
def test_names(name, tmp_path, monkeypatch):
    """The folder, the cache, the spec and the output have the same unusual name."""
    folder = tmp_path / name
    folder.mkdir()
    (folder / f"{name}.toml").write_text(SPEC)
    monkeypatch.setenv("POVGEN_CACHE", f"{name}/{name}")
    for kind in (".mp4", ".webm", ".gif"):
        arguments = ["movie", "-o", f"{name}/{name}{kind}", *TINY, "--", f"{name}/{name}.toml"]
        status, out, err = povgen(arguments, tmp_path)
        shown = name.replace("\n", "\\n")
        assert (status, out) == (0, f"wrote {shown}/{shown}{kind}\n"), err
    assert povgen(["frame", "chess", *TINY, "-o", f"{name}/{name}.png"], tmp_path)[0] == 0
    assert povgen(["pov", "chess", "-o", f"{name}/{name}.pov"], tmp_path)[0] == 0
    assert imageio_ffmpeg.count_frames_and_secs(str(folder / f"{name}.mp4"))[0] == 3
    kinds = (".gif", ".mp4", ".png", ".pov", ".toml", ".webm", "")
    assert {path.name for path in folder.iterdir()} == {f"{name}{kind}" for kind in kinds}
    assert os.listdir(tmp_path) == [name]


def test_a_link_as_output(tmp_path):
    """The file that it points to is written, and the link stays. A broken link is refused."""
    (tmp_path / "there").mkdir()
    (tmp_path / "link.png").symlink_to("there/frame.png")
    (tmp_path / "movie.gif").symlink_to(tmp_path / "there" / "real.gif")
    assert povgen(["frame", "chess", *TINY, "-o", "link.png"], tmp_path)[0] == 0
    run_povgen("movie", "-", *TINY, "-o", "movie.gif", cwd=tmp_path, input=SPEC)
    assert (tmp_path / "link.png").is_symlink() and (tmp_path / "movie.gif").is_symlink()
    assert (tmp_path / "there" / "frame.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "there" / "real.gif").read_bytes().startswith(b"GIF89a")
    for name, target in (("lost.png", "nowhere/frame.png"), ("circle.png", "circle.png")):
        (tmp_path / name).symlink_to(target)
        status, _, printed = povgen(["frame", "chess", *TINY, "-o", name], tmp_path)
        assert status == 2 and f"output = '{name}'" in printed and "allowed" in printed
    assert sorted(os.listdir(tmp_path / "there")) == ["frame.png", "real.gif"]


def test_a_spec_from_standard_input(tmp_path):
    run_povgen("movie", "-", *TINY, "-o", "a.mp4", cwd=tmp_path, input=SPEC)
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4"))[0] == 3
    for text, word in (("title = 1", "standard input"), ("[", "not TOML"), ("\udc80".join("ab"), "TOML")):
        printed = run_povgen(
            "movie", "-", "-o", "b.mp4", cwd=tmp_path, input=text, status=2, errors="surrogateescape"
        ).stderr
        assert printed.startswith("povgen: standard input: ") and word in printed
    run_povgen("movie", "-", *TINY, cwd=tmp_path, input=SPEC)
    assert sorted(os.listdir(tmp_path)) == ["a.mp4", "movie.mp4"]


@pytest.mark.parametrize(
    "change",
    [
        {"LC_ALL": "C", "LANG": "C", "PYTHONUTF8": None, "PYTHONIOENCODING": None},
        pytest.param({"TMPDIR": "/nowhere", "TERM": None, "COLUMNS": "20"}, marks=pytest.mark.release),
        pytest.param(
            {"HOME": "/nowhere/at/all", "POVGEN_CACHE": "own", "PATH": "/usr/bin:/bin"}, marks=pytest.mark.release
        ),
    ],
    ids=" ".join,
)
def test_surroundings_that_lack_something(change, tmp_path):
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache"), **change}
    environment = {key: value for key, value in environment.items() if value is not None}
    for path in ("é.toml", "ä.mp4"):
        (tmp_path / path).write_text(SPEC)
    printed = run_povgen("movie", "é.toml", *TINY, "-o", "ä.mp4", cwd=tmp_path, env=environment)
    assert "wrote ä.mp4" in printed.stdout
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "ä.mp4"))[0] == 3
    if "LC_ALL" in change:
        assert "ö.toml" in run_povgen("movie", "ö.toml", cwd=tmp_path, env=environment, status=2).stderr


@cache
def ordinary():
    """Return the start of a command line that runs a command without root's rights, if the tests run as root.

    It runs as the user nobody or, if nobody may not start Python, as a root without its rights.
    """
    if os.getuid():
        return []
    nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    # setpriv itself may start what nobody may not, so nobody's Python starts another one
    again = "import os, sys; os.execv(sys.executable, [sys.executable, '-c', ''])"
    starts = subprocess.run([*nobody, sys.executable, "-c", again], capture_output=True).returncode == 0
    return nobody if starts else ["setpriv", "--bounding-set=-all", "--inh-caps=-all"]


def as_nobody(folder, *arguments, status=0, **environment):
    environment = {"PATH": os.environ["PATH"], **environment}
    done = subprocess.run(
        [*ordinary(), POVGEN, *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == status, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done


@pytest.fixture
def open_folder():
    """A folder that every user can reach and write to."""
    folder = Path("/var/tmp" if os.access("/var/tmp", os.W_OK) else "/tmp") / f"povgen-test-{os.getpid()}"
    folder.mkdir()
    folder.chmod(0o777)
    yield folder
    shutil.rmtree(folder)


@pytest.mark.release
def test_an_ordinary_user(open_folder):
    own = str(open_folder / "cache")
    as_nobody(open_folder, "frame", "chess", *TINY, HOME="/nonexistent", POVGEN_CACHE=own)
    as_nobody(open_folder, "movie", "vary-z1", *TINY, "--quality", "draft", "-o", "a.mp4", POVGEN_CACHE=own)
    assert {"a.mp4", "frame.png"} <= set(os.listdir(open_folder))
    printed = as_nobody(open_folder, "check", POVGEN_CACHE=own).stdout
    assert printed.count("ok ") == len(printed.splitlines())


def test_folders_that_cannot_be_written_to(open_folder):
    (open_folder / "shut").mkdir(mode=0o555)
    (open_folder / "shut" / "there.png").write_bytes(b"kept")
    (open_folder / "shut" / "there.png").chmod(0o444)
    own = {"POVGEN_CACHE": str(open_folder / "cache")}
    for arguments in (
        ["frame", "chess", *TINY, "-o", "shut/a.png"],
        ["frame", "chess", *TINY, "-o", "shut/there.png"],
        ["movie", "vary-z1", "-o", "shut/a.mp4"],
    ):
        printed = as_nobody(open_folder, *arguments, status=2, **own).stderr
        assert "shut/" in printed and "allowed" in printed and len(printed.splitlines()) <= 2
    (open_folder / "a.toml").write_text(SPEC)
    as_nobody(open_folder / "shut", "movie", "../a.toml", *TINY, "--shard", "1/3", **own)
    printed = as_nobody(
        open_folder, "frame", "chess", *TINY, status=1, POVGEN_CACHE=str(open_folder / "shut" / "c")
    ).stderr
    assert "Permission denied" in printed and "shut/c" in printed and "POVGEN_CACHE" in printed
    assert os.listdir(open_folder / "shut") == ["there.png"]
    assert not (open_folder / "frame.png").exists()
    shut = {"POVGEN_CACHE": str(open_folder / "shut")}
    done = as_nobody(open_folder, "check", status=1, **shut)
    assert f"FAULT  cache: {open_folder}/shut: Permission denied (" in done.stdout


@pytest.mark.release
def test_files_of_another_user_in_the_cache(open_folder):
    own = {"POVGEN_CACHE": str(open_folder / "cache")}
    as_nobody(open_folder, "frame", "chess", *TINY, **own)
    parts = [open_folder / "cache", *(path for path in (open_folder / "cache").iterdir() if path.is_dir())]
    for part in parts:
        part.chmod(0o555)
    done = as_nobody(open_folder, "cache", "clear", status=1, **own)
    assert done.stdout.startswith("removed 0 frames") and "cache: files that could not be removed: 1\n" in done.stderr
    for part in parts:
        part.chmod(0o777)
    assert as_nobody(open_folder, "cache", "clear", **own).stdout.startswith("removed 1 frame,")


def test_on_a_terminal_and_without(tmp_path):
    """Progress is a bar on a terminal and lines elsewhere. With --quiet there are only errors."""
    (tmp_path / "a.toml").write_text(SPEC)
    arguments = ["movie", "a.toml", *TINY, "-o", "a.mp4"]
    assert "a.mp4: 3/3 frames" in run_povgen(*arguments, cwd=tmp_path).stderr
    assert run_povgen(*arguments, "--quiet", cwd=tmp_path).stderr == ""
    ours, theirs = pty.openpty()
    able = {**os.environ, "TERM": "xterm"}
    process = subprocess.Popen([POVGEN, *arguments], cwd=tmp_path, env=able, stderr=theirs, stdout=theirs, stdin=theirs)
    os.close(theirs)
    shown = b""
    while True:
        try:
            more = os.read(ours, 4096)
        except OSError:
            break
        if not more:
            break
        shown += more
    os.close(ours)
    assert process.wait() == 0 and b"3/3" in shown and b"\x1b[" in shown


@pytest.mark.parametrize("closed", ["<&- >&- 2>&-", pytest.param("2>/dev/full", marks=pytest.mark.release)])
def test_standard_files_that_are_closed(closed, tmp_path):
    """Exit status and files are the same as with open ones. No message gets into another file."""
    (tmp_path / "a.toml").write_text(SPEC)
    script = f'"$0" "$@" {closed}'
    run = ["sh", "-c", script, POVGEN, "movie", "a.toml", *TINY, "-o", "a.mp4"]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, timeout=200)
    assert (done.returncode, done.stderr) == (0, "") and done.stdout == ("" if ">&- " in closed else "wrote a.mp4\n")
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4"))[0] == 3
    run = ["sh", "-c", script, POVGEN, "frame", "chess", "--alpha", "nan"]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, timeout=200)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "")


@pytest.mark.release
def test_the_current_folder_removed(tmp_path):
    """A value that depends on it is refused in one line that names the value. Everything else works."""
    (tmp_path / "a.toml").write_text(SPEC)
    script = 'mkdir gone; cd gone; rmdir ../gone; exec "$0" "$@"'

    def gone(*arguments, **environment):
        run = ["sh", "-c", script, POVGEN, *arguments]
        return subprocess.run(
            run, cwd=tmp_path, env={**os.environ, **environment}, capture_output=True, text=True, timeout=200
        )

    done = gone("movie", tmp_path / "a.toml", *TINY, "-o", tmp_path / "a.mp4")
    assert done.returncode == 0 and (tmp_path / "a.mp4").exists(), done.stderr
    done = gone("check", PATH=f".:{os.environ['PATH']}")
    assert done.returncode == 0 and "FAULT" not in done.stdout
    for arguments, named, environment in (
        (["frame", "chess", *TINY], "output = 'frame.png'", {}),
        (["movie", "vary-z1", *TINY], "output = 'vary-z1.mp4'", {}),
        (["movie", "a.toml"], "a.toml", {}),
        (["demo"], "output = 'demo.html'", {}),
        (["cache", "info"], "POVGEN_CACHE = 'cache'", {"POVGEN_CACHE": "cache"}),
    ):
        done = gone(*arguments, **environment)
        assert done.returncode == 2 and done.stderr.startswith(f"povgen: {named}: "), done.stderr
        assert "allowed: " in done.stderr and len(done.stderr.splitlines()) == 1
