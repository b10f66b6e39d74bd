"""Builds the optional C engine and names the packages; everything else is declared in pyproject.toml.

Without a compiler the extension is left out (`optional=True`) and vibsim runs on its Python engine.
`-ffp-contract=off` keeps every product and sum rounded by itself, so that both engines agree bit for bit;
`-fno-trapping-math` says that no operation stops the program, so that loops become vectors: values stay.
`-fvisibility=hidden` lets files of the engine call each other without a table: only its module is seen.
VIBSIM_BUILD=strict takes warnings for errors, =sanitize watches addresses and undefined behaviour (`make
sanitize`), =coverage counts lines (`make coverage`); all fail where the engine does not build.
"""

import os
from glob import glob

from setuptools import Extension, find_packages, setup

ROOM = "vibsim/engine"
ROUNDING = ["-ffp-contract=off", "-fno-fast-math", "-fno-trapping-math"]
GCC_FLAGS = ["-std=c99", "-O3", *ROUNDING, "-fvisibility=hidden", "-Wall"]
MSVC_FLAGS = ["/O2", "/fp:strict", "/std:c11"]  # C99's restrict is C11's to it
STRICT = ["-Wextra", "-Werror"]
SANITIZED = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
COUNTED = ["-O0", "-g", "--coverage"]
EXTRA = {"": [], "strict": STRICT, "sanitize": STRICT + SANITIZED, "coverage": COUNTED}

kind = os.environ.get("VIBSIM_BUILD", "")
headers = sorted(glob(f"{ROOM}/**/*.h", recursive=True))

engine = Extension(
    "vibsim.engine._engine",
    sources=sorted(glob(f"{ROOM}/**/*.c", recursive=True)),
    depends=headers,
    include_dirs=sorted({os.path.dirname(header) for header in headers}),
    extra_compile_args=MSVC_FLAGS if os.name == "nt" else GCC_FLAGS + EXTRA[kind],
    extra_link_args=[flag for flag in EXTRA[kind] if flag.startswith(("-fsanitize", "--coverage"))],
    optional=not kind,
)

setup(
    packages=[*find_packages(include=["vibsim", "vibsim.*"]), "vibsim.shipped_cases"],
    package_dir={"vibsim": "vibsim", "vibsim.shipped_cases": "cases"},
    ext_modules=[engine],
)
