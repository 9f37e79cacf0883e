"""The worked numbers of the three papers' equations."""

import json
from math import atan2, degrees
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytest import approx

from echogrid.mapping.steering import vfh, vfh_plus
from echogrid.mapping.steering.vff import repulsions
from echogrid.mapping.steering.vfh_plus import Costs, cost
from echogrid.mapping.steering.window import Body, Window, enlargement

WORKED = Path(__file__).parents[4] / "shared/vectors/worked.json"
HALF = 16
"""(w_s - 1)/2 of the papers' window, 33 cells wide."""
PUSH = (-0.7130543285701398, -0.3849000919740879)
RESULT = (0.28694567142986016, -0.3849000919740879)
EXPECTED: dict[str, Any] = {
    "3.VFF Fr,Ft,R,theta_deg": [list(PUSH), [1.0, 0.0], list(RESULT), -53.29521710731363],
    "3.VFH dmax(cells), a (b=1)": [22.627416997969522] * 2,
    "3.VFH magnitude c=12,d=10 cells": 1818.3480477076112,
    "3.VFH sector of (dx=10,dy=5) alpha=5": [26.56505117707799, 5],
    "3.VFH smoothing of a unit spike 100 at 10 (l=5): k=10,8,5,4": [
        54.54545454545455,
        36.36363636363637,
        9.090909090909092,
        0.0,
    ],
    "3.VFH smoothing gain sum/orig (printed divisor 2l+1 -> 36/11)": 3.2727272727272725,
    "3.VFH+ a (b=1) ws=33": [257.0],
    "3.VFH+ m c=12,d=10 cells": 22608.0,
    "3.VFH+ enlargement asin(.35/1.0)deg": 20.487315114722662,
    "3.VFH+ costs: kt=0,heading=4,prev=5; cands 70,3,10": [36, 21, 72],
}


@pytest.mark.skipif(not WORKED.exists(), reason="no shared/vectors/worked.json beside the project")
@pytest.mark.parametrize("name", EXPECTED)
def test_the_numbers_here_are_the_reference_s(name: str) -> None:
    assert json.loads(WORKED.read_text())[name] == EXPECTED[name]


def spike() -> np.ndarray:
    density = np.zeros(72)
    density[10] = 100.0
    return vfh.smoothed(density, 5)


def reckoned() -> dict[str, Any]:
    x, y = repulsions(np.array([12, 9], np.int16), np.array([1.0, 1.0]), np.array([0.5, 0.6]), 0.05)
    push = [float(x.sum()), float(y.sum())]
    result = [1.0 + push[0], push[1]]
    window = Window(0.1, 40, Body(), 1.6)
    cell = int(np.flatnonzero((window.x == 1.0) & (window.y == 0.5))[0])
    costs = [cost(sector, (0.0, 4.0, 5.0), Costs(), 72) for sector in (70, 3, 10)]
    d_max, at_10 = (float(vfh.factors(np.array([d**2.0]), HALF)[0]) for d in (0, 10))
    a, plus_at_10 = (float(vfh_plus.factors(np.array([d**2.0]), HALF)[0]) for d in (0, 10))
    return {
        "3.VFF Fr,Ft,R,theta_deg": [push, [1.0, 0.0], result, degrees(atan2(result[1], result[0]))],
        "3.VFH dmax(cells), a (b=1)": [d_max, d_max],
        "3.VFH magnitude c=12,d=10 cells": 12**2 * at_10,
        "3.VFH sector of (dx=10,dy=5) alpha=5": [
            degrees(float(window.bearing[cell])),
            int(vfh.sectors_of(window)[cell]),
        ],
        "3.VFH smoothing of a unit spike 100 at 10 (l=5): k=10,8,5,4": spike()[[10, 8, 5, 4]].tolist(),
        "3.VFH smoothing gain sum/orig (printed divisor 2l+1 -> 36/11)": float(spike().sum()) / 100.0,
        "3.VFH+ a (b=1) ws=33": [a],
        "3.VFH+ m c=12,d=10 cells": 12**2 * plus_at_10,
        "3.VFH+ enlargement asin(.35/1.0)deg": degrees(float(enlargement(0.35, np.array([1.0]))[0])),
        "3.VFH+ costs: kt=0,heading=4,prev=5; cands 70,3,10": costs,
    }


@pytest.mark.parametrize("name", EXPECTED)
def test_the_equations_give_the_worked_numbers(name: str) -> None:
    ours, theirs = reckoned()[name], EXPECTED[name]
    assert flat(ours) == approx(flat(theirs), abs=1e-6)


def flat(value: Any) -> list[float]:
    return [part for each in value for part in flat(each)] if isinstance(value, list) else [float(value)]
