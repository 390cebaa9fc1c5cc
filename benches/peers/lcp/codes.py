"""The solvers: each takes an LCP, a form, a start or none and a tolerance, and gives multipliers."""

import importlib.metadata

import clarabel
import highspy
import numpy
import osqp
import piqp
import proxsuite
import qpalm
import scipy.sparse
import scs

INFINITE = numpy.inf
# The CPU seconds after which a solver that has a limit of time is to end.
SECONDS = 10.0


class Refused(Exception):
    """A solver that is not asked, with the reason."""


def programme(lcp, form):
    """`P`, `c` and the rows of `lower <= G x` of a form."""
    if form == "dual":
        rows = len(lcp.q)
        quadratic = scipy.sparse.csc_matrix(lcp.j @ lcp.j.T)
        quadratic.sort_indices()
        return quadratic, lcp.q, scipy.sparse.identity(rows, format="csc"), numpy.zeros(rows)
    size = lcp.j.shape[1]
    return scipy.sparse.identity(size, format="csc"), numpy.zeros(size), lcp.j, -lcp.q


def started(lcp, form, start):
    """The variables and the multipliers of `lower <= G x` at a start."""
    if form == "primal":
        return lcp.j.T @ start, start
    return start, numpy.maximum(lcp.q + lcp.j @ (lcp.j.T @ start), 0)


def multipliers(form, x, y):
    """The multipliers of the LCP."""
    return numpy.maximum(x if form == "dual" else y, 0)


def by_osqp(lcp, form, start, tolerance):
    p, c, g, low = programme(lcp, form)
    solver = osqp.OSQP()
    high = numpy.full(len(low), INFINITE)
    settings = {"eps_abs": tolerance, "eps_rel": 0.0, "max_iter": 100_000, "polishing": False, "verbose": False}
    solver.setup(scipy.sparse.triu(p, format="csc"), c, g, low, high, **settings)
    if start is not None:
        x, y = started(lcp, form, start)
        solver.warm_start(x=x, y=-y)
    found = solver.solve()
    return multipliers(form, found.x, -found.y)


def by_clarabel(lcp, form, start, tolerance):
    p, c, g, low = programme(lcp, form)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    cone = [clarabel.NonnegativeConeT(len(low))]
    found = clarabel.DefaultSolver(scipy.sparse.triu(p, format="csc"), c, -g, -low, cone, settings).solve()
    return multipliers(form, numpy.array(found.x), numpy.array(found.z))


def by_proxqp(lcp, form, start, tolerance):
    p, c, g, low = programme(lcp, form)
    solver = proxsuite.proxqp.sparse.QP(len(c), 0, len(low))
    solver.settings.eps_abs, solver.settings.eps_rel = tolerance, 0.0
    solver.init(p, c, None, None, g, low, numpy.full(len(low), 1e20))
    if start is not None:
        solver.settings.initial_guess = proxsuite.proxqp.InitialGuess.WARM_START
        x, y = started(lcp, form, start)
        solver.solve(x, numpy.zeros(0), -y)
    else:
        solver.solve()
    return multipliers(form, solver.results.x, -solver.results.z)


def by_piqp(lcp, form, start, tolerance):
    p, c, g, low = programme(lcp, form)
    solver = piqp.SparseSolver()
    solver.settings.eps_abs, solver.settings.eps_rel, solver.settings.verbose = tolerance, 0.0, False
    solver.settings.eps_duality_gap_abs, solver.settings.eps_duality_gap_rel = tolerance, 0.0
    solver.setup(p, c, None, None, g, low, None, None, None)
    solver.solve()
    found = solver.result
    return multipliers(form, numpy.array(found.x), numpy.array(found.z_l))


def by_qpalm(lcp, form, start, tolerance):
    p, c, g, low = programme(lcp, form)
    data = qpalm.Data(len(c), len(low))
    data.Q, data.q, data.A, data.bmin, data.bmax = p, c, g, low, numpy.full(len(low), 1e20)
    settings = qpalm.Settings()
    settings.eps_abs, settings.eps_rel, settings.max_iter, settings.verbose = tolerance, 0.0, 100_000, 0
    solver = qpalm.Solver(data, settings)
    if start is not None:
        x, y = started(lcp, form, start)
        solver.warm_start(x, -y)
    solver.solve()
    return multipliers(form, numpy.array(solver.solution.x), -numpy.array(solver.solution.y))


def by_scs(lcp, form, start, tolerance):
    p, c, g, low = programme(lcp, form)
    data = {"P": scipy.sparse.triu(p, format="csc"), "A": scipy.sparse.csc_matrix(-g), "b": -low, "c": c}
    settings = {"eps_abs": tolerance, "eps_rel": 0.0, "max_iters": 100_000, "verbose": False}
    solver = scs.SCS(data, {"l": len(low)}, **settings)
    if start is None:
        found = solver.solve()
    else:
        x, y = started(lcp, form, start)
        found = solver.solve(warm_start=True, x=x, y=y, s=numpy.maximum(g @ x - low, 0))
    return multipliers(form, found["x"], found["y"])


def by_highs(lcp, form, start, tolerance):
    p, c, g, low = programme(lcp, form)
    highs = highspy.Highs()
    for key, value in {
        "output_flag": False,
        "threads": 1,
        "time_limit": SECONDS,
        "primal_feasibility_tolerance": max(tolerance, 1e-10),
        "dual_feasibility_tolerance": max(tolerance, 1e-10),
    }.items():
        highs.setOptionValue(key, value)
    model = highspy.HighsModel()
    linear, square = model.lp_, model.hessian_
    rows = scipy.sparse.csr_matrix(g)
    linear.num_col_, linear.num_row_ = len(c), len(low)
    linear.col_cost_ = c
    free = numpy.full(len(c), 0.0 if form == "dual" else -highspy.kHighsInf)
    linear.col_lower_, linear.col_upper_ = free, numpy.full(len(c), highspy.kHighsInf)
    if form == "dual":
        rows, linear.num_row_ = rows[:0], 0
    linear.row_lower_, linear.row_upper_ = low[: linear.num_row_], numpy.full(linear.num_row_, highspy.kHighsInf)
    linear.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    linear.a_matrix_.start_, linear.a_matrix_.index_, linear.a_matrix_.value_ = rows.indptr, rows.indices, rows.data
    lower = scipy.sparse.tril(p, format="csc")
    lower.sort_indices()
    square.dim_, square.format_ = len(c), highspy.HessianFormat.kTriangular
    square.start_, square.index_, square.value_ = lower.indptr, lower.indices, lower.data
    highs.passModel(model)
    highs.run()
    if highs.getModelStatus() == highspy.HighsModelStatus.kTimeLimit:
        raise Refused(f"over {SECONDS:.0f} s by the clock")
    found = highs.getSolution()
    return multipliers(form, numpy.array(found.col_value), numpy.array(found.row_dual))


def by_ipopt(lcp, form, start, tolerance):
    import casadi

    p, c, g, low = programme(lcp, form)
    x = casadi.SX.sym("x", len(c))
    sparse = lambda matrix: casadi.DM(scipy.sparse.csc_matrix(matrix))
    problem = {"x": x, "f": 0.5 * casadi.bilin(sparse(p), x, x) + casadi.dot(casadi.DM(c), x)}
    arguments = {}
    if form == "primal":
        problem["g"] = casadi.mtimes(sparse(g), x)
        arguments.update(lbg=low)
    else:
        arguments.update(lbx=0.0)
    options = {"tol": tolerance, "print_level": 0, "sb": "yes", "max_cpu_time": SECONDS}
    options.update(constr_viol_tol=tolerance, dual_inf_tol=tolerance, compl_inf_tol=tolerance, bound_relax_factor=0.0)
    if start is not None:
        at, multiplier = started(lcp, form, start)
        arguments["x0"] = at
        arguments["lam_g" + "0" if form == "primal" else "lam_x0"] = -multiplier
        options.update(warm_start_init_point="yes", mu_init=1e-6)
    solver = casadi.nlpsol("lcp", "ipopt", problem, {"ipopt": options, "print_time": False})
    found = solver(**arguments)
    return multipliers(form, numpy.array(found["x"]).ravel(), -numpy.array(found["lam_g"]).ravel())


version = importlib.metadata.version
BOTH = ["dual", "primal"]
# The version, the forms, whether it takes a start, and the call.
CODES = {
    "OSQP": (version("osqp"), BOTH, True, by_osqp),
    "Clarabel": (version("clarabel"), BOTH, False, by_clarabel),
    "ProxQP": (version("proxsuite"), BOTH, True, by_proxqp),
    "PIQP": (version("piqp"), BOTH, False, by_piqp),
    "QPALM": (version("qpalm"), BOTH, True, by_qpalm),
    "SCS": (version("scs"), BOTH, True, by_scs),
    "HiGHS": (version("highspy"), BOTH, False, by_highs),
    "IPOPT (CasADi)": (version("casadi"), ["primal", "dual"], True, by_ipopt),
}
