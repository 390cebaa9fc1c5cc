//! The rows that a local solve takes out of a problem, and their connected parts.

/// The rows that are solved again, in global order.
#[derive(Default)]
pub struct Taken<const D: usize> {
    /// Their global indices.
    pub row: Vec<u32>,
    /// The global positions of their bodies.
    pub pair: Vec<[u32; 2]>,
    pub jacobian: Vec<[[f64; D]; 2]>,
    pub x: Vec<f64>,
    pub g: Vec<f64>,
}

impl<const D: usize> Taken<D> {
    /// Whether the body at a side of a row moves.
    pub(super) fn moves(&self, row: usize, side: usize) -> bool {
        self.jacobian[row][side] != [0.0; D]
    }

    /// The connected parts of rows, in the order of their first bodies.
    pub(super) fn parts(&self) -> Vec<Part> {
        let sides = || (0..self.row.len()).flat_map(|row| [(row, 0), (row, 1)]);
        let moving = || sides().filter(|(row, side)| self.moves(*row, *side));
        let mut bodies: Vec<u32> = moving().map(|(row, side)| self.pair[row][side]).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let place = |body: u32| bodies.binary_search(&body).unwrap_or(bodies.len());
        // Each part is identified by its first body.
        let mut first: Vec<u32> = (0..bodies.len() as u32).collect();
        fn root(first: &mut [u32], mut body: u32) -> u32 {
            while first[body as usize] != body {
                first[body as usize] = first[first[body as usize] as usize];
                body = first[body as usize];
            }
            body
        }
        let both = (0..self.row.len()).filter(|row| self.moves(*row, 0) && self.moves(*row, 1));
        for row in both {
            let [a, b] = self.pair[row].map(|body| root(&mut first, place(body) as u32));
            first[a.max(b) as usize] = a.min(b);
        }
        let mut number = vec![u32::MAX; bodies.len()];
        let mut parts: Vec<Part> = Vec::new();
        for body in 0..bodies.len() as u32 {
            let of = root(&mut first, body) as usize;
            if number[of] == u32::MAX {
                number[of] = parts.len() as u32;
                parts.push(Part::default());
            }
            parts[number[of] as usize].bodies.push(bodies[body as usize]);
        }
        for row in 0..self.row.len() {
            let Some(side) = (0..2).find(|side| self.moves(row, *side)) else { continue };
            let of = root(&mut first, place(self.pair[row][side]) as u32) as usize;
            parts[number[of] as usize].rows.push(row as u32);
        }
        parts
    }
}

/// A connected part: the positions of its bodies, and the indices of its rows among those taken.
#[derive(Default)]
pub(super) struct Part {
    pub bodies: Vec<u32>,
    pub rows: Vec<u32>,
}
