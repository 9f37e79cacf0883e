import pytest

from echogrid.runtime import odometry_check
from echogrid.runtime.evaluation import default_config


def test_calibration_lowers_the_worst_systematic_end_error_tenfold() -> None:
    old, new = odometry_check.errors(default_config(), *odometry_check.BODIES[0], 1)
    assert old > 0.3
    assert new < old / 10.0


def test_the_table_has_a_row_for_each_body(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(odometry_check, "errors", lambda *_: (0.379, 0.0158))
    header, rule, *rows = odometry_check.table(default_config(), 1)
    assert header.count("|") == rule.count("|") == rows[0].count("|")
    assert len(rows) == len(odometry_check.BODIES)
    assert rows[0] == "| 1.003, 99 % | 37.9 cm | 1.6 cm | 24 |"
