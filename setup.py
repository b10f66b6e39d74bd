"""Builds the optional C engine; everything else is declared in pyproject.toml.

Without a compiler the extension is left out (`optional=True`) and vibsim runs on its Python engine.
`-ffp-contract=off` keeps every product and sum rounded by itself, so that both engines agree bit for bit.
VIBSIM_BUILD=strict takes warnings for errors, VIBSIM_BUILD=sanitize watches addresses and undefined behaviour
(`make sanitize`); both fail where the engine does not build.
"""

import os
from glob import glob

from setuptools import Extension, setup

ROOM = "vibsim/engine"
GCC_FLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-fast-math", "-Wall"]
STRICT = ["-Wextra", "-Werror"]
SANITIZED = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
EXTRA = {"": [], "strict": STRICT, "sanitize": STRICT + SANITIZED}

kind = os.environ.get("VIBSIM_BUILD", "")

engine = Extension(
    "vibsim.engine._engine",
    sources=sorted(glob(f"{ROOM}/*.c")),
    depends=sorted(glob(f"{ROOM}/*.h")),
    extra_compile_args=["/O2", "/fp:strict"] if os.name == "nt" else GCC_FLAGS + EXTRA[kind],
    extra_link_args=[flag for flag in EXTRA[kind] if flag.startswith("-fsanitize")],
    optional=not kind,
)

setup(ext_modules=[engine])
