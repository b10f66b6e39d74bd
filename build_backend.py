"""Build backend of pip: setuptools, and the search for a compiler, which `setup.py` shares.

Where no compiler for C and C++ answers, and on Windows, whose own one has no whole numbers of 128 bits for
runs of many digits, the requirements of the build name `ziglang`, a package of some 100 MB with a complete
compiler (clang) for Linux, macOS and Windows. pip takes it from the package index for the build alone.
"""

import os
import platform
import subprocess
import sys
import sysconfig
import tempfile
from importlib.util import find_spec

from setuptools import build_meta

from distutils.ccompiler import new_compiler  # isort: skip  # of setuptools, which puts it in place
from distutils.errors import CCompilerError, CompileError, DistutilsError  # isort: skip
from distutils.sysconfig import customize_compiler  # isort: skip

build_sdist = build_meta.build_sdist
build_wheel = build_meta.build_wheel
build_editable = build_meta.build_editable
get_requires_for_build_sdist = build_meta.get_requires_for_build_sdist
prepare_metadata_for_build_wheel = build_meta.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = build_meta.prepare_metadata_for_build_editable

COMPILER_PACKAGE = "ziglang>=0.14"
WINDOWS = os.name == "nt"
# Processors of which the package has compilers, in the words of Python and of the compiler.
ARCHITECTURES = {
    "x86_64": "x86_64",
    "amd64": "x86_64",
    "aarch64": "aarch64",
    "arm64": "aarch64",
    "ppc64le": "powerpc64le",
    "s390x": "s390x",
    "riscv64": "riscv64",
}
# The C library that wheels of Python 3.10 and later ask for at least, 2.17, or the first one that there is.
OLDEST_GLIBC = {"riscv64": "2.27", "powerpc64le": "2.19"}
PROGRAMS = {
    "c.c": "#include <math.h>\ndouble f(double x) { return sqrt(x); }\n",
    "cpp.cpp": "#include <math.h>\nunsigned __int128 f(unsigned __int128 x) { return x + 1; }\n",
}


def get_requires_for_build_wheel(config_settings=None):
    """Requirements of a wheel beyond pyproject.toml: a compiler where none answers."""
    return [*build_meta.get_requires_for_build_wheel(config_settings), *missing_compiler()]


def get_requires_for_build_editable(config_settings=None):
    """Requirements of an editable installation: as of a wheel."""
    return [*build_meta.get_requires_for_build_editable(config_settings), *missing_compiler()]


def missing_compiler():
    """The package with a compiler as a list, empty where it is not needed or does not exist."""
    return [] if target() is None or (compiler_answers() and not WINDOWS) else [COMPILER_PACKAGE]


def compiler_answers():
    """Whether the compiler that setuptools would call (CC and CXX, where they are set) makes a shared library
    from C and, but on Windows, from C++20.
    """
    names = [name for name in PROGRAMS if not WINDOWS or name == "c.c"]
    with tempfile.TemporaryDirectory() as folder:
        try:
            for name in names:
                _compile(os.path.join(folder, name), PROGRAMS[name])
        except (CCompilerError, DistutilsError, OSError):
            return False
    return True


def _compile(path, program):
    compiler = new_compiler()
    customize_compiler(compiler)
    with open(path, "w") as file:
        file.write(program)
    flags = ["-std=c++20"] if path.endswith(".cpp") else []
    objects = compiler.compile([path], output_dir=os.path.dirname(path), extra_postargs=flags)
    language = "c++" if path.endswith(".cpp") else "c"
    compiler.link_shared_object(objects, path + ".module", target_lang=language)


def target():
    """The machine to compile for, as zig names it: this processor's family and an old C library.

    None where the package has no compiler for it.
    """
    system, _, machine = sysconfig.get_platform().replace("-", "_").partition("_")
    name = ARCHITECTURES.get(machine if system != "macosx" else platform.machine())
    if name is None:
        return None
    if system == "macosx":
        return f"{name}-macos.{sysconfig.get_config_var('MACOSX_DEPLOYMENT_TARGET') or '11.0'}"
    if system == "win":
        return f"{name}-windows-gnu"
    if system != "linux":
        return None
    if "musl" in (sysconfig.get_config_var("HOST_GNU_TYPE") or ""):
        return f"{name}-linux-musl"
    return f"{name}-linux-gnu.{OLDEST_GLIBC.get(name, '2.17')}"


def zig():
    """The command of the compiler of the package where it is installed, else None."""
    return [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") and target() else None


def build_with_zig(command, extension, module, folder):
    """Make `extension` the file `module`, with a cache of the compiler in `folder`. Raises CompileError."""
    of_system = {
        "linux": ["-fPIC"],
        "darwin": ["-fPIC", "-Wl,-undefined,dynamic_lookup"],
        "win32": ["-DMS_WIN64", *_python_library()],
    }
    words = [
        *command,
        *("-shared", "-target", target(), "-mcpu=baseline", "-fno-sanitize=undefined", "-DNDEBUG"),
        *extension.extra_compile_args,
        "-g0",
        *(f"-D{name}={value}" for name, value in extension.define_macros),
        *(f"-I{path}" for path in (*extension.include_dirs, sysconfig.get_path("include"))),
        *extension.sources,
        *of_system[sys.platform],
        *("-o", module),
    ]
    caches = {name: os.path.abspath(folder) for name in ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR")}
    os.makedirs(os.path.dirname(os.path.abspath(module)), exist_ok=True)
    if subprocess.run(words, env={**os.environ, **caches}, check=False).returncode:
        raise CompileError(f"{' '.join(command)} did not make {module}")


def _python_library():
    """Where Python's own library is on Windows, to which a module is linked there."""
    suffix = "t" if sysconfig.get_config_var("Py_GIL_DISABLED") else ""
    name = f"python{sys.version_info.major}{sys.version_info.minor}{suffix}"
    return [f"-L{os.path.join(sys.base_prefix, 'libs')}", f"-l{name}"]
