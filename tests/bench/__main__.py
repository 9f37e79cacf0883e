"""What things cost, beside what they may be compared with: the least of several runs, in one process.

python -m tests.bench       (make bench)
"""

from tests.bench import drivers, emulation
from tests.bench.stopwatch import Row


def main() -> None:
    """Print a table."""
    rows: list[Row] = [*drivers.rows(), *emulation.rows()]
    print("| what | us each | beside it | us each | ratio |")
    print("|---|---|---|---|---|")
    for row in rows:
        print(row)


if __name__ == "__main__":
    main()
