"""How to install what is missing."""

import shlex
import sys

import pytest

from povgen import remedies
from povgen.remedies import CHECKOUT


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """Return a function that makes programs of these names the only ones on the path."""

    def put(*names):
        for name in names:
            (tmp_path / name).write_text("#!/bin/sh\n")
            (tmp_path / name).chmod(0o755)

    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CONDA_PREFIX", raising=False)
    return put


@pytest.mark.parametrize(
    ("found", "povray", "gl"),
    [
        (["apt-get"], "apt-get install povray", "apt-get install libegl1 "),
        (["brew"], "brew install povray", "on Debian: apt-get install libegl1 "),
        (["conda"], "conda install conda-forge::povray", "on Debian: apt-get install libegl1 "),
        ([], "on Debian: apt-get install povray", "on Debian: apt-get install libegl1 "),
    ],
)
def test_the_command_is_of_this_system(found, povray, gl, programs):
    programs(*found)
    assert remedies.system("povray") == povray and remedies.system("gl").startswith(gl)


def test_an_extra_is_installed_from_where_povgen_is(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))  # no environment is active
    pip = [sys.executable, "-m", "pip"]
    assert shlex.split(remedies.extra("gl")) == [*pip, "install", "-e", f"{CHECKOUT}[gl]"]
    monkeypatch.setattr(remedies, "CHECKOUT", tmp_path)  # as a wheel's, which has no pyproject.toml beside it
    assert shlex.split(remedies.extra("gl")) == [*pip, "install", "povgen[gl]"]
    (tmp_path / "povgen-1.dist-info").mkdir()  # of a folder
    (tmp_path / "povgen-1.dist-info" / "direct_url.json").write_text('{"dir_info": {}, "url": "file:///a%20folder"}')
    (tmp_path / "pip").touch(mode=0o755)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))  # its environment is active
    assert shlex.split(remedies.extra("gl")) == ["pip", "install", "/a folder[gl]"]
