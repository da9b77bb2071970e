"""``python -m tissuec``"""

from tissuec.cli import main

if __name__ == "__main__":
    main()
