"""Growth and division by length, each cell with its own rate and its own length at division."""

import relcp

scene = relcp.Scene({
    "name": "growth",
    "seed": 3,
    "planar": True,
    "time": {"dt": 0.02, "end": 4.5},
    "growth": {
        "rate": 1.0, "rate_noise": 0.1, "division_length": 4.0, "division_length_noise": 0.2,
        "reorientation_degrees": 5,
    },
    "generate": [{"founder": {"diameter": 1.0, "length": 2.0}}],
})  # fmt: skip
simulation = relcp.Simulation(scene)
summary = simulation.run()

if __name__ == "__main__":
    print(f"{simulation.n_bodies} cells, {simulation.lengths.sum():.1f} long; overlap {summary['max_overlap']:.1e}")
    simulation.save_picture("growth.png", 240, 180, colour="age")
