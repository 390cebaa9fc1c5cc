"""The states of a run as a Dataset of xarray."""

import numpy as np

# Variables, the attributes of states that they are of, and their last dimension.
_VARIABLES = {
    "position": ("positions", "space"),
    "orientation": ("orientations", "quaternion"),
    "axis": ("axes", "space"),
    "velocity": ("velocities", "space"),
    "angular_velocity": ("angular_velocities", "space"),
    "length": ("lengths", None),
    "generation": ("generations", None),
}


def of_states(states, scene):
    """`states` of a run of `scene` over time and the ids of all bodies."""
    try:
        import xarray
    except ImportError as missing:
        raise ImportError("to_xarray needs xarray, which is not installed: pip install xarray") from missing
    ids = np.unique(np.concatenate([np.empty(0, np.int64), *(state.ids for state in states)]))
    data, parents, births = {}, np.full(len(ids), -1), np.full(len(ids), np.nan)
    for nth, state in enumerate(states):
        rows = np.searchsorted(ids, state.ids)
        parents[rows], births[rows] = state.parents, state.births
        values = {name: getattr(state, attribute) for name, (attribute, _) in _VARIABLES.items()}
        values["group"] = np.where(state.groups < 0, np.nan, state.groups)
        for name, of in {**values, **state.columns}.items():
            if name not in data:
                data[name] = np.full((len(states), len(ids), *of.shape[1:]), np.nan)
            data[name][nth, rows] = of
    dims = {name: ("time", "id", last) if last else ("time", "id") for name, (_, last) in _VARIABLES.items()}
    return xarray.Dataset(
        {name: (dims.get(name, ("time", "id")), of) for name, of in data.items()},
        coords={
            "time": states.times, "step": ("time", states.steps), "id": ids, "parent": ("id", parents),
            "birth": ("id", births), "space": ["x", "y", "z"], "quaternion": ["w", "x", "y", "z"],
        },
        attrs={"scene": scene.name, "group_names": scene.group_names},
    )  # fmt: skip
