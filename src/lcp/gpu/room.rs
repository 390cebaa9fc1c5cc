//! The parameters of a dispatch that a stage uses: the offsets of vectors and of scalars, each once.

use super::layout::{CONSTANTS, FIRST_CONSTANT, MOST_NUMBERS, MOST_VECTORS, TOLERANCE};
use super::number::Operation;
use super::stage::{Action, Block, Bodies, Clusters, Rows, Stage, Words, Work};

/// This many instructions and operations always fit: each uses at most four vectors and three scalars.
const FEW: usize = 6;

/// The vectors and scalars that a stage uses so far. It is updated as the stage grows: solvers write a hundred thousand
/// instructions per second, and a new count each time took a seventh of the time of steps of 64 cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Room {
    /// The number of instructions and operations.
    count: usize,
    vectors: Vec<u32>,
    /// Scalars that were computed before the stage, and constants that differ between solves.
    numbers: Vec<u32>,
    /// Scalars that the stage's own operations compute.
    made: Vec<u32>,
}

fn note(list: &mut Vec<u32>, place: u32) {
    if !list.contains(&place) {
        list.push(place);
    }
}

impl Room {
    /// The vectors and scalars of a whole stage.
    pub fn of(stage: &Stage) -> Self {
        let mut room = Room::default();
        stage.operations.iter().for_each(|words| room.operation(words));
        room.work(&stage.work);
        room
    }

    /// Adds the work that a stage executes after its operations.
    pub fn work(&mut self, work: &Work) {
        match work {
            Work::Rows(Rows { product, gather, before, block, after, .. }) => {
                self.vectors(product.map(|product| product.out));
                if let Some(gather) = gather {
                    self.number(gather.condition);
                    self.vectors([gather.instead, gather.out]);
                }
                if let Some(block) = block {
                    self.block(*block);
                }
                before.iter().chain(after).for_each(|words| self.instruction(words));
            }
            Work::Clusters(Clusters { condition, tolerance, x, g }) => {
                self.number(*condition);
                self.given(*tolerance);
                self.vectors([*x, *g]);
            }
            Work::Bodies(Bodies { x, low, instead, .. }) => {
                self.vectors([Some(*x), *low].into_iter().flatten());
                if let Some([condition, from]) = *instead {
                    self.number(condition);
                    self.vectors([from]);
                }
            }
            _ => {}
        }
    }

    /// Adds the small problems of pairs.
    pub fn block(&mut self, Block { x, w, g, out }: Block) {
        self.vectors([Some(x), w, g, Some(out)].into_iter().flatten());
    }

    fn vectors(&mut self, places: impl IntoIterator<Item = u32>) {
        places.into_iter().for_each(|place| note(&mut self.vectors, place));
    }

    /// Adds an instruction on rows.
    pub fn instruction(&mut self, words: &Words) {
        let [action, out, a, b, c, s, t, _] = *words;
        self.count += 1;
        self.vectors([a, b, c]);
        if !Action::ALL[action as usize].is_sum() {
            self.vectors([out]);
        }
        self.number(s);
        self.number(t);
    }

    /// Adds an operation on scalars.
    pub fn operation(&mut self, words: &[u32; 4]) {
        let [head, a, b, c] = *words;
        self.count += 1;
        let kind = head & 0xff;
        if kind != Operation::Take as u32 {
            self.number(a);
            // The last word of a check is its number; its tolerance is a parameter although it is a constant.
            if kind == Operation::Look as u32 {
                self.given(b);
            } else {
                self.number(b);
                self.number(c);
            }
        }
        self.made.push(head >> 8);
    }

    fn number(&mut self, place: u32) {
        if place == TOLERANCE || !(FIRST_CONSTANT..FIRST_CONSTANT + CONSTANTS).contains(&place) {
            self.given(place);
        }
    }

    /// Adds a scalar that is a parameter even if it is a constant.
    fn given(&mut self, place: u32) {
        if !self.made.contains(&place) {
            note(&mut self.numbers, place);
        }
    }

    /// The numbers of vectors and scalars that a dispatch passes.
    pub fn places(&self) -> [usize; 2] {
        [self.vectors.len(), self.numbers.len()]
    }

    /// Whether the parameters of a dispatch may not suffice for one more instruction or operation.
    pub fn is_full(&self) -> bool {
        let [vectors, numbers] = self.places();
        self.count > FEW && !(vectors + 4 <= MOST_VECTORS && numbers + 3 <= MOST_NUMBERS)
    }
}
