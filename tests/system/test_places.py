"""Unusual names, links, read-only folders, users without a home, missing settings and closed standard files."""

import os
import pty
import subprocess
from contextlib import suppress

import conftest
import imageio_ffmpeg
import pytest
from conftest import POVGEN, povgen, refused, run_povgen, some

TINY = ["--size", "64x48", "--sheet", "none"]
SPEC = conftest.SPEC.replace("frames = 8", "frames = 3")


@pytest.mark.parametrize(
    "name",
    some(['o\'clock "quoted" `$HOME` ö', "--help", "Größe-回転-🎬", "a%03d\n"], 1),
)
def test_names(name, tmp_path, monkeypatch):
    """The folder, the cache, the spec and the output have the same unusual name."""
    folder = tmp_path / name
    folder.mkdir()
    (folder / f"{name}.toml").write_text(SPEC)
    monkeypatch.setenv("POVGEN_CACHE", f"{name}/{name}")
    for kind in (".mp4", ".gif"):
        arguments = ["movie", "-o", f"{name}/{name}{kind}", *TINY, "--", f"{name}/{name}.toml"]
        status, out, err = povgen(arguments, tmp_path)
        shown = name.replace("\n", "\\n")
        assert (status, out) == (0, f"wrote {shown}/{shown}{kind}\n"), err
    assert povgen(["frame", "chess", *TINY, "-o", f"{name}/{name}.png"], tmp_path)[0] == 0
    assert povgen(["pov", "chess", "-o", f"{name}/{name}.pov"], tmp_path)[0] == 0
    kinds = (".gif", ".mp4", ".png", ".pov", ".toml", "")
    made = {path.name for path in folder.iterdir()}
    (mountains,) = made - {f"{name}{kind}" for kind in kinds}
    assert mountains.startswith("picture-") and len(made) == 7
    assert os.listdir(tmp_path) == [name]


def test_a_link_as_output(tmp_path):
    """The file that it points to is written, and the link stays. A broken link is refused."""
    (tmp_path / "there").mkdir()
    (tmp_path / "link.png").symlink_to("there/frame.png")
    (tmp_path / "movie.gif").symlink_to(tmp_path / "there" / "real.gif")
    assert povgen(["frame", "chess", *TINY, "-o", "link.png"], tmp_path)[0] == 0
    assert povgen(["movie", "-", *TINY, "-o", "movie.gif"], tmp_path, SPEC.encode())[0] == 0
    assert (tmp_path / "link.png").is_symlink() and (tmp_path / "movie.gif").is_symlink()
    assert (tmp_path / "there" / "frame.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "there" / "real.gif").read_bytes().startswith(b"GIF89a")
    for name, target in (("lost.png", "nowhere/frame.png"), ("circle.png", "circle.png")):
        (tmp_path / name).symlink_to(target)
        status, _, printed = povgen(["frame", "chess", *TINY, "-o", name], tmp_path)
        assert status == 2 and f"output = '{name}'" in printed and "allowed" in printed
    assert sorted(os.listdir(tmp_path / "there")) == ["frame.png", "real.gif"]


@pytest.mark.release
def test_a_spec_from_standard_input(tmp_path):
    assert povgen(["movie", "-", *TINY, "-o", "a.mp4"], tmp_path, SPEC.encode())[0] == 0
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4"))[0] == 3
    for text, word in ((b"title = 1", "standard input"), (b"[", "not TOML"), (b"a\x80b", "TOML")):
        status, _, printed = povgen(["movie", "-", "-o", "b.mp4"], tmp_path, text)
        assert status == 2 and printed.startswith("povgen: standard input: ") and word in printed
    run_povgen("movie", "-", *TINY, cwd=tmp_path, input=SPEC)
    assert sorted(os.listdir(tmp_path)) == ["a.mp4", "movie.mp4"]


@pytest.mark.release
def test_surroundings_that_lack_something(tmp_path):
    """A locale without UTF-8, no home, no terminal, and a folder of temporary files that does not exist."""
    environment = {**os.environ, "LC_ALL": "C", "LANG": "C", "HOME": "/nowhere", "TMPDIR": "/nowhere"}
    for name in ("PYTHONUTF8", "PYTHONIOENCODING", "TERM"):
        environment.pop(name, None)
    (tmp_path / "é.toml").write_text(SPEC)
    printed = run_povgen("movie", "é.toml", *TINY, "-o", "ä.mp4", cwd=tmp_path, env=environment)
    assert "wrote ä.mp4" in printed.stdout and (tmp_path / "ä.mp4").exists()
    assert "ö.toml" in run_povgen("movie", "ö.toml", cwd=tmp_path, env=environment, status=2).stderr


def test_folders_that_cannot_be_written_to(tmp_path, monkeypatch):
    """Nobody can make files in /proc."""
    for line in (["frame", "chess", *TINY, "-o", "/proc/a.png"], ["movie", "vary-z1", "-o", "/proc/a.mp4"]):
        said = refused(line, tmp_path)
        assert "'/proc/a." in said and "allowed" in said
    monkeypatch.setenv("POVGEN_CACHE", "/proc/cache")
    status, _, said = povgen(["frame", "chess", *TINY], tmp_path)
    assert status == 1 and "/proc/cache" in said and "POVGEN_CACHE" in said
    status, printed, _ = povgen(["check"], tmp_path)
    assert status == 1 and "FAULT  cache: /proc/cache: " in printed and not os.listdir(tmp_path)


def test_on_a_terminal_and_without(tmp_path):
    """Progress is a bar on a terminal and lines elsewhere. With --quiet there are only errors."""
    (tmp_path / "a.toml").write_text(SPEC)
    arguments = ["movie", "a.toml", *TINY, "-o", "a.mp4"]
    assert "a.mp4: 3/3 frames" in povgen(arguments, tmp_path)[2]
    assert povgen([*arguments, "--quiet"], tmp_path)[2] == ""
    ours, theirs = pty.openpty()
    able = {**os.environ, "TERM": "xterm"}
    process = subprocess.Popen([POVGEN, *arguments], cwd=tmp_path, env=able, stderr=theirs, stdout=theirs, stdin=theirs)
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # at the end
        while more := os.read(ours, 4096):
            shown += more
    os.close(ours)
    assert process.wait() == 0 and b"3/3" in shown and b"\x1b[" in shown
