"""`python -m vibsim` is the command `vibsim`."""

from vibsim.command_line.main import main

if __name__ == "__main__":
    main()
