"""The command `vibsim`, also as `python -m vibsim`: here its process begins."""

from vibsim.signals import ended_by_signals


def main() -> None:
    """Run the command; ends the process with the exit code.

    While the command line is imported there is nothing to be kept, and signals end the process as the system
    does it: a KeyboardInterrupt would come up somewhere within an import, with its traceback.
    """
    ended_by_signals()
    from vibsim.command_line.main import main as command

    command()


if __name__ == "__main__":
    main()
