"""Builds the optional C engine; everything else is declared in pyproject.toml.

Without a compiler the extension is left out (`optional=True`) and vibsim runs on its Python engine.
`-ffp-contract=off` keeps every product and sum rounded by itself, so that both engines agree bit for bit.
"""

import os
from glob import glob

from setuptools import Extension, setup

KERNEL = "vibsim/kernel"
GCC_FLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-fast-math", "-Wall"]

sources = sorted(glob(f"{KERNEL}/*.c"))
extensions = [
    Extension(
        "vibsim.kernel._kernel",
        sources=sources,
        depends=sorted(glob(f"{KERNEL}/*.h")),
        extra_compile_args=["/O2", "/fp:strict"] if os.name == "nt" else GCC_FLAGS,
        optional=True,
    )
]

setup(ext_modules=extensions if sources else [])
