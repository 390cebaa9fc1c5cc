"""The tables of `decades`: for each scene a row a tolerance, means over the draws with their standard errors."""

import statistics

# Decimals of the quantities.
QUANTITIES = {"radius": 4, "order": 3, "pressure": 2, "contacts a body": 2}


def of(values, places):
    """A mean and its standard error."""
    if not values:
        return ""
    mean = f"{statistics.mean(values):.{places}f}"
    error = statistics.stdev(values) / len(values) ** 0.5 if len(values) > 1 else None
    return mean if error is None else f"{mean} ± {error:.{places}f}"


def path(values):
    values = [value for value in values if value is not None]
    return f"{statistics.mean(values):.1e}" if values else "other cells"


def tables(rows, table):
    """Every scene's."""
    made = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        here = [row for row in rows if row["scene"] == scene]
        body = []
        loosest = statistics.mean(row["cpu_s"] for row in here if row["tolerance"] == max(r["tolerance"] for r in here))
        for tolerance in sorted({row["tolerance"] for row in here}, reverse=True):
            some = [row for row in here if row["tolerance"] == tolerance]
            seconds = statistics.mean(row["cpu_s"] for row in some)
            line = [f"{tolerance:.0e}", f"{seconds:.2f}", f"{seconds / loosest:.2f}"]
            line.append(f"{max(row['max_overlap'] for row in some):.1e}")
            line += [path([row[key] for row in some]) for key in ("path_early", "path_end")]
            line += [of([row[key] for row in some if key in row], places) for key, places in QUANTITIES.items()]
            body.append(line)
        bodies = sorted({row["bodies"] for row in here})
        many = f"{bodies[0]}" if len(bodies) == 1 else f"{bodies[0]} to {bodies[-1]}"
        head = ["overlap tolerance", "CPU s", "over the first", "largest overlap", "path, early", "path, at the end", *QUANTITIES]
        made.append(f"{scene}, {many} bodies, {len({row['seed'] for row in here})} draws:\n\n{table(head, body)}")
    return "\n".join(made)
