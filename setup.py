"""Builds the engines in C and names the packages; everything else is declared in pyproject.toml.

The same sources make `_engine`, in C on doubles, and for runs of many digits `_engine_2`, `_engine_3` and
`_engine_4`, in C++ on numbers of so many words (`vibsim/engine/numbers/`), and `_engine_words` on as many
words as a run needs. These need whole numbers of 128 bits, which the compiler of Windows has not: there the
package `ziglang` makes them.

Where no compiler answers, the one of the package `ziglang` is taken, which pip fetches for the build
(`build_backend.py`). Without that one too the build ends with an error. Only the engines on words are
optional: without them there are no runs of many digits.
`-ffp-contract=off` keeps every product and sum rounded by itself, so that bits are the same everywhere;
`-fno-trapping-math` says that no operation stops the program, so that loops become vectors: values stay.
`-fvisibility=hidden` lets files of the engine call each other without a table: only its module is seen.
VIBSIM_BUILD=strict takes warnings for errors, =sanitize watches addresses and undefined behaviour (`make
sanitize`), =coverage counts lines (`make coverage`); all fail where the engine does not build.
"""

import copy
import os
from glob import glob

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext

from build_backend import WINDOWS, build_with_zig, compiler_answers, zig

ROOM = "vibsim/engine"
ROUNDING = ["-ffp-contract=off", "-fno-fast-math", "-fno-trapping-math"]
SIMPLE = ["-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics", "-Wno-missing-field-initializers"]
WORDS = (2, 3, 4)  # of the numbers of many digits
MOST_WORDS = 53  # of 1000 digits and 20 bits beyond them
CPP_FLAGS = ["-std=c++20", "-nostdinc++", "-O1", "-g0", *SIMPLE, *ROUNDING, "-fvisibility=hidden", "-Wall"]
GCC_FLAGS = ["-std=c99", "-O3", "-g0", *ROUNDING, "-fvisibility=hidden", "-Wall"]
MSVC_FLAGS = ["/O2", "/fp:strict", "/std:c11"]  # C99's restrict is C11's to it
STRICT = ["-Wextra", "-Werror"]
SANITIZED = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
COUNTED = ["-O0", "-g", "--coverage"]
EXTRA = {"": [], "strict": STRICT, "sanitize": STRICT + SANITIZED, "coverage": COUNTED}

kind = os.environ.get("VIBSIM_BUILD", "")
headers = sorted(glob(f"{ROOM}/**/*.h", recursive=True))

sources = sorted(glob(f"{ROOM}/**/*.c", recursive=True))
OF_DOUBLES = (
    "double_functions.c",
    "matrices.c",
    "memory.c",
    "events/roots/roots_alone.c",
    "flows/series/lanes.c",
)
ONLY_DOUBLES = {f"{ROOM}/{file}" for file in OF_DOUBLES}


def engine(name, files, flags, **more):
    """An engine as a module of Python of that name."""
    return Extension(
        f"{ROOM.replace('/', '.')}.{name}",
        sources=files,
        depends=headers,
        include_dirs=sorted({os.path.dirname(header) for header in headers}),
        extra_compile_args=flags,
        extra_link_args=[flag for flag in EXTRA[kind] if flag.startswith(("-fsanitize", "--coverage"))],
        optional=name != "_engine" and not kind,
        **more,
    )


engines = [engine("_engine", sources, MSVC_FLAGS if WINDOWS else GCC_FLAGS + EXTRA[kind])]
if not WINDOWS or zig():
    of_words = [
        *(file for file in sources if file not in ONLY_DOUBLES),
        *sorted(glob(f"{ROOM}/numbers/*.cpp")),
    ]
    engines += [
        engine(f"_engine_{n}", of_words, CPP_FLAGS + EXTRA[kind], define_macros=[("LIMBS", str(n))])
        for n in WORDS
    ]
    by_run = [("LIMBS", str(MOST_WORDS + 1)), ("WORDS_BY_RUN", "1")]
    engines += [engine("_engine_words", of_words, CPP_FLAGS + EXTRA[kind], define_macros=by_run)]
NO_COMPILER = "vibsim: no C compiler answers here. Install one, or its package: python -m pip install ziglang"


def as_cpp(source, room):
    """A file in `room` that takes a source in C as one in C++."""
    if source.endswith(".cpp"):
        return source
    path = os.path.join(room, os.path.basename(source)[:-1] + "cpp")
    with open(path, "w") as file:
        file.write(f'#include "{os.path.abspath(source)}"\n')
    return path


class BuildApart(build_ext):
    """Builds the engines side by side, each in a directory of its own: they are made of the same sources."""

    def finalize_options(self):
        super().finalize_options()
        self.parallel = self.parallel or True

    def run(self):
        self.answers = compiler_answers()
        self.zig = zig() if WINDOWS or not self.answers else None
        if not self.answers and not self.zig:
            raise SystemExit(NO_COMPILER)
        super().run()

    def build_extension(self, ext):
        apart, ext = copy.copy(self), copy.copy(ext)
        apart.build_temp = os.path.join(self.build_temp, ext.name)
        if ext.define_macros:
            os.makedirs(apart.build_temp, exist_ok=True)
            ext.sources = [as_cpp(source, apart.build_temp) for source in ext.sources]
        if self.zig and (ext.define_macros or not self.answers):
            if WINDOWS and not ext.define_macros:
                ext.extra_compile_args = GCC_FLAGS + EXTRA[kind]
            build_with_zig(
                self.zig, ext, self.get_ext_fullpath(ext.name), os.path.join(self.build_temp, "zig")
            )
        else:
            build_ext.build_extension(apart, ext)


setup(
    packages=[*find_packages(include=["vibsim", "vibsim.*"]), "vibsim.shipped_cases"],
    package_dir={"vibsim": "vibsim", "vibsim.shipped_cases": "cases"},
    ext_modules=engines,
    cmdclass={"build_ext": BuildApart},
)
