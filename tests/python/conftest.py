"""What the tests share: the data that come with the repository, and the command to compare with."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def data() -> Path:
    return ROOT / "data"


@pytest.fixture(scope="session")
def command() -> Path:
    """The command; MORPHO_FIT names it, as scripts/python does."""
    path = Path(os.environ.get("MORPHO_FIT", ROOT / "target" / "debug" / "morpho-fit"))
    assert path.is_file(), f"{path} is missing: build it with `cargo build`, or name it in MORPHO_FIT"
    return path
