//! Mutated LCP files.

use super::archives;
use super::mutants::{Fate, each};
use relcp::lcp::{Problem, Stored};
use relcp::record::{LCP_FORMAT, LCP_VERSION, LcpHeader, decode_lcp, encode_lcp};
use zip::CompressionMethod;

fn header() -> LcpHeader {
    LcpHeader {
        format: LCP_FORMAT.into(),
        version: LCP_VERSION,
        program: "test".into(),
        scene: "a scene".into(),
        step: 7,
        recursion: 2,
        solver: "apgd".into(),
        tolerance: 1e-6,
        precision: "f64".into(),
        status: "solved".into(),
        products: 99,
    }
}

/// LCPs of three bodies in space and in the plane, as this program writes them and as numpy packs them.
pub fn files() -> Vec<Vec<u8>> {
    let space = Problem {
        bodies: 3,
        pair: vec![[0, 1], [2, 1]],
        jacobian: vec![[[-1.0, 0.0, 0.0, 0.5, 0.0, 0.0], [1.0; 6]], [[0.0, 1.0, 0.0, 0.0, 0.25, 0.0], [-1.0; 6]]],
        q: vec![-0.1, 0.2],
        ..Problem::default()
    };
    let plane = Problem {
        bodies: 2,
        pair: vec![[0, 1]],
        jacobian: vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]],
        q: vec![-0.1],
        ..Problem::default()
    };
    let lcps = [Stored::new(&space, vec![0.0; 2], &[0.5, 0.0]), Stored::new(&plane, vec![0.0], &[0.05])];
    let written = lcps.iter().map(|lcp| encode_lcp(lcp, &header()).unwrap());
    let numpy = written.clone().map(|bytes| {
        let mut entries = archives::entries(&bytes);
        entries.retain(|(name, _)| name != "header.npy");
        archives::pack(&entries, CompressionMethod::Deflated, false)
    });
    written.chain(numpy).collect()
}

/// What is read is as long as it says, and can be computed with.
pub fn fate(bytes: &[u8]) -> Fate {
    let (lcp, _) = match decode_lcp(bytes) {
        Ok(read) => read,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return Fate::Refused;
        }
    };
    let rows = lcp.pair.len();
    assert!([lcp.q.len(), lcp.start.len(), lcp.gamma.len()].iter().all(|n| *n == rows));
    assert!(lcp.rows.iter().all(|side| side.len() == rows * lcp.unknowns));
    assert_eq!(lcp.velocity.len(), lcp.bodies * lcp.unknowns);
    let _residual = lcp.residual(&lcp.gamma);
    assert!(lcp.problem::<3>().is_some() != lcp.problem::<6>().is_some());
    Fate::Made
}

#[test]
fn mutated_lcps_are_read_or_refused() {
    let files = files();
    for file in &files {
        assert!(fate(file) == Fate::Made);
    }
    let tally = each((2, "LCPs"), &files, |random, file| archives::mutate(random, file), fate);
    assert!(tally.made > tally.refused / 20 && tally.refused > tally.made / 20, "{tally:?}");
}
