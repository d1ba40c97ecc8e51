"""GitHub's workflows: what they call exists, and they test the Pythons and use the versions that the project names."""

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
    for target in targets:
        subprocess.run(["make", "--dry-run", target], cwd=PROJECT, capture_output=True, check=True)


def test_the_container_is_of_a_system_that_is_tested():
    """It installs by the steps that the workflow tries on a bare system."""
    text = (PROJECT / "Containerfile").read_text()
    (image,) = re.findall(r"^FROM docker.io/library/(\S+)-slim$", text, re.M)
    assert f'"{image}"' in TEXT
    assert "COPY .ci/install dist/*.whl" in text and "RUN /tmp/povgen/install /tmp/povgen/*.whl" in text


def test_actions_have_pinned_versions():
    uses = re.findall(r"uses: (\S+)(.*)", TEXT)
    assert uses and all(re.fullmatch(r"actions/[\w-]+@[0-9a-f]{40}", action) for action, _ in uses)
    assert all(re.fullmatch(r" # v[\d.]+", version) for _, version in uses)
    names = [action.partition("@")[0] for action in dict(uses)]
    assert len(names) == len(set(names))  # one version of each


def test_every_python_that_povgen_is_for_is_tested():
    (block,) = re.findall(r"python-version: \|\n((?: +3\.\d+\n)+)", TEXT)
    classifiers = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["classifiers"]
    assert sorted(block.split()) == [found[1] for text in classifiers if (found := re.search(r":: (3\.\d+)$", text))]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_job_has_only_the_permissions_that_it_names(path):
    text = path.read_text()
    assert "\npermissions: {}\n" in text
    assert text.count("runs-on:") == text.count("\n    permissions:\n") == text.count("timeout-minutes:")
