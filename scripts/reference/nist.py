# /// script
# requires-python = ">=3.10"
# dependencies = ["pip>=23"]
# ///
"""Fetch the NIST StRD nonlinear regression problems into `tests/reference/nist`.

    python scripts/reference/nist.py

The source distribution of lmfit carries the 27 files as NIST published them. They are copied byte for byte; what has
to be corrected is corrected by the reader, `tests/support/nist.rs`.
"""

import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path, PurePosixPath

PACKAGE, VERSION = "lmfit", "1.3.4"
PROBLEMS = 27
OUT = Path(__file__).resolve().parents[2] / "tests" / "reference" / "nist"


def main():
    with tempfile.TemporaryDirectory() as folder:
        download = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", PACKAGE]
        subprocess.run([*download, "--dest", folder, f"{PACKAGE}=={VERSION}"], check=True)
        (archive,) = Path(folder).glob("*.tar.gz")
        with tarfile.open(archive) as source:
            files = {
                PurePosixPath(member.name).name: source.extractfile(member).read()
                for member in source.getmembers()
                if PurePosixPath(member.name).match("*/NIST_STRD/*.dat")
            }
    assert len(files) == PROBLEMS, sorted(files)
    OUT.mkdir(parents=True, exist_ok=True)
    for name, content in sorted(files.items()):
        (OUT / name).write_bytes(content)
    print(f"{len(files)} problems, {sum(map(len, files.values()))} bytes")


if __name__ == "__main__":
    main()
