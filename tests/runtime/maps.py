"""Maps made by hand."""

import numpy as np

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.long_term_map import MapImage


def image(occupancy: list[list[float]], resolution: float = 0.5, x: float = -1.0, y: float = 2.0) -> MapImage:
    """Rows from the south; nan where unknown."""
    values = np.array(occupancy, np.float32)
    rows, cols = values.shape
    unknown = np.isnan(values)
    values[unknown] = 0.5
    return MapImage(GridGeometry(resolution, x, y, rows, cols), values, unknown)
