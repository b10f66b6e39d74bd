"""The command `vibsim`, also as `python -m vibsim`: here its process begins."""

import signal


def main() -> None:
    """Run the command; ends the process with the exit code.

    While the command line is imported there is nothing to be kept, and Ctrl-C ends the process as the system
    does it: a KeyboardInterrupt would come up somewhere within an import, with its traceback. Nothing is
    imported before, `typing` and `vibsim.signals` neither.
    """
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from vibsim.command_line.main import main as command

    command()


if __name__ == "__main__":
    main()
