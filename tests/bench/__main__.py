"""What things cost, beside what they may be compared with: the least of several runs, in one process.

python -m tests.bench       (make bench)
"""

from tests.bench import drivers, emulation, obstacles, planning, steering, wheels
from tests.bench.stopwatch import Row


def main() -> None:
    """Print two tables."""
    rows: list[Row] = [*drivers.rows(), *emulation.rows(), *steering.rows(), *obstacles.rows()]
    rows += planning.rows()
    print("| what | us each | beside it | us each | ratio |")
    print("|---|---|---|---|---|")
    for row in rows:
        print(row)
    print()
    print("| what goes on | frames/s | us each | % of a core | % if they come in one go each 10 ms |")
    print("|---|---|---|---|---|")
    for load in wheels.rows():
        print(load)


if __name__ == "__main__":
    main()
