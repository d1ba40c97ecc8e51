"""How to mend what is missing: the command for this system and this installation, and what the documentation says."""

import json
import os
import shlex
import shutil
import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

# For each program that installs a system's packages: the packages of POV-Ray, of Mesa's OpenGL without a window, and of
# the program ffmpeg. Homebrew and conda-forge have no Mesa that draws without a window: macOS has its own OpenGL, and a
# conda environment uses the system's. Fedora's ffmpeg has no encoder for H.264.
PACKAGES = {
    "apt-get": {"povray": "povray", "gl": "libegl1 libgl1 libegl-mesa0 libgl1-mesa-dri", "ffmpeg": "ffmpeg"},
    "dnf": {"povray": "povray", "gl": "mesa-libEGL mesa-libGL mesa-dri-drivers"},
    "brew": {"povray": "povray", "ffmpeg": "ffmpeg"},
    "conda": {"povray": "conda-forge::povray", "ffmpeg": "conda-forge::ffmpeg"},
}
CHECKOUT = Path(__file__).parents[1]


def page(symptom: str) -> str:
    """Return the address of a heading of docs/troubleshooting.md."""
    return f"docs/troubleshooting.md#{symptom}"


def system(what: str) -> str:
    """Return the command that installs `what` (povray, gl or ffmpeg) on this system.

    In an environment of conda this is conda's command, which needs no administrator. If no known program can install
    it, return "on Debian: " and Debian's command.
    """
    programs = ["conda", *PACKAGES] if "CONDA_PREFIX" in os.environ else [*PACKAGES]
    for program in programs:
        if what in PACKAGES[program] and shutil.which(program):
            return f"{program} install {PACKAGES[program][what]}"
    return f"on Debian: apt-get install {PACKAGES['apt-get'][what]}"


def pip() -> str:
    """Return the pip of the Python that runs povgen, as a shell calls it."""
    is_found = Path(shutil.which("pip") or "").parent == Path(sys.executable).parent
    return "pip" if is_found else f"{shlex.quote(sys.executable)} -m pip"


def extra(name: str) -> str:
    """Return the command that installs an extra of povgen: from the checkout that it runs in or was installed from."""
    if (CHECKOUT / "pyproject.toml").exists():
        return f"{pip()} install -e {shlex.quote(f'{CHECKOUT}[{name}]')}"
    source = "povgen"
    for file in CHECKOUT.glob("povgen-*.dist-info/direct_url.json"):
        origin = urlsplit(json.loads(file.read_text())["url"])
        source = unquote(origin.path) if origin.scheme == "file" else source
    return f"{pip()} install {shlex.quote(f'{source}[{name}]')}"
