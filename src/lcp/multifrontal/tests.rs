use super::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A matrix with random blocks, positive by its diagonal, whose bodies are in order of elimination.
struct Matrix<const D: usize> {
    own: Vec<[[f64; D]; D]>,
    first_link: Vec<u32>,
    later: Vec<u32>,
    linked: Vec<[[f64; D]; D]>,
}

impl<const D: usize> Matrix<D> {
    fn new(bodies: usize, links: &[[u32; 2]]) -> Self {
        let graph = |links: &mut Vec<[u32; 2]>| {
            links.iter_mut().for_each(|link| link.sort_unstable());
            links.sort_unstable();
            links.dedup();
            let first = (0..=bodies).map(|body| links.partition_point(|link| (link[0] as usize) < body) as u32);
            (first.collect::<Vec<u32>>(), links.iter().map(|link| link[1]).collect::<Vec<u32>>())
        };
        let mut links = links.to_vec();
        let (column, entry) = graph(&mut links);
        let place = elimination_order(Pattern { column: &column, entry: &entry }).unwrap();
        links.as_flattened_mut().iter_mut().for_each(|body| *body = place[*body as usize]);
        let (first_link, later) = graph(&mut links);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let block = |rng: &mut dyn Rng| -> [[f64; D]; D] {
            std::array::from_fn(|_| std::array::from_fn(|_| rng.random::<f64>() - 0.5))
        };
        let linked: Vec<[[f64; D]; D]> = later.iter().map(|_| block(&mut rng)).collect();
        // Each row's sum of others is less than the diagonal.
        let degree = |body: u32| links.as_flattened().iter().filter(|other| **other == body).count();
        let own = (0..bodies as u32).map(|body| {
            let half = block(&mut rng);
            let diagonal = ((degree(body) + 1) * D) as f64;
            std::array::from_fn(|k| std::array::from_fn(|l| if k == l { diagonal } else { half[k.min(l)][k.max(l)] }))
        });
        Matrix { own: own.collect(), first_link, later, linked }
    }

    fn graph(&self) -> Pattern<'_> {
        Pattern { column: &self.first_link, entry: &self.later }
    }

    fn blocks(&self) -> Blocks<'_, D> {
        Blocks { own: &self.own, first_link: &self.first_link, linked: &self.linked }
    }

    fn times(&self, x: &[[f64; D]]) -> Vec<[f64; D]> {
        let mut out = vec![[0.0; D]; x.len()];
        for (body, own) in self.own.iter().enumerate() {
            for k in 0..D {
                for l in 0..D {
                    out[body][l] += own[k][l] * x[body][k];
                }
            }
            for link in self.first_link[body]..self.first_link[body + 1] {
                let (other, block) = (self.later[link as usize] as usize, &self.linked[link as usize]);
                for k in 0..D {
                    for l in 0..D {
                        out[other][l] += block[k][l] * x[body][k];
                        out[body][k] += block[k][l] * x[other][l];
                    }
                }
            }
        }
        out
    }

    /// The solution for a right side, by a pool of some threads, and the number of tasks.
    fn solve(&self, threads: usize) -> (Vec<[f64; D]>, usize) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut cholesky = Multifrontal { least_work: 1e5, ..Multifrontal::default() };
            assert!(cholesky.analyse(self.graph(), usize::MAX));
            assert!(cholesky.factorize(self.blocks()));
            let mut x = self.right();
            cholesky.solve(&mut x);
            (x, cholesky.tasks.len())
        })
    }

    fn right(&self) -> Vec<[f64; D]> {
        (0..self.own.len()).map(|body| std::array::from_fn(|k| ((7 * body + 3 * k) % 11) as f64 - 5.0)).collect()
    }

    fn check(&self) -> usize {
        let (x, tasks) = self.solve(1);
        for (product, right) in self.times(&x).iter().flatten().zip(self.right().iter().flatten()) {
            assert!((product - right).abs() < 1e-11, "{product} {right}");
        }
        assert_eq!(self.solve(3).0, x);
        tasks
    }
}

/// Bodies on a square lattice, each with its four neighbours.
fn lattice(side: u32) -> Vec<[u32; 2]> {
    let place = move |x: u32, y: u32| (x * side + y) * 7_919 % (side * side);
    let at = (0..side).flat_map(|x| (0..side).map(move |y| (x, y)));
    at.flat_map(|(x, y)| {
        let right = (x + 1 < side).then(|| [place(x, y), place(x + 1, y)]);
        right.into_iter().chain((y + 1 < side).then(|| [place(x, y), place(x, y + 1)]))
    })
    .collect()
}

#[test]
fn solutions_solve_and_do_not_depend_on_threads() {
    assert_eq!(Matrix::<3>::new(0, &[]).solve(1).0, Vec::<[f64; 3]>::new());
    assert_eq!(Matrix::<3>::new(1, &[]).check(), 1);
    assert_eq!(Matrix::<6>::new(3, &[[0, 2]]).check(), 1);
    // Tasks are large unless a test asks for small ones.
    let mut large = Multifrontal::<3>::default();
    assert!(large.analyse(Matrix::<3>::new(900, &lattice(30)).graph(), usize::MAX) && large.tasks.len() == 1);
    assert!(Matrix::<3>::new(900, &lattice(30)).check() > 1);
    assert!(Matrix::<6>::new(1_600, &lattice(40)).check() > 8);
}

#[test]
fn a_long_chain_a_star_and_separate_parts_are_solved() {
    let chain: Vec<[u32; 2]> = (0..60_000).map(|body| [body, body + 1]).collect();
    Matrix::<3>::new(20_000, &chain[..19_999]).check();
    let star: Vec<[u32; 2]> = (1..2_000).map(|body| [0, body]).collect();
    Matrix::<3>::new(2_000, &star).check();
    let parts: Vec<[u32; 2]> = (0..40)
        .flat_map(|part| lattice(12).into_iter().map(move |link| link.map(|body| body + 144 * part)))
        .chain([[7, 151], [151, 300], [300, 5]])
        .collect();
    assert!(Matrix::<6>::new(144 * 40 + 10, &parts).check() > 8);
}

#[test]
fn a_dense_matrix_is_solved_and_a_pivot_that_is_not_positive_is_found() {
    let all: Vec<[u32; 2]> = (0..60).flat_map(|a| (0..a).map(move |b| [a, b])).collect();
    let mut matrix = Matrix::<6>::new(60, &all);
    matrix.check();
    let mut cholesky = Multifrontal::default();
    assert!(!cholesky.factorize(matrix.blocks()));
    assert!(cholesky.analyse(matrix.graph(), 360 * 360) && !cholesky.analyse(matrix.graph(), 360 * 180));
    assert!(cholesky.analyse(matrix.graph(), usize::MAX));
    for bad in [-1.0, f64::NAN] {
        matrix.own[30][4][4] = bad;
        assert!(!cholesky.factorize(matrix.blocks()), "{bad}");
    }
}
