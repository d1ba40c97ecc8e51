"""Scenes and processes that try what they must not: read or write other files, run commands, run or grow for ever."""

import errno
import os
import signal
import socket
import subprocess
from types import SimpleNamespace

import pytest
from conftest import POVGEN, povgen, some

from povgen import Chess, PovrayError, Rendering, render
from povgen.errors import TransientError
from povgen.inputs import pictures
from povgen.inputs.pieces import PieceFile, as_piece
from povgen.rendering import frames, povray, sandbox
from povgen.rendering.volumes import volumes

TINY = Rendering(size=(32, 32), antialias="off", timeout=200)
HUNGRY = "sphere { 0, 2 pigment { image_map { function 30000, 30000 { x } } } }"  # takes more memory than it may
SHORT = TINY.model_copy(update={"timeout": 1.0})
SCENE = """\
#version 3.7;
{}
camera {{ location -3*z look_at 0 }}
light_source {{ -9, 1 }}
sphere {{ 0, 1 pigment {{ rgb 1 }} }}
"""
landlock = pytest.mark.skipif(not sandbox.version(), reason="this kernel has no Landlock")


def run(tried, folder, rendering=TINY):
    """Render a scene that tries something. POV-Ray's work folder is work/1."""
    (folder / "work").mkdir()
    return povray.run(SCENE.format(tried), rendering, folder / "work")


def refused(tried, folder, *words):
    with pytest.raises(PovrayError) as failure:
        run(tried, folder)
    message = str(failure.value)
    assert message.startswith("POV-Ray") and len(message.splitlines()) <= 2
    assert all(word in message for word in words), message
    return message


def test_what_a_scene_may_do(tmp_path):
    """It may read POV-Ray's own include files, and write and read one file in the work folder."""
    own = '#fopen F "data.txt" write #write(F, "7,") #fclose F #fopen F "data.txt" read #read(F, N) #fclose F'
    includes = '#include "colors.inc" #include "textures.inc" sphere { 0, N texture { Polished_Chrome } }'
    assert run(f"{own}\n{includes}", tmp_path).is_file()
    assert (tmp_path / "work/1" / povray.DATA).read_text() == "7,"


@landlock
@pytest.mark.parametrize(
    "name", some(["{folder}/secret.txt", "../../secret.txt", "/proc/self/environ", "/usr/lib/os-release"], 1)
)
@pytest.mark.parametrize("way", ['#include "{}"', '#fopen F "{}" read #read(F, S) #error S'])
def test_no_other_file_is_read(name, way, tmp_path):
    (folder := tmp_path / (80 * "n" + "  n")).mkdir()  # POV-Ray breaks lines of its messages, also within words
    for secret in (tmp_path, folder):
        (secret / "secret.txt").write_text('"hidden"\n')
    name = name.format(folder=folder)
    assert "hidden" not in refused(way.format(name), tmp_path, "line 2", f"no file {name!r} that it may read")


@landlock
@pytest.mark.parametrize(
    ("name", "way"), some([("{folder}/kept.txt", "append"), ("{home}/written.txt", "write")], 1, several=True)
)
def test_nothing_is_written_outside_the_work_folder(name, way, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    (tmp_path / "kept.txt").write_text("kept")
    name = name.format(folder=tmp_path, home=tmp_path / "home")
    refused(f'#fopen F "{name}" {way} #write(F, "x")', tmp_path, "line 2", "Cannot open")
    assert not list(tmp_path.rglob("written.txt")) and (tmp_path / "kept.txt").read_text() == "kept"


@landlock
@pytest.mark.parametrize("name", some(["new.txt", "scene.pov", ".povray/3.7/povray.conf"], 2))
def test_a_scene_makes_no_file_and_changes_none_of_povgens(name, tmp_path):
    """So the sum of what it writes is bounded by the limit for a file, however many names it tries."""
    refused(f'#fopen F "{name}" write #write(F, "x")', tmp_path, "line 2", "Cannot open")
    made = {path.name for path in (tmp_path / "work/1").iterdir()}
    assert made == {"scene.pov", "fatal.log", "data.txt", "frame.png", "frame.pov-state", ".povray"}


@landlock
@pytest.mark.parametrize("program", some(["/bin/sh", "/usr/bin/env", "/usr/bin/python3"], 1))
def test_no_program_is_run_but_povray(program, tmp_path, monkeypatch):
    monkeypatch.setattr(povray, "command", lambda *_: [program, "-c", "echo > ran"])
    refused("", tmp_path, "Permission denied")
    assert not list(tmp_path.rglob("ran"))


def test_a_users_own_configuration_is_not_read(tmp_path, monkeypatch):
    for place in ("povrayrc", ".povrayrc", ".povray/3.7/povray.ini"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_text("Declare=Told=7\n")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("POVINI", str(tmp_path / ".povrayrc"))
    run('#ifdef (Told) #error "an ini file of the user\'s was read" #end', tmp_path)


def test_no_end(tmp_path):
    """POV-Ray is stopped, and tried once more."""
    with pytest.raises(PovrayError, match="took longer than 1 s"):
        run("#while (1) #end", tmp_path, SHORT)


def test_no_more_memory_than_its_share(tmp_path, monkeypatch):
    monkeypatch.setattr(povray, "MAX_MEMORY", 512 << 20)
    grows = '#declare S = "0123456789"; #while (1) #declare S = concat(S, S); #end'
    refused(grows, tmp_path, "out of memory: its limit is 512 MiB", "line 2")


LOG = (
    "File: scene.pov  Line: 2\nFile Context (5 lines):\n\n#version 3.7; // bad_alloc\n\nFatal Error: Parse Error: {}\n"
)
PARSER, RENDERER = "==== [Parsing...] ====\nFatal error in parser: {}\nRender failed\n", "Fatal error in renderer: {}\n"
UNCAUGHT = "terminate called after throwing an instance of '{}'\n  what():  {}\n"


@pytest.mark.parametrize(
    ("status", "messages", "log", "expected"),
    [
        (1, PARSER.format("Cannot parse input."), "std::bad_alloc", ": scene.pov, line 2: out of memory"),
        (-11, "", "std::bad_alloc", ": scene.pov, line 2: out of memory"),
        (1, RENDERER.format("Out of memory."), None, ": out of memory"),
        (-6, UNCAUGHT.format("St9bad_alloc", "std::bad_alloc"), None, ": out of memory"),
        (127, "libX11.so.6: cannot create shared object descriptor: Cannot allocate memory", None, ": out of memory"),
        (1, PARSER.format("Cannot parse input."), None, " failed, probably out of memory"),
        (-11, "", None, " was killed by signal 11, perhaps out of memory"),
        (-9, "", None, " was killed by signal 9"),
        (
            1,
            PARSER.format("Cannot parse input."),
            "Too many nested symbol tables",
            ": scene.pov, line 2: Too many nested symbol tables",
        ),
        (1, "", "halted \x1b[31m\x9bred", r": scene.pov, line 2: halted \x1b[31m\x9bred"),  # not obeyed by a terminal
        (-signal.SIGXFSZ, "", None, " was stopped: its limit for a file, 1024 MiB, is exceeded"),
        (1, "", None, " failed: it left no message"),
        (0, "", None, " failed: it left no message"),
    ],
)
def test_povrays_messages(status, messages, log, expected, tmp_path):
    (tmp_path / povray.FATAL).write_text(LOG.format(log) if log else "")
    failure = povray._failure(TINY, tmp_path, status, messages, "out of memory: its limit is 8192 MiB")
    assert str(failure).startswith("POV-Ray") and expected in str(failure)
    assert ("its limit is 8192 MiB" in str(failure)) == ("out of mem" in expected)
    # only a transient error is worth another try
    assert isinstance(failure, TransientError) == ("killed" in expected)


@pytest.mark.parametrize("missing", [0, 1])
def test_a_disk_without_room_for_a_picture_is_full(missing, tmp_path, monkeypatch):
    """POV-Ray does not say so. A picture takes up to 3 bytes for each pixel that POV-Ray renders, and 64 KiB."""
    free = 2**16 + 3 * (2 * 64) * (2 * 48) - missing
    disk = SimpleNamespace(f_bavail=free, f_frsize=1, f_files=0, f_favail=0)
    monkeypatch.setattr(os, "statvfs", lambda _: disk)
    failure = povray._failure(Rendering(size=(64, 48), antialias="2x"), tmp_path, 1, "", "out of memory")
    assert (getattr(failure, "errno", None) == errno.ENOSPC) == bool(missing)


def test_no_larger_file_than_its_share(tmp_path, monkeypatch):
    monkeypatch.setattr(povray, "MAX_FILE", 1 << 20)
    refused(
        '#fopen F "data.txt" write #while (1) #write(F, "0123456789") #end',
        tmp_path,
        "limit for a file, 1 MiB, is exceeded",
    )
    assert [file.stat().st_size for file in tmp_path.rglob(povray.DATA)] == [1 << 20]  # and is not tried again


def test_a_large_picture_takes_no_file_larger_than_itself(tmp_path, monkeypatch):
    """POV-Ray would write 20 bytes a pixel beside the picture: more than the limit from 7680x7000 on."""
    monkeypatch.setattr(povray, "MAX_FILE", 1 << 20)
    assert run("", tmp_path, Rendering(size=(320, 240), antialias="off")).stat().st_size < 1 << 20


def test_a_frame_under_lower_limits(tmp_path):
    """A process cannot raise a limit, unless it has that right."""
    arguments = f"{POVGEN} frame chess --sheet none --size 64x48 --quiet -o {tmp_path}/a.png"
    powerless = "" if os.geteuid() else "setpriv --bounding-set=-sys_resource"
    command = f"ulimit -v 4000000 && ulimit -f 500000 && exec {powerless} {arguments}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=200)
    assert done.returncode == 0 and (tmp_path / "a.png").is_file(), done.stderr


# The sandbox round Python code, which tries what POV-Ray does not.


def test_all_povrays_together_stay_within_the_memory(tmp_path, monkeypatch):
    gibibytes = {"SC_PHYS_PAGES": 1 << 18, "SC_PAGE_SIZE": 16 << 10}  # 4 GiB
    monkeypatch.setattr(os, "sysconf", gibibytes.get)
    assert [povray.max_memory(at_once) >> 20 for at_once in (1, 8, 16, 99)] == [4096, 512, 256, 256]
    assert povray.max_memory(99, 2**25) == (1 << 30) + (1 << 28)  # a large picture needs its pixels
    (tmp_path / "work").mkdir()
    sky = pictures.kept(f"picture-{0:064}.png", b"")
    for shown, limit in (("", 256), (f"// {sky.name}\n", 1024)):
        said = rf"out of memory: its limit is {limit}\.?\d* MiB; with fewer --workers it is higher"
        with pytest.raises(PovrayError, match=said):
            povray.Runner(at_once=16).run(SCENE.format(shown + HUNGRY), TINY, tmp_path / "work")
    for workers, count, at_once in ((None, 40, 16), (3, 40, 3), (None, 2, 2), (None, 0, 1)):
        monkeypatch.setattr(frames, "default_workers", lambda: 16)
        assert frames.renderer_of([Chess(sheet="none")] * count, TINY, None, workers)[1]._at_once == at_once


def test_without_a_sandbox_a_piece_of_somebodys_is_named(tmp_path, monkeypatch, caplog):
    caplog.set_level("WARNING", "povgen")
    (tmp_path / "own.inc").write_text("#declare Piece = sphere { 0.4*y, 0.4 }\n")
    piece = as_piece(tmp_path / "own.inc")
    small = {"size": (32, 32), "antialias": "off"}
    render(Chess(piece=piece, sheet="none"), **small)
    monkeypatch.setattr(sandbox, "version", lambda: 0)
    render(Chess(piece=PieceFile("a.stl", piece.text, is_mesh=True), sheet="none", z1=3), **small)
    frames.renderer_of([Chess(piece=piece)], TINY, povray.Runner(), 1)  # a cluster's: other machines read the piece
    assert not caplog.text
    for _ in range(2):
        render(Chess(piece=piece, sheet="none"), **small)
    (said,) = caplog.messages
    assert said.startswith("povgen: warning: piece = ") and "no sandbox here (no Landlock); render only what" in said
    povray._warn_once.cache_clear()
    volumes({"own": PieceFile("b.inc", piece.text + "\n")})
    assert "piece = 'b.inc': POV-Ray has no sandbox" in caplog.messages[1]
    line = ["frame", "chess", "--piece", "own.inc", "--sheet=none", "--size=32x32", "-o", "a.png", "--quiet"]
    assert povgen(line, tmp_path) == (0, "", "") and len(caplog.messages) == 2


@landlock
@pytest.mark.parametrize("right", ["read", "run"])
def test_what_may_be_read_or_run_is_not_written(right, tmp_path):
    file = tmp_path / "file"
    file.touch()
    for work in (lambda: file.write_text("x"), file.with_name("new").touch, file.unlink):
        with pytest.raises(PermissionError):
            sandbox.within(work, **{right: [tmp_path]})
    assert sandbox.within(file.read_text, **{right: [tmp_path]}) == ""


@pytest.mark.skipif(sandbox.version() < 4, reason="this kernel's Landlock does not know of networks")
def test_no_network():
    with socket.create_server(("127.0.0.1", 0)) as server:
        place = server.getsockname()
        with pytest.raises(PermissionError):
            sandbox.within(lambda: socket.create_connection(place, timeout=5))
        with pytest.raises(PermissionError):
            sandbox.within(lambda: socket.create_server(("127.0.0.1", 0)))
        socket.create_connection(place, timeout=5).close()  # outside the sandbox it works


@pytest.mark.skipif(sandbox.version() < 6, reason="this kernel's Landlock does not know of signals")
def test_no_signals():
    other = subprocess.Popen(["sleep", "60"])
    try:
        with pytest.raises(PermissionError):
            sandbox.within(lambda: os.kill(other.pid, signal.SIGKILL))
        assert other.poll() is None
    finally:
        other.kill()
        other.wait()
