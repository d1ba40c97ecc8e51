"""GitHub's workflows: what they call exists, and they test the Pythons that the project names.

That their actions have pinned versions is checked by `make lint`.
"""

import re
import subprocess
import tomllib

import pytest
from conftest import PROJECT

WORKFLOWS = sorted((PROJECT / ".github" / "workflows").glob("*.yml"))
TEXT = "\n".join(path.read_text() for path in WORKFLOWS)


def test_what_they_call_exists():
    scripts = set(re.findall(r"\.ci/[\w-]+", TEXT))
    assert scripts == {f".ci/{path.name}" for path in (PROJECT / ".ci").iterdir()}
    assert all((PROJECT / script).stat().st_mode & 0o111 for script in scripts)
    targets = set(re.findall(r"\bmake (?:--silent )?([a-z-]+)$", re.sub(r"( >| #).*", "", TEXT), re.M))
    assert targets
    subprocess.run(["make", "--dry-run", *targets], cwd=PROJECT, capture_output=True, check=True)


def test_the_container_is_of_a_system_that_is_tested():
    """It installs by the steps that the workflow tries on a bare system."""
    text = (PROJECT / "Containerfile").read_text()
    (image,) = re.findall(r"^FROM docker.io/library/(\S+)-slim$", text, re.M)
    assert f'"{image}"' in TEXT
    assert "COPY .ci/install dist/*.whl" in text and "RUN /tmp/povgen/install /tmp/povgen/*.whl" in text


def test_every_python_that_povgen_is_for_is_tested():
    (block,) = re.findall(r"python-version: \|\n((?: +3\.\d+\n)+)", TEXT)
    classifiers = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["classifiers"]
    assert sorted(block.split()) == [found[1] for text in classifiers if (found := re.search(r":: (3\.\d+)$", text))]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_job_has_only_the_permissions_that_it_names(path):
    text = path.read_text()
    assert "\npermissions: {}\n" in text
    assert text.count("runs-on:") == text.count("\n    permissions:\n") == text.count("timeout-minutes:")
