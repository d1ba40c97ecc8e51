"""Eviction from the cache: any sequence of stores, reads, trims and clears removes the least recently used files."""

import os
import shutil
import tempfile
import time
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from povgen.rendering import cache

KEYS = st.sampled_from("abcdef")


class Eviction(RuleBasedStateMachine):
    """The cache beside a dictionary of what it must hold, in the order of last use."""

    @initialize()
    def start(self):
        self.folder = Path(tempfile.mkdtemp())
        self.patch = pytest.MonkeyPatch()
        self.patch.setenv("POVGEN_CACHE", str(self.folder / "cache"))
        self.stored: dict[str, bytes] = {}

    def teardown(self):
        if hasattr(self, "patch"):
            self.patch.undo()
            shutil.rmtree(self.folder)

    def path(self, key):
        return cache.path_for(key, ".values" if key < "c" else ".png")

    @rule(key=KEYS, size=st.integers(0, 30))
    def store(self, key, size):
        data = (key * size).encode()
        cache.store(data, self.path(key))
        # exact, unlike the kernel's clock; modified long ago, so that the kernel does not update the time of use
        os.utime(self.path(key), ns=(time.time_ns(), 0))
        self.stored.pop(key, None)
        self.stored[key] = data

    @rule(key=KEYS)
    def read(self, key):
        assert cache.read(self.path(key)) == self.stored.get(key)
        if key in self.stored:
            self.stored[key] = self.stored.pop(key)

    @rule(most=st.integers(0, 300))
    def trim(self, most):
        removed = cache.trim(most)
        expected = []
        while sum(len(data) + cache.CHECKSUM for data in self.stored.values()) > most:
            oldest = next(iter(self.stored))
            expected.append(self.path(oldest))
            del self.stored[oldest]
        assert removed == expected

    @rule()
    def clear(self):
        assert sorted(cache.trim(-1)) == sorted(map(self.path, self.stored))
        self.stored.clear()

    @invariant()
    def holds_what_was_stored(self):
        """In the order of last use."""
        held = [(size, path) for _, size, path in cache.by_last_use()]
        assert held == [(len(data) + cache.CHECKSUM, self.path(key)) for key, data in self.stored.items()]


TestEviction = Eviction.TestCase
TestEviction.settings = settings(settings.get_profile("povgen"), max_examples=40, stateful_step_count=25)
