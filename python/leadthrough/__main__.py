"""The command line as `python -m leadthrough`, where the environment's scripts are not on PATH."""

from leadthrough.cli import main

if __name__ == "__main__":
    main()
