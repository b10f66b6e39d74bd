"""Check that a source distribution holds all files of the repository, and no others.

python complete.py dist/vibsim-0.1.0.tar.gz
"""

import subprocess
import sys
import tarfile

WRITTEN = ("PKG-INFO", "setup.cfg", "vibsim.egg-info/")  # by setuptools


def main() -> None:
    """Compare the archive with what git tracks; ends with an error where they differ."""
    with tarfile.open(sys.argv[1]) as archive:
        files = {member.name.partition("/")[2] for member in archive if member.isfile()}
    listed = subprocess.run(["git", "ls-files"], capture_output=True, text=True, check=True)
    tracked = set(listed.stdout.splitlines())
    missing = sorted(tracked - files)
    foreign = sorted(name for name in files - tracked if not name.startswith(WRITTEN))
    if missing or foreign:
        raise SystemExit(f"{sys.argv[1]}: missing {missing or 'nothing'}; foreign {foreign or 'nothing'}")
    print(f"{sys.argv[1]}: all {len(tracked)} files")


if __name__ == "__main__":
    main()
