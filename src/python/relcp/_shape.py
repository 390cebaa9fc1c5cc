"""The shapes by name."""

import enum

from ._relcp import shapes

Shape = enum.IntEnum("Shape", shapes(), module="relcp")  # type: ignore[misc]
Shape.__doc__ = "The shapes, as `shapes` has them: `simulation.shapes == relcp.Shape.TORUS`."
