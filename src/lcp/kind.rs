//! The kinds of solvers.

/// The LCP solvers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum SolverKind {
    /// `pair_block_cg`; on the CPU with `interior_point` as fallback for solves that miss the tolerance.
    #[default]
    Auto,
    /// Projected Jacobi with a safe step.
    ProjectedJacobi,
    /// Projected Gauss-Seidel, sequential.
    ProjectedGaussSeidel,
    /// Accelerated projected gradient descent with restart.
    Apgd,
    /// Projected gradient descent with safeguarded Barzilai-Borwein steps.
    Bbpgd,
    /// Projected nonlinear conjugate gradients, preconditioned by the blocks of the pairs.
    PairBlockCg,
    /// The same, with steps from the LCPs of overlapping clusters of bodies: fewer, more expensive iterations, for a
    /// GPU.
    ClusterCg,
    /// Dense pivoting, for tests and small systems.
    Dense,
    /// Primal-dual interior point with a sparse factorization: few iterations at any conditioning. Not on a GPU.
    InteriorPoint,
}

impl SolverKind {
    /// Whether it solves problems with friction cones ([`Problem::cones`](super::Problem::cones)): `auto`,
    /// `pair_block_cg` and `apgd` do.
    pub fn supports_friction(self) -> bool {
        matches!(self, SolverKind::Auto | SolverKind::PairBlockCg | SolverKind::Apgd)
    }

    /// All solvers that a scene may name, except `auto`, which uses some of them; with their names in scenes.
    ///
    /// ```
    /// # use relcp::lcp::SolverKind;
    /// assert!(SolverKind::NAMED.contains(&("bbpgd", SolverKind::Bbpgd)));
    /// ```
    pub const NAMED: [(&'static str, SolverKind); 8] = [
        ("projected_jacobi", SolverKind::ProjectedJacobi),
        ("projected_gauss_seidel", SolverKind::ProjectedGaussSeidel),
        ("apgd", SolverKind::Apgd),
        ("bbpgd", SolverKind::Bbpgd),
        ("pair_block_cg", SolverKind::PairBlockCg),
        ("cluster_cg", SolverKind::ClusterCg),
        ("dense", SolverKind::Dense),
        ("interior_point", SolverKind::InteriorPoint),
    ];
}
