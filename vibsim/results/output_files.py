"""Output files: whole or not at all under their name, one writer at a time, nothing replaced unawares.

What is written in one go is first a file of a name of its own, NAME.xxxxxxxx.partial, and then renamed: of
two who write one output at a time each publishes its own, whole. What grows for long (a run, or the points
that a journal keeps) is written by one process at a time, which holds NAME.lock. Neither needs the locks of
HDF5, which many clusters switch off (HDF5_USE_FILE_LOCKING=FALSE).
"""

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from platform import node
from typing import IO, Any

import h5py

from vibsim.results.hdf5_reading import ResultFileError, read_attr, reason
from vibsim.signals import ended_at_once, held_back

RESULT_SUFFIXES = (".h5", ".hdf5")


def check_result_name(path: str | Path) -> None:
    """Raises ResultFileError for a file name whose suffix promises another format than that of results."""
    suffix = Path(path).suffix
    if suffix.lower() not in RESULT_SUFFIXES:
        suffix_text = f"suffix {suffix}" if suffix else "no suffix"
        exported = "; for CSV or MAT: vibsim export" if suffix.lower() in (".csv", ".mat") else ""
        raise ResultFileError(f"{path}: {suffix_text}; results are HDF5 files, .h5 or .hdf5{exported}")


def check_result_output(path: str | Path, force: bool = False) -> Path:
    """As `check_output`, for a file of results. Raises ResultFileError, also for its suffix."""
    check_result_name(path)
    return check_output(path, force)


def check_output(path: str | Path, force: bool = False) -> Path:
    """Absolute path of an output file that may be written (links followed).

    Raises ResultFileError when it, or a part of a run beside it, exists and `force` is not given, when it is
    not a regular file or being written, or when its folder is missing or not writable.
    """
    try:
        target = Path(path).absolute().resolve()
        if target.exists():
            _check_existing(path, target, force)
        check_leftover(path, force)  # fails where that name is too long
        folder = target.parent
        if not folder.is_dir():
            raise ResultFileError(f"{path}: cannot write: folder {folder} does not exist")
        if not os.access(folder, os.W_OK | os.X_OK, effective_ids=os.access in os.supports_effective_ids):
            raise ResultFileError(f"{path}: cannot write: folder {folder} is not writable")
    except (OSError, RuntimeError, ValueError) as error:
        raise ResultFileError(f"{path}: cannot write: {reason(error)}") from error
    return target


def _check_existing(path: str | Path, target: Path, force: bool) -> None:
    if target.is_dir():
        raise ResultFileError(f"{path}: cannot write: is a folder")
    if not target.is_file():
        raise ResultFileError(f"{path}: cannot write: is not a regular file")
    if not force:
        raise ResultFileError(f"{path}: exists; kept (force=True replaces it)")


def publish(partial: Path, target: Path, force: bool = False) -> None:
    """Make a finished partial file durable and give it its name: fsync, rename, fsync of the folder.

    Raises ResultFileError where that cannot be, or where another has come under that name and `force` is not
    given.
    """
    try:
        with held_back():
            _fsync(partial)
            if force or not _linked(partial, target):
                os.replace(partial, target)
            if os.name == "posix":
                _fsync(target.parent)
    except OSError as error:
        raise ResultFileError(f"{target}: cannot write: {reason(error)}") from error


def _linked(partial: Path, target: Path) -> bool:
    """Whether a partial file has got a name that nothing had.

    False on a disk without links, where nothing has it yet. Raises ResultFileError where something has.
    """
    try:
        os.link(partial, target)
    except OSError:
        if os.path.lexists(target):
            raise ResultFileError(f"{target}: appeared meanwhile; kept (force=True replaces it)") from None
        return False
    partial.unlink()
    return True


@contextmanager
def output_file(path: str | Path, force: bool = False, encoding: str | None = None) -> Iterator[IO[Any]]:
    """A file to write to, binary or of an encoding; published when the block ends, removed when it raises.

    Other programs may write to the path that is its `name`. Two writers of one output have two such files.
    """
    target = check_output(path, force)
    partial, file = target, None
    try:
        with held_back():
            descriptor, partial = open_partial(target)
            file = open(  # noqa: SIM115
                partial,
                "w+b" if encoding is None else "w+",
                encoding=encoding,
                newline=None if encoding is None else "",
                opener=lambda *_: descriptor,
            )
        yield file
        file.flush()
        if os.name != "posix":  # what is open cannot be renamed there
            file.close()
        publish(partial, target, force)
    except OSError as error:
        raise ResultFileError(f"{path}: cannot write: {reason(error)}") from error
    finally:
        if file is not None:
            with held_back(), suppress(OSError):
                partial.unlink(missing_ok=True)
            with held_back(), suppress(OSError):  # of a full disk, once more
                file.close()


def _fsync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


# Who writes an output, and what a writer that was killed has left beside it.

try:
    import fcntl
except ImportError:  # Windows, where a file that is open cannot be removed
    fcntl = None  # type: ignore[assignment]

NO_LOCKS = {errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL}  # of disks that have none
TRIES = 100  # to make a file whose name others make and remove at the same time
ours: set[Path] = set()  # lock files that this process holds
OWNER_BYTES = 200  # of a lock file: process and machine of its owner


class Lock:
    """The right to write an output, held until `release`, and no longer than this process lives.

    Where the disk has flock, the system lets go of NAME.lock when its owner dies. Where it has none, that
    NAME.lock can be made by one process only is the lock; that of a dead process of this machine is removed.

    Raises ResultFileError where another writer has it, or where it cannot be made.
    """

    def __init__(self, target: Path, shown: str | Path):
        self.path = lock_path(target)
        self._descriptor = -1
        with held_back():
            try:
                self._descriptor = _acquired(self.path, shown)
            except OSError as error:
                raise ResultFileError(f"{shown}: cannot write: {reason(error)}") from error
            with suppress(OSError):  # on a full disk it names nobody, and locks all the same
                os.ftruncate(self._descriptor, 0)
                os.write(self._descriptor, f"{os.getpid()} {node()}\n".encode())
            ours.add(self.path)

    def release(self) -> None:
        """Let others write the output."""
        with held_back():
            if self._descriptor < 0:
                return
            ours.discard(self.path)
            if fcntl is None:
                os.close(self._descriptor)
            with suppress(OSError):
                self.path.unlink()
            if fcntl is not None:
                os.close(self._descriptor)
            self._descriptor = -1

    __del__ = release


def lock_path(target: Path) -> Path:
    """NAME.lock beside an output."""
    return target.with_name(target.name + ".lock")


def check_unlocked(target: Path, shown: str | Path) -> None:
    """Raise ResultFileError where another process has the lock of an output; remove that of a dead one."""
    path = lock_path(target)
    if path not in ours and path.exists():
        with suppress(OSError):
            descriptor = _acquired(path, shown)
            path.unlink(missing_ok=True)
            os.close(descriptor)


def _acquired(path: Path, shown: str | Path) -> int:
    """Descriptor of the lock file, locked. Raises ResultFileError where another has it, OSError."""
    for _ in range(TRIES):  # it may come and go meanwhile
        descriptor = _try_to_acquire(path, shown)
        if descriptor >= 0:
            return descriptor
    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))


def _try_to_acquire(path: Path, shown: str | Path) -> int:
    """As above; -1 where it came or went in between, or cannot be made."""
    try:
        if fcntl is None:
            path.unlink(missing_ok=True)
        made = not path.exists()
        descriptor = os.open(path, os.O_RDWR | (os.O_CREAT | os.O_EXCL if made else 0), 0o666)
    except (FileExistsError, FileNotFoundError):
        return -1
    except PermissionError:
        if fcntl is None:
            raise _refused(path, shown, "") from None
        raise
    try:
        held = _held(descriptor, path, shown, made)
    except BaseException:
        os.close(descriptor)
        raise
    if held:
        return descriptor
    os.close(descriptor)
    return -1


def _held(descriptor: int, path: Path, shown: str | Path, made: bool) -> bool:
    """Whether an open lock file is locked now, and still the one of its path.

    made : whether this process has made it. Raises ResultFileError where another has it.
    """
    if fcntl is None:
        return made
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise _refused(path, shown, _owner(descriptor)) from None
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
        owner = _owner(descriptor)
        if not made and not _is_dead(owner):
            raise _refused(path, shown, owner, f"; where it has ended, remove {path.name}") from None
        if not made and _is_at(descriptor, path):
            path.unlink()
        return made
    return _is_at(descriptor, path)


def _refused(path: Path, shown: str | Path, owner: str, remedy: str = "") -> ResultFileError:
    process, _, machine = owner.partition(" ")
    who = f" (process {process} on {machine})" if machine else ""
    return ResultFileError(f"{shown}: another command is writing it{who}{remedy}")


def _owner(descriptor: int) -> str:
    """Owner named by a lock file: process and machine."""
    os.lseek(descriptor, 0, os.SEEK_SET)
    return os.read(descriptor, OWNER_BYTES).decode("utf-8", "replace").strip()


def _is_dead(owner: str) -> bool:
    """Whether the owner of a lock file is a process of this machine that has ended."""
    process, _, machine = owner.partition(" ")
    if machine != node() or not process.isdigit():
        return False
    try:
        os.kill(int(process), 0)
    except ProcessLookupError:
        return True
    except OSError:  # of another user
        pass
    return False


def _is_at(descriptor: int, path: Path) -> bool:
    """Whether an open file is the one that the path leads to."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False


def open_partial(target: Path, folder: bool = False) -> tuple[int, Path]:
    """A new file, or folder, beside an output, under a name of its own: its descriptor and its path.

    It is locked as long as it is open, in the way that readers share: HDF5 locks what it reads, and may do so
    from the instant in which the file has the name of the output. Those that dead writers of the output have
    left are removed; where there is no flock nothing says which are, and they stay. Raises OSError. Signals
    are to be held back.
    """
    _remove_dead(target)
    for _ in range(TRIES):
        path = unique_path(target)
        try:
            if folder:
                path.mkdir()
            descriptor = os.open(path, os.O_RDONLY if folder else os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            continue
        except FileNotFoundError:
            if folder and target.parent.is_dir():  # taken for one of the dead before it was locked
                continue
            raise
        if _locked(descriptor, shared=True) is not False and _is_at(descriptor, path):
            return descriptor, path
        os.close(descriptor)  # taken for one that a dead writer has left, and removed
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))


def unique_path(target: Path) -> Path:
    """NAME.xxxxxxxx.partial beside an output."""
    return target.with_name(f"{target.name}.{os.urandom(4).hex()}.partial")


def _remove_dead(target: Path) -> None:
    """Remove what dead writers of an output have left."""
    pattern = re.compile(re.escape(target.name) + r"\.[0-9a-f]{8}\.partial")
    left = []
    with suppress(OSError), os.scandir(target.parent) as entries:
        left = [Path(entry.path) for entry in entries if pattern.fullmatch(entry.name)]
    for path in left:
        with suppress(OSError):
            descriptor = os.open(path, os.O_RDONLY)
            try:
                if _locked(descriptor) and _is_at(descriptor, path):
                    from shutil import rmtree

                    rmtree(path) if path.is_dir() else path.unlink()
            finally:
                os.close(descriptor)


def _locked(descriptor: int, shared: bool = False) -> bool | None:
    """Lock an open file, alone or beside others: whether that went, None where there are no locks."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno in NO_LOCKS:
            return None
        raise
    return True


def partial_path(target: Path) -> Path:
    """Path that a run is written to before it is whole: NAME.partial beside the target."""
    return target.with_name(target.name + ".partial")


def check_leftover(path: str | Path, force: bool = False) -> None:
    """Raise ResultFileError where a run is being written to an output, or NAME.partial holds a part of one.

    `force` lets a part of a run be replaced. What holds nothing that can be read is in nobody's way.
    """
    target = Path(path).absolute().resolve()
    with suppress(FileNotFoundError, NotADirectoryError):
        os.lstat(unique_path(target))  # fails where that name is too long
    check_unlocked(target, path)
    partial = partial_path(target)
    reached = 0.0 if force or not partial.is_file() else held_until(partial)
    if reached > 0.0 and not (target.exists() and partial.samefile(target)):
        what = f"holds a run that did not come to its end, until {reached:g} s"
        raise ResultFileError(f"{path}.partial: {what}; kept (force=True replaces it)")


@ended_at_once()
def held_until(partial: Path) -> float:
    """Time [s] of the last sample in an unfinished trajectory file; 0 without one, or without such a file."""
    try:
        with h5py.File(partial, "r") as file:
            time = file["time"]
            is_run = read_attr(file, "vibsim_kind", "trajectory") == "trajectory"
            return float(time[-1]) if is_run and len(time) else 0.0
    except (OSError, KeyError, RuntimeError, TypeError, ValueError):
        return 0.0
