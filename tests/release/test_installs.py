"""povgen where it is installed: on every Python that can be had, and with the oldest packages that it allows."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import PROJECT
from uv import find_uv_bin

pytestmark = pytest.mark.timeout(1500)  # packages come over the network


def pythons():
    """Interpreters that povgen is for: on the PATH, and pyenv's; the one that runs all tests comes first."""
    found = {sys.version_info[:2]: sys.executable}
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    for minor in (11, 12, 13, 14):
        candidates = [shutil.which(f"python3.{minor}"), *pyenv.glob(f"versions/3.{minor}*/bin/python3.{minor}")]
        for path in filter(None, candidates):
            works = subprocess.run([path, "-c", "import ssl, venv"], capture_output=True).returncode == 0
            if works:
                found.setdefault((3, minor), str(path))
    return found


PYTHONS = pythons()


def installed(folder, python, *how):
    """povgen's program in a new environment."""
    uv = find_uv_bin()
    subprocess.run([uv, "venv", "--quiet", "--python", python, folder], check=True, timeout=100)
    install = [uv, "pip", "install", "--quiet", "--python", folder / "bin" / "python"]
    done = subprocess.run([*install, *how], capture_output=True, text=True, timeout=400)
    assert done.returncode == 0, done.stderr
    return folder / "bin" / "povgen"


def works(povgen, folder, *more):
    for arguments in (
        ["check"],
        ["list"],
        ["frame", "spheres", "--size", "64x48", "--caption=full", "--overlay"],
        ["movie", "vary-z1", "--size", "64x48", "--sheet", "none", "--quality", "draft", "-o", "a.webm"],
        ["movie", "vary-z1", "--size", "64x48", "--sheet", "none", "--quality", "draft", "-o", "a.gif"],
        *more,
    ):
        done = subprocess.run([povgen, *arguments], cwd=folder, capture_output=True, text=True, timeout=200)
        assert done.returncode == 0 and "Traceback" not in done.stderr, done.stdout + done.stderr
        assert "Warning" not in done.stderr
    refused = subprocess.run([povgen, "frame", "chess", "--alpha", "nan"], cwd=folder, capture_output=True, text=True)
    assert refused.returncode == 2 and refused.stderr.startswith("povgen: alpha = 'nan'")


@pytest.mark.parametrize("version", list(PYTHONS)[1:] or PYTHONS, ids=lambda version: f"{version[0]}.{version[1]}")
def test_every_other_python(version, tmp_path):
    works(installed(tmp_path / "venv", PYTHONS[version], PROJECT), tmp_path)


def test_the_site_needs_no_other_packages_than_its_own(tmp_path):
    povgen = installed(tmp_path / "venv", sys.executable, f"{PROJECT}[docs]")
    subprocess.run(
        [povgen.with_name("python"), PROJECT / "docs" / "website.py", tmp_path / "site"], check=True, timeout=200
    )
    assert (tmp_path / "site" / "docs" / "worksheet.html").exists()


CLUSTER = """
import subprocess, sys
from distributed import LocalCluster

if __name__ == "__main__":
    with LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=None) as cluster:
        subprocess.run([*sys.argv[1:], "--scheduler", cluster.scheduler_address], check=True)
"""


def test_the_oldest_packages(tmp_path):
    extras = f"{PROJECT}[charts,cluster,parts,xarray]"
    povgen = installed(tmp_path / "venv", PYTHONS[3, 11], "--resolution", "lowest-direct", extras)
    works(povgen, tmp_path, ["figure", "5"], ["part", "chess", "-o", "a.stl"], ["frame", "chess", "--help"])
    table = "from povgen import Chess, results; results(Chess(), 'nu', alpha=[0, 9]).to_xarray().to_netcdf('a.nc')"
    subprocess.run([povgen.with_name("python"), "-c", table], cwd=tmp_path, check=True, timeout=100)
    (tmp_path / "cluster.py").write_text(CLUSTER)
    movie = [povgen, "movie", "vary-z1", "--size", "80x60", "--sheet", "none", "--quality", "draft", "-o", "b.mp4"]
    done = subprocess.run(
        [povgen.with_name("python"), "cluster.py", *movie], cwd=tmp_path, capture_output=True, text=True, timeout=200
    )
    assert done.returncode == 0 and (tmp_path / "b.mp4").exists(), done.stdout + done.stderr
