import pytest

from echogrid.emulation.worlds import WORLDS
from echogrid.runtime.acoustics_check import SONARS, outcome_shares, ring, table


@pytest.mark.parametrize("name", ["office", "clutter"])
def test_office_and_clutter_are_as_deceptive_as_they_should_be(name):
    """Bounds and figures are in docs/acoustics.md."""
    shares = outcome_shares(WORLDS[name](), 1, 2.0)
    assert 0.35 <= shares.no_echo <= 0.55
    assert 0.04 <= shares.first["bounce"] <= 0.10


def test_every_ping_has_one_outcome():
    shares = outcome_shares(WORLDS["home"](), 1, 20.0)
    assert shares.pings == SONARS * int(WORLDS["home"]().tour.lap_time / 20.0)
    assert shares.no_echo + sum(shares.first.values()) == pytest.approx(1.0)


def test_the_same_seed_gives_the_same_shares():
    venue = WORLDS["museum"]()
    assert outcome_shares(venue, 3, 20.0) == outcome_shares(venue, 3, 20.0)


def test_the_ring_looks_everywhere():
    mounts = [ranger.mount for ranger in ring()]
    assert len({round(yaw, 6) for _, _, yaw in mounts}) == SONARS
    assert all(x**2 + y**2 == pytest.approx(0.25**2) for x, y, _ in mounts)


def test_the_table_has_a_row_for_each_world():
    head, rule, *rows = table(1, 60.0)
    assert [row.split("|")[1].strip() for row in rows] == list(WORLDS)
    assert {row.count("|") for row in (head, rule, *rows)} == {head.count("|")}
