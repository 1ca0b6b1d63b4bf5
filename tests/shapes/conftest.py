"""The animal in two poses, made once."""

import pytest

from sherd.shapes.creature import creature


@pytest.fixture(name="full", scope="session")
def _full():
    return creature(5_000)


@pytest.fixture(name="posed", scope="session")
def _posed():
    return creature(5_000, pose="gallop")
