"""What the build adds to pyproject.toml: the README as an index of packages shows it.

There a link has to be absolute. It leads to the tag of this version, so that it does not change later.
"""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class Readme(MetadataHookInterface):
    """Makes the metadata's `readme`, with absolute links."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add `readme`. The address of the repository and the version are those of pyproject.toml."""
        text = (Path(self.root) / "README.md").read_text("utf-8")
        repository, tag = metadata["urls"]["Repository"], f"v{metadata['version']}"
        metadata["readme"] = {"content-type": "text/markdown", "text": absolute(text, repository, tag)}


def absolute(text: str, repository: str, tag: str) -> str:
    """Return Markdown with links to the repository's files at a tag in place of relative links."""

    def link(found: re.Match[str]) -> str:
        what, name, target = found.groups()
        return f"{what}[{name}]({repository}/{'raw' if what else 'blob'}/{tag}/{target})"

    return re.sub(r"(!?)\[([^][]*)\]\((?![a-z]+:|#)([^)\s]+)\)", link, text)
